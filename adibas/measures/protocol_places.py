"""The landmarks of a protocol file, marked and derived, and where each can be seen."""

import math
from collections.abc import Iterator

from adibas.data.protocols import DerivedLandmark, Landmark
from adibas.measures.json_lines import Node
from adibas.measures.protocol_fields import Findings, Group, number_of

WEIGHT_TOLERANCE = 1e-6


class Places:
    """What a protocol file calls by name.

    Attributes
    ----------
    landmarks : tuple of Landmark
        Marked ones.
    derived : tuple of DerivedLandmark
        Computed ones.
    views : dict
        Of each landmark of either kind, where it can be seen.
    """

    def __init__(self, whole: Group) -> None:
        self._findings: Findings = whole.findings
        self._ids: dict[str, Node] = {}
        self.views: dict[str, tuple[str, ...]] = {}
        self.landmarks = tuple(self._landmarks(whole))
        self.derived = tuple(self._derived(whole))
        self._place_derived()

    def is_known(self, name: str, node: Node) -> bool:
        """Say whether a landmark has that name; keep a mistake where not."""
        if name in self._ids:
            return True
        self._findings.mistake(
            node,
            "{file}, line {line}: the landmark {name} is not known. Add it to landmarks, or "
            "correct the name.",
            name=name[:40],
        )
        return False

    def _landmarks(self, whole: Group) -> Iterator[Landmark]:
        labels: dict[str, str] = {}
        for part in whole.groups("landmarks"):
            part.allow_only("id", "name", "views", "aliases", "number")
            identifier, name, views = self._new_id(part), part.wording("name"), part.views()
            aliases = part.texts("aliases", is_needed=False)
            if not identifier or name is None:
                continue
            self.views[identifier] = views
            landmark = Landmark(identifier, name, views, aliases)
            for label in sorted(landmark.labels):
                other = labels.setdefault(label, identifier)
                if other != identifier:
                    self._findings.mistake(
                        part.node,
                        "{file}, line {line}: {name} and {other} share the label {label}. Name "
                        "them so that they differ.",
                        name=identifier,
                        other=other,
                        label=label,
                    )
            yield landmark

    def _derived(self, whole: Group) -> Iterator[DerivedLandmark]:
        groups = whole.groups("derived", is_needed=False)
        for part in groups:
            part.allow_only("id", "name", "of", "source")
            self._new_id(part)
        for part in groups:
            identifier, name = part.text("id", is_needed=False), part.wording("name")
            weights = self._weights(part)
            source = part.text("source", is_needed=False)
            if weights and not source and len(set(weights.values())) > 1:
                self._findings.mistake(
                    part.node,
                    "{file}, line {line}: the weights of {name} have no source. Say in source "
                    "where they come from.",
                    name=identifier,
                )
            if identifier and name is not None and weights:
                yield DerivedLandmark(identifier, name, weights, source)

    def _weights(self, part: Group) -> dict[str, float]:
        node = part.need("of")
        if node is None:
            return {}
        of = Group(node, self._findings)
        members = node.value if isinstance(node.value, dict) else {}
        weights = {
            name: number_of(weight, self._findings) or 0.0
            for name, weight in members.items()
            if self.is_known(name, weight)
        }
        if (
            weights
            and len(weights) == len(members)
            and abs(math.fsum(weights.values()) - 1) > (WEIGHT_TOLERANCE)
        ):
            self._findings.mistake(
                of.node,
                "{file}, line {line}: the weights sum to {total} and not to 1. Correct them.",
                total=f"{math.fsum(weights.values()):.6g}",
            )
        return weights

    def _place_derived(self) -> None:
        """Note where each derived landmark can be seen; tell of those that rest on themselves."""
        waiting = {one.landmark_id: set(one.weights) for one in self.derived}
        while ready := [name for name, parts in waiting.items() if not parts & waiting.keys()]:
            for name in ready:
                seen = [set(self.views.get(part, ())) for part in waiting.pop(name)]
                self.views[name] = tuple(sorted(set.intersection(*seen)))
        for name, parts in waiting.items():
            self._findings.mistake(
                self._ids[name],
                "{file}, line {line}: {name} is computed from itself, through: {names}. Break the "
                "circle.",
                name=name,
                names=", ".join(sorted(parts & waiting.keys())),
            )

    def _new_id(self, part: Group) -> str:
        identifier = part.identifier("id")
        if identifier in self._ids:
            self._twice(part, identifier)
        elif identifier:
            self._ids[identifier] = part.node
        return identifier

    def _twice(self, part: Group, identifier: str) -> None:
        self._findings.mistake(
            part.node,
            "{file}, line {line}: the id {name} stands twice. Rename one of them.",
            name=identifier,
        )
