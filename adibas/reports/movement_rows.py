"""The rows of a movement's report, the same for every format."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from adibas.data.movement import Movement
from adibas.reports.movement_facts import SURE
from adibas.reports.movement_texts import JOINT_MOTIONS, angle_text
from adibas.texts import translate as _


@dataclass(frozen=True, slots=True)
class RangeRow:
    """How far one angle went; None where it is not known, or a speed is not told from noise."""

    angle: str
    least_deg: float
    greatest_deg: float
    range_deg: float
    sure_deg: float | None
    least_at_s: float
    greatest_at_s: float
    fastest_deg_s: float | None
    sure_deg_s: float | None
    is_speed_noise: bool
    seen_percent: float


@dataclass(frozen=True, slots=True)
class SymmetryRow:
    """Both sides of one joint; no index where they hardly moved."""

    motion: str
    left_deg: float
    right_deg: float
    difference_deg: float
    index_percent: float | None


def range_rows(movement: Movement) -> Iterator[RangeRow]:
    """Yield the angles in the order of the definition."""
    for found in movement.ranges:
        yield RangeRow(
            angle_text(found.name),
            found.least_deg,
            found.greatest_deg,
            found.range_deg,
            _known(SURE * found.sd_deg),
            found.least_at_s,
            found.greatest_at_s,
            None if found.is_speed_noise else _known(found.fastest_deg_s),
            _known(SURE * found.speed_sd_deg_s),
            found.is_speed_noise,
            100.0 * found.seen_share,
        )


def symmetry_rows(movement: Movement) -> Iterator[SymmetryRow]:
    """Yield the joints of which both sides were seen."""
    for found in movement.symmetries:
        yield SymmetryRow(
            _(JOINT_MOTIONS[found.name]),
            found.left_deg,
            found.right_deg,
            found.right_deg - found.left_deg,
            found.index_percent,
        )


def curve_table(movement: Movement) -> Iterator[tuple[float | None, ...]]:
    """Yield a row for each time: seconds, then degrees and degrees a second of every angle."""
    columns = [movement.times_s]
    for curve in movement.curves:
        columns += [curve.deg, curve.speed_deg_s]
    for row in np.column_stack(columns).tolist():
        yield tuple(_known(cell) for cell in row)


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value
