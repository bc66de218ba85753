"""Views of a body in closed form come together; girths and volumes are those of the formula."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform
from adibas.surface.girths import CALF, NOT_APART, THIGH, TOUCHED, slice_measures
from adibas.surface.merging import BodySurface, SeenPoints, merge_points
from adibas.surface.patient_axes import TURNS_RAD, guessed_axes, turned
from adibas.surface.slices import (
    leg_slices,
    slice_parts,
    steady_girths_m,
    trunk_slices,
    volume_m3,
)
from adibas.surface.view_joining import OrientedPoints, join_views

RADII_M = np.array([0.18, 0.9, 0.11])
CENTER_M = np.array([0.0, 0.9, 0.0])
SIDES = ("posterior", "right_lateral", "anterior", "left_lateral")
OUTWARD = {
    "posterior": (0.0, 0.0, 1.0),
    "right_lateral": (1.0, 0.0, 0.0),
    "anterior": (0.0, 0.0, -1.0),
    "left_lateral": (-1.0, 0.0, 0.0),
}


def ellipsoid(n=40_000, seed=0):
    """Points spread over an ellipsoid with a hump, which no turn about the vertical keeps."""
    rng = np.random.default_rng(seed)
    way = rng.normal(size=(n, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    points_m = CENTER_M + RADII_M * way
    normals = way / RADII_M
    return points_m, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def seen_from(side, noise_m=0.0, seed=0):
    points_m, normals = ellipsoid(seed=seed)
    cosines = normals @ np.array(OUTWARD[side])
    seen = cosines > 0.3
    rng = np.random.default_rng([seed, 1])
    points_m = points_m[seen] + rng.normal(0.0, noise_m, (seen.sum(), 1)) * normals[seen]
    return SeenPoints(
        points_m,
        normals[seen],
        cosines[seen],
        np.full(seen.sum(), 2.0),
        np.full((seen.sum(), 3), np.nan),
    )


def uncoloured(points_m, normals):
    n = len(points_m)
    return BodySurface(points_m, normals, np.ones(n), np.ones(n), np.full((n, 3), np.nan))


def test_a_place_has_the_colour_of_the_squarest_view_that_knows_one():
    place, out = np.array([[0.001, 0.001, 0.001]]), np.array([[0.0, 0.0, 1.0]])
    views = [
        SeenPoints(place, out, np.array([cosine]), np.array([2.0]), np.array([color]))
        for cosine, color in (
            (0.5, [10.0, 20.0, 30.0]),
            (0.9, [40.0, 50.0, 60.0]),
            (1.0, [np.nan] * 3),
        )
    ]
    np.testing.assert_allclose(merge_points(views).colors, [[40.0, 50.0, 60.0]])


def test_views_that_were_moved_come_back():
    true = [
        RigidTransform(np.eye(3), np.zeros(3)),
        RigidTransform(
            Rotation.from_rotvec([0.01, 0.03, -0.008]).as_matrix(), [0.01, 0.003, -0.012]
        ),
        RigidTransform(
            Rotation.from_rotvec([-0.006, -0.04, 0.01]).as_matrix(), [0.0, -0.004, 0.015]
        ),
        RigidTransform(
            Rotation.from_rotvec([0.008, 0.02, 0.005]).as_matrix(), [-0.012, 0.002, 0.006]
        ),
    ]
    views = []
    for number, (side, motion) in enumerate(zip(SIDES, true, strict=True)):
        seen = seen_from(side, 0.001, number)
        views.append(OrientedPoints(seen.points_m, seen.normals).moved(motion.inverse()))
    joined = join_views(views)
    for found, motion, view in zip(joined.motions, true, views, strict=True):
        apart_m = found.apply(view.points_m) - motion.apply(view.points_m)
        across_m = np.abs((apart_m * (view.normals @ motion.rotation.T)).sum(axis=1))
        assert np.sqrt((across_m**2).mean()) < 0.001
    assert joined.rms_m < 0.004
    assert joined.n_pairs > 1000


def test_views_without_a_shared_place_are_told():
    back, front = seen_from("posterior"), seen_from("anterior")
    views = [OrientedPoints(one.points_m, one.normals) for one in (back, front)]
    views = [
        OrientedPoints(view.points_m[far], view.normals[far])
        for view in views
        for far in (np.abs(view.normals[:, 2]) > 0.7,)
    ]
    assert join_views(views) is None
    with pytest.raises(ValueError, match="two views"):
        join_views(views[:1])


def test_outlines_put_the_views_within_centimetres():
    floor = Plane(np.array([0.0, -1.0, 0.0]), 1.0)
    camera_from_world = RigidTransform(np.diag([1.0, -1.0, -1.0]), [0.0, 1.0, 2.0])
    views = {}
    for side in SIDES:
        facing = turned(RigidTransform(np.eye(3), [0.02, 0.0, 0.05]), -TURNS_RAD[side])
        views[side] = (camera_from_world.apply(facing.apply(seen_from(side).points_m)), floor)
    guessed = guessed_axes(views)
    for side in SIDES:
        true_m = seen_from(side).points_m
        assert np.abs(guessed[side].apply(views[side][0]) - true_m).max() < 0.06


def test_a_single_view_is_guessed_too():
    floor = Plane(np.array([0.0, -1.0, 0.0]), 1.0)
    camera_from_world = RigidTransform(np.diag([1.0, -1.0, -1.0]), [0.0, 1.0, 2.0])
    points_m = camera_from_world.apply(seen_from("posterior").points_m)
    axes = guessed_axes({"posterior": (points_m, floor)})["posterior"]
    assert np.abs(axes.apply(points_m)[:, 1] - seen_from("posterior").points_m[:, 1]).max() < 1e-9


def test_merged_points_lie_on_the_surface_and_know_who_saw_them():
    surface = merge_points([seen_from(side, 0.001, k) for k, side in enumerate(SIDES)])
    way = (surface.points_m - CENTER_M) / RADII_M
    off = (np.linalg.norm(way, axis=1) - 1.0) * RADII_M[2]
    assert np.sqrt((off**2).mean()) < 0.0012
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=1), 1.0)
    assert surface.n_views.max() == 2.0
    with pytest.raises(ValueError, match="squarely"):
        merge_points(
            [SeenPoints(np.zeros((1, 3)), np.eye(3)[:1], np.zeros(1), np.ones(1), np.ones((1, 3)))]
        )


def test_girth_and_area_of_a_slice_are_those_of_the_ellipse():
    points_m, normals = ellipsoid(400_000)
    surface = uncoloured(points_m, normals)
    (part,) = slice_parts(surface, CENTER_M[1])
    a, b = RADII_M[[0, 2]]
    share = ((a - b) / (a + b)) ** 2
    ramanujan_m = np.pi * (a + b) * (1 + 3 * share / (10 + np.sqrt(4 - 3 * share)))
    assert part.girth_m == pytest.approx(ramanujan_m, rel=0.01)
    assert part.area_m2 == pytest.approx(np.pi * a * b, rel=0.02)
    assert part.seen_share == 1.0
    assert part.hollow_m < 0.004
    parts, n_touched = trunk_slices(surface, 0.4, 1.4)
    assert n_touched == 0
    low, high = (np.array([0.4, 1.4]) - CENTER_M[1]) / RADII_M[1]
    exact = np.pi * a * b * RADII_M[1] * ((high - high**3 / 3) - (low - low**3 / 3))
    assert volume_m3(parts, 0.4, 1.4, 0.01) == pytest.approx(exact, rel=0.03)
    some = [one for number, one in enumerate(parts) if number % 7]
    assert volume_m3(some, 0.4, 1.4, 0.01) == pytest.approx(exact, rel=0.03)


def test_a_trunk_that_an_arm_touches_has_no_girth():
    surface, arm = trunk_with_arm(0.9, 1.1)
    free = slice_parts(surface, 0.8)[0]
    touched = max(slice_parts(surface, 1.0), key=lambda part: part.area_m2)
    assert free.hollow_m < 0.003
    assert 0.015 < touched.hollow_m < 2 * arm
    parts, n_touched = trunk_slices(surface, 0.7, 1.3)
    heights_m = np.arange(0.7, 1.3, 0.01)
    wanted_m = heights_m[(heights_m < 0.885) | (heights_m > 1.115)]
    np.testing.assert_allclose([part.height_m for part in parts], wanted_m)
    assert n_touched == len(heights_m) - len(parts)
    assert np.ptp([part.girth_m for part in parts]) < 0.002


def trunk_with_arm(low_m, high_m):
    """Return a round trunk that an arm touches between two heights, and the arm's radius."""
    trunk_m, arm_m = 0.15, 0.045
    rng = np.random.default_rng(0)
    columns = []
    for x_m, radius_m, low, high, n in (
        (0.0, trunk_m, 0.6, 1.4, 200_000),
        (trunk_m + arm_m, arm_m, low_m, high_m, 40_000),
    ):
        angles, heights = rng.uniform(0, 2 * np.pi, n), rng.uniform(low, high, n)
        columns.append(
            np.stack([x_m + radius_m * np.cos(angles), heights, radius_m * np.sin(angles)], axis=1)
        )
    points_m = np.concatenate(columns)
    return uncoloured(points_m, np.tile([1.0, 0.0, 0.0], (len(points_m), 1))), arm_m


def test_one_slice_alone_makes_no_girth():
    part = slice_parts(trunk_with_arm(0.9, 1.1)[0], 0.8)[0]
    parts = [replace(part, height_m=0.7 + 0.01 * number) for number in range(9)]
    parts[4] = replace(parts[4], girth_m=2.0 * part.girth_m)
    np.testing.assert_allclose(steady_girths_m(parts), part.girth_m)


def test_a_seat_with_hands_at_it_is_not_measured():
    surface, _ = trunk_with_arm(0.6, 1.4)
    found = {one.definition.measure_id: one for one in slice_measures(surface, 2.0)}
    for name in ("GIRTH.TRUNK.LEAST", "GIRTH.SEAT.GREATEST", "VOLUME.TRUNK"):
        assert found[name].value is None
        assert found[name].reason is TOUCHED


def test_legs_are_two_and_named_by_the_patient():
    angles = np.random.default_rng(0).uniform(0, 2 * np.pi, 60_000)
    height_m = np.random.default_rng(1).uniform(0.1, 0.7, 60_000)
    columns = []
    for x_m, radius_m in ((-0.1, 0.06), (0.1, 0.07)):
        columns.append(
            np.stack([x_m + radius_m * np.cos(angles), height_m, radius_m * np.sin(angles)], axis=1)
        )
    points_m = np.concatenate(columns)
    surface = uncoloured(points_m, np.tile([1.0, 0.0, 0.0], (len(points_m), 1)))
    (left, _), (right, _) = leg_slices(surface, 0.2, 0.6)
    assert len(left) == len(right) >= 40
    assert np.median([part.girth_m for part in left]) == pytest.approx(2 * np.pi * 0.06, rel=0.02)
    assert np.median([part.girth_m for part in right]) == pytest.approx(2 * np.pi * 0.07, rel=0.02)
    assert slice_parts(surface, 3.0) == ()


def legs(hidden_deg, radii_m=(0.057, 0.057), n=60_000, apart_m=0.2):
    """Two round legs of 0.1 to 0.7 m; of each the inner side, so wide, was seen by nobody."""
    rng = np.random.default_rng(0)
    columns = []
    for side, radius_m in zip((-1.0, 1.0), radii_m, strict=True):
        angles = rng.uniform(0.5 * hidden_deg, 360.0 - 0.5 * hidden_deg, n)
        inward = np.radians(angles)  # 0 faces the other leg
        across_m = side * (apart_m / 2 - radius_m * np.cos(inward))
        columns.append(np.stack([across_m, rng.uniform(0.1, 0.7, n), radius_m * np.sin(inward)], 1))
    points_m = np.concatenate(columns)
    return uncoloured(points_m, np.tile([1.0, 0.0, 0.0], (len(points_m), 1)))


def test_an_inner_side_that_nobody_saw_is_bridged_by_an_arc():
    """A chord over 70 degrees is 1.2 % shorter than the round, and cuts off 2.2 % of the area."""
    (left, _), (right, _) = leg_slices(legs(70.0), 0.2, 0.6)
    for part in (*left, *right):
        assert part.girth_m == pytest.approx(2 * np.pi * 0.057, rel=0.004)
        assert part.area_m2 == pytest.approx(np.pi * 0.057**2, rel=0.012)
        assert part.seen_share < 0.85


STATURE_M = 1.8


def of_legs(surface):
    return {one.definition.measure_id: one for one in slice_measures(surface, STATURE_M)}


@pytest.mark.parametrize(("part", "shares"), [("CALF", CALF), ("THIGH", THIGH)])
def test_calves_and_thighs_have_a_girth_and_a_volume_each(part, shares):
    found = of_legs(legs(40.0, (0.05, 0.06)))
    length_m = STATURE_M * (shares[1] - shares[0])
    for side, radius_m in (("LEFT", 0.05), ("RIGHT", 0.06)):
        exact = {"GIRTH": 2 * np.pi * radius_m, "VOLUME": np.pi * radius_m**2 * length_m}
        for kind, truth in exact.items():
            one = found[f"{kind}.{part}.{side}"]
            assert one.value == pytest.approx(truth, rel=0.02)
            assert one.interval[0] < truth < one.interval[1]


def test_a_thigh_that_a_hand_touches_is_not_measured_and_the_other_is():
    rng = np.random.default_rng(3)
    angles, heights_m = rng.uniform(0, 2 * np.pi, 40_000), rng.uniform(0.5, 0.7, 40_000)
    across_m = 0.1 + 0.057 + 0.03 + 0.03 * np.cos(angles)
    hand_m = np.stack([across_m, heights_m, 0.03 * np.sin(angles)], axis=1)
    points_m = np.concatenate([legs(0.0).points_m, hand_m])
    found = of_legs(uncoloured(points_m, np.tile([1.0, 0.0, 0.0], (len(points_m), 1))))
    for kind in ("GIRTH", "VOLUME"):
        assert found[f"{kind}.THIGH.RIGHT"].value is None
        assert found[f"{kind}.THIGH.RIGHT"].reason is TOUCHED
        assert found[f"{kind}.THIGH.LEFT"].value is not None
        assert found[f"{kind}.CALF.RIGHT"].value is not None


def test_thighs_that_touch_are_told_apart_by_nothing():
    found = of_legs(legs(0.0, apart_m=0.11))
    assert found["VOLUME.THIGH.LEFT"].value is None
    assert found["VOLUME.THIGH.LEFT"].reason is NOT_APART


def test_girths_have_names_and_what_is_not_seen_has_a_reason():
    points_m, normals = ellipsoid(400_000)
    surface = uncoloured(points_m, normals)
    found = {one.definition.measure_id: one for one in slice_measures(surface, 1.8)}
    least = found["GIRTH.TRUNK.LEAST"]
    ellipse_m = slice_parts(surface, 0.70 * 1.8 - 0.01)[0].girth_m
    assert least.value == pytest.approx(ellipse_m, abs=0.02)
    assert found["VOLUME.TRUNK"].value > 0.01
    low, high = least.interval
    assert low < least.value < high
    assert high - least.value == pytest.approx(1.96 * 0.0113 * least.value, rel=1e-3)
    assert found["GIRTH.CALF.LEFT"].value is None
    assert found["GIRTH.CALF.LEFT"].reason
    half = points_m[:, 2] > 0.0
    behind = uncoloured(points_m[half], normals[half])
    assert all(one.value is None for one in slice_measures(behind, 1.8))
