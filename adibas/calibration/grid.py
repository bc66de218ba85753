"""A chessboard as an image shows it, before anyone says which board it is."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray, check_shape, read_only


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """X-corners in rows and columns; columns run to the right of the image, rows down.

    Turned by less than 45 degrees either way, seen from the camera, never mirrored.

    Attributes
    ----------
    pixels : (R, C, 2) array
        (u, v) of the corners; NaN where one is hidden. Some corner of each outer row and column
        is seen.
    sigma_px : (R, C) array
        Standard deviation of each coordinate; NaN where hidden.
    is_origin_dark : bool
        Whether the square outside the first corner is dark.
    dots : (R - 1, C - 1) bool array
        Squares between four corners that have a dot of the other colour.
    """

    pixels: FloatArray
    sigma_px: FloatArray
    is_origin_dark: bool
    dots: BoolArray

    def __post_init__(self) -> None:
        check_shape("pixels", self.pixels, (self.rows, self.columns, 2))
        check_shape("dots", self.dots, (self.rows - 1, self.columns - 1))
        for array in (self.pixels, self.sigma_px, self.dots):
            read_only(array)

    @property
    def rows(self) -> int:
        """How many rows of corners it has."""
        return int(self.sigma_px.shape[0])

    @property
    def columns(self) -> int:
        """How many columns of corners it has."""
        return int(self.sigma_px.shape[1])

    @property
    def n_seen(self) -> int:
        """How many corners are seen."""
        return int(np.count_nonzero(~np.isnan(self.sigma_px)))

    @property
    def square_px(self) -> float:
        """Median side of a square in the image; NaN without two neighbours."""
        sides = [np.linalg.norm(np.diff(self.pixels, axis=axis), axis=-1) for axis in (0, 1)]
        known = np.concatenate([side[~np.isnan(side)] for side in sides])
        return float(np.median(known)) if len(known) else float("nan")

    @property
    def corner_is_dark(self) -> tuple[bool, bool, bool, bool]:
        """Whether the squares outside the first, the two next and the last corner are dark.

        In the order top left, top right, bottom left, bottom right.
        """
        turns = (0, self.columns, self.rows, self.rows + self.columns)
        first, second, third, fourth = ((self.is_origin_dark + turn) % 2 == 1 for turn in turns)
        return first, second, third, fourth

    def turned(self, quarters: int) -> "Grid":
        """Return the same corners counted after `quarters` quarter turns of the rows."""
        quarters %= 4
        # The corners of the first column stand first after one turn, those of the last row after.
        dark = self.corner_is_dark[(0, 1, 3, 2)[quarters]]
        return Grid(
            np.rot90(self.pixels, quarters).copy(),
            np.rot90(self.sigma_px, quarters).copy(),
            dark,
            np.rot90(self.dots, quarters).copy(),
        )

    def trimmed(self, rows: slice, columns: slice) -> "Grid":
        """Return the corners of some rows and columns alone."""
        skipped = (rows.start or 0) + (columns.start or 0)
        n_rows = len(range(*rows.indices(self.rows)))
        n_columns = len(range(*columns.indices(self.columns)))
        first = rows.start or 0, columns.start or 0
        return Grid(
            self.pixels[rows, columns].copy(),
            self.sigma_px[rows, columns].copy(),
            self.is_origin_dark if skipped % 2 == 0 else not self.is_origin_dark,
            self.dots[first[0] : first[0] + n_rows - 1, first[1] : first[1] + n_columns - 1].copy(),
        )
