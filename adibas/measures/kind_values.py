"""The value of each kind of measure from points, in the plane and in space.

h is the coordinate along the measure's axis, w the one along the vertical. Angles are in radians
in (-pi, pi], lengths in metres, indices are shares. Coinciding points give NaN.

Source: SAPO 0.68 for line_to_horizontal, line_to_vertical, deviation from straight and the
asymmetry index (2 (m - n) / (m + n)); signs by the axis are ours. The parts of trunk symmetry are
those of Suzuki et al. 1999 (Stud Health Technol Inform 59:81-84), with the letters of SCODIAC 2.7.
"""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from adibas.arrays import FloatArray

Directions: TypeAlias = tuple[FloatArray, FloatArray]
"""Axis and up, (..., 3) unit vectors."""

Value: TypeAlias = Callable[[FloatArray, Directions], FloatArray]
"""Of (..., n, 3) points in metres."""


def _line_to_horizontal(points_m: FloatArray, directions: Directions) -> FloatArray:
    h, w = _plane(points_m[..., 1, :] - points_m[..., 0, :], directions)
    return _angle(w, h)


def _line_to_vertical(points_m: FloatArray, directions: Directions) -> FloatArray:
    h, w = _plane(points_m[..., 0, :] - points_m[..., 1, :], directions)
    return _angle(h, w)


def _line_to_line(points_m: FloatArray, directions: Directions) -> FloatArray:
    first = _line_to_horizontal(points_m[..., :2, :], directions)
    return wrapped(_line_to_horizontal(points_m[..., 2:, :], directions) - first)


def _deviation(points_m: FloatArray, directions: Directions) -> FloatArray:
    """Positive where the second line turns towards the axis, as both go downwards."""
    h1, w1 = _plane(points_m[..., 1, :] - points_m[..., 0, :], directions)
    h2, w2 = _plane(points_m[..., 2, :] - points_m[..., 1, :], directions)
    is_line = (np.hypot(h1, w1) > 0) & (np.hypot(h2, w2) > 0)
    return np.where(is_line, np.arctan2(h1 * w2 - w1 * h2, h1 * h2 + w1 * w2), np.nan)


def _distance(points_m: FloatArray, directions: Directions) -> FloatArray:
    return np.hypot(*_plane(points_m[..., 1, :] - points_m[..., 0, :], directions))


def _distance_difference(points_m: FloatArray, directions: Directions) -> FloatArray:
    return _distance(points_m[..., :2, :], directions) - _distance(points_m[..., 2:, :], directions)


def _offset(points_m: FloatArray, directions: Directions) -> FloatArray:
    return _along(points_m[..., 0, :] - points_m[..., 1, :], directions[0])


def _offset_share(points_m: FloatArray, directions: Directions) -> FloatArray:
    whole = np.abs(_offset(points_m[..., 2:, :], directions))
    return _offset(points_m[..., :2, :], directions) / np.where(whole > 0, whole, np.nan)


def _asymmetry(points_m: FloatArray, directions: Directions) -> FloatArray:
    m = np.abs(_offset(points_m[..., :2, :], directions))
    return _index(m, np.abs(_offset(points_m[..., 2:, :], directions)))


def _side_share(points_m: FloatArray, directions: Directions) -> FloatArray:
    return 0.5 * _asymmetry(points_m, directions)


def _trunk_symmetry(points_m: FloatArray, directions: Directions) -> FloatArray:
    """Return the (..., 6) signed parts of trunk symmetry.

    Points are the lower and the upper end of the middle, then axillae, waist and shoulders, each
    first on the side that the axis leaves and then on the side that it points to. The middle is
    the vertical through the lower end: FAI-C7 = i / (c + d), FAI-A = (c - d) / (c + d),
    FAI-T = (a - b) / (a + b), HDI-S, HDI-A and HDI-T = heights apart / e.
    """
    low, high, *sides = (points_m[..., place, :] for place in range(8))
    pairs = tuple(zip(sides[::2], sides[1::2], strict=True))
    axis, up = directions
    widths_m = [
        (np.abs(_along(last - low, axis)), np.abs(_along(first - low, axis)))
        for first, last in pairs[:2]
    ]
    across_m = sum(widths_m[0])
    height_m = np.abs(_along(high - low, up))
    parts = [_along(high - low, axis) / np.where(across_m > 0, across_m, np.nan)]
    parts += [0.5 * _index(*both) for both in widths_m]
    upright_m = np.where(height_m > 0, height_m, np.nan)
    parts += [_along(pairs[pair][1] - pairs[pair][0], up) / upright_m for pair in (2, 0, 1)]
    return np.stack(parts, axis=-1)


def _elevation(points_m: FloatArray, directions: Directions) -> FloatArray:
    """Angle of a line with the level plane, on the side of the axis that its projection has."""
    line_m = points_m[..., 1, :] - points_m[..., 0, :]
    h, w = _plane(line_m, directions)
    return _angle(w, np.copysign(_level(line_m, directions), h))


def _spatial_difference(points_m: FloatArray, _directions: Directions) -> FloatArray:
    first = np.linalg.norm(points_m[..., 1, :] - points_m[..., 0, :], axis=-1)
    return np.asarray(first - np.linalg.norm(points_m[..., 3, :] - points_m[..., 2, :], axis=-1))


def _level_asymmetry(points_m: FloatArray, directions: Directions) -> FloatArray:
    m = _level(points_m[..., 0, :] - points_m[..., 1, :], directions)
    return _index(m, _level(points_m[..., 2, :] - points_m[..., 3, :], directions))


PROJECTED: dict[str, Value] = {
    "line_to_horizontal": _line_to_horizontal,
    "line_to_vertical": _line_to_vertical,
    "line_to_line": _line_to_line,
    "deviation_from_straight": _deviation,
    "angle": _deviation,  # folded to the internal angle afterwards
    "distance": _distance,
    "distance_difference": _distance_difference,
    "offset": _offset,
    "offset_share": _offset_share,
    "asymmetry_index": _asymmetry,
    "side_share": _side_share,
}

SUMS: dict[str, Value] = {"trunk_symmetry": _trunk_symmetry}
"""Kinds that are sums of the sizes of signed parts, and those parts: (..., P)."""

SPATIAL: dict[str, Value] = {
    "line_to_horizontal": _elevation,
    "distance_difference": _spatial_difference,
    "asymmetry_index": _level_asymmetry,
}
"""Those whose interval is of first order; the others are lengths and unsigned angles."""


def wrapped(angle_rad: FloatArray) -> FloatArray:
    """Return angles in [-pi, pi]."""
    return np.asarray(np.arctan2(np.sin(angle_rad), np.cos(angle_rad)))


def _along(vectors_m: FloatArray, direction: FloatArray) -> FloatArray:
    return np.asarray((vectors_m * direction).sum(axis=-1))


def _plane(vectors_m: FloatArray, directions: Directions) -> tuple[FloatArray, FloatArray]:
    axis, up = directions
    return _along(vectors_m, axis), _along(vectors_m, up)


def _level(vectors_m: FloatArray, directions: Directions) -> FloatArray:
    up = directions[1]
    return np.asarray(np.linalg.norm(vectors_m - _along(vectors_m, up)[..., None] * up, axis=-1))


def _angle(opposite: FloatArray, adjacent: FloatArray) -> FloatArray:
    return np.where(np.hypot(opposite, adjacent) > 0, np.arctan2(opposite, adjacent), np.nan)


def _index(m: FloatArray, n: FloatArray) -> FloatArray:
    return np.asarray(2.0 * (m - n) / np.where(m + n > 0, m + n, np.nan))
