"""Protocols as data: what is marked on the patient, and what is measured between the marks.

Directions are the patient's: left, right, anterior, posterior, and up. A protocol is only built
of parts that fit together; what a file does wrong is told with its line by
`adibas.measures.protocol_file`.
"""

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from adibas.data.views import VIEWS
from adibas.texts import spoken_language

SIDEWAYS, LENGTHWAYS = ("left", "right"), ("anterior", "posterior")
VIEW_AXES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "anterior": SIDEWAYS,
        "posterior": SIDEWAYS,
        "right_lateral": LENGTHWAYS,
        "left_lateral": LENGTHWAYS,
    }
)
"""Directions that are seen in their true length in each of `VIEWS`."""

UP = "up"

UNITS: Mapping[str, tuple[str, float]] = MappingProxyType(
    {
        "deg": ("angle", math.pi / 180.0),
        "mm": ("length", 0.001),
        "cm": ("length", 0.01),
        "%": ("share", 0.01),
    }
)
"""What is measured in each unit, and one of it in radians, metres or as a share."""

CONVENTION, POPULATION = "convention", "population"
SPATIAL_KINDS = ("angle", "distance")
UPWARD_KINDS = ("offset", "offset_share")
"""Those that may be measured along the vertical, too."""


@dataclass(frozen=True, slots=True)
class KindRule:
    """What a kind of measure needs: so many points, and whether an axis gives it a sign."""

    quantity: str
    n_points: int
    has_axis: bool


KINDS: Mapping[str, KindRule] = MappingProxyType(
    {
        "line_to_horizontal": KindRule("angle", 2, has_axis=True),
        "line_to_vertical": KindRule("angle", 2, has_axis=True),
        "line_to_line": KindRule("angle", 4, has_axis=True),
        "deviation_from_straight": KindRule("angle", 3, has_axis=True),
        "angle": KindRule("angle", 3, has_axis=False),
        "distance": KindRule("length", 2, has_axis=False),
        "distance_difference": KindRule("length", 4, has_axis=False),
        "offset": KindRule("length", 2, has_axis=True),
        "offset_share": KindRule("share", 4, has_axis=True),
        "asymmetry_index": KindRule("share", 4, has_axis=True),
        "side_share": KindRule("share", 4, has_axis=True),
        "trunk_symmetry": KindRule("share", 8, has_axis=False),
    }
)
"""What can be measured (docs/protocols.md says how)."""


@dataclass(frozen=True, slots=True)
class Wording:
    """A text of a protocol in one or several languages, by their two letters."""

    by_language: Mapping[str, str]

    def __post_init__(self) -> None:
        if not self.by_language or not all(self.by_language.values()):
            raise ValueError("a wording needs words")

    @property
    def text(self) -> str:
        """Return it in the language in use, else in English, else in any that it has."""
        known = self.by_language
        return known.get(spoken_language()) or known.get("en") or next(iter(known.values()))


@dataclass(frozen=True, slots=True)
class ReferenceValue:
    """What others found or fixed; never without saying who.

    Attributes
    ----------
    kind : str
        `POPULATION`: measured on people. `CONVENTION`: fixed by the makers of a protocol, and no
        normal value of anybody.
    mean, sd : float or None
        In the unit of the measure; None where the source does not give it.
    who : str
        The people, or the program.
    source : str
        Where it can be read.
    note : str
        What the reader must know of it; may be empty.
    """

    kind: str
    mean: float
    sd: float | None
    who: str
    source: str
    note: str = ""

    def __post_init__(self) -> None:
        if self.kind not in (POPULATION, CONVENTION):
            raise ValueError(f"no kind of reference: {self.kind!r}")
        if not self.source.strip() or not self.who.strip():
            raise ValueError("a reference needs its source, and whom it is of")


@dataclass(frozen=True, slots=True)
class Landmark:
    """A place on the body that is marked, in the views where it can be seen.

    Attributes
    ----------
    landmark_id : str
        Such as ``left_acromion``: what a marker's label must be.
    name : Wording
        For people; a label may be that, too.
    views : tuple of str
        Of `VIEWS`.
    aliases : tuple of str
        Other labels that mean it.
    """

    landmark_id: str
    name: Wording
    views: tuple[str, ...]
    aliases: tuple[str, ...] = ()

    @property
    def labels(self) -> frozenset[str]:
        """Return every label that means it, as `same_label` compares them."""
        written = (self.landmark_id, *self.name.by_language.values(), *self.aliases)
        return frozenset(same_label(label) for label in written)


@dataclass(frozen=True, slots=True)
class DerivedLandmark:
    """A place computed as a weighted mean of others, such as a mid point.

    Attributes
    ----------
    landmark_id : str
        As of a landmark.
    name : Wording
        For people.
    weights : Mapping
        Share of each landmark, which may be a derived one; they sum to 1.
    source : str
        Where the weights come from; empty for a mid point, which is geometry.
    """

    landmark_id: str
    name: Wording
    weights: Mapping[str, float]
    source: str = ""


@dataclass(frozen=True, slots=True)
class MeasureDefinition:
    """One measure of a protocol.

    Attributes
    ----------
    measure_id : str
        Such as ``ANT.ACR.H``.
    name : Wording
        For people.
    views : tuple of str
        Of `VIEWS`, in which it is measured.
    kind : str
        Of `KINDS`.
    points : tuple of str
        Landmarks, in the order that the kind asks for.
    unit : str
        Of `UNITS`, of the kind's quantity.
    axis : str
        Patient's direction that a positive value points to; empty where the kind has no sign.
    positive : Wording or None
        What a positive value means.
    references : tuple of ReferenceValue
        None is "normal" without a source.
    """

    measure_id: str
    name: Wording
    views: tuple[str, ...]
    kind: str
    points: tuple[str, ...]
    unit: str
    axis: str = ""
    positive: Wording | None = None
    references: tuple[ReferenceValue, ...] = ()

    def __post_init__(self) -> None:
        rule = KINDS[self.kind]
        if len(self.points) != rule.n_points:
            raise ValueError(f"{self.kind} takes {rule.n_points} points, got {len(self.points)}")
        if UNITS[self.unit][0] != rule.quantity:
            raise ValueError(f"{self.kind} is no {UNITS[self.unit][0]}")
        if bool(self.axis) != rule.has_axis:
            raise ValueError(f"{self.kind} {'needs' if rule.has_axis else 'has no'} axis")
        for view in self.views:
            if self.axis and self.axis not in axes_of(self.kind, view):
                raise ValueError(f"{self.axis!r} is not seen in the view {view}")

    @property
    def is_spatial(self) -> bool:
        """Return whether the value in space is its main one: it has neither sign nor plane."""
        return self.kind in SPATIAL_KINDS

    @property
    def is_one_of_all(self) -> bool:
        """Return whether it is one of every pair or triplet, and nobody chose it by name."""
        return self.is_spatial and self.measure_id == id_of_all(self.kind, self.points)

    @property
    def per_unit(self) -> float:
        """Return one of its unit in radians, metres or as a share."""
        return UNITS[self.unit][1]


def id_of_all(kind: str, points: tuple[str, ...]) -> str:
    """Return the id of a distance or an angle that is one of every pair or triplet."""
    return ".".join(("D" if kind == "distance" else "A", *points))


def axes_of(kind: str, view: str) -> tuple[str, ...]:
    """Return the axes that a kind of measure may have in a view."""
    return (*VIEW_AXES[view], UP) if kind in UPWARD_KINDS else VIEW_AXES[view]


@dataclass(frozen=True, slots=True)
class Protocol:
    """A set of landmarks and what is measured between them.

    Attributes
    ----------
    protocol_id : str
        Such as ``sapo-1``: what the command line calls it.
    title : Wording
        For people.
    source : str
        Where it comes from.
    revision : str
        Of this set of measures; sessions of different revisions are not compared.
    landmarks, derived, measures : tuple
        Its parts.
    notes : Wording or None
        What the reader of every report must know.
    """

    protocol_id: str
    title: Wording
    source: str
    revision: str
    landmarks: tuple[Landmark, ...]
    derived: tuple[DerivedLandmark, ...]
    measures: tuple[MeasureDefinition, ...]
    notes: Wording | None = None

    @property
    def views(self) -> tuple[str, ...]:
        """Return the views in which something is measured, in the order of `VIEWS`."""
        used = {view for measure in self.measures for view in measure.views}
        return tuple(view for view in VIEWS if view in used)

    def measures_of(self, view: str) -> tuple[MeasureDefinition, ...]:
        """Return the measures of one of `VIEWS`, in their order."""
        return tuple(measure for measure in self.measures if view in measure.views)

    def unmarked(self, view: str, labels: Collection[str]) -> tuple[Landmark, ...]:
        """Return the landmarks of one of `VIEWS` that none of the labels means, in their order."""
        given = {same_label(label) for label in labels}
        return tuple(one for one in self.landmarks if view in one.views and not one.labels & given)

    def marks(self, view: str, label: str) -> bool:
        """Say whether a label means a landmark of one of `VIEWS`."""
        return any(view in one.views and same_label(label) in one.labels for one in self.landmarks)

    def marked_for(self, points: tuple[str, ...]) -> tuple[str, ...]:
        """Return the landmarks that must be marked for these, derived ones taken apart."""
        return tuple(self.shares_of(points))

    def shares_of(self, points: tuple[str, ...]) -> dict[str, tuple[float, ...]]:
        """Return of each marked landmark its share in each of the points.

        Parameters
        ----------
        points : tuple of str
            Landmarks or derived ones.

        Returns
        -------
        shares : dict
            As many numbers for each landmark as there are points, in the points' order.
        """
        found: dict[str, list[float]] = {}
        for place, point in enumerate(points):
            for landmark, share in self._taken_apart(point).items():
                row = found.setdefault(landmark, [0.0] * len(points))
                row[place] += share
        return {landmark: tuple(row) for landmark, row in found.items()}

    def _taken_apart(self, point: str) -> dict[str, float]:
        derived = {one.landmark_id: one for one in self.derived}
        if point not in derived:
            return {point: 1.0}
        total: dict[str, float] = {}
        for part, weight in derived[point].weights.items():
            for landmark, share in self._taken_apart(part).items():
                total[landmark] = total.get(landmark, 0.0) + weight * share
        return total


def same_label(label: str) -> str:
    """Return a label as labels are compared: case, underscores and spaces make no difference."""
    return re.sub(r"[\s_\-]+", " ", label.strip()).casefold()
