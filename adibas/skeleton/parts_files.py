"""Core and limbs as part of a skeleton model's file."""

from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np

from adibas.shapes.parts_types import Anchors, Core, Limbs
from adibas.skeleton.parts import PartsModel
from adibas.skeleton.parts_checks import check_parts
from adibas.skeleton.stance import Stance

DIGITS = 6
"""Significant ones: covariances of 1 cm beside shifts of half a metre."""
WHOLE = frozenset({"labels", "mirror", "kinds", "roots", "points", "limbs"})
"""Fields of whole numbers."""

Part = TypeVar("Part", Core, Limbs, Anchors, Stance)


def parts_to_json(parts: PartsModel) -> dict[str, Any]:
    """Return the document of a model; its names stand beside it."""
    return {
        "kinds": list(parts.kinds),
        "core": _to_json(parts.core),
        "limbs": _to_json(parts.limbs),
        "anchors": _to_json(parts.anchors),
        "stance": None if parts.stance is None else _to_json(parts.stance),
    }


def parts_from_json(names: tuple[str, ...], document: Mapping[str, Any]) -> PartsModel:
    """Return the model of a document.

    Raises
    ------
    KeyError, TypeError, ValueError
        Something is missing or does not fit.
    """
    stance = document["stance"]
    parts = PartsModel(
        names,
        tuple(str(kind) for kind in document["kinds"]),
        _from_json(Core, document["core"]),
        _from_json(Limbs, document["limbs"]),
        _from_json(Anchors, document["anchors"]),
        None if stance is None else _from_json(Stance, stance),
    )
    check_parts(parts)
    return parts


def _to_json(part: Core | Limbs | Anchors | Stance) -> dict[str, Any]:
    return {
        name: _rounded(array.tolist()) if array.dtype.kind == "f" else array.tolist()
        for name, array in part._asdict().items()
    }


def _from_json(kind: type[Part], document: Mapping[str, Any]) -> Part:
    arrays = {name: np.array(document[name]) for name in kind._fields}
    for name, array in arrays.items():
        if array.dtype.kind not in "if" or not np.isfinite(array).all():
            raise ValueError(f"{name} holds something that is no number")
        arrays[name] = np.ascontiguousarray(array, np.int64 if name in WHOLE else float)
    return kind(**arrays)


def _rounded(values: Any) -> Any:
    if isinstance(values, list):
        return [_rounded(value) for value in values]
    return float(f"{values:.{DIGITS}g}")
