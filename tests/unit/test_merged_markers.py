"""Two markers in one spot are told by its length, whichever way they are turned."""

import numpy as np
import pytest

from adibas.data.markers import Marker
from adibas.markers.blobs import Blob
from adibas.markers.burst import BurstMarker
from adibas.markers.detection import Detections
from adibas.markers.merged import MergedParams, are_merged
from adibas.pipeline.posture_checks import (
    MOST_BESIDE,
    apart_from_others,
    are_gaps,
    refuse_beside,
)


def blob(u, v, separation=10.0):
    color = np.zeros(3)
    return Blob(u, v, 20, 3.0, 0.9, separation, 0.8, 0.9, np.eye(2), 1.0, 1.0, 0.0, color, color)


def seen(turned_rad, radius_m=0.005):
    """Return radius of equal area and axis ratio of a disc that is turned away."""
    ratio = np.cos(turned_rad)
    return radius_m * np.sqrt(ratio), ratio


def judged(*spots):
    radii_m, ratios = np.array(spots).T
    return are_merged(radii_m, ratios).tolist()


def test_a_disc_is_as_long_however_it_is_turned():
    assert judged(*(seen(angle) for angle in np.deg2rad([0, 10, 30, 50, 65]))) == [False] * 5


@pytest.mark.parametrize(("ratio", "is_two"), [(0.5, True), (0.79, True), (0.9, False)])
def test_a_spot_as_long_as_two_is_two_unless_it_is_round(ratio, is_two):
    long_one = (0.0075 * np.sqrt(ratio), ratio)
    assert judged(*[seen(0.3)] * 4, long_one) == [*[False] * 4, is_two]


def test_a_spot_drawn_long_by_its_motion_is_one_marker_where_size_counts_too():
    ratio = 0.5
    drawn, two = (0.005, ratio), (0.007, ratio)
    radii_m, ratios = np.array([*[seen(0.0)] * 5, drawn, two]).T
    found = are_merged(radii_m, ratios, MergedParams(least_radius=1.1))
    assert found.tolist() == [*[False] * 6, True]


def test_three_markers_have_no_usual_length():
    assert judged(seen(0), seen(0), (0.01, 0.5)) == [False] * 3


def found(radius_px, ratio, depth_m, *, u=100.0, is_faint=False, rough_depth_m=None):
    """Return one marker as it looks, and where it is."""
    looks = BurstMarker(u, 50.0, radius_px, ratio, np.eye(2), 30, is_faint)
    if depth_m is None:
        return looks, Marker("m", u, 50.0, radius_px, np.eye(2), rough_depth_m=rough_depth_m)
    place_m = np.array([0.0, 0.0, depth_m])
    return looks, Marker("m", u, 50.0, radius_px, np.eye(2), place_m, np.eye(3))


def test_a_near_marker_is_not_two_far_ones_and_one_without_a_place_is_kept():
    spots = [found(5, 0.7, 2.0), found(5, 0.7, 2.0), found(5, 0.7, 2.0), found(10, 0.7, 1.0)]
    spots += [found(30, 0.4, None), found(9, 0.6, 2.0)]
    looks, markers = zip(*spots, strict=True)
    nowhere = np.zeros(len(markers), bool)
    kept, refused = apart_from_others(looks, markers, nowhere, 1000.0)
    assert kept == markers[:5]
    assert [one.reason for one in refused] == ["as long as two markers side by side"]


class Outlines:
    """A finder whose depth has an outline at column 300."""

    def is_between_surfaces(self, pixel_uv):
        return pixel_uv[0] == 300.0


def test_what_is_faint_and_small_and_has_several_surfaces_but_no_skin_is_a_gap():
    at = {"u": 300.0, "is_faint": True}
    spots = [
        found(4, 1.0, None, **at, rough_depth_m=2.0),
        found(4, 1.0, None, u=300.0, rough_depth_m=2.0),
        found(4, 1.0, 2.0, **at),
        found(4, 1.0, None, u=200.0, is_faint=True, rough_depth_m=2.0),
        found(4, 1.0, None, **at, rough_depth_m=2.3),
        found(4, 1.0, None, **at),
        *[found(5, 1.0, 2.0)] * 7,
    ]
    looks, markers = zip(*spots, strict=True)
    is_gap = are_gaps(looks, markers, Outlines())
    assert is_gap.tolist() == [True, *[False] * 12]
    kept, refused = apart_from_others(looks, markers, is_gap, 1000.0)
    assert kept == markers[1:]
    assert [(one.u, one.reason) for one in refused] == [
        (300.0, "faint, and between two surfaces, as a gap between fingers is")
    ]
    assert not are_gaps(looks[5:6], markers[5:6], Outlines()).any()


def test_the_rim_of_a_marker_is_no_spot_beside_the_patient_and_a_full_wall_is_not_told():
    at_rim, beside = blob(105.0, 50.0), blob(300.0, 40.0)
    _looks, marker = found(5, 1.0, 2.0)
    (told,) = refuse_beside(Detections((at_rim, beside), (), 0.01), [marker], 0.3)
    assert (told.u, told.v, told.reason) == (300.0, 40.0, "not on the patient")
    assert refuse_beside(Detections((beside,), (), 0.4), [], 0.3) == ()
    many = tuple(blob(10.0 * i, 0.0, separation=float(i)) for i in range(30))
    surest = refuse_beside(Detections(many, (), 0.01), [], 0.3)
    assert [one.u for one in surest] == [10.0 * i for i in range(29, 29 - MOST_BESIDE, -1)]
