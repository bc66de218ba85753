"""Two undo stacks of one capture, by two operators at the same time, become one.

Markers are followed through their names: what one operator renamed and the other moved gets the new
name at the new place. Only where both did the same thing to one marker in different ways, or gave
one name to two markers, somebody has to choose.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

from adibas.data.corrections import (
    Correction,
    CorrectionHistory,
    FreeMeasure,
    MarkerCorrection,
    MeasureCorrection,
)
from adibas.data.markers import Marker

Tracked = dict[str, Marker | None]
"""Markers by where they come from; None of those that were deleted."""


@dataclass(frozen=True, slots=True, eq=False)
class Clash:
    """A marker with two versions, by its name; None of one that was deleted."""

    name: str
    theirs: Marker | None
    mine: Marker | None


class HistoryMerge:
    """Brings `mine` together with `theirs`; both began from `seen`.

    Attributes
    ----------
    clashes : tuple of Clash
        What has to be decided, one by name.
    """

    def __init__(
        self,
        detected: tuple[Marker, ...],
        seen: CorrectionHistory,
        theirs: CorrectionHistory,
        mine: CorrectionHistory,
    ) -> None:
        self._detected = detected
        self._histories = (seen, theirs, mine)
        sides = [_tracked(detected, one) for one in self._histories]
        self._theirs, self._mine = sides[1], sides[2]
        self._merged: Tracked = {}
        self._choices: dict[str, list[str]] = {}
        clashes = {}
        for origin in dict.fromkeys([*sides[1], *sides[2]]):
            versions = [side.get(origin) for side in sides]
            self._merged[origin], is_clash = _merged(*versions)
            if is_clash:
                clash = _clash(versions[1], versions[2])
                clashes[clash.name] = clash
                self._choices.setdefault(clash.name, []).append(origin)
        clashes |= {one.name: one for one in self._same_names()}
        self.clashes = tuple(clashes.values())

    def history(self, mine_holds: Mapping[str, bool]) -> CorrectionHistory:
        """Return their stack with what is mine on top of it.

        Parameters
        ----------
        mine_holds : Mapping
            Of every clash, by name.
        """
        _seen, history, _mine = self._histories
        for correction in _steps(self._theirs, self._wanted(mine_holds)):
            history = history.after(correction)
        for measure in self._measures(history):
            history = history.after(measure)
        return history

    def lost(self, mine_holds: Mapping[str, bool]) -> tuple[MarkerCorrection, ...]:
        """Return the corrections of mine that do not hold, for the record."""
        wanted = self._wanted(mine_holds)
        origins = [one for group in self._choices.values() for one in group]
        if wanted is self._theirs:
            origins = list(self._mine)
        pairs = ((wanted.get(origin), self._mine.get(origin)) for origin in origins)
        return tuple(MarkerCorrection(*pair) for pair in pairs if not _is_same(*pair))

    def _wanted(self, mine_holds: Mapping[str, bool]) -> Tracked:
        """Return all markers as decided; theirs where that would give one name to two of them."""
        wanted = dict(self._merged)
        for name, origins in self._choices.items():
            side = self._mine if mine_holds[name] else self._theirs
            wanted |= {origin: side.get(origin) for origin in origins}
        return self._theirs if _has_twins(wanted) else wanted

    def _same_names(self) -> Iterator[Clash]:
        """Give names that would stand at two markers, which then come from one side together."""
        by_name: dict[str, list[str]] = {}
        for origin, marker in self._merged.items():
            if marker is not None:
                by_name.setdefault(marker.label, []).append(origin)
        for name, origins in by_name.items():
            if len(origins) > 1:
                self._choices[name] = origins
                versions = (_named(side, name) for side in (self._theirs, self._mine))
                yield Clash(name, *versions)

    def _measures(self, history: CorrectionHistory) -> Iterator[MeasureCorrection]:
        """Give what I asked for and took away, as far as its markers are there."""
        seen, _theirs, mine = (_alike(one.measures()) for one in self._histories)
        now = _alike(history.measures())
        labels = {marker.label for marker in history.markers(self._detected)}
        mine_labels = {one.label for one in self._mine.values() if one is not None}
        for key, measure in mine.items():
            if key not in seen and key not in now and labels.issuperset(measure.labels):
                yield MeasureCorrection(None, measure)
        for key, measure in seen.items():
            if key not in mine and key in now and mine_labels.issuperset(measure.labels):
                yield MeasureCorrection(now[key], None)


def _tracked(detected: tuple[Marker, ...], history: CorrectionHistory) -> Tracked:
    """Follow every marker through the corrections that are in force."""
    found: Tracked = {f"found {one.label}": one for one in detected}
    origins = {one.label: f"found {one.label}" for one in detected}
    for correction in history.corrections[: history.n_done]:
        if not isinstance(correction, MarkerCorrection):
            continue
        before, after = correction.before, correction.after
        origin = _new_origin(after, origins) if before is None else origins.pop(before.label)
        found[origin] = after
        if after is not None:
            origins[after.label] = origin
    return found


def _new_origin(marker: Marker | None, origins: Mapping[str, str]) -> str:
    """Return where a marker that was added comes from: the same place for both operators."""
    origin = "added" if marker is None else f"added {marker.label}"
    while origin in origins.values():  # it was added, renamed, and another one added
        origin += "'"
    return origin


def _merged(
    seen: Marker | None, theirs: Marker | None, mine: Marker | None
) -> tuple[Marker | None, bool]:
    """Return what a marker becomes, and whether both changed it in different ways."""
    if _is_same(seen, mine) or _is_same(theirs, mine):
        return theirs, False
    if _is_same(seen, theirs):
        return mine, False
    if seen is None or theirs is None or mine is None:
        return theirs, True
    name, is_name_clash = _of_three(seen, theirs, mine, lambda one: one.label)
    place, is_place_clash = _of_three(seen, theirs, mine, lambda one: (one.u, one.v))
    if is_name_clash or is_place_clash:
        return theirs, True
    return replace(place, label=name.label, named_by=name.named_by), False


def _of_three(
    seen: Marker, theirs: Marker, mine: Marker, part: Callable[[Marker], object]
) -> tuple[Marker, bool]:
    """Return whose part holds, and whether both changed it in different ways."""
    if part(theirs) == part(seen):
        return mine, False
    return theirs, part(mine) not in (part(seen), part(theirs))


def _clash(theirs: Marker | None, mine: Marker | None) -> Clash:
    named = theirs or mine
    return Clash("" if named is None else named.label, theirs, mine)


def _named(side: Tracked, name: str) -> Marker | None:
    return next((one for one in side.values() if one is not None and one.label == name), None)


def _has_twins(markers: Tracked) -> bool:
    labels = [one.label for one in markers.values() if one is not None]
    return len(set(labels)) < len(labels)


def _is_same(one: Marker | None, other: Marker | None) -> bool:
    if one is None or other is None:
        return one is other
    return (one.label, one.u, one.v) == (other.label, other.u, other.v)


def _steps(now: Tracked, wanted: Tracked) -> Iterator[Correction]:
    """Give corrections that lead from one state to the other without a name that comes twice."""
    pairs = [(now.get(origin), after) for origin, after in wanted.items()]
    stay = [(before, after) for before, after in pairs if before is not None and after is not None]
    yield from (MarkerCorrection(one, None) for one, after in pairs if one and after is None)
    for before, after in stay:
        moved = replace(after, label=before.label)
        if not _is_same(before, moved):
            yield MarkerCorrection(before, moved)
    yield from _renaming(
        {
            one.label: (replace(after, label=one.label, named_by=one.named_by), after)
            for one, after in stay
            if one.label != after.label
        }
    )
    yield from (MarkerCorrection(None, after) for one, after in pairs if after and one is None)


def _renaming(renamed: dict[str, tuple[Marker, Marker]]) -> Iterator[Correction]:
    """Give new names, those first that are free; names in a circle by removing and adding."""
    while free := [old for old, (_before, after) in renamed.items() if after.label not in renamed]:
        for old in free:
            yield MarkerCorrection(*renamed.pop(old))
    for before, _after in renamed.values():
        yield MarkerCorrection(before, None)
    for _before, after in renamed.values():
        yield MarkerCorrection(None, after)


def _alike(measures: tuple[FreeMeasure, ...]) -> dict[tuple[str, ...], FreeMeasure]:
    """Return measures by their markers, whichever end was named first."""
    return {min(one.labels, one.labels[::-1]): one for one in measures}
