"""A trained recogniser as a JSON file."""

import json
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, get_args

import numpy as np

from adibas.arrays import AnyArray
from adibas.errors import GestureError
from adibas.files import DAMAGED_JSON, written_whole
from adibas.gestures.descriptor import DESCRIBED_JOINTS, DescriptorParams
from adibas.gestures.hidden_markov import Chain, HiddenMarkov
from adibas.gestures.likeness import Likeness
from adibas.gestures.model import GestureModel, Judge, Method
from adibas.resources import resource_path
from adibas.timeseries.mixture_stream import MixtureModel

FORMAT, VERSION = "adibas-gestures", 1
DECIMALS = 4
"""Of a descriptor: a tenth of a millimetre on an adult."""


def shipped_gestures() -> Path:
    """Return where the model of five gestures lies that comes with the program."""
    return resource_path("models", "gestures.json")


def write_model(path: Path, model: GestureModel) -> None:
    """Write a model.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    with written_whole(path) as unfinished:
        unfinished.write_text(json.dumps(_document(model), allow_nan=False), "utf-8")


def read_model(path: Path) -> GestureModel:
    """Read a model.

    Raises
    ------
    GestureError
        The file is missing, no model, or of another descriptor or version.
    """
    try:
        document = json.loads(path.read_text("utf-8"))
    except (OSError, *DAMAGED_JSON) as error:
        raise GestureError(
            "{file} cannot be read: {reason}. Give a model that `adibas gestures train` wrote.",
            file=path.name,
            reason=getattr(error, "strerror", None) or str(error),
        ) from error
    _check_kind(path, document)
    try:
        return _model(document)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise GestureError(
            "{file} is damaged: a part of the model is missing or wrong. Train it again.",
            file=path.name,
        ) from error


def _check_kind(path: Path, document: Any) -> None:
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise GestureError(
            "{file} is no model of gestures. Give one that `adibas gestures train` wrote.",
            file=path.name,
        )
    if document.get("version") != VERSION:
        raise GestureError(
            "{file} was written by another version of ADiBAS. Train it again.", file=path.name
        )
    if document.get("joints") != list(DESCRIBED_JOINTS):
        raise GestureError(
            "{file} was trained on another descriptor: its joints are not the ones that are "
            "measured here. Train it again from the examples.",
            file=path.name,
        )
    if not _is_described_as_here(document):
        raise GestureError(
            "{file} was trained on another descriptor: its frames are described by other numbers "
            "than here. Train it again from the examples.",
            file=path.name,
        )


def _is_described_as_here(document: dict[str, Any]) -> bool:
    """Say whether all examples have the length that a frame's descriptor has by its settings."""
    settings, examples = document.get("descriptor"), document.get("examples")
    if not isinstance(settings, dict) or not isinstance(examples, list):
        return True  # a part is missing: damaged
    if set(settings) != {field.name for field in fields(DescriptorParams)}:
        return False
    try:
        n_numbers = DescriptorParams(**settings).n_numbers
        lengths = {len(frame) for example in examples for frame in example["frames"]}
    except (KeyError, TypeError, ValueError):
        return True
    return len(lengths) != 1 or lengths == {n_numbers}


def _document(model: GestureModel) -> dict[str, object]:
    return {
        "format": FORMAT,
        "version": VERSION,
        "method": model.method,
        "labels": list(model.labels),
        "joints": list(DESCRIBED_JOINTS),
        "descriptor": asdict(model.descriptor),
        "weights": _described_weights(model),
        "thresholds": model.thresholds.tolist(),
        "gates": [value if np.isfinite(value) else None for value in model.gates.tolist()],
        "examples": [
            {"label": model.labels[owner], "frames": _listed(frames)}
            for owner, frames in zip(model.owners, model.examples, strict=True)
        ],
        "judge": _described_judge(model.judge),
        "mixtures": [
            {
                "shares": one.shares.tolist(),
                "means": one.means.tolist(),
                "variances": one.variances.tolist(),
            }
            for one in model.mixtures
        ],
        "provenance": model.provenance,
    }


def _described_weights(model: GestureModel) -> dict[str, Any]:
    """Return the weights of the joints: of each gesture, or of all where they are the same."""
    rows = [dict(zip(DESCRIBED_JOINTS, row, strict=True)) for row in model.weights.tolist()]
    if all(row == rows[0] for row in rows):
        return rows[0]
    return dict(zip(model.labels, rows, strict=True))


def _described_judge(judge: Judge | None) -> dict[str, object] | None:
    if judge is None:
        return None
    if isinstance(judge, HiddenMarkov):
        return {
            "kind": "hmm",
            "mean": judge.mean.tolist(),
            "axes": judge.axes.tolist(),
            "chains": [
                {
                    "stay": chain.stay.tolist(),
                    "means": chain.means.tolist(),
                    "variances": chain.variances.tolist(),
                }
                for chain in judge.chains
            ],
        }
    return {
        "kind": "likeness",
        "segments": _listed(judge.segments),
        "coefficients": judge.coefficients.tolist(),
        "scales": judge.scales.tolist(),
    }


def _listed(array: AnyArray) -> Any:
    """Return nested lists; None where not seen."""
    listed = np.round(array, DECIMALS).astype(object)
    listed[~np.isfinite(array)] = None
    return listed.tolist()


def _array(listed: Any, n_dimensions: int) -> AnyArray:
    array = np.array(listed, np.float64)  # None turns to NaN
    if array.ndim != n_dimensions:
        raise ValueError("an array of the model has the wrong shape")
    return array


def _model(document: dict[str, Any]) -> GestureModel:
    labels = tuple(str(label) for label in document["labels"])
    method: Method = document["method"]
    descriptor = DescriptorParams(**document["descriptor"])
    if method not in get_args(Method) or not labels:
        raise ValueError("unknown method, or no labels")
    examples = tuple(_array(example["frames"], 2) for example in document["examples"])
    owners = [labels.index(example["label"]) for example in document["examples"]]
    if not examples or any(frames.shape[1] != descriptor.n_numbers for frames in examples):
        raise ValueError("examples do not fit the descriptor")
    gates = [np.inf if value is None else value for value in document["gates"]]
    stored = document["judge"]
    return GestureModel(
        method,
        labels,
        descriptor,
        examples,
        np.array(owners, np.int64),
        _weights(document["weights"], labels),
        _per_label(document["thresholds"], labels),
        _per_label(gates, labels),
        None if stored is None else _judge(stored, labels),
        dict(document["provenance"]),
        _mixtures(document.get("mixtures", ()), owners, method, descriptor),
    )


def _weights(stored: Any, labels: tuple[str, ...]) -> AnyArray:
    found = dict(stored)
    is_of_each = any(isinstance(value, dict) for value in found.values())
    rows = [found[label] if is_of_each else found for label in labels]
    return np.array([[row[joint] for joint in DESCRIBED_JOINTS] for row in rows], np.float64)


def _mixtures(
    stored: Any, owners: list[int], method: Method, descriptor: DescriptorParams
) -> tuple[MixtureModel, ...]:
    found = tuple(
        MixtureModel(_array(one["shares"], 2), _array(one["means"], 3), _array(one["variances"], 3))
        for one in stored
    )
    wanted = len(set(owners)) if method == "gmm-dtw" else 0
    if len(found) != wanted or any(one.means.shape[2] != descriptor.n_numbers for one in found):
        raise ValueError("a mixture for each label, of the descriptor's numbers")
    return found


def _per_label(values: Any, labels: tuple[str, ...]) -> AnyArray:
    array = _array(values, 1)
    if len(array) != len(labels):
        raise ValueError("one value a label")
    return array


def _judge(stored: dict[str, Any], labels: tuple[str, ...]) -> Judge:
    if stored["kind"] == "hmm":
        chains = tuple(
            Chain(
                _array(chain["stay"], 1), _array(chain["means"], 2), _array(chain["variances"], 2)
            )
            for chain in stored["chains"]
        )
        if len(chains) < len(labels):
            raise ValueError("a chain for each label")
        return HiddenMarkov(
            _array(stored["mean"], 1), _array(stored["axes"], 2), chains, len(labels)
        )
    segments = _array(stored["segments"], 3)
    coefficients = _array(stored["coefficients"], 2)
    if coefficients.shape != (len(segments), len(labels)):
        raise ValueError("coefficients do not fit the segments")
    return Likeness(segments, coefficients, _array(stored["scales"], 1))
