"""Pieces of one board, parted by an arm: one lies on the rows and columns of the other."""

import numpy as np

from adibas.arrays import FloatArray, Int32Array
from adibas.calibration.corner_saddle_kernels import U, V
from adibas.calibration.grid_growth import Lattice
from adibas.calibration.homography import fit_homography

MOST_OFF = 0.25
"""Of a corner from the cell of the other piece, in squares: the lens over a gap of a few."""
WIDEST_GAP = 6
"""Rows or columns between two pieces; beyond, the extrapolation tells nothing."""


def join_all(lattices: list[Lattice]) -> list[Lattice]:
    """Return the lattices, each piece joined to the largest that it continues."""
    whole: list[Lattice] = []
    for piece in sorted(lattices, key=lambda lattice: -lattice.n_known):
        for i, larger in enumerate(whole):
            joined = _joined(larger, piece)
            if joined is not None:
                whole[i] = joined
                break
        else:
            whole.append(piece)
    return whole


def _joined(larger: Lattice, piece: Lattice) -> Lattice | None:
    """Return both as one, None unless `piece` continues the rows and columns of `larger`."""
    cells = _cells_on(larger, piece)
    if cells is None:
        return None
    known = piece.fields[~np.isnan(piece.fields[..., U])]
    own = np.argwhere(~np.isnan(piece.fields[..., U])).astype(np.int32)
    turn = _quarter(own, cells)
    if turn is None or not _same_colors(larger, piece, (own, cells), turn):
        return None
    size = np.array(larger.fields.shape[:2])
    low = np.minimum(cells.min(axis=0), 0)
    high = np.maximum(cells.max(axis=0) + 1, size)
    if (cells.min(axis=0) - size > WIDEST_GAP).any() or (cells.max(axis=0) < -WIDEST_GAP).any():
        return None
    fields = np.full((*(high - low), larger.fields.shape[2]), np.nan)
    fields[-low[0] : size[0] - low[0], -low[1] : size[1] - low[1]] = larger.fields
    rows, columns = (cells - low).T
    if not np.isnan(fields[rows, columns, U]).all():
        return None
    fields[rows, columns] = known
    return Lattice(fields, int((larger.parity + low.sum()) % 2))


def _cells_on(larger: Lattice, piece: Lattice) -> Int32Array | None:
    """Return (N, 2) the cells of `larger` where the corners of `piece` lie, None if between."""
    known = ~np.isnan(larger.fields[..., U])
    cells = np.argwhere(known)
    homography = fit_homography(
        larger.fields[known][:, [U, V]], cells.astype(float), is_refined=False
    )
    if homography is None:
        return None
    pixels = piece.fields[~np.isnan(piece.fields[..., U])][:, [U, V]]
    mapped = np.column_stack([pixels, np.ones(len(pixels))]) @ homography.T
    if (mapped[:, 2] * np.sign(mapped[0, 2]) <= 0).any():
        return None
    places: FloatArray = mapped[:, :2] / mapped[:, 2:]
    nearest = np.rint(places)
    if not (np.abs(places - nearest) <= MOST_OFF).all():
        return None
    return nearest.astype(np.int32)


def _quarter(own: Int32Array, cells: Int32Array) -> int | None:
    """Return how many quarter turns make `cells` of `own` rows and columns; None if none do."""
    moved = cells - cells[0]
    steps = own - own[0]
    for quarters in range(4):
        if np.array_equal(moved, steps):
            return quarters
        steps = np.column_stack([steps[:, 1], -steps[:, 0]])
    return None


def _same_colors(
    larger: Lattice, piece: Lattice, pair: tuple[Int32Array, Int32Array], quarters: int
) -> bool:
    """Return whether bright squares stay bright; a quarter turn exchanges the kinds of edges."""
    own, cells = pair
    kinds = (piece.is_first_along(own) + quarters) % 2
    return bool(np.array_equal(kinds, larger.is_first_along(cells)))
