"""Core and limbs as part of a skeleton model's file."""

from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np

from adibas.arrays import check_shape
from adibas.shapes.parts_types import Anchors, Core, Limbs
from adibas.skeleton.bones_training import without_bones
from adibas.skeleton.parts import PartsModel
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

    One without lengths of bones, or without how people stand, is from an earlier version.

    Raises
    ------
    KeyError, TypeError, ValueError
        Something is missing or does not fit.
    """
    return PartsModel(
        names,
        tuple(str(kind) for kind in document["kinds"]),
        _from_json(Core, document["core"]),
        _from_json(Limbs, _with_bones(document)),
        _from_json(Anchors, document["anchors"]),
        _stance(names, document.get("stance")),
    )


def _to_json(part: Core | Limbs | Anchors | Stance) -> dict[str, Any]:
    return {
        name: _rounded(array.tolist()) if array.dtype.kind == "f" else array.tolist()
        for name, array in part._asdict().items()
    }


def _with_bones(document: Mapping[str, Any]) -> Mapping[str, Any]:
    limbs = document["limbs"]
    return {**without_bones(len(limbs["roots"]), len(document["kinds"])), **limbs}


def _stance(names: tuple[str, ...], document: Mapping[str, Any] | None) -> Stance | None:
    if document is None:
        return None
    stance = _from_json(Stance, document)
    n_components, n_limbs, n_coordinates = len(stance.weights), len(stance.limbs), 3 * len(names)
    check_shape("means", stance.means, (n_components, n_coordinates))
    check_shape("covariances", stance.covariances, (*stance.means.shape, n_coordinates))
    check_shape("limbs", stance.limbs, (n_limbs, 3))
    for name in ("bone_means", "bone_sds"):
        check_shape(name, getattr(stance, name), (n_limbs, 2))
    if stance.weights.min() <= 0 or stance.bone_sds.min() <= 0:
        raise ValueError("weights and deviations must be positive")
    if not ((stance.limbs >= 0) & (stance.limbs < len(names))).all():
        raise ValueError("limbs have labels that no point has")
    np.linalg.cholesky(stance.covariances)
    return stance


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
