"""The vertical and the horizon in a picture, from which way is up.

Lens distortion is left aside: towards the picture's border the lines are off by as much as it
bends straight lines, a few pixels.

Source: Hartley & Zisserman, Multiple View Geometry, 2nd ed., section 8.6 (vanishing points and
lines).
"""

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.calibration import CameraCalibration

Segment: TypeAlias = tuple[tuple[float, float], tuple[float, float]]
"""Two end points (u, v) on the border of the picture."""

PARALLEL = 1e-12


@dataclass(frozen=True, slots=True)
class PlumbLine:
    """How a camera stands, for drawing.

    Attributes
    ----------
    vertical : Segment or None
        Image of the vertical through what the picture's centre sees, upper end first; None where
        the camera looks straight down or up.
    horizon : Segment or None
        None where it lies outside the picture.
    roll_rad : float
        Between the vertical and the nearest of the picture's axes, -pi/4 ... pi/4: what the
        tripod's head must be turned by; positive where the picture shows the vertical turned
        clockwise.
    pitch_rad : float
        Look of the camera above the horizon; negative is downwards.
    """

    vertical: Segment | None
    horizon: Segment | None
    roll_rad: float
    pitch_rad: float


def plumb_line(up: FloatArray, camera: CameraCalibration) -> PlumbLine:
    """Return the vertical and the horizon in the picture of a camera.

    Parameters
    ----------
    up : (3,) array
        Unit vector that points up, in the axes of that camera.
    camera : CameraCalibration
        Its distortion has no effect.
    """
    k = camera.intrinsics
    centre_u, centre_v = (camera.width - 1) / 2, (camera.height - 1) / 2
    x, y = (centre_u - k.cx) / k.fx, (centre_v - k.cy) / k.fy
    along = (k.fx * (up[0] - x * up[2]), k.fy * (up[1] - y * up[2]))
    size = (camera.width, camera.height)
    vertical = None
    if math.hypot(*along) > PARALLEL:
        # The line a u + b v + c = 0 through the centre, in the direction of `along`.
        a, b = -along[1], along[0]
        vertical = _clipped((a, b, -(a * centre_u + b * centre_v)), size)
        if vertical is not None and _advance(vertical, along) > 0:
            vertical = (vertical[1], vertical[0])
    a, b = up[0] / k.fx, up[1] / k.fy
    horizon = _clipped((a, b, up[2] - a * k.cx - b * k.cy), size)
    return PlumbLine(
        vertical=vertical,
        horizon=horizon,
        roll_rad=_lean(math.atan2(along[0], -along[1])),
        pitch_rad=math.asin(float(np.clip(up[2], -1.0, 1.0))),
    )


def _advance(segment: Segment, along: tuple[float, float]) -> float:
    (u1, v1), (u2, v2) = segment
    return (u2 - u1) * along[0] + (v2 - v1) * along[1]


def _lean(angle_rad: float) -> float:
    """Return the angle to the nearest quarter turn, -pi/4 ... pi/4."""
    return float(angle_rad - math.pi / 2 * round(angle_rad / (math.pi / 2)))


def _clipped(line: tuple[float, float, float], size: tuple[int, int]) -> Segment | None:
    """Return where the line a u + b v + c = 0 crosses the border of a (width, height) picture."""
    a, b, c = (float(number) for number in line)
    left, top, right, bottom = -0.5, -0.5, size[0] - 0.5, size[1] - 0.5
    found: list[tuple[float, float]] = []
    if abs(b) > PARALLEL:
        found += [(u, -(a * u + c) / b) for u in (left, right)]
    if abs(a) > PARALLEL:
        found += [(-(b * v + c) / a, v) for v in (top, bottom)]
    inside = [(u, v) for u, v in found if left <= u <= right and top <= v <= bottom]
    if not inside:
        return None
    first = inside[0]
    last = max(inside, key=lambda point: math.dist(first, point))
    return None if first == last else (first, last)
