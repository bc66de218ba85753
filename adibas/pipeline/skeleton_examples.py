"""The clinic's corrected captures as examples of how landmarks lie, sorted by what they mark.

Most protocols mark other places in each view, so that no capture shows them all: the captures of
each view are a set of their own. Where all views mark the same places they are one set.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.protocols import Protocol, same_label
from adibas.data.sessions import Capture
from adibas.errors import ProtocolError
from adibas.measures.protocol_store import find_protocol
from adibas.measures.sight_plane import vertical_of
from adibas.pipeline.skeleton_names import upright_turn
from adibas.pipeline.skeleton_training import LEAST_NAMES
from adibas.progress import Progress
from adibas.skeleton.points_csv import PointSet

if TYPE_CHECKING:  # the database: namers need the sets alone
    from adibas.sessions import SessionStore
    from adibas.sessions.correcting import CorrectedCapture

UNNAMED = "m"


@dataclass(frozen=True, slots=True, order=True)
class LandmarkSet:
    """Which landmarks: those of a protocol in one of its views, or in all (empty).

    Sessions without a protocol have an empty one.
    """

    protocol: str = ""
    view: str = ""


@dataclass(frozen=True, slots=True)
class Example:
    """One corrected capture, and whose."""

    patient: str
    points: PointSet


def landmark_set(name: str, view: str) -> LandmarkSet:
    """Return the set of a protocol in a view; the view counts only where it makes a difference.

    Raises
    ------
    ProtocolError
        There is no such protocol, or each of its views marks other places and none is given.
    """
    protocol = find_protocol(name)
    if _marks_the_same_everywhere(protocol):
        return LandmarkSet(protocol.protocol_id)
    if not view:
        raise ProtocolError(
            "{protocol} marks other places in each view, and each has a model of its own. Choose "
            "one with --view.",
            protocol=name,
        )
    return LandmarkSet(protocol.protocol_id, view)


def landmarks_of(which: LandmarkSet) -> frozenset[str]:
    """Return the ids of all landmarks of the set's protocol; none where there is no protocol."""
    protocol = _protocol_of(which.protocol)
    landmarks = () if protocol is None else protocol.landmarks
    return frozenset(one.landmark_id for one in landmarks)


def corrected_sets(store: "SessionStore") -> "dict[LandmarkSet, tuple[CorrectedCapture, ...]]":
    """Return the captures in which somebody corrected a marker, by what they mark.

    Nothing of a patient is read. Captures without a view are left out where the protocol marks
    other places in each.
    """
    known = lru_cache(maxsize=None)(_protocol_of)
    found: dict[LandmarkSet, list[CorrectedCapture]] = {}
    for one in store.captures.corrected():
        which = _set_of(one, known)
        if which is not None:
            found.setdefault(which, []).append(one)
    return {which: tuple(found[which]) for which in sorted(found)}


def examples_of(
    store: "SessionStore",
    which: LandmarkSet,
    captures: "Sequence[CorrectedCapture]",
    progress: Progress,
) -> tuple[Example, ...]:
    """Return the named markers of captures, upright; those with fewer than three are left out."""
    protocol = _protocol_of(which.protocol)
    found = []
    for done, one in enumerate(captures, 1):
        points = _points(store.captures.get(one.capture_id), protocol, one.rotation_deg)
        if points is not None:
            found.append(Example(one.patient, points))
        progress(done, len(captures))
    return tuple(found)


def _protocol_of(name: str) -> Protocol | None:
    """Return a protocol by its name; None where there is none, or it is lost."""
    if not name:
        return None
    try:
        return find_protocol(name)
    except ProtocolError:
        return None


def _set_of(one: "CorrectedCapture", known: Callable[[str], Protocol | None]) -> LandmarkSet | None:
    protocol = known(one.protocol)
    if protocol is None or _marks_the_same_everywhere(protocol):
        return LandmarkSet(one.protocol)
    return LandmarkSet(one.protocol, one.view) if one.view else None


def _marks_the_same_everywhere(protocol: Protocol) -> bool:
    return len({frozenset(landmark.views) for landmark in protocol.landmarks}) == 1


def _points(capture: Capture, protocol: Protocol | None, rotation_deg: int) -> PointSet | None:
    """Return the named markers of a capture, upright; None where there are too few."""
    named = dict(_named(capture, protocol))
    if len(named) < LEAST_NAMES:
        return None
    positions_m = np.stack(list(named.values()))
    upright_m = positions_m @ upright_turn(vertical_of(capture.calibration, rotation_deg).up).T
    labels = tuple(named)
    return PointSet(capture.capture_id, labels, labels, upright_m, capture.view)


def _named(capture: Capture, protocol: Protocol | None) -> Iterator[tuple[str, FloatArray]]:
    """Give the places in space by the ids of landmarks; without a protocol, by the labels."""
    landmarks = () if protocol is None else protocol.landmarks
    ids = {label: one.landmark_id for one in landmarks for label in one.labels}
    for marker in capture.markers():
        if marker.position_m is None or _is_number(marker.label):
            continue
        name = marker.label if protocol is None else ids.get(same_label(marker.label))
        if name is not None:
            yield name, marker.position_m


def _is_number(label: str) -> bool:
    return label.startswith(UNNAMED) and label.removeprefix(UNNAMED).isdecimal()
