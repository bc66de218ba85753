"""From a recording to the joints of everybody in it, without markers."""

from collections import Counter
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from adibas import __version__
from adibas.arrays import Float32Array, FloatArray
from adibas.calibration.files import check_fits
from adibas.clock import NS_PER_S, Clock, to_text, utc_now
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import depth_in_metres
from adibas.data.limbs import FULL_BODY
from adibas.data.movement import Movement
from adibas.data.posture import Provenance
from adibas.data.protocol_measures import VerticalOrigin
from adibas.data.sentence import Sentence
from adibas.data.skeleton_track import SkeletonTrack
from adibas.errors import CalibrationError, LimbError, RecordingError
from adibas.geometry.quarter_turns import QuarterTurn
from adibas.limbs.judging import NOBODY, REMARKS
from adibas.limbs.model import LimbModel, load_model
from adibas.measures.sight_plane import vertical_of
from adibas.movement.measuring import CAMERA_UP
from adibas.pipeline.calibration_age import check_age
from adibas.pipeline.frame_notices import counted
from adibas.pipeline.person_facts import PersonFacts, facts_of, unsure_sides
from adibas.pipeline.person_judge import person_judge
from adibas.pipeline.pose_following import PoseEstimator, PoseParams, forest_segmenter
from adibas.pipeline.pose_model import joint_model_for
from adibas.pipeline.provenance import identity_of
from adibas.pipeline.recording_access import FILES, RecordingAccess
from adibas.pipeline.session import calibration_of, wanted_frames
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.pipeline.upright import turn_to_upright, turned_camera, turned_floor, turned_joints
from adibas.progress import Progress
from adibas.recordings.clock_jumps import check_steps
from adibas.recordings.ports import RecordingReader
from adibas.skeleton.following import ChosenJoints
from adibas.skeleton.settled_sides import settled
from adibas.skeleton.smoothing import Smoother, SmoothingParams
from adibas.texts import Message, message
from adibas.timeseries.lowpass import even_times, resample

MOST_NOTICES = 4
SELDOM = message(
    "What was seen had too few joints, or was there for too short a time. Let the whole person "
    "be in view for a second or longer."
)


@dataclass(frozen=True, slots=True)
class PoseRequest:
    """What to look for joints in.

    Attributes
    ----------
    recording : Path
    access : RecordingAccess
        How it is opened: usually as a file.
    model : Path or None
        Of limbs; None: the shipped one.
    calibration : Path or None
        In place of the recording's own.
    frames : (first, one past the last or None)
    pose : PoseParams
    smoothing : SmoothingParams
    least_joints : int
        A frame speaks for a person with so many joints: 6.
    least_frames : int
        Somebody seen in fewer frames, or in less than half of a shorter recording, is left out:
        5. What is no person seldom has bones that fit for long.
    oldest_calibration_days : int or None
        An older calibration is refused; None: of any age.
    rotation_deg : int
        How far the picture is turned clockwise to be upright; see `turn_to_upright`.
    """

    recording: Path
    model: Path | None = None
    calibration: Path | None = None
    frames: tuple[int, int | None] = (0, None)
    pose: PoseParams = field(default_factory=PoseParams)
    smoothing: SmoothingParams = field(default_factory=SmoothingParams)
    least_joints: int = 6
    least_frames: int = 5
    access: RecordingAccess = FILES
    oldest_calibration_days: int | None = None
    rotation_deg: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class PosedRecording:
    """Joints of everybody.

    Attributes
    ----------
    tracks : tuple of SkeletonTrack
        Depth camera's axes, smoothed; the person seen longest first.
    facts : tuple of PersonFacts
        Of each of them.
    n_frames : int
        That were looked at.
    lag_frames, lag_s : int, float
        By how much a live result would come later than its frame.
    up : (3,) array or None
        Against gravity, in the same axes; None where nobody measured it.
    turn : QuarterTurn
        After which people stand upright in the picture.
    provenance : Provenance
    notices : tuple of Sentence
    """

    tracks: tuple[SkeletonTrack, ...]
    facts: tuple[PersonFacts, ...]
    n_frames: int
    lag_frames: int
    lag_s: float
    up: FloatArray | None
    turn: QuarterTurn
    provenance: Provenance
    notices: tuple[Sentence, ...]

    @property
    def picture_up(self) -> FloatArray:
        """Return the upper side of the picture as people stand upright in it."""
        return self.turn.inverse().points(np.array(CAMERA_UP))


def pose_recording(
    request: PoseRequest, progress: Progress, clock: Clock = utc_now
) -> PosedRecording:
    """Find the joints of everybody in a recording.

    Raises
    ------
    RecordingError
        It is missing, broken, or has no such frames, or no depth.
    CalibrationError
        There is none of the depth camera, or one that is too old or for another resolution.
    LimbError
        Nobody was found, or the model is for other limbs.
    FileError
        The model cannot be read.
    """
    model = shipped_model() if request.model is None else load_model(request.model)
    with request.access.open(request.recording) as recording:
        wanted = wanted_frames(recording, request.frames, request.recording.name)
        times_ns = np.asarray(recording.timestamps_ns)[wanted.start : wanted.stop]
        check_steps(request.recording.name, times_ns / NS_PER_S)
        calibration = calibration_of(recording, request.calibration)
        check_age(calibration, request.oldest_calibration_days, clock())
        found = _Found(request, calibration, model)
        for number, index in enumerate(wanted, 1):
            found.take(recording, index)
            progress(number, len(wanted))
        notice = recording.notice
    tracks, facts = found.tracks()
    notices = (*found.notices(len(wanted)), *unsure_sides(tracks, facts))
    if notice is not None:
        notices = (Sentence(message("{notice}"), {"notice": notice}), *notices)
    if not tracks:
        raise LimbError(
            "Nobody was found in {file}. {reason}",
            file=request.recording.name,
            reason=" ".join(one.text for one in found.reasons(len(wanted))),
        )
    vertical = vertical_of(calibration)
    up = None
    if vertical.origin is not VerticalOrigin.UNKNOWN:
        up = calibration.color_from_depth.rotation.T @ vertical.up
    provenance = Provenance(
        request.access.sha256(request.recording),
        identity_of(calibration),
        __version__,
        to_text(clock()),
        {
            **asdict(request.pose),
            **asdict(request.smoothing),
            "model": _model_name(request),
            "rotation_deg": request.rotation_deg,
        },
    )
    lag_frames = request.smoothing.lag_frames
    lag_s = lag_frames * found.frame_s()
    return PosedRecording(
        *(tracks, facts, len(wanted), lag_frames, lag_s, up, found.turn, provenance, notices)
    )


def _model_name(request: PoseRequest) -> str:
    return FULL_BODY.name if request.model is None else request.model.name


class _Found:
    """What was found up to now."""

    def __init__(
        self, request: PoseRequest, calibration: RgbdCalibration, model: LimbModel
    ) -> None:
        if calibration.depth is None:
            raise CalibrationError(
                "The calibration is of a colour camera alone, and limbs are found in depth. Give "
                "one of the depth camera with --calibration FILE."
            )
        self._request = request
        self._calibration = calibration
        self.turn = turn_to_upright(calibration, request.rotation_deg)
        camera = turned_camera(calibration.depth, self.turn)
        floor = turned_floor(calibration.floor, self.turn)
        self._estimator = PoseEstimator(
            *(camera, forest_segmenter(model, camera, request.pose.limbs), floor, request.pose),
            joints=joint_model_for(model),
            judge=person_judge(model, camera),
        )
        self._frames: dict[int, list[tuple[int, ChosenJoints]]] = {}
        self._said: Counter[Message] = Counter()
        self._sentences: dict[Message, Sentence] = {}
        self._times_ns: list[int] = []

    def take(self, recording: RecordingReader, index: int) -> None:
        """Look at a frame; one that is not after the one before is left out."""
        frame = recording.read(index)
        if frame.depth_raw is None:
            raise RecordingError(
                "{file} has no depth, and limbs are found in depth. Record with a depth camera.",
                file=self._request.recording.name,
            )
        if self._times_ns and frame.timestamp_ns <= self._times_ns[-1]:
            return
        depth_m = depth_in_metres(frame.depth_raw, recording.info.depth_unit_m)
        if not self._times_ns:
            check_fits(self._calibration, None, depth_m.shape)
        self._times_ns.append(frame.timestamp_ns)
        depth_m = np.ascontiguousarray(self._calibration.corrected_depth(depth_m), np.float32)
        self._look(depth_m, frame.timestamp_ns)

    def _look(self, depth_m: Float32Array, timestamp_ns: int) -> None:
        now = self._estimator.look(self.turn.picture(depth_m), timestamp_ns / NS_PER_S)
        for notice in {notice.message: notice for notice in now.notices}.values():
            self._said[notice.message] += 1
            self._sentences[notice.message] = notice
        for one in now.people:
            self._frames.setdefault(one.person, []).append((timestamp_ns, one.joints))

    def frame_s(self) -> float:
        """Return the time from one frame to the next."""
        if len(self._times_ns) < 2:  # noqa: PLR2004  (two ends)
            return 0.0
        return float(np.median(np.diff(self._times_ns))) / NS_PER_S

    def tracks(self) -> tuple[tuple[SkeletonTrack, ...], tuple[PersonFacts, ...]]:
        """Return everybody who was seen for long enough, numbered anew."""
        least = min(self._request.least_frames, max(1, len(self._times_ns) // 2))
        kept = {
            person: frames
            for person, frames in self._frames.items()
            if sum(one.n_seen >= self._request.least_joints for _, one in frames) >= least
        }
        longest = sorted(kept, key=lambda person: -len(kept[person]))
        sides = self._request.pose.follow.sides
        tracks, facts = [], []
        for number, person in enumerate(longest, 1):
            times_ns, chosen = zip(*kept[person], strict=True)
            upright = settled(chosen, sides)
            facts.append(facts_of(self._estimator.follower(person), upright, sides))
            turned = [turned_joints(one, self.turn.inverse()) for one in upright]
            frames = list(zip(times_ns, turned, strict=True))
            tracks.append(smooth_track(frames, number, self._request.smoothing))
        return tuple(tracks), tuple(facts)

    def notices(self, n_frames: int) -> tuple[Sentence, ...]:
        """Return what was said most often."""
        return self._counted(self._said.most_common(MOST_NOTICES), n_frames)

    def reasons(self, n_frames: int) -> tuple[Sentence, ...]:
        """Return why nobody was found: what was said most often of all that refuses somebody.

        Where that is only that nobody was there, before or after, what was said most often of
        somebody is told, too. And what was remarked, such as that only a part was in the picture:
        it may be why.
        """
        if not self._said:
            return (Sentence(SELDOM),)
        refusals = [one for one in self._said.most_common() if one[0] not in REMARKS]
        n_told = 2 if refusals and refusals[0][0] == NOBODY else 1
        remarks = [one for one in self._said.most_common() if one[0] in REMARKS]
        return self._counted([*refusals[:n_told], *remarks], n_frames)

    def _counted(self, said: list[tuple[Message, int]], n_frames: int) -> tuple[Sentence, ...]:
        return counted(((self._sentences[one].text, n) for one, n in said), n_frames)


def smooth_track(
    frames: list[tuple[int, ChosenJoints]], person: int, params: SmoothingParams
) -> SkeletonTrack:
    """Return the smoothed track of one person's frames and their times (ns)."""
    smoother = Smoother(params)
    given = []
    for when_ns, joints in frames:
        ready = smoother.push((when_ns - frames[0][0]) / NS_PER_S, joints)
        given += [] if ready is None else [ready]
    given += smoother.finish()
    return SkeletonTrack(
        np.array([when_ns for when_ns, _ in frames], np.int64),
        np.stack([joints.joints_m for _, joints in given]),
        np.stack([joints.confidence for _, joints in given]),
        person,
    )


def movement_of(posed: PosedRecording, person: int) -> Movement:
    """Return the joints of one person at even times, for the files of other programs."""
    track = next(track for track in posed.tracks if track.person == person)
    since_s = track.times_s - track.times_s[0]
    times_s = even_times(since_s)
    joints_m = resample(since_s, track.joints_m, times_s, SmoothingParams().reach_s)
    up = posed.picture_up if posed.up is None else posed.up
    return Movement(
        times_s,
        joints_m,
        up,
        posed.up is not None,
        (),
        (),
        (),
        "markerless",
        "",
        posed.provenance,
        asdict(SmoothingParams()),
        posed.notices,
    )
