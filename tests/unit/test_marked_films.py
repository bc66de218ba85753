"""Simulated films of people with markers, and how well their markers are named."""

import math

import numpy as np
import pytest

from adibas.data.joints import JOINT_NAMES
from adibas.geometry.pinhole import project
from adibas.pipeline.marked_films import (
    FILM_KINDS,
    N_FRAMES,
    RATE_HZ,
    SEATED,
    TURNING,
    marked_films,
)
from adibas.pipeline.marked_people import MARKER_SD_M, SHOWN_M
from adibas.pipeline.skeleton_names import upright_turn
from benchmarks.accuracy_labelling_films import count_film
from benchmarks.labelling_names import NamesCount

SEED = 6150
"""Of people that nothing was learned from."""
MOVING_ASIDE, SEATED_ASIDE, TURNED_ASIDE = 20, 6, 7


def film_number(number):
    (film,) = marked_films(SEED, number + 1, number)
    return film


@pytest.fixture(scope="module")
def seated():
    return film_number(SEATED_ASIDE)


@pytest.fixture(scope="module")
def turning():
    return film_number(TURNED_ASIDE)


def counted(film, way="body known"):
    count = NamesCount()
    count_film(count, film, way)
    return count


def paths_of(film):
    """Return a dictionary of each name's (T, 3) places; NaN where it is hidden."""
    paths_m = {name: np.full((len(film.pictures), 3), np.nan) for name in JOINT_NAMES}
    for number, picture in enumerate(film.pictures):
        for name, point_m in zip(picture.names, picture.points_m, strict=True):
            paths_m[name][number] = point_m
    return paths_m


def test_films_are_of_all_kinds_from_all_sides_and_as_long_as_told(seated, turning):
    assert (seated.kind, seated.view) == (SEATED, "left_lateral")
    assert (turning.kind, turning.view) == (TURNING, "left_lateral")
    assert len(FILM_KINDS) == 4
    for film in (seated, turning):
        assert len(film.pictures) == len(film.times_s) == N_FRAMES
        np.testing.assert_allclose(np.diff(film.times_s), 1.0 / RATE_HZ)


def test_a_film_is_the_same_every_time(seated):
    again = film_number(SEATED_ASIDE)
    for one, other in zip(seated.pictures, again.pictures, strict=True):
        assert one.names == other.names
        np.testing.assert_array_equal(one.points_m, other.points_m)
        np.testing.assert_array_equal(one.depth_m, other.depth_m)


def test_the_camera_stands_still_and_so_do_the_feet_of_who_sits(seated):
    first = seated.pictures[0]
    assert all(np.array_equal(one.up, first.up) for one in seated.pictures)
    moved_m = {
        name: float(np.nanmax(np.nanmax(path_m, axis=0) - np.nanmin(path_m, axis=0)))
        for name, path_m in paths_of(seated).items()
        if not np.isnan(path_m).all()
    }
    feet_m, hands_m = (
        [moved for name, moved in moved_m.items() if name.endswith(part)]
        for part in ("foot", "hand")
    )
    assert max(feet_m) < 10 * MARKER_SD_M
    assert max(hands_m) > 0.1


def test_each_marker_lies_on_what_its_frame_shows(turning):
    for picture in turning.pictures:
        if not len(picture.names):
            continue
        u, v = np.rint(project(picture.points_m, picture.camera.intrinsics)).astype(int).T
        is_inside = (u < picture.camera.width) & (v < picture.camera.height) & (u >= 0) & (v >= 0)
        assert is_inside.mean() > 0.8
        off_m = picture.depth_m[v[is_inside], u[is_inside]] - picture.points_m[is_inside, 2]
        assert np.nanmedian(np.abs(off_m)) < SHOWN_M


def test_who_turns_round_shows_the_other_side_at_last(turning):
    """Half a turn, to the left or right: what was at the image's right is at its left."""
    paths_m = paths_of(turning)
    pairs_m = [
        paths_m[f"left_{joint}"] - paths_m[f"right_{joint}"] for joint in ("shoulder", "hip")
    ]
    across_m = max(pairs_m, key=lambda one: np.isfinite(one[:, 0]).sum())
    seen = np.flatnonzero(np.isfinite(across_m[:, 0]))
    flat_m = across_m[seen] @ upright_turn(turning.pictures[0].up).T
    angles = np.unwrap(np.arctan2(flat_m[:, 2], flat_m[:, 0]))
    turned = abs(angles[-1] - angles[0]) / (seen[-1] - seen[0])
    assert turned == pytest.approx(math.pi / N_FRAMES, rel=0.15)


@pytest.fixture(scope="module")
def aside():
    return film_number(MOVING_ASIDE)


@pytest.mark.parametrize("which", ["seated", "turning", "aside"])
def test_with_the_body_nearly_all_are_named(which, request):
    known = counted(request.getfixturevalue(which))
    assert known.n_right > 0.95 * known.n_markers
    assert known.n_wrong < 0.01 * known.n_markers


def test_of_whom_a_body_is_known_few_markers_from_the_side_are_plausible(aside):
    """By places alone they could as well be chance points: in all frames fewer than 2.5 nats for
    each."""
    assert counted(aside, "body not known").n_right == 0


def test_frames_in_which_nobody_is_found_do_not_take_the_names_from_others(seated):
    """By places alone many show nobody."""
    places = counted(seated, "body not known")
    assert places.n_right > 0.95 * places.n_markers
    assert places.n_wrong == 0


def test_live_names_are_carried_on_over_frames_that_are_not_sure(aside):
    alone, live = (counted(aside, f"{way}, body known") for way in ("each frame alone", "live"))
    assert live.n_right > alone.n_right
    assert live.n_wrong < 0.5 * alone.n_wrong
