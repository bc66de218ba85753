"""Markerless joints: real depth of people never seen, hard simulated scenes, and bad input.

Printed by ``adibas benchmark accuracy limbs`` as well.
"""

from collections.abc import Iterable

from benchmarks import pose_odd, pose_real, pose_scenes, pose_sides
from benchmarks.table import Row


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` a part of each."""
    yield from pose_real.rows(quick=quick)
    yield from pose_scenes.rows(quick=quick)
    yield from pose_sides.rows(quick=quick)
    yield from pose_odd.rows(quick=quick)
