"""Arms are told from the trunk where they hang apart, of simulated bodies whose parts are known."""

import numpy as np
import pytest

from adibas.simulation.body import BODY_PART_NAMES, load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.poses import standing
from adibas.surface.hanging_arms import are_of_arms

SHAPES = (
    BodyShape("male", 35, 1.78, 75),
    BodyShape("female", 50, 1.60, 95),
    BodyShape("male", 10, 1.40, 35),
)
IS_ARM = np.array([("arm" in name or "hand" in name) for name in BODY_PART_NAMES])


def skin_of(shape, n_points, rng):
    """Return points of a standing body's skin, y down, and which of them are of arms."""
    model = load_body_model()
    vertices_m = model.shaped(shape).posed(standing()).vertices_m
    corners_m = vertices_m[model.triangles]
    sides = corners_m[:, 1:] - corners_m[:, :1]
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    chosen = rng.choice(len(areas), n_points, p=areas / areas.sum())
    share = rng.dirichlet([1.0, 1.0, 1.0], n_points)
    points_m = (share[:, :, None] * corners_m[chosen]).sum(axis=1)
    return points_m - [0.0, vertices_m[:, 1].max(), 0.0], IS_ARM[model.triangle_parts[chosen]]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("heading_deg", [0, 40])
def test_what_hangs_beside_the_trunk_is_of_arms(shape, heading_deg):
    points_m, is_arm = skin_of(shape, 60_000, np.random.default_rng(0))
    heading = np.radians(heading_deg)
    turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    heights_m = -points_m[:, 1]
    told = are_of_arms(points_m[:, [0, 2]] @ turn, heights_m, float(heights_m.max()))
    assert is_arm[told].mean() > 0.99
    beside = is_arm & (heights_m > 0.5 * heights_m.max()) & (heights_m < 0.85 * heights_m.max())
    assert told[beside].mean() > 0.2  # the rest touches the trunk from above
    assert not told[heights_m < 0.5 * heights_m.max()].any()


def test_few_points_that_fall_apart_are_no_arms():
    rng = np.random.default_rng(3)
    around, heights_m = rng.uniform(0, 2 * np.pi, 3000), rng.uniform(0.9, 1.7, 3000)
    over_m = 0.15 * np.column_stack([np.cos(around), np.sin(around)])
    assert not are_of_arms(over_m, heights_m, 1.7).any()


def test_something_beside_the_trunk_for_a_few_centimetres_is_no_arm():
    rng = np.random.default_rng(4)
    around, heights_m = rng.uniform(0, 2 * np.pi, 60_000), rng.uniform(0.9, 1.4, 60_000)
    trunk_m = np.column_stack([0.16 * np.cos(around), 0.1 * np.sin(around)])
    for thickness_m, is_told in ((0.05, False), (0.3, True)):
        beside_m = rng.uniform([0.25, -0.03], [0.31, 0.03], (4000, 2))
        over_m = np.concatenate([trunk_m, beside_m])
        both_m = np.concatenate([heights_m, rng.uniform(1.0, 1.0 + thickness_m, 4000)])
        told = are_of_arms(over_m, both_m, 1.7)
        assert told.any() == is_told
        assert not told[: len(trunk_m)].any()


def test_nobody_between_the_heights_has_no_arms():
    assert not are_of_arms(np.zeros((5, 2)), np.full(5, 0.1), 1.7).any()
