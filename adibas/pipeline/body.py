"""From recordings of standing views to one surface, landmarks in one frame, and the back."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from adibas.clock import Clock, utc_now
from adibas.data.body_measures import BodyMeasure
from adibas.data.measures import AngleMeasure, DistanceMeasure
from adibas.data.posture import Provenance
from adibas.data.sentence import Sentence
from adibas.errors import BodyError, MarkerError
from adibas.measures.geometry_tables import all_angles, all_distances
from adibas.pipeline.back import Back, BackParams, measure_back
from adibas.pipeline.body_landmarks import (
    Landmark,
    MarkedView,
    as_markers,
    doubts_about_landmarks,
    landmarks_of,
)
from adibas.pipeline.body_protocol import SideMeasures, notices_of_sides, protocol_of_body
from adibas.pipeline.body_views import BodyView, ViewRequest, see_view
from adibas.pipeline.posture import PostureParams
from adibas.pipeline.protocol_measuring import ProtocolWish
from adibas.pipeline.provenance import provenance_of
from adibas.pipeline.session import PostureRequest, find_in_recording
from adibas.pipeline.turning import see_turn
from adibas.pipeline.whole_body import WholeBody, WholeBodyParams, join_body
from adibas.progress import Progress
from adibas.recordings.checksum import recording_sha256
from adibas.surface.crown import crown_height_m
from adibas.surface.girths import no_measures, slice_measures
from adibas.texts import Message, message

POSTERIOR = "posterior"
ORDER = (POSTERIOR, "anterior", "right_lateral", "left_lateral")
"""The first of the views gives the axes."""
VIEWS_ALL_AROUND = 3
NO_BACK = message("Without a posterior view the back is not measured.")
NO_CROWN = message("Every view cuts the head off, and heights are shares of the stature.")
NO_MARKER = {
    "anterior": message("No marker was found in the view from the front."),
    "posterior": message("No marker was found in the view from behind."),
    "right_lateral": message("No marker was found in the view of the right side."),
    "left_lateral": message("No marker was found in the view of the left side."),
}
FOUND_IN = {
    "anterior": message("In the view from the front: {notice}"),
    "posterior": message("In the view from behind: {notice}"),
    "right_lateral": message("In the view of the right side: {notice}"),
    "left_lateral": message("In the view of the left side: {notice}"),
}
NOTICE = message("{notice}")


@dataclass(frozen=True, slots=True)
class BodyParams:
    """Settings of all steps."""

    back: BackParams = field(default_factory=BackParams)
    joining: WholeBodyParams = field(default_factory=WholeBodyParams)


@dataclass(frozen=True, slots=True)
class BodyRequest:
    """What to measure.

    Attributes
    ----------
    views : tuple of ViewRequest
        Each side once; none where a turn is given.
    markers : str
        A file of learned colours, or ``led``; empty: no markers are looked for.
    labels : mapping
        By view: a file that names the markers.
    patient : str
        A pseudonym or empty.
    turn : ViewRequest or None
        One recording of a patient who turns around, and the view with which the turn begins.
    protocol : ProtocolWish or None
        What to measure besides, on the landmarks.
    params : BodyParams
    """

    views: tuple[ViewRequest, ...]
    markers: str = ""
    labels: Mapping[str, Path] = field(default_factory=dict)
    patient: str = ""
    turn: ViewRequest | None = None
    protocol: ProtocolWish | None = None
    params: BodyParams = field(default_factory=BodyParams)


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredBody:
    """What the views give.

    Attributes
    ----------
    whole : WholeBody
    back : Back or None
        None without a posterior view.
    stature_m : float or None
        From the floor to the crown, which is worked out; None where every view cuts the head off.
    girths : tuple of BodyMeasure
        Girths and volumes; empty of fewer than three views.
    landmarks : tuple of Landmark
    distances, angles : tuples
        Between landmarks, wherever they were seen: of every pair and every triplet.
    protocol : tuple of SideMeasures
        By the protocol that was asked for.
    patient : str
    n_frames : mapping
        By view.
    provenances : mapping
        By view.
    notices : tuple of Sentence
    """

    whole: WholeBody
    back: Back | None
    stature_m: float | None
    girths: tuple[BodyMeasure, ...]
    landmarks: tuple[Landmark, ...]
    distances: tuple[DistanceMeasure, ...]
    angles: tuple[AngleMeasure, ...]
    protocol: tuple[SideMeasures, ...]
    patient: str
    n_frames: Mapping[str, int]
    provenances: Mapping[str, Provenance]
    notices: tuple[Sentence, ...]


def measure_body(request: BodyRequest, progress: Progress, clock: Clock = utc_now) -> MeasuredBody:
    """Join the views, and measure the back where it is among them.

    Raises
    ------
    RecordingError, CalibrationError
        A recording cannot be used.
    BodyError
        A view shows nobody, the views do not fit together, nobody turns, or the back is hidden.
    MarkerError
        Markers were asked for and no view shows one, or labels name markers that are not there.
    """
    _check_views(request)
    seen = (_standing if request.turn is None else _turned)(request, progress)
    sources = seen.sources
    looked = [_marked(view, sources[view.view], request) for view in seen.views]
    views = [view for view, _told in looked]
    lacking = _check_markers(request, views)
    told = tuple(
        Sentence(FOUND_IN[view.view], {"notice": notice})
        for view, notices in looked
        for notice in notices
    )
    provenances = {view.view: _provenance(sources[view.view], view, clock) for view in seen.views}
    body = measure_views(views, provenances, request.patient, request.protocol, request.params)
    return replace(body, notices=(*seen.notices, *lacking, *told, *body.notices))


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """Views, where in which recording each was seen, and what is to be told of it."""

    views: Sequence[BodyView]
    sources: Mapping[str, ViewRequest]
    notices: tuple[Sentence, ...] = ()


def _standing(request: BodyRequest, progress: Progress) -> _Seen:
    """See each view in its own recording."""
    views: list[BodyView] = []
    total = 100 * len(request.views)
    for number, one in enumerate(request.views):

        def told(done: int, of: int, number: int = number) -> None:
            progress(100 * number + 100 * done // max(of, 1), total)

        views.append(see_view(one, told))
    return _Seen(views, {one.view: one for one in request.views})


def _turned(request: BodyRequest, progress: Progress) -> _Seen:
    """See the views that come by in a turn; markers are looked for in the middle frames of each."""
    if request.turn is None:
        raise ValueError("no turn is asked for")
    turn = see_turn(request.turn, progress)
    sources = {
        view: replace(request.turn, view=view, frames=turn.middle_of(view)) for view in turn.frames
    }
    _check_labels(request, sources)
    return _Seen(turn.views, sources, turn.notices)


def measure_views(
    views: Sequence[MarkedView],
    provenances: Mapping[str, Provenance],
    patient: str,
    protocol: ProtocolWish | None = None,
    params: BodyParams | None = None,
) -> MeasuredBody:
    """Join views that were seen, and measure the back where it is among them.

    Parameters
    ----------
    views : sequence of MarkedView
        Each side once.
    provenances : mapping
        By view: where it comes from.
    patient : str
        A pseudonym or empty.
    protocol : ProtocolWish or None
        What to measure besides, on the landmarks.

    Raises
    ------
    BodyError
        The views do not fit together, or the back is hidden.
    """
    params = params or BodyParams()
    views = sorted(views, key=lambda one: ORDER.index(one.view))
    seen = [view.seen for view in views]
    whole = join_body(seen, params.joining)
    back = None
    if views[0].view == POSTERIOR:
        back = measure_back(seen[0], views[0].markers, params.back)
    settings = {"back": asdict(params.back), "joining": asdict(params.joining)}
    told = {name: replace(one, parameters=settings) for name, one in provenances.items()}
    landmarks = landmarks_of(views, whole)
    fused = as_markers(landmarks)
    sides: tuple[SideMeasures, ...] = ()
    if protocol is not None:
        axes = whole.patient_from_camera[views[0].view]
        sides = protocol_of_body(protocol, views, landmarks, axes)
    return MeasuredBody(
        whole,
        back,
        stature_of(whole, seen),
        girths_of(whole, seen),
        landmarks,
        all_distances(fused),
        all_angles(fused),
        sides,
        patient,
        MappingProxyType({view.view: view.n_frames for view in seen}),
        MappingProxyType(told),
        (*_notices(seen, back), *doubts_about_landmarks(landmarks), *notices_of_sides(sides)),
    )


def girths_of(whole: WholeBody, views: Sequence[BodyView]) -> tuple[BodyMeasure, ...]:
    """Return girths and volumes of joined views; none of fewer than three."""
    if len(views) < VIEWS_ALL_AROUND:
        return ()
    stature_m = stature_of(whole, views)
    if stature_m is None:
        return no_measures(NO_CROWN)
    return slice_measures(whole.surface, stature_m)


def stature_of(whole: WholeBody, views: Sequence[BodyView]) -> float | None:
    """Return the height of the crown over the floor; None where every view cuts the head off."""
    crowns_m = []
    for view in views:
        if not view.is_cut_above:
            axes = whole.patient_from_camera[view.view]
            focal_px = view.camera.intrinsics.fx
            crowns_m.append(crown_height_m(axes.apply(view.points_m()), axes, focal_px))
    return float(np.median(crowns_m)) if crowns_m else None


def _check_views(request: BodyRequest) -> None:
    names = [one.view for one in request.views]
    if len(set(names)) < len(names):
        raise BodyError("The same side is given twice. Give each view once.")
    if request.protocol is not None and not request.markers:
        raise BodyError("A protocol is measured between markers. Give --markers, too.")
    if request.turn is not None and names:
        raise BodyError("A turn shows all sides. Give the turn alone, or the views without it.")
    if request.turn is None:
        _check_labels(request, names)


def _check_labels(request: BodyRequest, names: Iterable[str]) -> None:
    strange = sorted(set(request.labels) - set(names))
    if strange:
        raise BodyError(
            "There are labels for the view {view}, but no recording. Give both.", view=strange[0]
        )


def _marked(
    view: BodyView, one: ViewRequest, request: BodyRequest
) -> tuple[MarkedView, tuple[Message, ...]]:
    """Return a view with its markers, where any are to be looked for, and the doubts about them."""
    if not request.markers:
        return MarkedView(view), ()
    wish = request.protocol
    is_named = wish is not None and one.view in wish.protocol.views
    found = find_in_recording(
        PostureRequest(
            recording=one.recording,
            markers=request.markers,
            calibration=one.calibration,
            frames=one.frames,
            view=one.view,
            params=PostureParams(rotation_deg=one.rotation_deg),
            protocol=wish if is_named else None,
            labels=request.labels.get(one.view),
        ),
        lambda _done, _total: None,
        may_lack=one.view not in request.labels,
    )
    return MarkedView(view, found.markers), found.doubts


def _check_markers(request: BodyRequest, views: Sequence[MarkedView]) -> tuple[Sentence, ...]:
    """Return which views show none of the markers; raise MarkerError where no view shows one."""
    if not request.markers:
        return ()
    without = [view.view for view in views if not view.markers]
    if len(without) == len(views):
        raise MarkerError(
            "No view shows a marker. Check that the markers have the learned colour and are in "
            "view, or learn the colour again in this light."
        )
    return tuple(Sentence(NO_MARKER[name]) for name in without)


def _provenance(one: ViewRequest, view: BodyView, clock: Clock) -> Provenance:
    params = PostureParams(rotation_deg=one.rotation_deg)
    return provenance_of(recording_sha256(one.recording), view.calibration, None, params, clock())


def _notices(views: Sequence[BodyView], back: Back | None) -> tuple[Sentence, ...]:
    # Views of one turn come out of one recording.
    lost = dict.fromkeys(view.notice for view in views if view.notice)
    told = [Sentence(NOTICE, {"notice": notice}) for notice in lost]
    return (*told, *(back.notices if back is not None else (Sentence(NO_BACK),)))
