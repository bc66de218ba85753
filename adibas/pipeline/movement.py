"""From a moving recording, or a table of joints, to joint angles over time."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from adibas import __version__
from adibas.clock import NS_PER_S, Clock, to_text, utc_now
from adibas.data.movement import Movement
from adibas.data.posture import Provenance
from adibas.data.protocol_measures import VerticalOrigin
from adibas.data.sentence import Sentence
from adibas.data.skeleton_track import SkeletonTrack
from adibas.errors import CalibrationError, LimbError, MarkerError, RecordingError
from adibas.measures.sight_plane import vertical_of
from adibas.movement.measuring import MovementParams, MovementSource, measure_movement
from adibas.pipeline.calibration_age import check_age
from adibas.pipeline.learning import read_target
from adibas.pipeline.movement_joints import MarkedJoints, joints_of_markers
from adibas.pipeline.pose import PoseRequest, pose_recording
from adibas.pipeline.pose_following import PoseParams
from adibas.pipeline.posture import PostureParams
from adibas.pipeline.provenance import provenance_of
from adibas.pipeline.session import calibration_of
from adibas.progress import Progress
from adibas.recordings import open_recording
from adibas.recordings.checksum import recording_sha256
from adibas.recordings.clock_jumps import check_steps
from adibas.recordings.joints_csv import is_joint_table, read_joints_csv
from adibas.recordings.reading import no_whole_frame
from adibas.skeleton.sides import BACK, FRONT
from adibas.texts import message

OTHER_PEOPLE = message(
    "The file has joints of {n} people; these are of person {person}. Choose another with --person."
)


@dataclass(frozen=True, slots=True)
class MovementRequest:
    """What to measure.

    Attributes
    ----------
    source : Path
        A recording, or a table of joints (``.csv``).
    markers : str
        A file of learned colours, or ``led``; of no use for a table.
    is_markerless : bool
        Joints are found in the depth alone, see `adibas.pipeline.pose`.
    model : Path or None
        Of limbs, without markers; None: the shipped one.
    calibration : Path or None
        In place of the recording's own.
    view, patient : str
        Of the first frame, one of `VIEWS` or empty; a pseudonym or empty.
    person : int or None
        Of a table, or without markers; None: the one who was seen longest.
    oldest_calibration_days : int or None
        An older calibration is refused; None: of any age.
    """

    source: Path
    markers: str = ""
    is_markerless: bool = False
    model: Path | None = None
    calibration: Path | None = None
    view: str = ""
    patient: str = ""
    person: int | None = None
    oldest_calibration_days: int | None = None
    posture: PostureParams = field(default_factory=PostureParams)
    movement: MovementParams = field(default_factory=MovementParams)


def measure_moving(
    request: MovementRequest, progress: Progress, clock: Clock = utc_now
) -> Movement:
    """Measure the movement of a recording or of a table of joints.

    Raises
    ------
    RecordingError
        The source is missing, broken, or empty, or has no such person.
    CalibrationError
        The recording has no calibration, or one that is too old or for another resolution; or
        the source is a table, and an age is asked for.
    MarkerError
        No marker was found in any frame, or none could be named, or the colour model fits
        everything.
    LimbError
        Nobody was found without markers, or the view is one from the side, of which they know
        nothing.
    """
    if is_joint_table(request.source):
        return _of_table(request, clock)
    if request.is_markerless:
        return _without_markers(request, progress, clock)
    return _of_recording(request, progress, clock)


def _of_table(request: MovementRequest, clock: Clock) -> Movement:
    if request.oldest_calibration_days is not None:
        raise CalibrationError(
            "{file} does not say when the sensor was calibrated. Give the recording, or leave "
            "--oldest-calibration out.",
            file=request.source.name,
        )
    read = read_joints_csv(request.source)
    tracks = {track.person: track for track in read.tracks}
    longest = max(read.tracks, key=lambda track: int(track.seen.any(axis=1).sum()))
    person = longest.person if request.person is None else request.person
    _check_person(request.source, tracks, person)
    notices = read.notices
    if len(tracks) > 1:
        notices += (Sentence(OTHER_PEOPLE, {"n": len(tracks), "person": person}),)
    provenance = Provenance(
        recording_sha256(request.source),
        "",
        __version__,
        to_text(clock()),
        asdict(request.movement),
    )
    source = MovementSource(
        read.origin, provenance, request.patient, read.up, request.posture.up, notices
    )
    return measure_movement(tracks[person], source, request.movement)


def _without_markers(request: MovementRequest, progress: Progress, clock: Clock) -> Movement:
    """Measure what is found in the depth alone; in the depth camera's axes."""
    if request.view not in {"", FRONT, BACK}:
        raise LimbError(
            "Without markers --view is anterior or posterior. From the side the program finds out "
            "which way the patient looks: leave --view out."
        )
    posed = pose_recording(
        PoseRequest(
            request.source,
            request.model,
            request.calibration,
            pose=PoseParams(view=request.view),
            oldest_calibration_days=request.oldest_calibration_days,
            rotation_deg=request.posture.rotation_deg,
        ),
        progress,
        clock,
    )
    tracks = {track.person: track for track in posed.tracks}
    person = posed.tracks[0].person if request.person is None else request.person
    _check_person(request.source, tracks, person)
    notices = posed.notices
    if len(tracks) > 1:
        notices += (Sentence(OTHER_PEOPLE, {"n": len(tracks), "person": person}),)
    parameters = {**posed.provenance.parameters, **asdict(request.movement)}
    provenance = replace(posed.provenance, parameters=parameters)
    source = MovementSource(
        "markerless", provenance, request.patient, posed.up, posed.picture_up, notices
    )
    return measure_movement(tracks[person], source, request.movement)


def _check_person(source: Path, tracks: Mapping[int, SkeletonTrack], person: int) -> None:
    if person not in tracks:
        raise RecordingError(
            "{file} has no person {person}. Choose one of: {people}.",
            file=source.name,
            person=person,
            people=", ".join(map(str, sorted(tracks))),
        )


def _of_recording(request: MovementRequest, progress: Progress, clock: Clock) -> Movement:
    target = read_target(request.markers)
    with open_recording(request.source) as recording:
        if len(recording) == 0:
            raise no_whole_frame(request.source.name)
        check_steps(request.source.name, np.asarray(recording.timestamps_ns) / NS_PER_S)
        calibration = calibration_of(recording, request.calibration)
        check_age(calibration, request.oldest_calibration_days, clock())
        marked = joints_of_markers(
            recording, calibration, target, request.posture, request.view, progress
        )
        notice = recording.notice
    if not marked.track.seen.any():
        raise _nothing_named(marked, request.view)
    provenance = provenance_of(
        recording_sha256(request.source), calibration, target, request.posture, clock()
    )
    parameters = {**provenance.parameters, **asdict(request.movement), "names": marked.names}
    provenance = replace(provenance, parameters=parameters)
    vertical = vertical_of(calibration)
    up = None if vertical.origin is VerticalOrigin.UNKNOWN else vertical.up
    notices: tuple[Sentence, ...] = ()
    if notice is not None:
        notices += (Sentence(message("{notice}"), {"notice": notice}),)
    source = MovementSource(
        "markers", provenance, request.patient, up, request.posture.up, (*notices, *marked.doubts)
    )
    return measure_movement(marked.track, source, request.movement)


def _nothing_named(marked: MarkedJoints, view: str) -> MarkerError:
    if not marked.n_markers:
        return MarkerError(
            "No marker was found in any frame. Check that the markers have the learned colour, sit "
            "on the joints, and are in view."
        )
    if not view:
        return MarkerError(
            "Markers were found, but which joints they are is not sure in any frame. Say with "
            "--view which side is seen in the first frame."
        )
    return MarkerError(
        "Markers were found, but which joints they are is not sure in any frame. Check that they "
        "sit on the joints, and that --view is the side that is seen in the first frame."
    )
