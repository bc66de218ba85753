"""From a recording of a moving camera to its path and one coloured surface."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from adibas.alignment.camera_track import KeyFrameParams, path_length_m
from adibas.alignment.gtsam_graph import check_gtsam
from adibas.alignment.pairing import TEXTS
from adibas.alignment.surfels import Surface, SurfelMap, SurfelParams
from adibas.alignment.views import View, ViewParams, prepare_view
from adibas.arrays import IntArray
from adibas.data.frames import SensorFrame
from adibas.data.sentence import Sentence
from adibas.errors import RecordingError
from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.frame_notices import counted
from adibas.pipeline.in_order import in_order
from adibas.pipeline.map_body import BodyMotion, body_motion
from adibas.pipeline.map_following import N_THREADS, Followed, Follower
from adibas.pipeline.map_frames import MapFrames, Shown
from adibas.pipeline.map_preview import MapWatch, picture_of
from adibas.pipeline.map_state import (
    FileKeeper,
    Keeper,
    MapMemory,
    settings_of,
    unfinished_path,
)
from adibas.pipeline.recording_access import FILES, RecordingAccess
from adibas.pipeline.session import calibration_of, wanted_frames
from adibas.progress import Progress
from adibas.recordings.ports import RecordingReader
from adibas.texts import Message, message

FULL = message("The surface is too large: parts of it were left out. Choose fewer frames.")
WRONG_LOOPS = message("Loops that did not fit the rest and count nothing: {n}.")
NO_FLOOR = message("No floor is seen in the first frame: the camera is taken to stand upright.")
ONE_FRAME = message("It is a single frame. Give more of them, of a camera that moves.")
JUMPS = message("The recording jumps: places where more than a second is missing: {n}.")
MOVING = message(
    "Something moved before the camera, which a map takes to stand still. What was seen through "
    "later was removed."
)
FEWEST_PLACED = 2
MOST_WRONG_LOOPS = 2
"""So few may be wrong even where none is right; more, and the path is taken for wrong."""
FRAMES_A_PICTURE = 25
"""While the surface grows, it is shown every so many frames."""
MOTION_FRAMES = 60
"""At most, evenly chosen, tell how a person was not rigid."""
FINEST = ViewParams(n_levels=1)
"""Of the resolutions, a surface takes the finest alone."""


@dataclass(frozen=True, slots=True)
class MapRequest:
    """What to map.

    Attributes
    ----------
    recording : Path
    calibration : Path or None
        In place of the recording's own.
    frames : (first, one past the last or None)
    is_body : bool
        The person alone: a patient who turns before a camera that stands still.
    tracking : KeyFrameParams
    surfels : SurfelParams
    out : Path or None
        Where the surface will be written; what is unfinished is kept beside it. None: nothing is.
    memory : MapMemory or None
        Holds what is unfinished where there is no `out`.
    access : RecordingAccess
    """

    recording: Path
    calibration: Path | None = None
    frames: tuple[int, int | None] = (0, None)
    is_body: bool = False
    tracking: KeyFrameParams = field(default_factory=KeyFrameParams)
    surfels: SurfelParams = field(default_factory=SurfelParams)
    out: Path | None = None
    memory: MapMemory | None = None
    access: RecordingAccess = FILES


@dataclass(frozen=True, slots=True, eq=False)
class MappedRecording:
    """A path and a surface, both in the axes of the depth camera at the first frame.

    Attributes
    ----------
    timestamps_ns : (N,) array
        Of the frames that were placed.
    world_from_camera : tuple of RigidTransform
        Of each of them.
    surface : Surface
    path_m : float
        How far the camera went.
    n_frames : int
        That were looked at.
    n_key_frames, n_loops, n_wrong_loops : int
    notices : tuple of Sentence
        What was left out and why.
    motion : BodyMotion or None
        How a person who was mapped alone was not rigid.
    """

    timestamps_ns: IntArray
    world_from_camera: tuple[RigidTransform, ...]
    surface: Surface
    path_m: float
    n_frames: int
    n_key_frames: int
    n_loops: int
    n_wrong_loops: int
    notices: tuple[Sentence, ...]
    motion: BodyMotion | None = None


def map_recording(
    request: MapRequest, progress: Progress, watch: MapWatch | None = None
) -> MappedRecording:
    """Find the camera's path, then fuse all frames into one surface.

    With `MapRequest.out` or `memory`, what was found is kept until `forget_unfinished`; the same
    request goes on from there after a break, and comes to the same result.

    Raises
    ------
    RecordingError
        It is missing, broken, or has no such frames, or no two of them fit together.
    CalibrationError
        There is none of both cameras, or one for another resolution.
    FileError
        What is unfinished cannot be kept.
    MapError
        The pose graph was to be solved by a library that is not installed.
    """
    if request.tracking.graph.solver == "gtsam":
        check_gtsam()
    with request.access.open(request.recording) as recording:
        wanted = wanted_frames(recording, request.frames, request.recording.name)
        calibration = calibration_of(recording, request.calibration)
        frames = MapFrames(recording, wanted, calibration, is_body=request.is_body)
        frames.look_for_floor()
        keeper = _keeper(request, frames)
        followed = Follower(frames, request.tracking, keeper, watch).follow(progress)
        _check(request, followed)
        placed = tuple(pose for pose in followed.track.world_from if pose is not None)
        fusing = _Fusing(frames, followed, request.surfels)
        surfels = fusing.fuse(progress, watch)
        motion = fusing.motion(surfels) if request.is_body else None
        notices = _notices(recording, followed, frames)
    if surfels.was_full:
        notices = (*notices, Sentence(FULL))
    return MappedRecording(
        followed.times_ns[[pose is not None for pose in followed.track.world_from]],
        placed,
        surfels.surface(),
        path_length_m(placed),
        len(frames),
        followed.track.n_key_frames,
        followed.track.n_loops,
        followed.track.n_wrong_loops,
        notices,
        motion,
    )


def forget_unfinished(request: MapRequest) -> None:
    """Remove what was kept, once the output is written.

    Raises
    ------
    FileError
        It cannot be removed.
    """
    if request.memory is not None:
        request.memory.forget()
    if request.out is not None:
        FileKeeper(unfinished_path(request.out), {}).remove()


def _keeper(request: MapRequest, frames: MapFrames) -> Keeper | None:
    if request.out is None and request.memory is None:
        return None
    sha256 = request.access.sha256(request.recording)
    settings = settings_of(
        sha256, frames.calibration, request.frames, request.tracking, is_body=request.is_body
    )
    if request.out is not None:
        return FileKeeper(unfinished_path(request.out), settings)
    return None if request.memory is None else request.memory.keeper(settings)


def _check(request: MapRequest, followed: Followed) -> None:
    """Refuse a path that is none, or that contradicts itself: no map is better than a wrong one."""
    track, name = followed.track, request.recording.name
    if sum(pose is not None for pose in track.world_from) < FEWEST_PLACED:
        forget_unfinished(request)
        raise RecordingError(
            "No two frames could be put together in {file}. {reason}",
            file=name,
            reason=_first_reason(followed),
        )
    if track.n_wrong_loops > max(track.n_loops, MOST_WRONG_LOOPS):
        forget_unfinished(request)
        raise _denied(request, track.n_loops + track.n_wrong_loops, track.n_wrong_loops)


def _denied(request: MapRequest, n: int, wrong: int) -> RecordingError:
    """Return what is said where most of `n` views of places that were seen before are wrong."""
    if request.is_body:
        return RecordingError(
            "The turn in {file} contradicts itself: of {n} views of sides that were seen before, "
            "{wrong} do not fit. Let the person turn more slowly, and hold arms and head still.",
            file=request.recording.name,
            n=n,
            wrong=wrong,
        )
    return RecordingError(
        "The path of the camera in {file} contradicts itself: of {n} views of places that were "
        "seen before, {wrong} do not fit. Move the camera more slowly, past things that can be "
        "recognised. Where a person turns before a camera that stands still, map the person alone.",
        file=request.recording.name,
        n=n,
        wrong=wrong,
    )


class _Fusing:
    """Goes through the frames that were placed, again."""

    def __init__(self, frames: MapFrames, followed: Followed, params: SurfelParams) -> None:
        self._frames = frames
        self._params = params
        self._poses = {
            int(index): pose
            for index, pose in zip(followed.indices, followed.track.world_from, strict=True)
            if pose is not None
        }

    def fuse(self, progress: Progress, watch: MapWatch | None) -> SurfelMap:
        """Return all frames as one surface."""
        surfels = SurfelMap(self._params)
        total, poses = len(self._frames), list(self._poses.values())
        with in_order(self._prepare, self._read(list(self._poses)), N_THREADS) as prepared:
            for number, (shown, view) in enumerate(prepared, 1):
                surfels.add(
                    view, shown.color_rgb, self._frames.calibration, self._poses[shown.index]
                )
                if watch is not None and number % FRAMES_A_PICTURE == 0:
                    watch(picture_of(surfels.surface(), poses))
                progress(total + shown.index + 1 - self._frames.wanted.start, 2 * total)
        if watch is not None:
            watch(picture_of(surfels.surface(), poses))
        return surfels

    def motion(self, surfels: SurfelMap) -> BodyMotion | None:
        """Return how frames differ from the surface."""
        indices = list(self._poses)[:: 1 + len(self._poses) // MOTION_FRAMES]
        with in_order(self._prepare, self._read(indices), N_THREADS) as prepared:
            distances = [
                surfels.distances_m(view, self._poses[shown.index]) for shown, view in prepared
            ]
        frames = self._frames
        poses = [self._poses[i] for i in indices]
        return body_motion(distances, poses, frames.level, is_floor=frames.floor is not None)

    def _read(self, indices: list[int]) -> Iterator[tuple[int, SensorFrame]]:
        for index in indices:
            yield self._frames.read(index)

    def _prepare(self, numbered: tuple[int, SensorFrame]) -> tuple[Shown, View]:
        shown, _ = self._frames.show(numbered)
        return shown, prepare_view(shown.depth_m, self._frames.depth_camera, FINEST)


def _notices(
    recording: RecordingReader, followed: Followed, frames: MapFrames
) -> tuple[Sentence, ...]:
    """Return what was left out, and why."""
    track = followed.track
    notices = list(followed.notices)
    if recording.notice:
        notices.append(Sentence(message("{notice}"), {"notice": recording.notice}))
    notices += counted(_reasons(followed).most_common(), len(frames))
    if followed.n_jumps:
        notices.append(Sentence(JUMPS, {"n": followed.n_jumps}))
    if track.n_moving and not frames.is_body:
        notices += counted([(MOVING, track.n_moving)], len(frames))
    if frames.is_body and frames.floor is None and frames.calibration.gravity is None:
        notices.append(Sentence(NO_FLOOR))
    if track.n_wrong_loops:
        notices.append(Sentence(WRONG_LOOPS, {"n": track.n_wrong_loops}))
    return tuple(notices)


def _reasons(followed: Followed) -> Counter[Message]:
    """Count why frames were not placed."""
    said = Counter(followed.left_out)
    said.update(TEXTS[problem] for problem in followed.track.problems.values())
    return said


def _first_reason(followed: Followed) -> Message:
    """Return why frames were not placed, the most frequent reason."""
    reasons = _reasons(followed)
    return reasons.most_common(1)[0][0] if reasons else ONE_FRAME
