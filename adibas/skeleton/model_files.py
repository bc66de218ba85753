"""Skeleton models as files: JSON, so that a reader can see what a model is made of."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from adibas.arrays import FloatArray
from adibas.errors import FileError
from adibas.files import DAMAGED_JSON, cannot_read, written_whole
from adibas.skeleton.model import NeighbourTree, PointModel, Prototype, SkeletonModel
from adibas.skeleton.parts_files import parts_from_json, parts_to_json

FORMAT = "adibas-skeleton"
VERSION = 2
DIGITS = 4
"""Significant ones: a ten-thousandth of a body is less than a palpation."""


def write_model(model: SkeletonModel, path: Path) -> None:
    """Write a model; what stood there is replaced when the new one is whole.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    with written_whole(path) as unfinished:
        unfinished.write_text(json.dumps(model_to_json(model), indent=None), encoding="utf-8")


def read_model(path: Path) -> SkeletonModel:
    """Read a model.

    Raises
    ------
    FileError
        The file is missing, or no skeleton model.
    """
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise cannot_read(path, error) from error
    except DAMAGED_JSON as error:
        raise _no_model(path) from error
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise _no_model(path)
    if document.get("version") != VERSION:
        raise FileError(
            "{file} was written by another version of this program. Update the program, or train "
            "the model again.",
            file=path.name,
        )
    try:
        return model_from_json(document)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        raise _no_model(path) from error


def model_to_json(model: SkeletonModel) -> dict[str, Any]:
    """Return the document of a model."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "names": list(model.names),
        "temperature": model.temperature,
        "provenance": dict(model.provenance),
        "space": None if model.space is None else _points_to_json(model.space),
        "planes": {view: _points_to_json(plane) for view, plane in model.planes.items()},
        "parts": None if model.parts is None else parts_to_json(model.parts),
    }


def model_from_json(document: Mapping[str, Any]) -> SkeletonModel:
    """Return the model of a document.

    Raises
    ------
    KeyError, TypeError, ValueError, IndexError, AttributeError
        Something is missing or does not fit.
    """
    names = tuple(str(name) for name in document["names"])
    space = document["space"]
    parts = document.get("parts")
    return SkeletonModel(
        None if space is None else _points_from_json(names, space),
        {str(view): _points_from_json(names, one) for view, one in document["planes"].items()},
        float(document["temperature"]),
        dict(document["provenance"]),
        None if parts is None else parts_from_json(names, parts),
    )


def _points_to_json(model: PointModel) -> dict[str, Any]:
    tree = model.tree
    return {
        "is_upright": model.is_upright,
        "tree": {
            "edges": tree.edges.tolist(),
            "log_lengths": _rounded(tree.log_lengths),
            "log_length_sds": _rounded(tree.log_length_sds),
            "direction_costs": np.round(tree.directions, 2).tolist(),
        },
        "prototypes": [
            {
                "kind": one.kind,
                "weight": one.weight,
                "log_size": one.log_size,
                "log_size_sd": one.log_size_sd,
                "mean": _rounded(one.mean),
                "modes": _rounded(one.modes),
                "noise": [float(f"{value:.{DIGITS}g}") for value in one.noise],
            }
            for one in model.prototypes
        ],
    }


def _points_from_json(names: tuple[str, ...], document: Mapping[str, Any]) -> PointModel:
    tree = document["tree"]
    n_edges = len(names) - 1
    return PointModel(
        names,
        tuple(
            Prototype(
                str(one["kind"]),
                float(one["weight"]),
                _finite(one["mean"]),
                _finite(one["modes"]),
                _finite(one["noise"]),
                float(one["log_size"]),
                float(one["log_size_sd"]),
            )
            for one in document["prototypes"]
        ),
        NeighbourTree(
            np.array(tree["edges"], np.int64).reshape(n_edges, 2),
            _finite(tree["log_lengths"]),
            _finite(tree["log_length_sds"]),
            _finite(tree["direction_costs"]).reshape(n_edges, *_cells(tree["direction_costs"])),
        ),
        bool(document["is_upright"]),
    )


def _cells(directions: list[Any]) -> tuple[int, int]:
    return (len(directions[0]), len(directions[0][0])) if directions else (1, 1)


def _finite(values: object) -> FloatArray:
    array = np.array(values, np.float64)
    if not np.isfinite(array).all():
        raise ValueError("a number is not finite")
    return array


def _rounded(array: FloatArray) -> Any:
    return np.round(array, DIGITS).tolist()


def _no_model(path: Path) -> FileError:
    return FileError(
        "{file} is no skeleton model. Choose a file that adibas skeleton train has written.",
        file=path.name,
    )
