"""What a forest says of a person, and what a context network makes of it."""

import numpy as np

from adibas.arrays import AnyArray, Float32Array, UInt8Array
from adibas.context.examples import ContextExample
from adibas.context.sites import site_levels
from adibas.forests.forest import Forest
from adibas.limbs.cells import PersonCells, PersonView, person_cells, to_pixels
from adibas.limbs.model import LimbModel

N_PLACE_FEATURES = 3
"""Of a cell, beside what the forest says of it."""
_LEAST_SHARE = 0.02
"""Added to a forest's probabilities: it is never so sure."""
_USUAL_DISTANCE_M, _USUAL_THICKNESS_M = 4.0, 0.5


def limb_probabilities(view: PersonView, model: LimbModel) -> Float32Array:
    """Return (P, K) probabilities of the model's labels, pixels row by row.

    Where nothing is measured, all labels are as likely.
    """
    network = model.context
    cells = None if network is None else person_cells(view)
    if network is None:
        return forest_probabilities(view, model)
    if cells is None:
        n_pixels, n_labels = np.count_nonzero(view.pixels), len(model.names)
        return np.full((n_pixels, n_labels), 1.0 / n_labels, np.float32)
    levels = site_levels(cells.occupied, len(network.shape.widths))
    odds = network.log_odds(cell_features(view, model.forest, cells), levels)
    most = np.ascontiguousarray(odds.T).max(axis=0)  # along rows it takes seven times as long
    shares = np.exp(odds - most[:, None])
    shares /= shares.sum(axis=1, keepdims=True)
    return _merged(to_pixels(cells, shares, view), model)


def forest_probabilities(view: PersonView, model: LimbModel) -> Float32Array:
    """Return what `limb_probabilities` does where a model has no network."""
    told = model.forest.probabilities(view.depth_m, view.mask, view.focal_px, view.pixels)
    return _merged(told, model)


def _merged(told: Float32Array, model: LimbModel) -> Float32Array:
    if len(model.names) == told.shape[1]:
        return told
    merged: Float32Array = told @ model.onto
    merged /= merged.sum(axis=1, keepdims=True)
    return merged


def cell_features(view: PersonView, forest: Forest, cells: PersonCells) -> Float32Array:
    """Return (N, F + 3) features of cells: what the forest says, then depth and its quality."""
    said = forest.probabilities_at(view.depth_m, view.mask, view.focal_px, cells.pixel)
    distance = cells.distance_m / _USUAL_DISTANCE_M
    return np.column_stack(
        [
            0.5 * np.log(said + np.float32(_LEAST_SHARE)) + 1.0,
            cells.ahead_m / np.float32(_USUAL_THICKNESS_M),
            cells.measured,
            np.full(len(cells), distance, np.float32),
        ]
    ).astype(np.float32)


def context_example(
    depth_m: Float32Array, labels: UInt8Array, focal_px: float, forest: Forest
) -> ContextExample | None:
    """Return a person's cells with the labels that most of their pixels have; None without depth.

    Parameters
    ----------
    depth_m : (H, W) float32 array
    labels : (H, W) uint8 array
        Of the forest's labels, from 1; 0 beside the person.
    focal_px : float
    forest : Forest
        That was not trained on this image.
    """
    mask = labels > 0
    view = PersonView(depth_m, mask, mask, focal_px)
    cells = person_cells(view)
    if cells is None:
        return None
    rows, columns = np.nonzero(cells.occupied)
    return ContextExample(
        rows.astype(np.int16),
        columns.astype(np.int16),
        cell_features(view, forest, cells).astype(np.float16),
        *_two_most_frequent(depth_m, labels, cells, len(forest.labels)),
    )


def _two_most_frequent(
    depth_m: Float32Array, labels: UInt8Array, cells: PersonCells, n_labels: int
) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Return (N,) labels of cells from 0, the next most frequent ones, and what share these have.

    By measured pixels; -1 where there are none.
    """
    rows, columns = np.nonzero((labels > 0) & np.isfinite(depth_m))
    row = ((rows - cells.top) / cells.size_px).astype(np.intp)
    column = ((columns - cells.left) / cells.size_px).astype(np.intp)
    votes = np.zeros((len(cells), n_labels), np.int32)
    np.add.at(votes, (cells.numbers[row, column], labels[rows, columns] - 1), 1)
    number = np.arange(len(cells))
    first = votes.argmax(axis=1)
    n_first = votes[number, first]
    votes[number, first] = 0
    second = votes.argmax(axis=1)
    n_second = votes[number, second]
    share = n_second / np.maximum(n_first + n_second, 1)
    return (
        np.where(n_first > 0, first, -1).astype(np.int8),
        np.where(n_second > 0, second, first).astype(np.int8),
        share.astype(np.float16),
    )
