"""Rows of measures from markers; the core measures, and is imported with the first of them."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from adibas.data.corrections import FreeMeasure
from adibas.data.markers import Marker
from adibas.texts import translate as _
from ui.ports import Job, JobControl, Jobs
from ui.review.content import MeasureRow

if TYPE_CHECKING:
    from adibas.pipeline.review import Measures

MM_PER_M = 1000.0


def free_rows(
    markers: tuple[Marker, ...], chosen: tuple[FreeMeasure, ...]
) -> tuple[MeasureRow, ...]:
    """Measure what was asked for; a row has no value where a marker has no position."""
    if not chosen:
        return ()
    from adibas.pipeline.review import chosen_measures

    found = {row.labels: row for row in _rows(chosen_measures(markers, chosen))}
    return tuple(found.get(one.labels, MeasureRow(one.labels)) for one in chosen)


def all_rows(markers: tuple[Marker, ...]) -> tuple[MeasureRow, ...]:
    """Measure every pair, then every triplet at each of its vertices."""
    from adibas.pipeline.review import measures_of

    return _rows(measures_of(markers))


def _rows(measures: "Measures") -> tuple[MeasureRow, ...]:
    distances = (
        MeasureRow(
            (found.a, found.b),
            MM_PER_M * found.value_m,
            (MM_PER_M * found.interval_m[0], MM_PER_M * found.interval_m[1]),
        )
        for found in measures.distances
    )
    angles = (
        MeasureRow(
            (found.a, found.vertex, found.c),
            math.degrees(found.value_rad),
            (math.degrees(found.interval_rad[0]), math.degrees(found.interval_rad[1])),
        )
        for found in measures.angles
    )
    return (*distances, *angles)


class MeasureTable:
    """Keeps the table of all measures near the markers: one job at a time, the newest wins.

    Forty markers have 30,000 angles, too many for the window's thread while one is dragged.

    Attributes
    ----------
    is_warm : bool
        Whether the core has measured once: the first time takes half a second.
    """

    def __init__(self, jobs: Jobs, show: Callable[[tuple[MeasureRow, ...]], None]) -> None:
        self._jobs = jobs
        self._show = show
        self._job: Job | None = None
        self._wanted: tuple[str, tuple[Marker, ...]] = ("", ())
        self.is_warm = False

    def follow(self, capture_id: str, markers: tuple[Marker, ...]) -> None:
        """Show the measures of these markers as soon as possible."""
        self._wanted = (capture_id, markers)
        if self._job is not None and self._job.is_running:
            return

        def work(_control: JobControl) -> tuple[MeasureRow, ...]:
            return all_rows(markers)

        def done(rows: tuple[MeasureRow, ...]) -> None:
            self.is_warm = True
            wanted_id, newest = self._wanted
            if wanted_id == capture_id:  # a drag may have overtaken: the table follows, a bit late
                self._show(rows)
            if newest is not markers:
                self.follow(wanted_id, newest)

        self._job = self._jobs.start(_("Measuring"), work, done)

    def clear(self) -> None:
        """Show nothing; what still runs is not shown."""
        self._wanted = ("", ())
        self._show(())
