"""The measures of a protocol file, checked against its landmarks and views."""

from collections.abc import Iterator
from itertools import combinations

from adibas.data.protocols import (
    CONVENTION,
    KINDS,
    POPULATION,
    UNITS,
    Landmark,
    MeasureDefinition,
    ReferenceValue,
    Wording,
    axes_of,
    id_of_all,
)
from adibas.data.views import VIEWS
from adibas.measures.json_lines import Node
from adibas.measures.protocol_fields import Findings, Group, text_of
from adibas.measures.protocol_places import Places

MOST_FOR_EVERY_TRIPLET = 40
LONGEST_SHOWN = 40
LINES = {
    2: ((0, 1),),
    3: ((0, 1), (1, 2)),
    4: ((0, 1), (2, 3)),
    8: ((0, 1), (2, 3), (4, 5), (6, 7)),
}
"""Which of the points of a measure are the ends of its lines, by how many points it has."""


class Rules:
    """Reads the measures of one file."""

    def __init__(self, whole: Group, places: Places) -> None:
        self._whole = whole
        self._places = places
        self._findings: Findings = whole.findings

    def measures(self) -> Iterator[MeasureDefinition]:
        """Yield the measures that the file names, without those that have mistakes."""
        ids: set[str] = set()
        for part in self._whole.groups("measures", is_needed=False):
            part.allow_only(
                *("id", "name", "views", "kind", "points", "unit", "axis", "positive"),
                "references",
            )
            measure = self._measure(part)
            identifier = part.text("id", is_needed=False)
            if identifier in ids:
                self._findings.mistake(
                    part.node,
                    "{file}, line {line}: the id {name} stands twice. Rename one of them.",
                    name=identifier,
                )
            ids.add(identifier)
            if measure is not None:
                yield measure

    def _measure(self, part: Group) -> MeasureDefinition | None:
        before = len(self._findings.errors)
        identifier, name, views = part.identifier("id"), part.wording("name"), part.views()
        kind = part.text("kind")
        if kind and kind not in KINDS:
            self._findings.mistake(
                part.need("kind") or part.node,
                "{file}, line {line}: {name} is no kind of measure. Give one of: {names}.",
                name=kind[:LONGEST_SHOWN],
                names=", ".join(KINDS),
            )
            return None
        unit, axis = part.text("unit"), part.text("axis", is_needed=False)
        points = self._points(part, views)
        positive = part.wording("positive", is_needed=False)
        references = tuple(self._references(part))
        if kind:
            self._check_kind(part, kind, points, views)
        if name is None or len(self._findings.errors) > before:
            return None
        return MeasureDefinition(
            *(identifier, name, views, kind, points, unit, axis), positive, references
        )

    def _points(self, part: Group, views: tuple[str, ...]) -> tuple[str, ...]:
        found = []
        for node in part.items("points"):
            point = text_of(node, self._findings)
            found.append(point)
            if not point or not self._places.is_known(point, node):
                continue
            for view in views:
                if view not in self._places.views.get(point, VIEWS):
                    self._findings.mistake(
                        node,
                        "{file}, line {line}: {name} is no landmark of the view {view}. Add the "
                        "view to it, or measure in another one.",
                        name=point,
                        view=view,
                    )
        return tuple(found)

    def _check_kind(
        self, part: Group, kind: str, points: tuple[str, ...], views: tuple[str, ...]
    ) -> None:
        rule = KINDS[kind]
        node = part.get("points")
        if node is not None and len(points) != rule.n_points:
            self._findings.mistake(
                node,
                "{file}, line {line}: {kind} takes {wanted} points, and here are {n}. Correct "
                "them.",
                kind=kind,
                wanted=rule.n_points,
                n=len(points),
            )
        elif node is not None:
            self._check_lines(node, points)
        self._check_unit(part, kind)
        if rule.has_axis:
            part.need("positive")
            self._check_axis(part.need("axis"), kind, views)
        elif (axis := part.get("axis")) is not None:
            self._findings.mistake(
                axis, "{file}, line {line}: {kind} has no axis. Remove it.", kind=kind
            )

    def _check_lines(self, node: Node, points: tuple[str, ...]) -> None:
        for first, last in LINES[len(points)]:
            if points[first] and points[first] == points[last]:
                self._findings.mistake(
                    node,
                    "{file}, line {line}: a line from {name} to itself has neither length nor "
                    "direction. Name two points.",
                    name=points[first][:LONGEST_SHOWN],
                )

    def _check_unit(self, part: Group, kind: str) -> None:
        unit = part.get("unit")
        quantity = KINDS[kind].quantity
        units = [name for name, (measured, _size) in UNITS.items() if measured == quantity]
        if unit is not None and isinstance(unit.value, str) and unit.value not in units:
            self._findings.mistake(
                unit,
                "{file}, line {line}: {name} is no unit of {kind}. Give one of: {names}.",
                name=unit.value[:LONGEST_SHOWN],
                kind=kind,
                names=", ".join(units),
            )

    def _check_axis(self, axis: Node | None, kind: str, views: tuple[str, ...]) -> None:
        if axis is None or not isinstance(axis.value, str) or not views:
            return
        shown = set.intersection(*(set(axes_of(kind, view)) for view in views))
        if axis.value not in shown:
            self._findings.mistake(
                axis,
                "{file}, line {line}: {name} is no direction that these views show. Give one of: "
                "{names}.",
                name=axis.value[:LONGEST_SHOWN],
                names=", ".join(sorted(shown)) or "-",
            )

    def _references(self, part: Group) -> Iterator[ReferenceValue]:
        for node in part.items("references", is_needed=False):
            reference = Group(node, self._findings)
            reference.allow_only("kind", "mean", "sd", "who", "source", "note")
            kind, mean = reference.text("kind"), reference.number("mean")
            sd = reference.number("sd", is_needed=False)
            if sd is not None and sd < 0:
                self._findings.mistake(
                    reference.need("sd") or node,
                    "{file}, line {line}: a standard deviation cannot be negative. Correct it.",
                )
            who, note = reference.text("who"), reference.text("note", is_needed=False)
            source = reference.text("source", is_needed=False)
            if not source:
                self._findings.mistake(
                    node,
                    "{file}, line {line}: this reference value has no source. Say where it can be "
                    "read, or remove it.",
                )
            elif kind not in (POPULATION, CONVENTION):
                self._findings.mistake(
                    node,
                    "{file}, line {line}: {name} is no kind of reference. Give one of: {names}.",
                    name=kind[:LONGEST_SHOWN],
                    names=f"{POPULATION}, {CONVENTION}",
                )
            elif who and mean is not None:
                yield ReferenceValue(kind, mean, sd, who, source, note)

    def every(self) -> Iterator[MeasureDefinition]:
        """Yield the distances of all pairs and the angles of all triplets, where asked for."""
        landmarks = self._places.landmarks
        if self._whole.truth("every_pair"):
            for a, b in combinations(landmarks, 2):
                yield _free("distance", (a, b), (a, b))
        if self._whole.truth("every_triplet"):
            if len(landmarks) > MOST_FOR_EVERY_TRIPLET:
                self._findings.mistake(
                    self._whole.node,
                    "{file}, line {line}: every triplet of more than {most} landmarks is too much. "
                    "Name the angles that are wanted.",
                    most=MOST_FOR_EVERY_TRIPLET,
                )
                return
            for i, j, k in combinations(landmarks, 3):
                for corners in ((j, i, k), (i, j, k), (i, k, j)):
                    yield _free("angle", corners, (i, j, k))


def _free(kind: str, points: tuple[Landmark, ...], seen: tuple[Landmark, ...]) -> MeasureDefinition:
    """Return a distance or an angle in every view that shows its landmarks."""
    names = tuple(point.landmark_id for point in points)
    languages = set.intersection(*(set(point.name.by_language) for point in points)) or {"en"}
    name = {
        language: " \N{EN DASH} ".join(
            point.name.by_language.get(language, point.name.text) for point in points
        )
        for language in sorted(languages)
    }
    shared = [view for view in points[0].views if all(view in one.views for one in seen)]
    unit = "mm" if kind == "distance" else "deg"
    return MeasureDefinition(
        id_of_all(kind, names), Wording(name), tuple(shared), kind, names, unit
    )
