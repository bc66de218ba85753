"""A trained model of limbs: a forest, and what belongs to its labels."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from adibas.arrays import (
    AnyArray,
    Float32Array,
    FloatArray,
    Int32Array,
    IntArray,
    check_shape,
    read_only,
)
from adibas.context.files import SHAPE, network_arrays, network_of
from adibas.context.network import ContextNetwork
from adibas.data.limbs import LimbLabels, labels_named
from adibas.errors import FileError, LimbError
from adibas.files import DAMAGED_ARRAYS
from adibas.forests.files import load_forest_and, save_forest
from adibas.forests.forest import Forest
from adibas.limbs.penalties import omega_2

CLUTTER = "clutter"
"""The last label of a forest that knows what is no limb: furniture, floor, wall."""
_MERGED = "merged"
"""In a forest's provenance: labels of the model, which each of the forest's is, and its weight."""
CONTEXT = "context"
"""In a forest's provenance: how the network was trained."""
LABEL_SHARES = "label_shares"
"""In what is told of the network: of the cells that it was trained on."""


@dataclass(frozen=True, slots=True, eq=False)
class LimbModel:
    """What segments limbs.

    Attributes
    ----------
    labels : LimbLabels
        The L limbs.
    forest : Forest
        Of F labels: the same ones, perhaps with `CLUTTER` behind them, or finer ones.
    omega_2 : (K, K) int32 array
        Table of equation 6.25; K labels, with `CLUTTER`.
    context : ContextNetwork or None
        Corrects what the forest says by what is around.
    onto : (F, K) float32 array
        What a probability of each of the forest's labels counts for the K; one of them each.
    """

    labels: LimbLabels
    forest: Forest
    omega_2: Int32Array
    context: ContextNetwork | None
    onto: Float32Array

    def __post_init__(self) -> None:
        n_labels = len(self.names)
        check_shape("omega_2", self.omega_2, (n_labels, n_labels))
        check_shape("onto", self.onto, (len(self.forest.labels), n_labels))
        read_only(self.omega_2)
        read_only(self.onto)

    @property
    def names(self) -> tuple[str, ...]:
        """Return the K labels: the limbs, and `CLUTTER` where the model knows it."""
        return (*self.labels.names, *((CLUTTER,) if self.has_clutter else ()))

    @property
    def has_clutter(self) -> bool:
        """Say whether the model knows what is no limb."""
        return self.forest.labels[-1] == CLUTTER and len(self.forest.labels) > 1

    @property
    def created_utc(self) -> str:
        """Return when its training ended, as its provenance has it; "" where it has not."""
        return str(self.forest.provenance.get("created_utc", ""))

    def is_made(self, created_utc: object) -> bool:
        """Say whether this is the model that was made then."""
        return self.created_utc != "" and self.created_utc == created_utc

    def require(self, labels: LimbLabels) -> None:
        """See that the model is for these labels.

        Raises
        ------
        LimbError
            It is for others.
        """
        if self.labels != labels:
            raise LimbError(
                "The model is for other limbs ({found}), and {wanted} are needed. Choose a model "
                "that was trained for these.",
                found=self.labels.name,
                wanted=labels.name,
            )


def model_of(forest: Forest, context: ContextNetwork | None = None) -> LimbModel:
    """Return the model of a forest; what its provenance says of labels and table, or ours."""
    told: Any = forest.provenance.get(_MERGED)
    names = forest.labels if told is None else tuple(told["labels"])
    n_found = len(forest.labels)
    onto = np.zeros((n_found, len(names)), np.float32)
    columns = range(n_found) if told is None else told["columns"]
    onto[np.arange(n_found), columns] = 1.0 if told is None else told["weights"]
    limbs = names[:-1] if names[-1] == CLUTTER and len(names) > 1 else names
    table = forest.provenance.get("omega_2")
    penalties = omega_2(names) if table is None else np.array(table, np.int32)
    return LimbModel(labels_named(limbs), forest, penalties, context, onto)


def load_model(path: Path) -> LimbModel:
    """Read a model.

    Raises
    ------
    FileError
        The file is missing, damaged, of another format or of a later version.
    """
    forest, context = load_forest_and(path, _context_of)
    try:
        return model_of(forest, context)
    except DAMAGED_ARRAYS as error:
        raise FileError(
            "{file} is no model of limbs, or it is damaged. Choose a file that adibas limbs train "
            "wrote.",
            file=path.name,
        ) from error


def _context_of(arrays: Mapping[str, AnyArray]) -> ContextNetwork | None:
    return network_of(arrays) if SHAPE in arrays else None


def save_model(model: LimbModel, path: Path) -> None:
    """Write a model to `path`, its table in the provenance; whole or not at all.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    table = {"omega_2": model.omega_2.tolist()}
    forest = replace(model.forest, provenance={**model.forest.provenance, **table})
    save_forest(forest, path, None if model.context is None else network_arrays(model.context))


def merged(model: LimbModel, labels: LimbLabels, onto: Mapping[str, str]) -> LimbModel:
    """Return the model of fewer labels: it says what training with these would have said.

    The splits stay those that were best for the labels before. A context network needs what the
    forest says of all labels: what it says is added up behind it.

    Parameters
    ----------
    model : LimbModel
        With the pixels of each label in its provenance, and with the shares of the cells that a
        network was trained on, as training leaves them there.
    labels : LimbLabels
        Wanted.
    onto : mapping
        The new label of each old one; one that is missing keeps its name.
    """
    forest = model.forest
    names = (*labels.names, *((CLUTTER,) if model.has_clutter else ()))
    target = np.array([names.index(onto.get(name, name)) for name in forest.labels])
    if model.context is not None:
        weights = _weights_behind(forest.provenance[CONTEXT], target)
        told = {"labels": names, "columns": target.tolist(), "weights": weights.tolist()}
        table = {"omega_2": omega_2(names).tolist(), "merged_from": model.labels.name}
        provenance = {**forest.provenance, **table, _MERGED: told}
        return model_of(replace(forest, provenance=provenance), model.context)
    pixels = np.array(forest.provenance["label_pixels"], float)
    moved = np.zeros((len(target), len(names)))
    moved[np.arange(len(target)), target] = 1.0
    weights = pixels[_tree_of_leaf(forest)]
    shares: FloatArray = (forest.leaves * weights) @ moved / np.maximum(weights @ moved, 1.0)
    shares /= shares.sum(axis=1, keepdims=True)
    provenance = {
        **forest.provenance,
        "label_pixels": (pixels @ moved).astype(int).tolist(),
        "merged_from": model.labels.name,
        "omega_2": omega_2(names).tolist(),
    }
    return model_of(
        replace(forest, labels=names, leaves=shares.astype(np.float32), provenance=provenance)
    )


def _weights_behind(trained: Any, target: IntArray) -> FloatArray:
    """Return (F,) weights of what a network says of a label, in a sum over labels merged.

    Trained with weights ``P(l) ** -e``, evenness e and shares P, it says ``q(l|x)`` in proportion
    to ``P(x|l) P(l) ** (1 - e)``. Of a sum c of labels the same training would have said
    ``P(x|c) P(c) ** (1 - e)``, and ``P(x|c) P(c)`` is the sum of ``P(x|l) P(l)``: so ``q(l|x)``
    counts ``(P(l) / P(c)) ** e``.
    """
    shares: FloatArray = np.array(trained[LABEL_SHARES], float)
    of_sum = np.bincount(target, weights=shares)[target]
    return np.asarray((shares / of_sum) ** float(trained["params"]["evenness"]))


def _tree_of_leaf(forest: Forest) -> IntArray:
    """Return the tree of each leaf."""
    trees = np.searchsorted(forest.roots, np.arange(len(forest.child)), side="right") - 1
    is_leaf = forest.child < 0
    of_leaf = np.empty(len(forest.leaves), np.int64)
    of_leaf[-1 - forest.child[is_leaf]] = trees[is_leaf]
    return of_leaf
