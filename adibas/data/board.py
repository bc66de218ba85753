"""The chessboard that a camera is calibrated with, and its corners as an image shows them.

The board's frame has its origin in the first inner corner, x along the columns, y along the rows
and z into the board, away from a camera in front of it: such a camera sees x, y and z as right,
down and forward, turned in the image plane at most.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only

SMALLEST_SIDE = 3
LARGEST_SIDE = 100
MARK_OFFSETS = ((0, 0), (0, 1), (0, 2), (1, 0))
"""An L of four squares is its own image under no rotation and no reflection."""
MARK_RADIUS = 0.2
"""Of a dot in its square, as a share of the square's side."""


@dataclass(frozen=True, slots=True)
class Board:
    """A chessboard by its inner corners.

    Attributes
    ----------
    columns, rows : int
        Inner corners along x and along y; the board has one square more each way.
    square_m : float
        Side of one square.
    """

    columns: int
    rows: int
    square_m: float

    def __post_init__(self) -> None:
        for name, side in (("columns", self.columns), ("rows", self.rows)):
            if not SMALLEST_SIDE <= side <= LARGEST_SIDE:
                raise ValueError(f"{name} must be {SMALLEST_SIDE} to {LARGEST_SIDE}, got {side}")
        if not 0 < self.square_m < np.inf:
            raise ValueError(f"square_m must be positive, got {self.square_m}")

    @property
    def n_corners(self) -> int:
        """How many inner corners it has."""
        return self.columns * self.rows

    def points_m(self) -> FloatArray:
        """Return the (rows * columns, 3) corners in the board's frame, row by row, in metres."""
        row, column = np.divmod(np.arange(self.n_corners), self.columns)
        return np.stack([column, row, np.zeros_like(row)], axis=-1) * self.square_m

    def is_dark(self, row: int, column: int) -> bool:
        """Return whether the square is dark; (0, 0) is outside the first corner, and dark."""
        return (row + column) % 2 == 0

    def marked_squares(self) -> tuple[tuple[int, int], ...]:
        """Return (row, column) of the squares with a dot on a board that this program printed.

        The dot has the other colour. A board without dots serves as well, but its image does not
        tell whether the camera mirrors it.
        """
        row, column = (self.rows + 1) // 2 - 1, (self.columns + 1) // 2 - 1
        return tuple((row + down, column + right) for down, right in MARK_OFFSETS)


@dataclass(frozen=True, slots=True, eq=False)
class BoardCorners:
    """The corners of one board in one image.

    Attributes
    ----------
    image : str
        Name of the image, for the reader.
    width, height : int
        Its size in pixels.
    pixels : (rows * columns, 2) array
        (u, v) of every inner corner in the order of `Board.points_m`; NaN where it is hidden. The
        square outside the first corner is dark where the board has such a corner; of two, the
        one nearer to the image's top left.
    sigma_px : (rows * columns,) array
        Standard deviation of each coordinate by the finder's own account; NaN where hidden.
    is_mirrored : bool or None
        Whether the board's dots are those of its mirror image; None without dots.
    """

    image: str
    width: int
    height: int
    pixels: FloatArray
    sigma_px: FloatArray
    is_mirrored: bool | None = None

    def __post_init__(self) -> None:
        if self.width <= 0 or self.height <= 0:
            raise ValueError(f"image size must be positive: {self.width} x {self.height}")
        check_shape("pixels", self.pixels, (len(self.sigma_px), 2))
        is_hidden = np.isnan(self.pixels).any(axis=-1)
        if not np.array_equal(is_hidden, np.isnan(self.sigma_px)):
            raise ValueError("pixels and sigma_px must be NaN at the same corners")
        read_only(self.pixels)
        read_only(self.sigma_px)

    @property
    def n_seen(self) -> int:
        """How many corners the image shows."""
        return int(np.count_nonzero(~np.isnan(self.sigma_px)))
