"""A protocol on a whole body, in rows: what the view itself gives beside what all views give."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from adibas.pipeline.body_protocol import SideMeasures
from adibas.reports.rows import MeasureRow, NumberRow, measure_row


@dataclass(frozen=True, slots=True)
class SideRow:
    """One measure of one side.

    Attributes
    ----------
    view : str
        Of `VIEWS`.
    seen : NumberRow or None
        By the markers of the view itself; None where they do not give it.
    fused : MeasureRow
        By the landmarks of all views.
    """

    view: str
    seen: NumberRow | None
    fused: MeasureRow


def side_rows(sides: Sequence[SideMeasures]) -> Iterator[SideRow]:
    """Yield the measures of each side in the protocol's order, in the language in use."""
    for side in sides:
        for seen, fused in side.pairs():
            own = None if seen is None else measure_row(seen).main
            yield SideRow(side.view, own, measure_row(fused))
