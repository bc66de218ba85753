"""Grids: how they are turned, trimmed, joined and laid on a board."""

import numpy as np
import pytest

from adibas.calibration.corner_saddle_kernels import N_FIELDS, U, V
from adibas.calibration.grid import Grid
from adibas.calibration.grid_growth import GrowthParams, Lattice, tidied
from adibas.calibration.grid_joining import join_all
from adibas.calibration.grid_placement import place, without_weak_edges
from adibas.data.board import Board


def grid_of(rows, columns, *, is_origin_dark=True, dots=()):
    v, u = np.mgrid[:rows, :columns] * 20.0 + 50.0
    has_dot = np.zeros((rows - 1, columns - 1), bool)
    for dot in dots:
        has_dot[dot] = True
    return Grid(np.stack([u, v], axis=-1), np.full((rows, columns), 0.1), is_origin_dark, has_dot)


def marked(board):
    """Return the grid of a whole board as printed: squares count from outside the corners."""
    dots = [(row - 1, column - 1) for row, column in board.marked_squares()]
    return grid_of(board.rows, board.columns, dots=dots)


def lattice_of(rows, columns, parity=0, first=(0, 0)):
    fields = np.ones((rows, columns, N_FIELDS))
    row, column = np.mgrid[:rows, :columns] + np.reshape(first, (2, 1, 1))
    fields[..., U], fields[..., V] = 100 + 20 * column, 100 + 20 * row
    return Lattice(fields, parity)


@pytest.mark.parametrize(("rows", "columns"), [(3, 4), (4, 4), (5, 3)])
@pytest.mark.parametrize("is_dark", [True, False])
def test_four_quarter_turns_change_nothing(rows, columns, is_dark):
    grid = grid_of(rows, columns, is_origin_dark=is_dark, dots=[(0, 1)])
    turned = grid
    for _ in range(4):
        turned = turned.turned(1)
    np.testing.assert_array_equal(turned.pixels, grid.pixels)
    np.testing.assert_array_equal(turned.dots, grid.dots)
    assert turned.is_origin_dark is grid.is_origin_dark


def test_a_square_keeps_its_color_when_the_grid_is_turned():
    grid = grid_of(4, 5)
    colors = {}
    for quarters in range(4):
        turned = grid.turned(quarters)
        colors[tuple(turned.pixels[0, 0])] = turned.is_origin_dark
    # Outside the four corners of a board: rows + columns apart, as on paper.
    assert colors == {(50, 50): True, (130, 50): False, (50, 110): True, (130, 110): False}


def test_a_grid_without_its_first_row_begins_with_the_other_color():
    grid = grid_of(5, 4).trimmed(slice(1, None), slice(None))
    assert (grid.rows, grid.columns) == (4, 4)
    assert grid.is_origin_dark is False


@pytest.mark.parametrize("quarters", range(4))
def test_dots_lay_a_turned_grid_on_the_board(quarters):
    board = Board(7, 7, 0.03)
    whole = marked(board)
    placement = place(whole.turned(quarters), board)
    np.testing.assert_array_equal(placement.grid.pixels, whole.pixels)
    assert placement.is_mirrored is False


def test_dots_lay_a_part_on_the_board():
    board = Board(9, 6, 0.03)
    part = marked(board).trimmed(slice(1, 6), slice(2, 8))
    placement = place(part, board)
    assert (placement.row, placement.column) == (1, 2)


def test_a_part_without_dots_is_not_laid_anywhere():
    assert place(grid_of(5, 9), Board(9, 6, 0.03)) is None


def test_dots_that_no_board_of_ours_has_do_not_stop_the_colors():
    board = Board(9, 6, 0.03)
    placement = place(grid_of(6, 9, dots=[(0, 0), (4, 7), (0, 7)]), board)
    assert placement is not None
    assert placement.is_mirrored is None


def test_colors_that_do_not_fit_the_board_refuse_it():
    # 7 x 5: all corner squares of the true board are dark.
    assert place(grid_of(5, 7, is_origin_dark=False), Board(7, 5, 0.03)) is None


def test_hardly_seen_rows_beyond_the_board_are_cut_off():
    grid = grid_of(7, 9)
    sigma = grid.sigma_px.copy()
    sigma[0, 1:] = np.nan
    pixels = np.where(np.isnan(sigma)[..., None], np.nan, grid.pixels)
    ragged = Grid(pixels, sigma, True, grid.dots.copy())
    cut = without_weak_edges(ragged, Board(9, 6, 0.03))
    assert (cut.rows, cut.columns) == (6, 9)
    np.testing.assert_array_equal(cut.pixels, grid.pixels[1:])


def test_a_whole_row_beyond_the_board_stays():
    assert without_weak_edges(grid_of(7, 9), Board(9, 6, 0.03)).rows == 7


def test_a_corner_off_its_row_is_dropped():
    lattice = lattice_of(5, 6)
    lattice.fields[2, 3, V] += 8
    kept = tidied(lattice, GrowthParams())
    assert kept.n_known == 29
    assert np.isnan(kept.fields[2, 3, U])


def test_pieces_on_the_same_rows_and_columns_are_joined():
    left, right = lattice_of(5, 4), lattice_of(5, 3, parity=1, first=(0, 5))
    (whole,) = join_all([right, left])
    assert whole.fields.shape[:2] == (5, 8)
    assert whole.n_known == 35
    assert np.isnan(whole.fields[:, 4, U]).all()


@pytest.mark.parametrize(
    "other",
    [
        lattice_of(5, 3, parity=0, first=(0, 5)),
        lattice_of(5, 3, parity=1, first=(0.5, 5)),
        lattice_of(5, 3, parity=0, first=(0, 30)),
    ],
    ids=["other colors", "between the rows", "far away"],
)
def test_other_boards_are_not_joined(other):
    assert len(join_all([lattice_of(5, 4), other])) == 2
