"""From a moving recording, or a table of joints, to joint angles over time."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from adibas import __version__
from adibas.arrays import FloatArray, IntArray
from adibas.calibration.files import check_fits
from adibas.clock import NS_PER_S, Clock, to_text, utc_now
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import RgbdFrame
from adibas.data.joints import JOINT_NAMES
from adibas.data.movement import Movement
from adibas.data.posture import Provenance
from adibas.data.protocol_measures import VerticalOrigin
from adibas.data.sentence import Sentence
from adibas.data.skeleton_track import SkeletonTrack
from adibas.errors import CalibrationError, LimbError, MarkerError, RecordingError
from adibas.geometry.rigid import RigidTransform
from adibas.measures.sight_plane import vertical_of
from adibas.movement.measuring import MovementParams, MovementSource, measure_movement
from adibas.pipeline.calibration_age import check_age
from adibas.pipeline.in_order import in_order
from adibas.pipeline.learning import read_target
from adibas.pipeline.movement_markers import (
    FrameMarkers,
    SeenPerson,
    doubts_about_frames,
    markers_of_frame,
)
from adibas.pipeline.pose import PoseRequest, pose_recording
from adibas.pipeline.pose_following import PoseParams
from adibas.pipeline.posture import N_THREADS, MarkerTarget, PostureParams
from adibas.pipeline.provenance import provenance_of
from adibas.pipeline.seen_body import body_odds, see_body
from adibas.pipeline.session import calibration_of
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_names import upright_turn
from adibas.progress import Progress
from adibas.recordings import open_recording
from adibas.recordings.checksum import recording_sha256
from adibas.recordings.clock_jumps import check_steps
from adibas.recordings.decoding import to_rgbd
from adibas.recordings.joints_csv import is_joint_table, read_joints_csv
from adibas.recordings.ports import RecordingReader
from adibas.recordings.reading import no_whole_frame
from adibas.skeleton.body_marks import BodyOdds
from adibas.skeleton.sides import BACK, FRONT
from adibas.skeleton.tracking import MovingPoints, SeenFrom, TrackedNames, name_movement
from adibas.texts import message

OTHER_PEOPLE = message(
    "The file has joints of {n} people; these are of person {person}. Choose another with --person."
)
SPARE_MARKERS = message(
    "In {percent} % of the frames some markers have no name: they are none of the 15 joints, or "
    "which one is not sure. They are not in the angles."
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
        No joint was found in any frame, or the colour model fits everything.
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
        joints, doubts = _follow(recording, calibration, target, request, progress)
        notice = recording.notice
    if not joints.seen.any():
        raise MarkerError(
            "No joint was found in any frame. Check that the markers have the learned colour, sit "
            "on the joints, and are in view."
        )
    provenance = provenance_of(
        recording_sha256(request.source), calibration, target, request.posture, clock()
    )
    provenance = replace(
        provenance, parameters={**provenance.parameters, **asdict(request.movement)}
    )
    vertical = vertical_of(calibration)
    up = None if vertical.origin is VerticalOrigin.UNKNOWN else vertical.up
    notices: tuple[Sentence, ...] = ()
    if notice is not None:
        notices += (Sentence(message("{notice}"), {"notice": notice}),)
    source = MovementSource(
        "markers", provenance, request.patient, up, request.posture.up, (*notices, *doubts)
    )
    return measure_movement(joints, source, request.movement)


def _follow(
    recording: RecordingReader,
    calibration: RgbdCalibration,
    target: MarkerTarget,
    request: MovementRequest,
    progress: Progress,
) -> tuple[SkeletonTrack, tuple[Sentence, ...]]:
    """Return the joints in the colour camera's axes, and what the reader must know of them."""
    up = vertical_of(calibration, request.posture.rotation_deg).up
    upright_from_camera = upright_turn(up)
    every_ns = np.asarray(recording.timestamps_ns, np.int64)
    # A frame that is not after all before it has no place in a movement.
    kept = np.flatnonzero(np.diff(np.maximum.accumulate(every_ns), prepend=every_ns[0] - 1))
    n_frames, timestamps_ns = len(kept), every_ns[kept]
    times_s = (timestamps_ns - timestamps_ns[0]) / NS_PER_S
    seen: list[FrameMarkers] = []

    def work(frame: RgbdFrame) -> tuple[FrameMarkers, SeenPerson | None]:
        return markers_of_frame(frame, calibration, target, request.posture)

    def upright(
        found: Iterable[tuple[FrameMarkers, SeenPerson | None]],
    ) -> Iterator[MovingPoints]:
        sees = _Bodies(calibration, upright_from_camera, request.posture.rotation_deg)
        for time_s, (of_frame, person) in zip(times_s.tolist(), found, strict=True):
            seen.append(of_frame)
            progress(len(seen), n_frames)
            points_m = of_frame.points_m @ upright_from_camera.T
            yield MovingPoints(points_m, time_s, body=sees.of(person))

    with in_order(work, _frames(recording, calibration, kept), N_THREADS) as found:
        named = name_movement(shipped_namer(), upright(found), request.view)
    joints = _joints(timestamps_ns, [one.points_m for one in seen], named)
    return joints, (*_spare(named), *doubts_about_frames(seen))


@dataclass(frozen=True, slots=True, eq=False)
class _Bodies:
    """What the bodies tell that the depth of a recording shows."""

    calibration: RgbdCalibration
    upright_from_color: FloatArray
    rotation_deg: int

    def of(self, person: SeenPerson | None) -> SeenFrom | None:
        """Return what tells of a frame's body, once the view is known."""
        if person is None:
            return None
        return lambda view: self._told(person, view)

    def _told(self, person: SeenPerson, view: str) -> BodyOdds | None:
        calibration = self.calibration
        body = see_body(person.depth_m, view, calibration, self.rotation_deg, person.pixels)
        if body is None:
            return None
        upright = RigidTransform(self.upright_from_color, np.zeros(3))
        return body_odds(body, view, upright @ calibration.color_from_depth)


def _joints(
    timestamps_ns: IntArray, points_m: Sequence[FloatArray], named: Sequence[TrackedNames]
) -> SkeletonTrack:
    """Return the points that have a name, each in its joint's place."""
    joints_m = np.full((len(named), len(JOINT_NAMES), 3), np.nan)
    confidence = np.full((len(named), len(JOINT_NAMES)), np.nan)
    for number, (of_frame_m, one) in enumerate(zip(points_m, named, strict=True)):
        for name, point_m, sure in zip(one.names, of_frame_m, one.confidences, strict=True):
            if name is not None:
                place = JOINT_NAMES.index(name)
                joints_m[number, place], confidence[number, place] = point_m, sure
    return SkeletonTrack(timestamps_ns, joints_m, confidence)


def _spare(named: Sequence[TrackedNames]) -> Iterator[Sentence]:
    if n_unnamed := sum(None in one.names for one in named):
        yield Sentence(SPARE_MARKERS, {"percent": 100.0 * n_unnamed / len(named)}, decimals=0)


def _frames(
    recording: RecordingReader, calibration: RgbdCalibration, kept: IntArray
) -> Iterator[RgbdFrame]:
    for index in kept.tolist():
        frame = to_rgbd(recording.read(index), recording.info)
        if index == kept[0]:
            check_fits(calibration, frame.color_rgb.shape[:2], frame.depth_m.shape)
        yield frame
