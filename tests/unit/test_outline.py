"""The body in the colour image: where it lies, and where it goes on beyond the depth."""

import numpy as np
import pytest

from adibas.alignment.registration import register_pixels
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.pipeline.outline import body_in_color

DEPTH = CameraCalibration(640, 480, Intrinsics(580, 580, 319.5, 239.5))
COLOR = CameraCalibration(1280, 1024, Intrinsics(1050, 1050, 639.5, 511.5))
MARGIN_M = 0.01


def outline(body, behind_m=3.0):
    depth_m = np.where(body, 2.0, behind_m).astype(np.float32)
    registration = register_pixels(depth_m, RgbdCalibration(COLOR, DEPTH))
    return body_in_color(body, registration, COLOR, MARGIN_M)


def box(rows, columns):
    body = np.zeros((480, 640), bool)
    body[rows, columns] = True
    return body


@pytest.mark.parametrize(("behind_m", "share"), [(np.nan, 1.0), (3.0, 0.5)])
def test_the_outline_is_widened_by_the_margin_and_by_half_of_it_before_a_wall(behind_m, share):
    found = outline(box(slice(100, 300), slice(200, 400)), behind_m)
    margin = share * MARGIN_M * 1050 / 2.0
    top = (100 - 0.5 - 239.5) / 580 * 1050 + 511.5
    left = (200 - 0.5 - 319.5) / 580 * 1050 + 639.5
    rows, columns = np.flatnonzero(found.any(axis=1)), np.flatnonzero(found.any(axis=0))
    assert abs(rows[0] - (top - margin)) < 1.5
    assert abs(columns[0] - (left - margin)) < 1.5


def test_a_hole_of_a_marker_is_closed():
    body = box(slice(100, 300), slice(200, 400))
    body[200:203, 300:303] = False
    assert outline(body)[380:560, 460:740].all()


def outline_with_hole(radius_px, in_hole_m):
    body = box(slice(50, 400), slice(150, 450))
    rows, columns = np.indices(body.shape)
    hole = (rows - 225) ** 2 + (columns - 300) ** 2 <= radius_px**2
    depth_m = np.where(body, 2.0, 3.0).astype(np.float32)
    depth_m[hole] = in_hole_m
    registration = register_pixels(depth_m, RgbdCalibration(COLOR, DEPTH))
    found = body_in_color(body & ~hole, registration, COLOR, MARGIN_M)
    return found[380:600, 500:710]


def test_a_place_without_depth_that_the_body_surrounds_is_body():
    assert outline_with_hole(12, np.nan).all()  # 41 mm


@pytest.mark.parametrize(("radius_px", "in_hole_m"), [(18, np.nan), (12, 3.0)])
def test_a_gap_that_is_large_or_shows_the_wall_is_no_body(radius_px, in_hole_m):
    assert not outline_with_hole(radius_px, in_hole_m).all()


@pytest.mark.parametrize(
    ("rows", "columns", "edge"),
    [
        (slice(100, 480), slice(250, 300), np.s_[-1, 500:580]),
        (slice(0, 300), slice(250, 300), np.s_[0, 520:590]),
        (slice(200, 260), slice(0, 300), np.s_[450:530, 0]),
        (slice(200, 260), slice(300, 640), np.s_[450:530, -1]),
    ],
    ids=["below", "above", "left", "right"],
)
def test_a_body_cut_off_by_the_depth_image_goes_on_to_the_edge(rows, columns, edge):
    found = outline(box(rows, columns))
    assert found[edge].any()
    whole = outline(box(slice(100, 300), slice(200, 400)))
    assert not whole[[0, -1]].any()
    assert not whole[:, [0, -1]].any()


def test_two_legs_go_on_apart():
    body = box(slice(100, 480), slice(250, 280)) | box(slice(100, 480), slice(340, 370))
    last_row = outline(body)[-1]
    assert last_row[540]
    assert last_row[700]
    assert not last_row[620]


def test_a_body_beside_the_colour_picture_has_no_outline_in_it():
    narrow = CameraCalibration(200, 1024, Intrinsics(1050, 1050, 99.5, 511.5))
    body = box(slice(100, 480), slice(0, 60))
    depth_m = np.where(body, 2.0, 3.0).astype(np.float32)
    registration = register_pixels(depth_m, RgbdCalibration(narrow, DEPTH))
    assert not body_in_color(body, registration, narrow, MARGIN_M).any()


def rows_of_border(found):
    """Return the columns of the left border, row by row."""
    rows = np.flatnonzero(found.any(axis=1))
    return found[rows].argmax(axis=1)


def test_the_noise_of_a_border_is_not_seen():
    body = box(slice(100, 300), slice(200, 400))
    rng = np.random.default_rng(5)
    for row in range(100, 300):
        body[row, 200 : 200 + rng.integers(0, 4)] = False
    columns = rows_of_border(outline(body))[40:-40]
    assert np.abs(np.diff(columns)).mean() < 0.25
    assert np.abs(np.diff(columns)).max() <= 2


def test_a_leg_that_is_carried_on_grows_wider_little_by_little():
    found = outline(box(slice(100, 480), slice(250, 300)))
    below = rows_of_border(found)[-120:]
    assert below[0] - below[-1] > 10, "it grows wider"
    assert np.abs(np.diff(below)).max() <= 2, "without a step"
