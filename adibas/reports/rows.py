"""The numbers of a report in clinical units: one place, so that every format shows the same."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from adibas.data.markers import Marker
from adibas.data.posture import PostureAnalysis

MM_PER_M = 1000.0


@dataclass(frozen=True, slots=True)
class MarkerRow:
    """A marker in pixels and millimetres; None where there is no position."""

    label: str
    u_px: float
    v_px: float
    position_mm: tuple[float, float, float] | None
    deviation_mm: tuple[float, float, float] | None


@dataclass(frozen=True, slots=True)
class DistanceRow:
    """A distance and its 95 % interval, millimetres."""

    a: str
    b: str
    mm: float
    low_mm: float
    high_mm: float


@dataclass(frozen=True, slots=True)
class AngleRow:
    """An angle, its 95 % interval and its bias, degrees."""

    a: str
    vertex: str
    c: str
    deg: float
    low_deg: float
    high_deg: float
    bias_deg: float


def marker_rows(analysis: PostureAnalysis) -> Iterator[MarkerRow]:
    """Yield the markers in their order."""
    for marker in analysis.markers:
        yield MarkerRow(marker.label, marker.u, marker.v, *_millimetres(marker))


def distance_rows(analysis: PostureAnalysis) -> Iterator[DistanceRow]:
    """Yield the distances in their order."""
    for distance in analysis.distances:
        low_m, high_m = distance.interval_m
        yield DistanceRow(
            distance.a,
            distance.b,
            distance.value_m * MM_PER_M,
            low_m * MM_PER_M,
            high_m * MM_PER_M,
        )


def angle_rows(analysis: PostureAnalysis) -> Iterator[AngleRow]:
    """Yield the angles in their order."""
    for angle in analysis.angles:
        low_rad, high_rad = angle.interval_rad
        yield AngleRow(
            angle.a,
            angle.vertex,
            angle.c,
            math.degrees(angle.value_rad),
            math.degrees(low_rad),
            math.degrees(high_rad),
            math.degrees(angle.bias_rad),
        )


def _millimetres(
    marker: Marker,
) -> tuple[tuple[float, float, float] | None, tuple[float, float, float] | None]:
    """Return position and standard deviation of each axis, or None twice."""
    if marker.position_m is None or marker.covariance_m2 is None:
        return None, None
    x, y, z = (marker.position_m * MM_PER_M).tolist()
    sx, sy, sz = (np.sqrt(np.diag(marker.covariance_m2)) * MM_PER_M).tolist()
    return (x, y, z), (sx, sy, sz)
