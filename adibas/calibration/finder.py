"""Find chessboards in an image, and a given board among them."""

from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from adibas.arrays import FloatArray, UInt8Array, check_shape
from adibas.calibration.corner_saddle_kernels import CONTRAST
from adibas.calibration.corners import (
    CornerParams,
    FitParams,
    Pyramid,
    as_gray,
    build_pyramid,
    find_corners,
)
from adibas.calibration.grid import Grid
from adibas.calibration.grid_dots import find_dots
from adibas.calibration.grid_fit import fit_lattice
from adibas.calibration.grid_growth import (
    GrowthParams,
    Lattice,
    grown,
    lattices,
)
from adibas.calibration.grid_growth_kernels import strays
from adibas.calibration.grid_joining import join_all
from adibas.calibration.grid_link_kernels import label_grids, link_all
from adibas.calibration.grid_placement import Placement, place, without_weak_edges
from adibas.data.board import SMALLEST_SIDE, Board, BoardCorners
from adibas.texts import Message, message

__all__ = [
    "BoardProblem",
    "BoardSearch",
    "FinderParams",
    "as_gray",
    "find_board",
    "find_boards",
    "search_board",
]


SAME_PX = 2.0
"""Two candidates so near are one corner."""


ROUGH_PX = 0.5
"""Standard deviation of a saddle's place before the fit, as seen on blurred boards."""


@dataclass(frozen=True, slots=True)
class FinderParams:
    """How boards are found.

    Attributes
    ----------
    corners, growth, fit
        Of the steps.
    longest_share : float
        Of the image's longer side: a square is not longer, or no three corners fit a row.
    fewest_share : float
        Of the board's corners; fewer say little about its place.
    most_shares : float
        Of the board's corners; a grid with more is another board or a shirt, and not fitted.
    like_share : float
        Of the larger board's squares: a second board with smaller ones is a picture of a board
        or lies far behind, and does not make the search doubtful.
    """

    corners: CornerParams = field(default_factory=CornerParams)
    growth: GrowthParams = field(default_factory=GrowthParams)
    fit: FitParams = field(default_factory=FitParams)
    longest_share: float = 0.5
    fewest_share: float = 0.35
    most_shares: float = 3.0
    like_share: float = 0.4


class BoardProblem(Enum):
    """Why an image gives no corners of a board."""

    NO_BOARD = "no board"
    ANOTHER_SIZE = "another size"
    PARTLY_SEEN = "partly seen"
    TOO_FEW = "too few corners"
    TWO_BOARDS = "two boards"


TEXTS: dict[BoardProblem, Message] = {
    BoardProblem.NO_BOARD: message("No chessboard is seen. Hold it in view, in even light."),
    BoardProblem.ANOTHER_SIZE: message(
        "A board of {columns} x {rows} inner corners is seen, not of {wanted_columns} x "
        "{wanted_rows}. Choose its size, or hold the right board."
    ),
    BoardProblem.PARTLY_SEEN: message(
        "Only {columns} x {rows} inner corners of the board are seen. Hold it so that every row "
        "and column is in view."
    ),
    BoardProblem.TOO_FEW: message(
        "Only {seen} of the board's {wanted} inner corners are seen. Uncover it."
    ),
    BoardProblem.TWO_BOARDS: message("Two boards of this size are in view. Take one away."),
}


@dataclass(frozen=True, slots=True, eq=False)
class BoardSearch:
    """What a search for a board came to.

    Attributes
    ----------
    corners : BoardCorners or None
        None where there is a problem.
    problem : BoardProblem or None
        Why there are none; `TEXTS` has the sentence.
    fields : dict
        What stands at the places of that sentence.
    """

    corners: BoardCorners | None
    problem: BoardProblem | None = None
    fields: dict[str, int] = field(default_factory=dict)


def find_boards(gray: UInt8Array, params: FinderParams | None = None) -> tuple[Grid, ...]:
    """Find every chessboard of any size in an image.

    Parameters
    ----------
    gray : (H, W) array
        Brightness, 0-255; see `as_gray`.
    params : FinderParams, optional
        Of the steps.

    Returns
    -------
    grids : tuple of Grid
        The one with most corners first; at least 3 x 3 corners each.
    """
    return _find(gray, params or FinderParams(), np.inf)


def find_board(
    gray: UInt8Array, board: Board, image: str, params: FinderParams | None = None
) -> BoardCorners | None:
    """Return the corners of `board` in the image called `image`; None where it is not found."""
    return search_board(gray, board, image, params).corners


def search_board(
    gray: UInt8Array, board: Board, image: str, params: FinderParams | None = None
) -> BoardSearch:
    """Find one board in an image, or say why there is none.

    Parameters
    ----------
    gray : (H, W) array
        Brightness, 0-255; see `as_gray`.
    board : Board
        What to look for; boards of other sizes are passed over.
    image : str
        Name of the image.
    params : FinderParams, optional
        Of the steps.

    Returns
    -------
    search : BoardSearch
        Corners in the order of `Board.points_m`, or a problem.
    """
    params = params or FinderParams()
    largest = params.most_shares * board.n_corners
    grids = [without_weak_edges(grid, board) for grid in _find(gray, params, largest)]
    placed = [placement for grid in grids if (placement := place(grid, board)) is not None]
    placed.sort(key=lambda placement: -placement.grid.square_px)
    if not placed:
        return _why_none(grids, board, gray.shape)
    best = placed[0]
    rivals = [p for p in placed[1:] if p.grid.square_px > params.like_share * best.grid.square_px]
    if rivals:
        return BoardSearch(None, BoardProblem.TWO_BOARDS)
    if best.grid.n_seen < params.fewest_share * board.n_corners:
        fields = {"seen": best.grid.n_seen, "wanted": board.n_corners}
        return BoardSearch(None, BoardProblem.TOO_FEW, fields)
    return BoardSearch(_board_corners(best, board, image, gray.shape))


def _find(gray: UInt8Array, params: FinderParams, largest: float) -> tuple[Grid, ...]:
    """Return the grids of an image; those of more than `largest` corners are left unfitted."""
    check_shape("gray", gray, (None, None))
    gray = np.ascontiguousarray(gray, np.uint8)
    pyramid = build_pyramid(gray)
    if not pyramid:
        return ()
    found = _lattices(pyramid, max(gray.shape), params)
    grids = [
        _grid(lattice, gray, pyramid, params)
        if lattice.n_known <= largest
        else _upright(_rough_grid(lattice))
        for lattice in found
    ]
    worth = [grid for grid in grids if grid is not None]
    return tuple(sorted(worth, key=lambda grid: -grid.n_seen))


def _rough_grid(lattice: Lattice) -> Grid:
    """Return the grid as it was before the fit."""
    sigma_px = np.where(np.isnan(lattice.fields[..., 0]), np.nan, ROUGH_PX)
    dots = np.zeros(np.subtract(sigma_px.shape, 1), np.bool_)
    return Grid(lattice.pixels, sigma_px, lattice.parity == 1, dots)


def _lattices(pyramid: Pyramid, longer_side: int, params: FinderParams) -> list[Lattice]:
    """Return the grids of an image that are large enough, no corner in two of them."""
    corners = find_corners(pyramid, params.corners)
    links = link_all(corners, pyramid[0], params.longest_share * longer_side)
    pieces: list[Lattice] = []
    for seed in lattices(corners, label_grids(corners, links), params.growth):
        if seed.n_known >= params.growth.fewest_linked and not _is_known(seed, pieces):
            pieces.append(grown(seed, corners, pyramid, params.growth, params.corners))
    whole = join_all(pieces)
    if len(whole) < len(pieces):
        whole = [grown(one, corners, pyramid, params.growth, params.corners) for one in whole]
    return [
        lattice
        for lattice in whole
        if lattice.n_known >= params.growth.fewest
        and min(lattice.fields.shape[:2]) >= SMALLEST_SIDE
    ]


def _is_known(seed: Lattice, found: list[Lattice]) -> bool:
    """Return whether a grid that grew has reached half of the corners of `seed` already."""
    if not found:
        return False
    mine = _known_pixels(seed)
    theirs = np.concatenate([_known_pixels(lattice) for lattice in found])
    apart = np.abs(mine[:, None] - theirs[None]).max(axis=-1).min(axis=1)
    return bool(np.median(apart) < SAME_PX)


def _known_pixels(lattice: Lattice) -> FloatArray:
    pixels = lattice.pixels.reshape(-1, 2)
    known: FloatArray = pixels[~np.isnan(pixels[:, 0])]
    return known


def _grid(
    lattice: Lattice, gray: UInt8Array, pyramid: Pyramid, params: FinderParams
) -> Grid | None:
    """Return the grid with fitted corners, None if too few are left."""
    contrast = float(np.nanmedian(lattice.fields[..., CONTRAST]))
    is_dark = lattice.parity == 1
    dots = find_dots(pyramid[0], lattice.pixels, contrast, is_origin_dark=is_dark)
    precise = fit_lattice(lattice, gray, dots, params.fit)
    seen = find_dots(pyramid[0], precise[..., :2], contrast, is_origin_dark=is_dark)
    if (seen & ~dots).any():
        # Blurred dots pull the corners before the fit so far that they hide behind that.
        precise = fit_lattice(lattice, gray, seen | dots, params.fit)
    _drop_strays(precise, params.growth)
    rows, columns = np.nonzero(~np.isnan(precise[..., 0]))
    if len(rows) < params.growth.fewest:
        return None
    if min(np.ptp(rows), np.ptp(columns)) < SMALLEST_SIDE - 1:
        return None
    cut = slice(rows.min(), rows.max() + 1), slice(columns.min(), columns.max() + 1)
    precise = precise[cut]
    is_dark = bool((lattice.parity + rows.min() + columns.min()) % 2 == 1)
    dots = find_dots(pyramid[0], precise[..., :2], contrast, is_origin_dark=is_dark)
    return _upright(Grid(precise[..., :2].copy(), precise[..., 2].copy(), is_dark, dots))


def _drop_strays(precise: FloatArray, params: GrowthParams) -> None:
    """Make NaN, in (R, C, 3) fitted corners, what its neighbours do not expect there."""
    while True:
        pixels = np.ascontiguousarray(precise[..., :2])
        steps = np.linalg.norm(np.diff(pixels, axis=1), axis=-1)
        square_px = np.nanmedian(steps) if (~np.isnan(steps)).any() else np.inf
        largest = params.most_fitted_stray + 3.0 * np.nan_to_num(precise[..., 2]) / square_px
        is_stray = np.isposinf(strays(pixels, largest))
        if not is_stray.any():
            return
        precise[is_stray] = np.nan


def _upright(grid: Grid) -> Grid:
    """Turn the grid until its columns run to the right of the image."""
    step = np.nanmean(np.diff(grid.pixels, axis=1).reshape(-1, 2), axis=0)
    quarters = -round(np.arctan2(step[1], step[0]) / (np.pi / 2))
    return grid.turned(quarters)


def _board_corners(
    placement: Placement, board: Board, image: str, size: tuple[int, ...]
) -> BoardCorners:
    pixels = np.full((board.rows, board.columns, 2), np.nan)
    sigma_px = np.full((board.rows, board.columns), np.nan)
    grid = placement.grid
    rows = slice(placement.row, placement.row + grid.rows)
    columns = slice(placement.column, placement.column + grid.columns)
    pixels[rows, columns], sigma_px[rows, columns] = grid.pixels, grid.sigma_px
    return BoardCorners(
        image, size[1], size[0], pixels.reshape(-1, 2), sigma_px.ravel(), placement.is_mirrored
    )


def _why_none(grids: list[Grid], board: Board, size: tuple[int, ...]) -> BoardSearch:
    """Say what is wrong with the largest grid."""
    if not grids:
        return BoardSearch(None, BoardProblem.NO_BOARD)
    grid = grids[0]
    long, short = max(grid.rows, grid.columns), min(grid.rows, grid.columns)
    is_wide = board.columns >= board.rows
    fields = {"columns": long if is_wide else short, "rows": short if is_wide else long}
    fits = long <= max(board.rows, board.columns) and short <= min(board.rows, board.columns)
    if fits and not _is_complete(grid, size):
        return BoardSearch(None, BoardProblem.PARTLY_SEEN, fields)
    wanted = {"wanted_columns": board.columns, "wanted_rows": board.rows}
    return BoardSearch(None, BoardProblem.ANOTHER_SIZE, fields | wanted)


def _is_complete(grid: Grid, size: tuple[int, ...]) -> bool:
    """Return whether the grid has no gaps, and would go on inside the image on all sides."""
    if grid.n_seen < 0.95 * grid.rows * grid.columns:
        return False
    pixels = grid.pixels
    beyond = np.concatenate(
        [
            2 * pixels[0] - pixels[1],
            2 * pixels[-1] - pixels[-2],
            2 * pixels[:, 0] - pixels[:, 1],
            2 * pixels[:, -1] - pixels[:, -2],
        ]
    )
    beyond = beyond[~np.isnan(beyond[:, 0])]
    limit = np.array([size[1], size[0]]) - 1
    return bool(((beyond >= 0) & (beyond <= limit)).all())
