"""A trained model of limbs: a forest, and what belongs to its labels."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from adibas.arrays import AnyArray, FloatArray, Int32Array, IntArray, check_shape, read_only
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
"""In a forest's provenance: labels of the model, and which of them each of the forest's is."""


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
    columns : (F,) int array
        Which of the K each label of the forest is.
    """

    labels: LimbLabels
    forest: Forest
    omega_2: Int32Array
    context: ContextNetwork | None
    columns: IntArray

    def __post_init__(self) -> None:
        n_labels = len(self.names)
        check_shape("omega_2", self.omega_2, (n_labels, n_labels))
        check_shape("columns", self.columns, (len(self.forest.labels),))
        read_only(self.omega_2)
        read_only(self.columns)

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
    columns = range(len(names)) if told is None else told["columns"]
    limbs = names[:-1] if names[-1] == CLUTTER and len(names) > 1 else names
    table = forest.provenance.get("omega_2")
    penalties = omega_2(names) if table is None else np.array(table, np.int32)
    return LimbModel(labels_named(limbs), forest, penalties, context, np.array(columns, np.int64))


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
    """Return the model of fewer labels: leaves say what training with these would have said.

    The splits stay those that were best for the labels before. With a context network, which
    needs what the forest says of all labels, probabilities are added up behind it instead.

    Parameters
    ----------
    model : LimbModel
        With the pixels of each label in its provenance, as training leaves them there.
    labels : LimbLabels
        Wanted.
    onto : mapping
        The new label of each old one; one that is missing keeps its name.
    """
    forest = model.forest
    names = (*labels.names, *((CLUTTER,) if model.has_clutter else ()))
    target = np.array([names.index(onto.get(name, name)) for name in forest.labels])
    if model.context is not None:
        told = {"labels": names, "columns": target.tolist()}
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


def _tree_of_leaf(forest: Forest) -> IntArray:
    """Return the tree of each leaf."""
    trees = np.searchsorted(forest.roots, np.arange(len(forest.child)), side="right") - 1
    is_leaf = forest.child < 0
    of_leaf = np.empty(len(forest.leaves), np.int64)
    of_leaf[-1 - forest.child[is_leaf]] = trees[is_leaf]
    return of_leaf
