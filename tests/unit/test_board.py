"""A chessboard by its inner corners, and what an image shows of it."""

import numpy as np
import pytest

from adibas.data.board import Board, BoardCorners

BOARD = Board(columns=9, rows=6, square_m=0.025)


def test_corners_run_along_the_columns_first_a_square_apart():
    points = BOARD.points_m()
    assert points.shape == (54, 3)
    assert points[0].tolist() == [0, 0, 0]
    assert points[8] == pytest.approx([0.2, 0, 0])
    assert points[9] == pytest.approx([0, 0.025, 0])
    assert points[-1] == pytest.approx([0.2, 0.125, 0])


def test_squares_alternate_from_a_dark_one():
    assert BOARD.is_dark(0, 0)
    assert not BOARD.is_dark(0, 1)
    assert BOARD.is_dark(3, 5)


@pytest.mark.parametrize("board", [Board(3, 3, 1.0), Board(9, 6, 1.0), Board(8, 11, 1.0)])
def test_no_turn_and_no_reflection_of_the_board_shows_its_marks_again(board):
    marks = set(board.marked_squares())
    assert all(0 <= row <= board.rows and 0 <= column <= board.columns for row, column in marks)
    turned = {(board.rows - row, board.columns - column) for row, column in marks}
    left_right = {(row, board.columns - column) for row, column in marks}
    up_down = {(board.rows - row, column) for row, column in marks}
    transposed = {(column, row) for row, column in marks}
    assert marks not in (turned, left_right, up_down, transposed)


@pytest.mark.parametrize(
    "size", [(2, 6, 0.025), (9, 2, 0.025), (101, 6, 0.025), (9, 6, 0.0), (9, 6, np.inf)]
)
def test_a_board_that_cannot_be_is_refused(size):
    with pytest.raises(ValueError, match="must be"):
        Board(*size)


def test_hidden_corners_are_not_counted():
    pixels, sigma_px = np.zeros((54, 2)), np.full(54, 0.05)
    pixels[:4], sigma_px[:4] = np.nan, np.nan
    assert BoardCorners("a.png", 640, 480, pixels, sigma_px).n_seen == 50


def test_corners_without_a_deviation_are_refused():
    with pytest.raises(ValueError, match="NaN at the same corners"):
        BoardCorners("a.png", 640, 480, np.full((54, 2), np.nan), np.zeros(54))


@pytest.mark.parametrize("size", [(0, 480), (640, -1)])
def test_an_image_without_a_size_is_refused(size):
    with pytest.raises(ValueError, match="image size"):
        BoardCorners("a.png", *size, np.zeros((54, 2)), np.zeros(54))
