"""The lines and bars of the timeline. Knows nothing of Qt."""

from collections.abc import Iterable, Iterator, Sequence

from adibas.behaviour.editing import Draft
from adibas.behaviour.matching import Difference
from adibas.data.coding import Coding, Occurrence
from ui.behaviour.content import Bar, Layer, Row, Timeline

COLORS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#B59F00", "#7F7F7F")
"""Of behaviours without a colour. Source: Okabe & Ito, Color Universal Design (2008), the yellow
darker so that it is seen on white."""

Place = tuple[str, str]


def timeline_of(
    draft: Draft,
    subject: str,
    chosen: Occurrence | None,
    other: Coding | None = None,
    differences: Sequence[Difference] = (),
) -> Timeline:
    """Return what is seen of a draft, and of another observer's coding beside it.

    Parameters
    ----------
    draft : Draft
    subject : str
        All behaviours of this one have a line, also those that do not occur.
    chosen : Occurrence or None
    other : Coding or None
        Of another observer.
    differences : sequence of Difference
        Between the two.
    """
    coding = draft.coding
    layers: tuple[tuple[Layer, Sequence[Occurrence]], ...] = (
        ("coded", coding.occurrences),
        ("begun", draft.begun),
        ("proposed", draft.proposed),
        ("other", () if other is None else other.occurrences),
    )
    occurring = {(one.subject, one.behaviour) for _layer, some in layers for one in some}
    places = {place: row for row, place in enumerate(_places(draft, subject, occurring))}
    bars = [
        Bar(
            places[one.subject, one.behaviour],
            one.begin_ms,
            one.end_ms,
            layer,
            None if layer == "other" else one,
        )
        for layer, some in layers
        for one in some
    ]
    bars += [
        Bar(places[one.subject, one.behaviour], one.begin_ms, one.end_ms, "difference")
        for one in differences
        if (one.subject, one.behaviour) in places
    ]
    return Timeline(
        coding.begin_ms,
        coding.end_ms,
        tuple(_row(draft, *place) for place in places),
        tuple(bars),
        coding.sections,
        chosen,
    )


def _places(draft: Draft, subject: str, occurring: set[Place]) -> Iterator[Place]:
    """Yield the lines in the order of the scheme, then what it does not know."""
    coding = draft.coding
    names = [one.name for one in coding.ethogram.behaviours]
    known = [(who, name) for who in coding.subjects for name in names]
    known += [(subject, name) for name in names]
    seen = dict.fromkeys(place for place in known if place in occurring or place[0] == subject)
    yield from seen
    yield from sorted(occurring - set(seen))


def _row(draft: Draft, subject: str, behaviour: str) -> Row:
    names = [one.name for one in draft.coding.ethogram.behaviours]
    found = draft.coding.ethogram.behaviour(behaviour)
    number = names.index(behaviour) if behaviour in names else len(names) + len(behaviour)
    told = "" if found is None else found.color
    return Row(subject, behaviour, told or COLORS[number % len(COLORS)])


def in_order(events: Iterable[Occurrence]) -> list[Occurrence]:
    """Return events by their beginning."""
    return sorted(events, key=lambda one: (one.begin_ms, one.end_ms, one.behaviour, one.subject))
