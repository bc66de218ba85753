"""The boards that the program prints, by the name of the paper.

Columns plus rows are odd for all of them, so that a board looks another way when it is turned by
half a turn.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from adibas.data.board import Board


@dataclass(frozen=True, slots=True)
class PrintedBoard:
    """A board and the page that it is printed on, landscape.

    Attributes
    ----------
    name : str
        Of the size, as the user types it.
    page_m : (width, height)
    board : Board
    """

    name: str
    page_m: tuple[float, float]
    board: Board


PRINTED_BOARDS: Mapping[str, PrintedBoard] = MappingProxyType(
    {
        printed.name: printed
        for printed in (
            PrintedBoard("A4", (0.297, 0.210), Board(9, 6, 0.025)),
            PrintedBoard("A3", (0.420, 0.297), Board(9, 6, 0.035)),
            PrintedBoard("A0", (1.189, 0.841), Board(11, 8, 0.080)),
            # The thesis' board (8.1.3): 11 x 8 squares of 105 mm are 115.5 x 84 cm exactly, so
            # the page must be larger.
            PrintedBoard("115.5x84cm", (1.300, 0.980), Board(10, 7, 0.105)),
        )
    }
)
"""By name; the largest round squares that leave half a square of white paper and the rulers."""
