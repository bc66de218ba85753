"""What is drawn over the picture of a board. Knows nothing of Qt."""

from functools import lru_cache

import numpy as np

from adibas.arrays import BoolArray
from adibas.calibration.guidance import PLACES, Guidance
from adibas.data.board import Board, BoardCorners
from ui.widgets.overlays import Curve, Overlay, Region, Role

Size = tuple[int, int]
"""(height, width) of a picture."""


def board_overlays(corners: BoardCorners, board: Board, *, is_ready: bool) -> tuple[Overlay, ...]:
    """Return lines along rows and columns that cross in the corners.

    Parameters
    ----------
    is_ready : bool
        Nothing hinders that the picture is taken.
    """
    grid = corners.pixels.reshape(board.rows, board.columns, 2)
    role: Role = "outline" if is_ready else "marker"
    overlays = []
    for line in (*grid, *grid.swapaxes(0, 1)):
        seen = line[~np.isnan(line[:, 0])].tolist()
        if len(seen) > 1:
            overlays.append(Curve(tuple((u, v) for u, v in seen), role))
    return tuple(overlays)


def coverage_overlays(guidance: Guidance, size: Size) -> tuple[Overlay, ...]:
    """Return the border of where corners were found, and the part that lacks most, tinted."""
    return _regions(guidance.covered.tobytes(), guidance.covered.shape, target(guidance), size)


def target(guidance: Guidance) -> tuple[int, int] | None:
    """Return the ninth of the picture in which the board lacks most, -1 to 1 down and right."""
    places = {text: place for place, text in PLACES.items()}
    return next((places[text] for text in guidance.lacking if text in places), None)


@lru_cache(maxsize=4)
def _regions(
    covered: bytes, cells: tuple[int, ...], place: tuple[int, int] | None, size: Size
) -> tuple[Overlay, ...]:
    """Return the same regions as long as nothing changes: their pictures are kept then."""
    found = np.frombuffer(covered, bool).reshape(cells)
    overlays: list[Overlay] = []
    if found.any():
        overlays.append(Region(_enlarged(found, size), "outline"))
    if place is not None:
        wanted = np.zeros((3, 3), bool)
        wanted[place[0] + 1, place[1] + 1] = True
        overlays.append(Region(_enlarged(wanted, size), "selected", is_filled=True))
    return tuple(overlays)


def _enlarged(cells: BoolArray, size: Size) -> BoolArray:
    """Return the (H, W) mask of cells."""
    rows = np.arange(size[0]) * cells.shape[0] // size[0]
    columns = np.arange(size[1]) * cells.shape[1] // size[1]
    return cells[np.ix_(rows, columns)]
