"""A person as square cells of one size on the body, near or far, and the way back to pixels."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from adibas.arrays import (
    BoolArray,
    Float32Array,
    FloatArray,
    Int32Array,
    IntArray,
    check_shape,
    read_only,
)
from adibas.kernels import compiled, compiled_parallel, parallel_range

CELL_M = 0.02
"""Size of a cell, at the person's median distance."""


class PersonView(NamedTuple):
    """A person in a depth image.

    Attributes
    ----------
    depth_m : (H, W) float32 array
        NaN where not measured.
    mask : (H, W) bool array
        The person.
    pixels : (H, W) bool array
        The P of them that are labelled: all, or those of every `step`-th row and column.
    focal_px : float
    step : int
    """

    depth_m: Float32Array
    mask: BoolArray
    pixels: BoolArray
    focal_px: float
    step: int = 1

    def places(self) -> tuple[IntArray, IntArray]:
        """Return the (P,) rows and columns of the pixels that are labelled, row by row."""
        # `numpy.nonzero` takes four times as long.
        rows, columns = np.divmod(np.flatnonzero(self.pixels), self.pixels.shape[1])
        return rows, columns


@dataclass(frozen=True, slots=True, eq=False)
class PersonCells:
    """The N cells in which a person has pixels, row by row.

    Attributes
    ----------
    numbers : (h, w) int32 array
        Of each place; N where no cell is.
    pixel : (N,) int64 array
        The pixel that stands for each, in the flat image: the measured one nearest to the middle,
        or the nearest of all.
    ahead_m : (N,) float32 array
        Mean depth in the cell less the person's; 0 where nothing is measured.
    measured : (N,) float32 array
        Share of its pixels that are measured.
    distance_m : float
        Median depth of the person.
    top, left, size_px : float
        Where the first cell begins, from the middle of the image's first pixel, and how large a
        cell is, pixels.
    """

    numbers: Int32Array
    pixel: IntArray
    ahead_m: Float32Array
    measured: Float32Array
    distance_m: float
    top: float
    left: float
    size_px: float

    def __post_init__(self) -> None:
        n_cells = len(self.pixel)
        check_shape("ahead_m", self.ahead_m, (n_cells,))
        check_shape("measured", self.measured, (n_cells,))
        for array in (self.numbers, self.pixel, self.ahead_m, self.measured):
            read_only(array)

    def __len__(self) -> int:
        return len(self.pixel)

    @property
    def occupied(self) -> BoolArray:
        """Return (h, w): where cells are."""
        return np.asarray(self.numbers < len(self))


def person_cells(view: PersonView) -> PersonCells | None:
    """Return the cells of a person, no smaller than its step; None where nothing is measured."""
    rows, columns = view.places()
    depths_m = view.depth_m[rows, columns]
    known = depths_m[np.isfinite(depths_m)]
    if not len(known):
        return None
    distance_m = float(np.median(known))
    size_px = max(CELL_M * view.focal_px / distance_m, float(view.step))
    top, left = rows.min() - 0.5 * view.step, columns.min() - 0.5 * view.step
    shape = (int((rows.max() - top) / size_px) + 1, int((columns.max() - left) / size_px) + 1)
    counts, sums_m, pixel = _gathered(
        rows,
        columns,
        depths_m,
        np.array([top, left, size_px]),
        np.array([*shape, view.pixels.shape[1]]),
    )
    here = counts[:, :, 0] > 0
    numbers = np.full(shape, np.count_nonzero(here), np.int32)
    numbers[here] = np.arange(np.count_nonzero(here), dtype=np.int32)
    n_all, n_measured = counts[here].T
    ahead_m = np.where(n_measured > 0, sums_m[here] / np.maximum(n_measured, 1) - distance_m, 0.0)
    return PersonCells(
        numbers,
        pixel[here],
        ahead_m.astype(np.float32),
        (n_measured / n_all).astype(np.float32),
        distance_m,
        float(top),
        float(left),
        size_px,
    )


@compiled
def _gathered(
    rows: IntArray, columns: IntArray, depths_m: Float32Array, place: Float32Array, sizes: IntArray
) -> tuple[IntArray, Float32Array, IntArray]:
    """Return (h, w, 2) pixels, all and measured, (h, w) sums of depth, (h, w) pixel that stands."""
    top, left, size_px = place
    height, width, image_width = sizes
    counts = np.zeros((height, width, 2), np.int64)
    sums_m = np.zeros((height, width))
    pixel = np.zeros((height, width), np.int64)
    gaps = np.full((height, width), np.inf)
    for number in range(len(rows)):
        down, right = (rows[number] - top) / size_px, (columns[number] - left) / size_px
        row, column = int(down), int(right)
        counts[row, column, 0] += 1
        gap = max(abs(down - row - 0.5), abs(right - column - 0.5))
        if np.isfinite(depths_m[number]):
            counts[row, column, 1] += 1
            sums_m[row, column] += depths_m[number]
        else:
            gap += 1.0
        if gap < gaps[row, column]:
            gaps[row, column] = gap
            pixel[row, column] = rows[number] * image_width + columns[number]
    return counts, sums_m, pixel


def to_pixels(cells: PersonCells, values: Float32Array, view: PersonView) -> Float32Array:
    """Return (P, K) values of pixels, row by row, between those of the cells around.

    Where one limb is before another, a pixel is asked how deep it lies: of the cells around those
    of its own depth count. A gap of one cell's size, as between cells of a surface at 45 degrees,
    counts half. Source: Kopf et al., Joint Bilateral Upsampling, SIGGRAPH 2007, equation 3, with
    Cauchy's function of the gap, by which no cell counts nothing.

    Parameters
    ----------
    cells : PersonCells
    values : (N, K) float32 array
        Of the middles of cells.
    view : PersonView
        Of whose P pixels the cells were made. One without depth takes what lies between.
    """
    rows, columns = view.places()
    place = np.array([cells.top, cells.left, cells.size_px])
    ahead_m = view.depth_m[rows, columns] - np.float32(cells.distance_m)
    is_measured = cells.measured > 0
    cells_ahead_m = np.where(is_measured, cells.ahead_m, np.float32(np.inf))
    given = np.ascontiguousarray(values)
    return _between(rows, columns, ahead_m, place, cells.numbers, cells_ahead_m, given)


@compiled_parallel
def _between(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    rows: IntArray,
    columns: IntArray,
    ahead_m: Float32Array,
    place: FloatArray,
    numbers: Int32Array,
    cells_ahead_m: Float32Array,
    values: Float32Array,
) -> Float32Array:
    top, left, size_px = place
    n_cells, n_values = values.shape
    found = np.zeros((len(rows), n_values), np.float32)
    for pixel in parallel_range(len(rows)):
        down = (rows[pixel] - top) / size_px - 0.5
        right = (columns[pixel] - left) / size_px - 0.5
        first_row, first_column = int(np.floor(down)), int(np.floor(right))
        total = 0.0
        for row in range(max(first_row, 0), min(first_row + 2, numbers.shape[0])):
            for column in range(max(first_column, 0), min(first_column + 2, numbers.shape[1])):
                number = numbers[row, column]
                if number == n_cells:
                    continue
                weight = (1.0 - abs(down - row)) * (1.0 - abs(right - column))
                if np.isfinite(ahead_m[pixel]):
                    gap = (ahead_m[pixel] - cells_ahead_m[number]) / CELL_M
                    weight /= 1.0 + gap * gap
                total += weight
                for value in range(n_values):
                    found[pixel, value] += np.float32(weight) * values[number, value]
        for value in range(n_values):
            found[pixel, value] /= np.float32(total)
    return found
