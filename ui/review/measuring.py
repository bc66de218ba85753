"""Rows of measures from markers; the core measures, and is imported with the first of them."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from adibas.data.corrections import FreeMeasure
from adibas.data.markers import Marker
from adibas.data.sessions import Capture
from adibas.texts import translate as _
from ui.ports import Job, JobControl, Jobs
from ui.review.content import MeasureRow

if TYPE_CHECKING:
    from adibas.data.protocol_measures import ProtocolMeasures
    from adibas.data.protocols import Protocol
    from adibas.pipeline.review import Measures

MM_PER_M = 1000.0


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """What is to be measured.

    Attributes
    ----------
    capture : Capture
    markers : tuple of Marker
        As seen, a drag in progress included.
    by_hand : frozenset of str
        Labels of those that were placed by hand.
    protocol : Protocol or None
        To be followed, too.
    rotation_deg : int
        How far the picture is turned clockwise to be upright.
    """

    capture: Capture
    markers: tuple[Marker, ...]
    by_hand: frozenset[str] = frozenset()
    protocol: "Protocol | None" = None
    rotation_deg: int = 0

    @property
    def is_by_protocol(self) -> bool:
        """Whether the protocol measures something in this view."""
        return self.protocol is not None and self.capture.view in self.protocol.views


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """Every pair and triplet, and the protocol's measures where one is followed."""

    rows: tuple[MeasureRow, ...] = ()
    protocol: "ProtocolMeasures | None" = None


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


def measured(asked: Asked) -> Measured:
    """Measure everything."""
    rows = all_rows(asked.markers)
    if asked.protocol is None or not asked.is_by_protocol:
        return Measured(rows)
    from adibas.pipeline.protocol_measuring import ProtocolWish, measured_capture

    wish = ProtocolWish(asked.protocol)
    found = measured_capture(asked.capture, asked.markers, wish, asked.rotation_deg, asked.by_hand)
    return Measured(rows, found)


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

    def __init__(self, jobs: Jobs, show: Callable[[Measured], None]) -> None:
        self._jobs = jobs
        self._show = show
        self._job: Job | None = None
        self._wanted: Asked | None = None
        self.is_warm = False

    def follow(self, asked: Asked) -> None:
        """Show the measures of these markers as soon as possible."""
        self._wanted = asked
        if self._job is not None and self._job.is_running:
            return

        def work(_control: JobControl) -> Measured:
            return measured(asked)

        def done(found: Measured) -> None:
            self.is_warm = True
            newest = self._wanted
            if newest is None:
                return
            if newest.capture.capture_id == asked.capture.capture_id:
                self._show(found)  # a drag may have overtaken: the table follows, a bit late
            if newest is not asked:
                self.follow(newest)

        self._job = self._jobs.start(_("Measuring"), work, done)

    def clear(self) -> None:
        """Show nothing; what still runs is not shown."""
        self._wanted = None
        self._show(Measured())
