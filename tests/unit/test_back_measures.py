"""Measures between markers and along the line, by hand; asymmetry; what lies before the back."""

import numpy as np
import pytest

from adibas.surface.asymmetry import asymmetry_m
from adibas.surface.back_grid import BackGrid, grid_of
from adibas.surface.back_measures import ROTATION_RMS, PlacedMarker, back_measures
from adibas.surface.sagittal import sagittal_shape
from adibas.surface.spine_profile import fit_profile
from adibas.surface.symmetry_line import find_symmetry_line
from adibas.surface.trunk import TrunkParams, back_points, chest_width_m, hidden_share
from tests.unit.back_surfaces import STATURE_M, line_m
from tests.unit.back_surfaces import back_points as points_of_back

SD_M = 0.001
MARKERS = {
    name: PlacedMarker(np.array(place), SD_M**2 * np.eye(3))
    for name, place in (
        ("c7", (0.02, 1.40, -0.03)),
        ("left_psis", (-0.04, 0.95, 0.01)),
        ("right_psis", (0.04, 0.96, 0.01)),
    )
}


@pytest.fixture(scope="module")
def back():
    points_m = points_of_back()
    grid = grid_of(points_m)
    profile = fit_profile(points_m, find_symmetry_line(grid))
    return points_m, grid, profile, sagittal_shape(profile, STATURE_M)


def measured(back, markers, vertical_sd_rad=0.0):
    found = back_measures(back[2], back[3], markers, vertical_sd_rad)
    return {one.definition.measure_id: one for one in found}


def test_measures_between_markers_are_those_of_the_ruler(back):
    found = measured(back, MARKERS)
    rise_m, aside_m, forward_m = 1.40 - 0.955, 0.02, 0.04
    assert found["BACK.TRUNK.LENGTH"].value == pytest.approx(
        np.sqrt(rise_m**2 + aside_m**2 + forward_m**2)
    )
    assert found["BACK.TRUNK.INCLINATION"].value == pytest.approx(np.arctan(forward_m / rise_m))
    assert found["BACK.TRUNK.IMBALANCE"].value == pytest.approx(np.arctan(aside_m / rise_m))
    assert found["BACK.TRUNK.IMBALANCE.LATERAL"].value == pytest.approx(aside_m)
    assert found["BACK.PELVIS.TILT"].value == pytest.approx(np.arctan(0.01 / 0.08))
    assert found["BACK.PELVIS.TILT.HEIGHT"].value == pytest.approx(0.01)
    straight_m = 0.02 * (1.2 - 0.955) / rise_m
    assert abs(found["BACK.DEVIATION.MAX"].value) > abs(line_m(1.2) - straight_m) - 0.002


def test_intervals_come_from_the_markers_and_the_vertical(back):
    found = measured(back, MARKERS)
    low, high = found["BACK.PELVIS.TILT.HEIGHT"].interval
    assert high - low == pytest.approx(2 * 1.96 * np.sqrt(2) * SD_M, rel=1e-3)
    narrow, wide = (
        np.ptp(measured(back, MARKERS, sd)["BACK.TRUNK.INCLINATION"].interval)
        for sd in (0.0, np.radians(0.5))
    )
    assert wide > max(narrow, 2 * 1.9 * np.radians(0.5))
    same = np.ptp(measured(back, MARKERS, 0.1)["BACK.PELVIS.TILT"].interval)
    assert same == pytest.approx(np.ptp(found["BACK.PELVIS.TILT"].interval))


def test_the_deviation_is_as_sure_as_its_markers(back):
    vague = {
        name: PlacedMarker(one.position_m, (0.01 if name == "c7" else 1e-5) ** 2 * np.eye(3))
        for name, one in MARKERS.items()
    }
    for name in ("BACK.DEVIATION.RMS", "BACK.DEVIATION.MAX"):
        sure, unsure = (measured(back, markers)[name] for markers in (MARKERS, vague))
        assert sure.interval[0] <= sure.value <= sure.interval[1]
        assert np.ptp(unsure.interval) > 1.2 * np.ptp(sure.interval)


def test_the_greatest_rotation_of_a_straight_back_has_no_sure_sign(back):
    low_rad, high_rad = measured(back, {})["BACK.ROTATION.MAX"].interval
    assert low_rad < 0.0 < high_rad


def test_the_interval_of_the_rotation_grows_with_noise_and_holds_a_known_turn():
    turn_rad = np.radians(4.0)
    widths_rad = []
    for noise_m in (0.001, 0.006):
        points_m = points_of_back(np.random.default_rng(2), noise_m, turn_rad)
        profile = fit_profile(points_m, find_symmetry_line(grid_of(points_m)))
        shape = sagittal_shape(profile, STATURE_M)
        found = {one.definition: one for one in back_measures(profile, shape, {})}
        low_rad, high_rad = found[ROTATION_RMS].interval
        assert 0.0 <= low_rad <= turn_rad <= high_rad
        widths_rad.append(high_rad - low_rad)
    assert widths_rad[0] < widths_rad[1]


def test_without_markers_or_curves_there_is_a_reason_and_no_value(back):
    found = measured(back, {})
    for name in ("BACK.TRUNK.LENGTH", "BACK.PELVIS.TILT", "BACK.DEVIATION.RMS"):
        assert found[name].value is None
        assert "markers" in found[name].reason
    assert found["BACK.KYPHOSIS"].value is not None
    flat = {one.definition.measure_id: one for one in back_measures(back[2], None, MARKERS)}
    assert flat["BACK.KYPHOSIS"].value is None
    assert flat["BACK.ROTATION.MAX"].reason == flat["BACK.KYPHOSIS"].reason
    assert flat["BACK.TRUNK.LENGTH"].value is not None


def test_every_measure_names_its_source(back):
    for one in back_measures(back[2], back[3], MARKERS):
        assert one.definition.source.startswith("doi 10.")


def test_asymmetry_is_the_difference_to_the_mirrored_side(back):
    _, grid, profile, _ = back
    difference_m = asymmetry_m(grid, profile.line)
    assert np.nanmax(np.abs(difference_m[10:-10])) < 0.004
    x_m = np.arange(60) * 0.004 - 0.118
    slanted = BackGrid(x_m, grid.y_m, np.tile(0.1 * x_m, (len(grid.y_m), 1)))
    straight = find_symmetry_line(slanted, np.array([[0.0, 1.2, 0.0]]))
    expected_m = 0.2 * (x_m[None, :] - straight.at(slanted.y_m)[:, None])
    found_m = asymmetry_m(slanted, straight)
    known = np.isfinite(found_m)
    assert known.mean() > 0.5
    np.testing.assert_allclose(found_m[known], expected_m[known], atol=1e-3)


def test_asymmetry_does_not_bridge_gaps(back):
    holed_m = back[1].back_m.copy()
    holed_m[50:60, :40] = np.nan
    holed_m[70] = np.nan
    found_m = asymmetry_m(BackGrid(back[1].x_m, back[1].y_m, holed_m), back[2].line)
    assert np.isnan(found_m[55, -30:]).all()
    assert np.isnan(found_m[70]).all()


def test_an_arm_or_a_hole_before_the_spine_is_counted(back):
    _, grid, profile, _ = back
    params = TrunkParams()
    assert hidden_share(grid, profile, STATURE_M, params) == 0.0
    rows = np.abs(grid.y_m - 1.2) < 0.04
    armed_m = grid.back_m.copy()
    armed_m[rows] += 0.07
    assert (
        hidden_share(BackGrid(grid.x_m, grid.y_m, armed_m), profile, STATURE_M, params)
        > params.most_hidden
    )
    holed_m = grid.back_m.copy()
    holed_m[rows] = np.nan
    assert (
        hidden_share(BackGrid(grid.x_m, grid.y_m, holed_m), profile, STATURE_M, params)
        > params.most_hidden
    )
    far = BackGrid(grid.x_m, grid.y_m + 3.0, grid.back_m)
    assert hidden_share(far, profile, STATURE_M, params) == 1.0


def test_height_and_width_of_the_trunk(back):
    points_m = back[0]
    params = TrunkParams()
    chosen = points_m[back_points(points_m, STATURE_M, params), 1]
    assert chosen.min() >= 0.5 * STATURE_M
    assert chosen.max() <= 0.93 * STATURE_M
    assert chest_width_m(points_m, STATURE_M, params) == pytest.approx(0.317, abs=0.01)
    assert chest_width_m(points_m + 9.0, STATURE_M, params) == 0.0
