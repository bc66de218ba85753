"""A wrong depth tilts the floor by what the covariance says."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.calibration.vertical import Vertical, vertical_from_floor
from adibas.calibration.vertical_uncertainty import with_depth_error
from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.planes import Plane

CAMERA = CameraCalibration(640, 480, Intrinsics(575.0, 570.0, 320.0, 240.0))
LEAN = 0.1
UP = np.array([0.0, -np.cos(LEAN), -np.sin(LEAN)])
FLOOR = Plane(UP, 1.0)
TERMS = (0.001, -0.002, 0.003, -0.001, 0.002)


def pixels():
    rows, columns = np.mgrid[380:470:15, 40:600:40].astype(float)
    return columns.ravel(), rows.ravel()


def blocks(camera=CAMERA, bias=None):
    """Return the floor as a camera that is taken for `camera`, corrected by `bias`, sees it."""
    u, v = pixels()
    k = CAMERA.intrinsics
    rays = np.stack([(u - k.cx) / k.fx, (v - k.cy) / k.fy, np.ones_like(u)], axis=-1)
    z_m = -FLOOR.offset_m / (rays @ UP)
    wrong = camera.intrinsics
    x, y = (u - wrong.cx) / wrong.fx, (v - wrong.cy) / wrong.fy
    if bias is not None:
        p, q, r, s, t = bias.image_term
        square = bias.c + p * x + q * y + r * x * x + s * x * y + t * y * y
        z_m = bias.a + bias.b * z_m + square * z_m**2
    return np.stack([x, y, np.ones_like(x)], axis=-1) * z_m[:, None]


def known(name, sd):
    return RgbdCalibration(
        depth=CAMERA,
        depth_bias=DepthBias(image_term=TERMS),
        parameter_names=("color.fx", name),
        covariance=np.diag([100.0, sd**2]),
    )


EXACT = Vertical(-UP, 0.0, FLOOR, 0.0)
NONE = DepthBias(image_term=(0.0,) * 5)


@pytest.mark.parametrize(
    ("name", "step"),
    [
        ("depth_bias.a", 0.001),
        ("depth_bias.b", 0.001),
        ("depth_bias.c", 0.001),
        ("depth_bias.image_term.1", 0.001),
        ("depth_bias.image_term.4", 0.001),
        ("depth.fx", 0.5),
        ("depth.fy", 0.5),
        ("depth.cx", 0.5),
        ("depth.cy", 0.5),
    ],
)
def test_a_wrong_depth_tilts_the_floor_by_its_standard_deviation(name, step):
    bias, camera = NONE, CAMERA
    group, _, last = name.partition(".")
    if group == "depth":
        moved = replace(camera.intrinsics, **{last: getattr(camera.intrinsics, last) + step})
        camera = replace(camera, intrinsics=moved)
    elif last in "abc":
        bias = replace(bias, **{last: getattr(bias, last) + step})
    else:
        terms = list(bias.image_term)
        terms[int(last[-1])] = step
        bias = replace(bias, image_term=tuple(terms))
    tilted = vertical_from_floor(blocks(camera, bias), FLOOR)
    angle_rad = tilted.disagreement_rad(EXACT)
    predicted = with_depth_error(EXACT, blocks(), known(name, step)).sd_rad
    assert predicted == pytest.approx(angle_rad, rel=0.03, abs=2e-6)


def test_its_own_scatter_comes_on_top():
    before = Vertical(-UP, 0.003, FLOOR, 0.001)
    alone = with_depth_error(EXACT, blocks(), known("depth_bias.b", 0.01)).sd_rad
    both = with_depth_error(before, blocks(), known("depth_bias.b", 0.01)).sd_rad
    assert both == pytest.approx(np.hypot(alone, 0.003))


def test_nothing_comes_on_top_where_nothing_is_known_or_no_floor_was_seen():
    sensor = Vertical(-UP, 0.003)
    assert with_depth_error(sensor, blocks(), known("depth_bias.a", 0.1)) is sensor
    unknown = RgbdCalibration(depth=CAMERA)
    assert with_depth_error(EXACT, blocks(), unknown) is EXACT
    assert with_depth_error(EXACT, blocks(), known("color.cy", 1.0)) is EXACT
