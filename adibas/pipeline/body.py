"""From recordings of standing views to one surface, landmarks in one frame, and the back."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from adibas.arrays import FloatArray
from adibas.clock import Clock, utc_now
from adibas.data.body_measures import BodyMeasure
from adibas.data.markers import Marker
from adibas.data.posture import Provenance
from adibas.data.sentence import Sentence
from adibas.errors import BodyError
from adibas.pipeline.back import Back, BackParams, measure_back
from adibas.pipeline.body_views import BodyView, ViewRequest, see_view
from adibas.pipeline.posture import PostureParams
from adibas.pipeline.provenance import provenance_of
from adibas.pipeline.session import PostureRequest, analyse_recording
from adibas.pipeline.whole_body import WholeBody, WholeBodyParams, join_body
from adibas.progress import Progress
from adibas.recordings.checksum import recording_sha256
from adibas.surface.girths import slice_measures
from adibas.texts import message

POSTERIOR = "posterior"
ORDER = (POSTERIOR, "anterior", "right_lateral", "left_lateral")
"""The first of the views gives the axes."""
VIEWS_ALL_AROUND = 3
NO_BACK = message("Without a posterior view the back is not measured.")
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
        Each side once.
    markers : str
        A file of learned colours, or ``led``; empty: no markers are looked for.
    labels : mapping
        By view: a file that names the markers.
    patient : str
        A pseudonym or empty.
    """

    views: tuple[ViewRequest, ...]
    markers: str = ""
    labels: Mapping[str, Path] = field(default_factory=dict)
    patient: str = ""
    params: BodyParams = field(default_factory=BodyParams)


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
    """

    name: str
    places_m: Mapping[str, FloatArray]
    apart_m: float | None


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredBody:
    """What the views give.

    Attributes
    ----------
    whole : WholeBody
    back : Back or None
        None without a posterior view.
    girths : tuple of BodyMeasure
        Girths and volumes; empty of fewer than three views.
    landmarks : tuple of Landmark
    patient : str
    n_frames : mapping
        By view.
    provenances : mapping
        By view.
    notices : tuple of Sentence
    """

    whole: WholeBody
    back: Back | None
    girths: tuple[BodyMeasure, ...]
    landmarks: tuple[Landmark, ...]
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
        A view shows nobody, the views do not fit together, or the back is hidden.
    MarkerError
        Markers were asked for and are not found.
    """
    requests = sorted(request.views, key=lambda one: ORDER.index(one.view))
    _check_views(request, [one.view for one in requests])
    views: list[BodyView] = []
    markers: dict[str, tuple[Marker, ...]] = {}
    total = 100 * len(requests)
    for number, one in enumerate(requests):

        def told(done: int, of: int, number: int = number) -> None:
            progress(100 * number + 100 * done // max(of, 1), total)

        views.append(see_view(one, told))
        if request.markers:
            markers[one.view] = _markers(one, request)
    provenances = {
        one.view: _provenance(one, view, clock) for one, view in zip(requests, views, strict=True)
    }
    return measure_views(views, markers, provenances, request.patient, request.params)


def measure_views(
    views: Sequence[BodyView],
    markers: Mapping[str, tuple[Marker, ...]],
    provenances: Mapping[str, Provenance],
    patient: str,
    params: BodyParams | None = None,
) -> MeasuredBody:
    """Join views that were seen, and measure the back where it is among them.

    Parameters
    ----------
    views : sequence of BodyView
        Each side once.
    markers : mapping
        Those of each view, in the colour camera's axes.
    provenances : mapping
        By view: where it comes from.
    patient : str
        A pseudonym or empty.

    Raises
    ------
    BodyError
        The views do not fit together, or the back is hidden.
    """
    params = params or BodyParams()
    views = sorted(views, key=lambda one: ORDER.index(one.view))
    whole = join_body(views, params.joining)
    back = None
    if views[0].view == POSTERIOR:
        back = measure_back(views[0], markers.get(POSTERIOR, ()), params.back)
    settings = {"back": asdict(params.back), "joining": asdict(params.joining)}
    told = {name: replace(one, parameters=settings) for name, one in provenances.items()}
    return MeasuredBody(
        whole,
        back,
        _girths(whole, len(views)),
        _landmarks(views, markers, whole),
        patient,
        MappingProxyType({view.view: view.n_frames for view in views}),
        MappingProxyType(told),
        _notices(views, back),
    )


def _girths(whole: WholeBody, n_views: int) -> tuple[BodyMeasure, ...]:
    if n_views < VIEWS_ALL_AROUND:
        return ()
    surface = whole.surface
    return slice_measures(surface, float(surface.points_m[:, 1].max()))


def _check_views(request: BodyRequest, names: list[str]) -> None:
    if len(set(names)) < len(names):
        raise BodyError("The same side is given twice. Give each view once.")
    strange = sorted(set(request.labels) - set(names))
    if strange:
        raise BodyError(
            "There are labels for the view {view}, but no recording. Give both.", view=strange[0]
        )


def _markers(one: ViewRequest, request: BodyRequest) -> tuple[Marker, ...]:
    found = analyse_recording(
        PostureRequest(
            recording=one.recording,
            markers=request.markers,
            calibration=one.calibration,
            frames=one.frames,
            view=one.view,
            labels=request.labels.get(one.view),
        ),
        lambda _done, _total: None,
    )
    return found.markers


def _landmarks(
    views: Sequence[BodyView], markers: Mapping[str, tuple[Marker, ...]], whole: WholeBody
) -> tuple[Landmark, ...]:
    """Return the markers by name, those that are alone in their view and number too."""
    places: dict[str, dict[str, FloatArray]] = {}
    for view in views:
        axes = whole.patient_from_camera[view.view]
        from_color = axes @ view.calibration.color_from_depth.inverse()
        for marker in markers.get(view.view, ()):
            if marker.position_m is not None and not _is_number(marker.label):
                place = from_color.apply(marker.position_m)
                places.setdefault(marker.label, {})[view.view] = place
    return tuple(
        Landmark(name, MappingProxyType(seen), _apart_m(list(seen.values())))
        for name, seen in sorted(places.items())
    )


def _is_number(label: str) -> bool:
    """Say whether a marker was only counted: m01, m02, ... of two views are not the same."""
    return label.startswith("m") and label[1:].isdecimal()


def _apart_m(places: list[FloatArray]) -> float | None:
    if len(places) <= 1:
        return None
    table = np.stack(places)
    return float(np.sqrt(((table - table.mean(axis=0)) ** 2).sum(axis=1).mean()))


def _provenance(one: ViewRequest, view: BodyView, clock: Clock) -> Provenance:
    return provenance_of(
        recording_sha256(one.recording), view.calibration, None, PostureParams(), clock()
    )


def _notices(views: Sequence[BodyView], back: Back | None) -> tuple[Sentence, ...]:
    told = [Sentence(NOTICE, {"notice": view.notice}) for view in views if view.notice]
    return (*told, *(back.notices if back is not None else (Sentence(NO_BACK),)))
