"""Landmarks of joined views in one frame: where each view saw them, and their best mean."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.landmark_texts import LandmarkNames
from adibas.data.markers import Marker, is_numbered
from adibas.data.sentence import Sentence
from adibas.pipeline.body_views import BodyView
from adibas.pipeline.whole_body import WholeBody
from adibas.surface.fused_landmarks import FusedPlace, SeenPlace, fuse_places
from adibas.texts import message

MOST_APART_SDS = 3.0
APART = message(
    "The landmark {name} lies {mm} mm apart in its views, more than their errors explain. "
    "Look at its name in each view."
)


@dataclass(frozen=True, slots=True, eq=False)
class MarkedView:
    """A view with the markers that were found in it.

    Attributes
    ----------
    seen : BodyView
    markers : tuple of Marker
        In the colour camera's axes.
    by_hand : frozenset of str
        Labels of markers that were placed by hand.
    """

    seen: BodyView
    markers: tuple[Marker, ...] = ()
    by_hand: frozenset[str] = frozenset()

    @property
    def view(self) -> str:
        """The side that is seen."""
        return self.seen.view


@dataclass(frozen=True, slots=True, eq=False)
class Landmark:
    """A marker that was named, in the patient axes of the first view.

    Attributes
    ----------
    name : str
    places_m : mapping
        (3,) position by view.
    apart_m : float or None
        Root mean square distance from the mean of the views; None where one view alone saw it.
    fused : FusedPlace
        The mean of all views by their errors.
    """

    name: str
    places_m: Mapping[str, FloatArray]
    apart_m: float | None
    fused: FusedPlace


def landmarks_of(views: Sequence[MarkedView], whole: WholeBody) -> tuple[Landmark, ...]:
    """Return the markers by name, those that are alone in their view and number too.

    Parameters
    ----------
    views : sequence of MarkedView
        In the order in which they were joined.
    """
    found: dict[str, dict[str, SeenPlace]] = {}
    for number, view in enumerate(views):
        for marker in view.markers:
            seen = _seen(number, view.seen, marker, whole)
            if seen is not None and not is_numbered(marker.label):
                found.setdefault(marker.label, {})[view.view] = seen
    return tuple(
        Landmark(
            name,
            MappingProxyType({view: one.position_m for view, one in seen.items()}),
            _apart_m([one.position_m for one in seen.values()]),
            fuse_places(list(seen.values()), whole.joined),
        )
        for name, seen in sorted(found.items())
    )


def as_markers(landmarks: Sequence[Landmark]) -> tuple[Marker, ...]:
    """Return fused landmarks as markers of the patient axes, for distances and angles."""
    return tuple(
        Marker(
            mark.name,
            *(np.nan, np.nan, 0.0, np.zeros((2, 2))),  # of no picture
            position_m=mark.fused.position_m,
            covariance_m2=mark.fused.covariance_m2,
            shared_m=mark.fused.shared_m,
        )
        for mark in landmarks
    )


def doubts_about_landmarks(landmarks: Sequence[Landmark]) -> tuple[Sentence, ...]:
    """Return a sentence on each landmark whose views contradict one another."""
    return tuple(
        Sentence(APART, {"name": LandmarkNames((mark.name,)), "mm": 1e3 * mark.apart_m})
        for mark in landmarks
        if mark.apart_m is not None and mark.fused.apart_sds > MOST_APART_SDS
    )


def _seen(number: int, view: BodyView, marker: Marker, whole: WholeBody) -> SeenPlace | None:
    if marker.position_m is None or marker.covariance_m2 is None:
        return None
    axes = whole.patient_from_camera[view.view] @ view.calibration.color_from_depth.inverse()
    shared_m = np.zeros((3, 0)) if marker.shared_m is None else marker.shared_m
    own_m2 = marker.covariance_m2 - shared_m @ shared_m.T
    turn = axes.rotation
    return SeenPlace(number, axes.apply(marker.position_m), turn @ own_m2 @ turn.T, turn @ shared_m)


def _apart_m(places: Sequence[FloatArray]) -> float | None:
    if len(places) <= 1:
        return None
    table = np.stack(places)
    return float(np.sqrt(((table - table.mean(axis=0)) ** 2).sum(axis=1).mean()))
