"""What a node asks of a pixel; compiled for float32 images, many of them end to end in one array.

- ``features`` (F, 5 or more) float32: ``kind, u_row, u_column, v_row, v_column``, offsets in
  metres on the body.
- ``places`` (B, 4) int64: where each image begins, its height, its width; the fourth is not used.
- A pixel is ``at = (image, row, column)``, and how many pixels a metre is there.

What lies outside the image reads `far_m`, without slope. Rows of tables are passed as the table
and a number: a view of a row costs a counted reference.
"""

import math

from adibas.arrays import Float32Array, IntArray
from adibas.kernels import compiled

KIND, U_ROW, U_COLUMN, V_ROW, V_COLUMN = range(5)
BEGIN, HEIGHT, WIDTH = range(3)


@compiled
def look_up(
    image: Float32Array, places: IntArray, number: int, row: int, column: int, outside: float
) -> float:
    """Return the value at a pixel; `outside` where the image has none."""
    if 0 <= row < places[number, HEIGHT] and 0 <= column < places[number, WIDTH]:
        return float(image[places[number, BEGIN] + row * places[number, WIDTH] + column])
    return outside


@compiled
def offset(features: Float32Array, feature: int, part: int, scale: float) -> int:
    """Return an offset in whole pixels."""
    pixels = features[feature, part] * scale
    return math.floor(float(pixels) + 0.5)


@compiled
def depth_step(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    depth_m: Float32Array,
    places: IntArray,
    at: tuple[int, int, int],
    scale: float,
    features: Float32Array,
    feature: int,
    far_m: float,
) -> float:
    """Return equation 6.16 at a pixel, metres."""
    number, row, column = at
    u_row = row + offset(features, feature, U_ROW, scale)
    u_column = column + offset(features, feature, U_COLUMN, scale)
    v_row = row + offset(features, feature, V_ROW, scale)
    v_column = column + offset(features, feature, V_COLUMN, scale)
    first = look_up(depth_m, places, number, u_row, u_column, far_m)
    return first - look_up(depth_m, places, number, v_row, v_column, far_m)


@compiled
def gradient_angle(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    slope_x: Float32Array,
    slope_y: Float32Array,
    places: IntArray,
    at: tuple[int, int, int],
    scale: float,
    features: Float32Array,
    feature: int,
) -> float:
    """Return the angle from the gradient at u to that at v, -pi to pi; 0 where one is none.

    Source: thesis, equation 6.26, by its text ("the angle between the two gradient vectors"); the
    formula as printed is the angle of their difference.
    """
    number, row, column = at
    u_row = row + offset(features, feature, U_ROW, scale)
    u_column = column + offset(features, feature, U_COLUMN, scale)
    v_row = row + offset(features, feature, V_ROW, scale)
    v_column = column + offset(features, feature, V_COLUMN, scale)
    ux = look_up(slope_x, places, number, u_row, u_column, 0.0)
    uy = look_up(slope_y, places, number, u_row, u_column, 0.0)
    vx = look_up(slope_x, places, number, v_row, v_column, 0.0)
    vy = look_up(slope_y, places, number, v_row, v_column, 0.0)
    sine, cosine = ux * vy - uy * vx, ux * vx + uy * vy
    # The angle of (0, -0) would be pi.
    return math.atan2(sine, cosine) if sine != 0.0 or cosine != 0.0 else 0.0


@compiled
def feature_value(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    depth_m: Float32Array,
    slope_x: Float32Array,
    slope_y: Float32Array,
    places: IntArray,
    at: tuple[int, int, int],
    scale: float,
    features: Float32Array,
    feature: int,
    far_m: float,
) -> float:
    """Return a feature of either kind at a pixel, metres or radians."""
    if features[feature, KIND] > 0:
        return gradient_angle(slope_x, slope_y, places, at, scale, features, feature)
    return depth_step(depth_m, places, at, scale, features, feature, far_m)
