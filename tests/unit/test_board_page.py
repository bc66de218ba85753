"""The printed board has its squares, dots and rulers exactly where a ruler would find them."""

import numpy as np
import pytest
from pypdf import PdfReader
from pypdf.generic import ContentStream
from reportlab.pdfbase import pdfmetrics

from adibas.data.board import Board
from adibas.data.printed_boards import PRINTED_BOARDS
from adibas.errors import FileError, ReportError
from adibas.reports.board_page import UNPRINTABLE_MM, write_board_pdf
from adibas.reports.fonts import BOLD
from adibas.texts import LANGUAGES, speaking

MM = 72.0 / 25.4
SIZES = tuple(PRINTED_BOARDS)


class Drawn:
    """What the page's commands draw, millimetres from the lower left corner."""

    def __init__(self, path):
        reader = PdfReader(path)
        assert len(reader.pages) == 1
        self.page = reader.pages[0]
        self.preferences = reader.trailer["/Root"].get("/ViewerPreferences")
        self.squares, self.discs, self.lines = [], [], []
        self._stack, self._matrix, self._gray = [], np.eye(3), 0.0
        self._path = []
        for operands, operator in ContentStream(self.page.get_contents(), reader).operations:
            self._draw([*operands], operator.decode())

    def _at(self, x, y):
        return tuple((np.array([float(x), float(y), 1.0]) @ self._matrix)[:2] / MM)

    def _draw(self, operands, operator):
        numbers = [float(x) for x in operands] if operator in {"cm", "g", "re"} else ()
        if operator == "q":
            self._stack.append((self._matrix, self._gray))
        elif operator == "Q":
            self._matrix, self._gray = self._stack.pop()
        elif operator == "cm":
            self._matrix = np.c_[np.reshape(numbers, (3, 2)), (0, 0, 1)] @ self._matrix
        elif operator == "g":
            self._gray = numbers[0]
        elif operator == "re":
            x, y, width, height = numbers
            self._path.append(("re", self._at(x, y), self._at(x + width, y + height)))
        elif operator in {"m", "l", "c"}:
            self._path.append((operator, self._at(*operands[-2:])))
        else:
            self._paint(operator)

    def _paint(self, operator):
        if operator not in {"f", "F", "f*", "S", "n"}:
            return
        kinds = "".join(step[0][0] for step in self._path)
        if operator.lower().startswith("f") and kinds == "r":
            self.squares.append((self._gray, *self._path[0][1:]))
        elif operator.lower().startswith("f") and "c" in kinds:
            points = np.array([step[1] for step in self._path])
            middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
            self.discs.append((self._gray, middle, np.ptp(points[:, 0]) / 2))
        elif operator == "S":
            self.lines.append(np.array([step[1] for step in self._path]))
        self._path = []


@pytest.fixture(scope="module", params=SIZES)
def printed(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("board") / "board.pdf"
    return request.param, write_board_pdf(path, request.param), Drawn(path)


def pattern_of(drawn):
    """Return left and top of the dark squares' outline."""
    low = np.array([low for _, low, _ in drawn.squares])
    high = np.array([high for _, _, high in drawn.squares])
    return low.min(axis=0), high.max(axis=0)


def test_the_page_has_the_size_of_the_paper(printed):
    name, _, drawn = printed
    expected = {
        "A4": (297, 210),
        "A3": (420, 297),
        "A0": (1189, 841),
        "115.5x84cm": (1300, 980),
    }[name]
    box = drawn.page.mediabox
    np.testing.assert_allclose((float(box.width) / MM, float(box.height) / MM), expected, atol=0.01)
    assert drawn.preferences["/PrintScaling"] == "/None"


def test_dark_squares_are_exactly_where_the_board_has_them(printed):
    _, board, drawn = printed
    side = 1000 * board.square_m
    low, high = pattern_of(drawn)
    expected = {
        (round(column), round(row)): (low[0] + column * side, high[1] - (row + 1) * side)
        for row in range(board.rows + 1)
        for column in range(board.columns + 1)
        if board.is_dark(row, column)
    }
    np.testing.assert_allclose(
        high - low, np.array([board.columns + 1, board.rows + 1]) * side, atol=1e-3
    )
    found = {}
    for gray, first, last in drawn.squares:
        assert gray == 0.0
        np.testing.assert_allclose(np.subtract(last, first), side, atol=1e-4)
        place = (first[0] - low[0]) / side, (high[1] - last[1]) / side
        found[tuple(round(x) for x in place)] = first
    assert found.keys() == expected.keys()
    for place, corner in expected.items():
        np.testing.assert_allclose(found[place], corner, atol=1e-3)


def test_dots_of_the_other_colour_are_in_the_middle_of_marked_squares(printed):
    _, board, drawn = printed
    side = 1000 * board.square_m
    low, high = pattern_of(drawn)
    assert len(drawn.discs) == 4
    found = {}
    for gray, middle, radius in drawn.discs:
        assert radius == pytest.approx(0.2 * side, rel=1e-4)
        column, row = (middle[0] - low[0]) / side - 0.5, (high[1] - middle[1]) / side - 0.5
        assert abs(column - round(column)) < 1e-4
        assert abs(row - round(row)) < 1e-4
        found[round(row), round(column)] = gray
    assert found == {
        place: 1.0 if board.is_dark(*place) else 0.0 for place in board.marked_squares()
    }


def test_the_rulers_are_100_mm_with_ticks_every_10(printed):
    _, _, drawn = printed
    rulers = [line for line in drawn.lines if np.linalg.norm(line[1] - line[0]) > 50]
    ticks = [line for line in drawn.lines if np.linalg.norm(line[1] - line[0]) < 50]
    assert len(rulers) == 2
    for ruler in rulers:
        along = (ruler[1] - ruler[0]) / 100.0
        assert np.linalg.norm(along) == pytest.approx(1.0, abs=1e-5)
        assert np.abs(along).max() == pytest.approx(1.0)
        away = np.array([tick[0] - ruler[0] for tick in ticks])
        is_mine = np.abs(away[:, 0] * along[1] - away[:, 1] * along[0]) < 1e-3
        places = away[is_mine] @ along
        np.testing.assert_allclose(sorted(places), np.arange(0, 101, 10), atol=1e-3)


def test_white_paper_is_left_around_the_pattern_and_at_the_border(printed):
    _, board, drawn = printed
    low, high = pattern_of(drawn)
    quiet = 500 * board.square_m - 1e-3
    width, height = float(drawn.page.mediabox.width) / MM, float(drawn.page.mediabox.height) / MM
    assert min(*low, width - high[0], height - high[1]) >= quiet
    for line in drawn.lines:
        outside = (line < low - quiet).any() or (line > high + quiet).any()
        assert outside
        assert line.min() >= UNPRINTABLE_MM - 1e-6
        assert (line <= np.array([width, height]) - UNPRINTABLE_MM + 1e-3).all()


def test_the_page_says_what_it_is_and_how_to_print_it(printed):
    name, board, drawn = printed
    text = drawn.page.extract_text()
    assert name in text
    assert f"{board.columns} x {board.rows} inner corners" in text
    assert f"{1000 * board.square_m:g} mm" in text
    assert "100 %" in text


def test_the_boards_cannot_be_mistaken_when_turned_by_half_a_turn():
    assert all((one.board.columns + one.board.rows) % 2 == 1 for one in PRINTED_BOARDS.values())
    thesis = PRINTED_BOARDS["115.5x84cm"].board
    assert thesis == Board(10, 7, 0.105)
    assert (11 * thesis.square_m, 8 * thesis.square_m) == pytest.approx((1.155, 0.84))


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_text_fits_on_the_page_in_every_language(tmp_path, language):
    with speaking(language):
        write_board_pdf(tmp_path / "board.pdf", "a4")
    ends_mm = {}

    def note(text, _matrix, place, _font, size):
        if text.strip() and place[1] == 0:
            width = pdfmetrics.stringWidth(text.strip(), BOLD, place[0] * size)
            ends_mm[text.strip()] = (place[4] + width) / MM

    Drawn(tmp_path / "board.pdf").page.extract_text(visitor_text=note)
    assert any("A4" in text for text in ends_mm)
    assert max(ends_mm.values()) < 297 - UNPRINTABLE_MM


def test_the_same_size_gives_the_same_file(tmp_path):
    for name in ("one.pdf", "two.pdf"):
        write_board_pdf(tmp_path / name, "A3")
    assert (tmp_path / "one.pdf").read_bytes() == (tmp_path / "two.pdf").read_bytes()


def test_an_unknown_size_is_told_with_those_that_exist(tmp_path):
    with pytest.raises(ReportError) as told:
        write_board_pdf(tmp_path / "board.pdf", "A5")
    for name in ("A5", *SIZES):
        assert name in str(told.value)
    assert not (tmp_path / "board.pdf").exists()


def test_a_folder_in_the_way_is_told(tmp_path):
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(FileError):
        write_board_pdf(tmp_path / "taken" / "board.pdf", "A4")
