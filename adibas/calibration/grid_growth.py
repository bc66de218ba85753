"""Grids from neighbours: put corners into rows and columns, drop strays, fill in and go on."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, Int32Array
from adibas.calibration.corner_saddle_kernels import CONTRAST, SCALE, U, V
from adibas.calibration.corners import CornerParams, Pyramid, seek_corners
from adibas.calibration.grid_growth_kernels import choose, frontier, step_px, strays


@dataclass(frozen=True, slots=True)
class GrowthParams:
    """How a grid grows.

    Attributes
    ----------
    fewest_linked : int
        Corners that have to know each other by their edges before the grid is looked at.
    fewest : int
        Corners of a grid worth reporting.
    most_stray : float
        Of a corner from where its neighbours expect it, in squares, before the fit.
    most_fitted_stray : float
        After it, beside three standard deviations; 0.04 is seen of true corners on boards tilted
        by 65 degrees and by strong lenses.
    search : float
        Around the place where a corner is expected, in squares.
    most_rounds : int
        Rows or columns added on each side at most.
    smallest_square_px : float
        Narrower squares are blurred into each other.
    """

    fewest_linked: int = 6
    fewest: int = 9
    most_stray: float = 0.2
    most_fitted_stray: float = 0.06
    search: float = 0.25
    most_rounds: int = 12
    smallest_square_px: float = 3.5


@dataclass(slots=True, eq=False)
class Lattice:
    """A grid that grows.

    Attributes
    ----------
    fields : (R, C, N_FIELDS) array
        The corners as the finder describes them; NaN where none is known.
    parity : int
        0 if the first corner's edge along its row is the FIRST kind (bright below it), else 1.
    """

    fields: FloatArray
    parity: int

    @property
    def pixels(self) -> FloatArray:
        """(R, C, 2) of the corners, contiguous."""
        return np.ascontiguousarray(self.fields[..., [U, V]])

    @property
    def n_known(self) -> int:
        """How many corners it has."""
        return int(np.count_nonzero(~np.isnan(self.fields[..., U])))

    def cropped(self) -> "Lattice":
        """Return it without empty outer rows and columns."""
        rows, columns = np.nonzero(~np.isnan(self.fields[..., U]))
        if len(rows) == 0:
            return Lattice(self.fields[:0, :0], 0)
        top, left = int(rows.min()), int(columns.min())
        return Lattice(
            self.fields[top : rows.max() + 1, left : columns.max() + 1].copy(),
            (self.parity + top + left) % 2,
        )

    def padded(self) -> "Lattice":
        """Return it with an empty row and column on each side."""
        fields = np.pad(self.fields, ((1, 1), (1, 1), (0, 0)), constant_values=np.nan)
        return Lattice(fields, self.parity)

    def is_first_along(self, cells: Int32Array) -> Int32Array:
        """Return (N,) 1 where the row's edge at a cell is the FIRST kind, else 0."""
        kinds: Int32Array = ((self.parity + cells.sum(axis=1) + 1) % 2).astype(np.int32)
        return kinds


def lattices(corners: FloatArray, labels: Int32Array, params: GrowthParams) -> list[Lattice]:
    """Return the grids among labelled corners, the largest first."""
    counts = np.bincount(labels[labels[:, 0] >= 0, 0]) if len(labels) else np.empty(0, int)
    order = np.argsort(-counts, kind="stable")
    found = (
        _lattice(corners[labels[:, 0] == n], labels[labels[:, 0] == n])
        for n in order
        if counts[n] >= params.fewest_linked
    )
    return [tidied(lattice, params) for lattice in found]


def _lattice(corners: FloatArray, labels: Int32Array) -> Lattice:
    rows, columns = labels[:, 1] - labels[:, 1].min(), labels[:, 2] - labels[:, 2].min()
    parity = int((labels[0, 3] + rows[0] + columns[0]) % 2)
    fields = np.full((rows.max() + 1, columns.max() + 1, corners.shape[1]), np.nan)
    is_sound = (labels[:, 3] + rows + columns) % 2 == parity
    cells = rows * fields.shape[1] + columns
    is_alone = np.bincount(cells)[cells] == 1  # two corners in one cell: a false link on the way
    keep = is_sound & is_alone
    fields[rows[keep], columns[keep]] = corners[keep]
    return Lattice(fields, parity)


def tidied(lattice: Lattice, params: GrowthParams) -> Lattice:
    """Return it without the corners that lie where their neighbours do not expect them."""
    while lattice.n_known:
        largest = np.full(lattice.fields.shape[:2], params.most_stray)
        is_stray = np.isposinf(strays(lattice.pixels, largest))
        if not is_stray.any():
            break
        lattice.fields[is_stray] = np.nan
        lattice = lattice.cropped()
    return lattice


def grown(
    lattice: Lattice,
    corners: FloatArray,
    pyramid: Pyramid,
    params: GrowthParams,
    corner_params: CornerParams,
) -> Lattice:
    """Return it with what `corners` and the image show where further corners are expected."""
    for _ in range(params.most_rounds):
        wider = lattice.padded()
        cells, expectations = frontier(wider.pixels, params.smallest_square_px)
        if len(cells) == 0:
            break
        is_first = wider.is_first_along(cells)
        found = _found(corners, expectations, is_first, params)
        is_left = np.isnan(found[:, U])
        if is_left.any():
            sought = _sought(wider, pyramid, expectations[is_left], corner_params)
            kind = np.ascontiguousarray(is_first[is_left])
            found[is_left] = _own(sought, expectations[is_left], kind, params)
        found[found[:, CONTRAST] < 0.3 * np.nanmedian(wider.fields[..., CONTRAST])] = np.nan
        wider.fields[cells[:, 0], cells[:, 1]] = found
        lattice_now = tidied(wider.cropped(), params)
        if lattice_now.n_known <= lattice.n_known:
            return lattice_now if lattice_now.n_known == lattice.n_known else lattice
        lattice = lattice_now
    return lattice


def _found(
    corners: FloatArray, expectations: FloatArray, is_first: Int32Array, params: GrowthParams
) -> FloatArray:
    """Return the candidate at each place, NaN without one."""
    chosen = choose(corners, expectations, is_first, params.search)
    found = np.full((len(expectations), corners.shape[1]), np.nan)
    found[chosen >= 0] = corners[chosen[chosen >= 0]]
    return found


def _sought(
    lattice: Lattice, pyramid: Pyramid, expectations: FloatArray, params: CornerParams
) -> FloatArray:
    """Return what the image shows at places without a candidate, looking more leniently."""
    widths_px = np.array([step_px(expectation) for expectation in expectations])
    places = np.column_stack([expectations[:, :2], 0.45 * widths_px])
    scale = float(np.nanmedian(lattice.fields[..., SCALE]))
    return seek_corners(pyramid, places, scale, params)


def _own(
    sought: FloatArray, expectations: FloatArray, is_first: Int32Array, params: GrowthParams
) -> FloatArray:
    """Return each place's own corner, NaN where it does not fit there."""
    result = np.full_like(sought, np.nan)
    for i in np.flatnonzero(~np.isnan(sought[:, U])):
        chosen = choose(
            sought[i : i + 1], expectations[i : i + 1], is_first[i : i + 1], params.search
        )
        if chosen[0] >= 0:
            result[i] = sought[i]
    return result
