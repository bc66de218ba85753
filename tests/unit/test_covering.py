"""Discs at the points of a surface leave no gap, and are no larger than that."""

import numpy as np
import pytest

from adibas.surface.covering import MOST_M, covering_radii_m


@pytest.mark.parametrize("side_m", [0.004, 0.007])
def test_discs_of_a_grid_reach_the_middles_of_its_squares(side_m):
    rows, columns = np.mgrid[:20, :30]
    grid_m = side_m * np.stack([columns, rows, 0 * rows], axis=-1).reshape(-1, 3)
    radii_m = covering_radii_m(grid_m).reshape(20, 30)
    assert radii_m[1:-1, 1:-1] == pytest.approx(side_m * np.sqrt(0.5), rel=0.01)
    assert radii_m.min() >= 0.99 * side_m * np.sqrt(0.5)
    assert radii_m.max() <= 1.5 * side_m


def test_discs_of_scattered_points_cover_nearly_all_of_their_plane():
    rng = np.random.default_rng(2)
    places = np.stack(np.meshgrid(*[np.arange(0.0, 0.3, 0.006)] * 2), axis=-1).reshape(-1, 2)
    places += rng.uniform(-0.002, 0.002, places.shape)
    radii_m = covering_radii_m(np.column_stack([places, np.zeros(len(places))]))
    asked = rng.uniform(0.01, 0.28, (4000, 2))
    away_m = np.linalg.norm(asked[:, None] - places, axis=2)
    assert (away_m < radii_m).any(axis=1).mean() > 0.995
    assert (away_m < 0.7 * radii_m).any(axis=1).mean() < 0.95  # smaller ones would not


def test_gaps_that_nobody_saw_stay():
    alone = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]])
    assert covering_radii_m(alone) == pytest.approx(MOST_M)
    far = np.random.default_rng(1).uniform(0, 1, (200, 3))
    assert covering_radii_m(far).max() == pytest.approx(MOST_M)
    assert covering_radii_m(np.empty((0, 3))).shape == (0,)
