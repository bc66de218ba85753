"""Which corner of a given board is which corner of a grid: by size, colours and dots."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray
from adibas.calibration.grid import Grid
from adibas.data.board import Board

FEWEST_DOTS = 3
MOST_WRONG_DOTS = 1
WEAK_SHARE = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """A grid on a board: its first corner is the board's corner (row, column)."""

    grid: Grid
    row: int
    column: int
    is_mirrored: bool | None


def flipped(grid: Grid) -> Grid:
    """Return the grid with its columns counted from the other side."""
    return Grid(
        grid.pixels[:, ::-1].copy(),
        grid.sigma_px[:, ::-1].copy(),
        grid.corner_is_dark[1],
        grid.dots[:, ::-1].copy(),
    )


def place(grid: Grid, board: Board) -> Placement | None:
    """Return where the grid lies on the board; None where that is open or impossible.

    Dots decide where they are seen; else the grid must be as large as the board, and of two
    places that its colours allow, the one whose first corner is nearer the top left counts.
    """
    by_dots = _place_by_dots(grid, board)
    if by_dots is not None:
        return by_dots
    whole = [p for p in _placements(grid, board) if _is_whole(p, board)]
    return min(whole, key=lambda p: _from_top_left(p.grid), default=None)


def without_weak_edges(grid: Grid, board: Board) -> Grid:
    """Return the grid without outer rows and columns that exceed the board and are hardly seen."""
    long, short = max(board.rows, board.columns), min(board.rows, board.columns)
    is_upright = grid.rows >= grid.columns
    most_rows, most_columns = (long, short) if is_upright else (short, long)
    while grid.rows > most_rows:
        smaller = _without_weakest_row(grid)
        if smaller is None:
            return grid
        grid = smaller
    while grid.columns > most_columns:
        smaller = _without_weakest_row(grid.turned(1))
        if smaller is None:
            return grid
        grid = smaller.turned(-1)
    return grid


def _without_weakest_row(grid: Grid) -> Grid | None:
    seen = (~np.isnan(grid.sigma_px)).mean(axis=1)
    if min(seen[0], seen[-1]) > WEAK_SHARE:
        return None
    rows = slice(1, None) if seen[0] <= seen[-1] else slice(0, -1)
    return grid.trimmed(rows, slice(None))


def _placements(grid: Grid, board: Board) -> list[Placement]:
    """Return every place on the board that the colours of the squares allow."""
    found = []
    for quarters in range(4):
        turned = grid.turned(quarters)
        found += [
            Placement(turned, row, column, None)
            for row in range(board.rows - turned.rows + 1)
            for column in range(board.columns - turned.columns + 1)
            if board.is_dark(row, column) == turned.is_origin_dark
        ]
    return found


def _is_whole(placement: Placement, board: Board) -> bool:
    return (placement.grid.rows, placement.grid.columns) == (board.rows, board.columns)


def _from_top_left(grid: Grid) -> float:
    """Return how far right and down the first corner is, or where it would be."""
    known = ~np.isnan(grid.sigma_px)
    rows, columns = np.nonzero(known)
    terms = np.column_stack([np.ones(len(rows)), rows, columns])
    solution = np.linalg.lstsq(terms, grid.pixels[known], rcond=None)[0]
    return float(np.hypot(*np.maximum(solution[0], 0.0)))


def _place_by_dots(grid: Grid, board: Board) -> Placement | None:
    """Return the one place at which the dots are the board's or its mirror image's."""
    if np.count_nonzero(grid.dots) < FEWEST_DOTS:
        return None
    scored = []
    for is_mirrored, seen in ((False, grid), (True, flipped(grid))):
        for placement in _placements(seen, board):
            n_right, n_wrong = _compare_dots(placement, board)
            if n_right >= FEWEST_DOTS and n_wrong <= MOST_WRONG_DOTS:
                found = Placement(placement.grid, placement.row, placement.column, is_mirrored)
                scored.append((n_right - n_wrong, found))
    scored.sort(key=lambda pair: -pair[0])
    if not scored or (len(scored) > 1 and scored[0][0] == scored[1][0]):
        return None
    return scored[0][1]


def _compare_dots(placement: Placement, board: Board) -> tuple[int, int]:
    """Return how many dots are where they belong, and how many squares are not as they should."""
    expected = np.zeros((board.rows + 1, board.columns + 1), np.bool_)
    expected[tuple(np.transpose(board.marked_squares()))] = True
    grid = placement.grid
    top, left = placement.row + 1, placement.column + 1
    here = expected[top : top + grid.rows - 1, left : left + grid.columns - 1]
    wrong = (here != grid.dots) & _is_framed(grid)
    return int(np.count_nonzero(here & grid.dots)), int(np.count_nonzero(wrong))


def _is_framed(grid: Grid) -> BoolArray:
    """Return (R - 1, C - 1) which squares have all four corners seen."""
    seen = ~np.isnan(grid.sigma_px)
    framed: BoolArray = seen[:-1, :-1] & seen[:-1, 1:] & seen[1:, :-1] & seen[1:, 1:]
    return framed
