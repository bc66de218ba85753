"""The crown of a head that is seen from below, against a head in closed form."""

import numpy as np
import pytest

from adibas.geometry.rigid import RigidTransform
from adibas.surface.crown import CROWN_RADIUS_M, RIM_PX_PER_M, crown_height_m

STATURE_M, FOCAL_PX = 1.75, 575.0


def seen_head(eye_m: np.ndarray) -> np.ndarray:
    """Points of a spherical head that a place sees: those whose surface looks towards it."""
    rng = np.random.default_rng(5)
    way = rng.normal(size=(400_000, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    points_m = np.array([0.0, STATURE_M - CROWN_RADIUS_M, 0.0]) + CROWN_RADIUS_M * way
    return points_m[((eye_m - points_m) * way).sum(axis=1) > 0]


@pytest.mark.parametrize("away_m", [1.4, 2.0, 3.0])
@pytest.mark.parametrize("height_m", [0.4, 1.0, 1.4])
def test_it_lies_where_the_head_ends_that_is_seen_from_below(away_m, height_m):
    eye_m = np.array([0.3, height_m, -away_m])
    points_m = seen_head(eye_m)
    found_m = crown_height_m(points_m, RigidTransform(np.eye(3), eye_m), FOCAL_PX)
    rim_m = RIM_PX_PER_M * away_m**2 / FOCAL_PX
    assert points_m[:, 1].max() < STATURE_M - 1e-4, "the crown itself is hidden"
    # The look touches a head that comes nearer by half its depth, and aside.
    assert found_m - rim_m == pytest.approx(STATURE_M, abs=0.004)


def test_nothing_is_added_where_the_crown_is_seen_from_above():
    eye_m = np.array([0.0, 2.2, -2.0])
    points_m = seen_head(eye_m)
    found_m = crown_height_m(points_m, RigidTransform(np.eye(3), eye_m), FOCAL_PX)
    assert found_m == points_m[:, 1].max() == pytest.approx(STATURE_M, abs=1e-4)
