"""The rows of a report of an exercise, the same for every format."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from adibas.gestures.exercise import Repetition
from adibas.pipeline.exercise import ExerciseCheck

LEAST_RANGE_DEG = 5.0
"""Where the mean range of both sides is smaller, their symmetry means nothing."""


@dataclass(frozen=True, slots=True)
class RangeRow:
    """How far one angle went in one repetition, and in the therapist's."""

    number: int
    angle: str
    range_deg: float | None
    model_deg: float
    share: float | None
    deviation_deg: float | None
    """Root mean square over the repetition."""
    worst_deg: float | None
    worst_at: float | None
    """Share of the repetition."""


@dataclass(frozen=True, slots=True)
class SymmetryRow:
    """Both sides of one joint in one repetition; number 0 is the therapist's."""

    number: int
    motion: str
    left_deg: float
    right_deg: float
    index_percent: float | None


def range_rows(check: ExerciseCheck) -> Iterator[RangeRow]:
    """Yield the angles of every repetition."""
    shown = np.ptp(check.model.angles.deg, axis=0)
    for number, one in enumerate(check.repetitions, 1):
        for column, angle in enumerate(check.model.angles.names):
            yield _range_row(number, angle, one, column, float(shown[column]))


def symmetry_rows(check: ExerciseCheck) -> Iterator[SymmetryRow]:
    """Yield the joints of which both sides take part.

    Source: Robinson, Herzog & Nigg (1987), as in the report of a movement.
    """
    names = check.model.angles.names
    ranges = [np.ptp(check.model.angles.deg, axis=0)]
    ranges += [one.range_deg for one in check.repetitions]
    for number, some in enumerate(ranges):
        for name in names:
            motion = name.removeprefix("left_")
            if motion == name or f"right_{motion}" not in names:
                continue
            left = float(some[names.index(name)])
            right = float(some[names.index(f"right_{motion}")])
            mean = (left + right) / 2
            if math.isfinite(mean):
                index = 100.0 * (right - left) / mean if mean >= LEAST_RANGE_DEG else None
                yield SymmetryRow(number, motion, left, right, index)


def _range_row(number: int, angle: str, one: Repetition, column: int, model_deg: float) -> RangeRow:
    deviation = one.deviation_deg[:, column]
    known = np.isfinite(deviation)
    reached = float(one.range_deg[column])
    if not known.any() or not math.isfinite(reached):
        return RangeRow(number, angle, None, model_deg, None, None, None, None)
    worst = int(np.nanargmax(np.abs(deviation)))
    return RangeRow(
        *(number, angle, reached, model_deg, reached / model_deg),
        float(np.sqrt((deviation[known] ** 2).mean())),
        float(deviation[worst]),
        worst / max(len(deviation) - 1, 1),
    )
