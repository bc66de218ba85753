"""What a node asks of a pixel; compiled for float32 images, many of them end to end in one array.

- ``features`` (F, 5 or more) float32: ``kind, u_row, u_column, v_row, v_column``, offsets in
  metres on the body.
- ``places`` (B, 4) int64: where the first pixel of each image is, its height, its width, and how
  much further the next row is: every image has a border, one pixel wide, of what is read outside.
- A pixel is ``at = (image, row, column)``, and how many pixels a metre is there.

Rows of tables are passed as the table and a number: a view of a row costs a counted reference.
"""

import math

from adibas.arrays import Float32Array, IntArray
from adibas.kernels import compiled

KIND, U_ROW, U_COLUMN, V_ROW, V_COLUMN = range(5)
BEGIN, HEIGHT, WIDTH, STRIDE = range(4)


@compiled
def look_up(image: Float32Array, places: IntArray, number: int, row: int, column: int) -> float:
    """Return the value at a pixel; far away from the image, that of its border.

    To cut coordinates costs less than to ask whether they are inside: nobody can guess that.
    """
    inside_row = min(max(row, -1), places[number, HEIGHT])
    inside_column = min(max(column, -1), places[number, WIDTH])
    return float(image[places[number, BEGIN] + inside_row * places[number, STRIDE] + inside_column])


@compiled
def offset(features: Float32Array, feature: int, part: int, scale: float) -> int:
    """Return an offset in whole pixels."""
    pixels = features[feature, part] * scale
    return math.floor(float(pixels) + 0.5)


@compiled
def depth_step(
    depth_m: Float32Array,
    places: IntArray,
    at: tuple[int, int, int],
    scale: float,
    features: Float32Array,
    feature: int,
) -> float:
    """Return equation 6.16 at a pixel, metres."""
    number, row, column = at
    u_row = row + offset(features, feature, U_ROW, scale)
    u_column = column + offset(features, feature, U_COLUMN, scale)
    v_row = row + offset(features, feature, V_ROW, scale)
    v_column = column + offset(features, feature, V_COLUMN, scale)
    first = look_up(depth_m, places, number, u_row, u_column)
    return first - look_up(depth_m, places, number, v_row, v_column)


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
    ux = look_up(slope_x, places, number, u_row, u_column)
    uy = look_up(slope_y, places, number, u_row, u_column)
    vx = look_up(slope_x, places, number, v_row, v_column)
    vy = look_up(slope_y, places, number, v_row, v_column)
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
) -> float:
    """Return a feature of either kind at a pixel, metres or radians."""
    if features[feature, KIND] > 0:
        return gradient_angle(slope_x, slope_y, places, at, scale, features, feature)
    return depth_step(depth_m, places, at, scale, features, feature)
