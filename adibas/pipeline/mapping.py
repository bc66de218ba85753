"""From a recording of a moving camera to its path and one coloured surface."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from adibas.alignment.key_frames import KeyFrameParams, Track, Tracker, path_length_m
from adibas.alignment.pairing import TEXTS, Moment
from adibas.alignment.sights import see
from adibas.alignment.surfels import Surface, SurfelMap, SurfelParams
from adibas.alignment.views import ViewParams, prepare_view
from adibas.arrays import Float32Array, IntArray, UInt8Array
from adibas.calibration.files import check_fits
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import depth_in_metres
from adibas.data.sentence import Sentence
from adibas.errors import CalibrationError, RecordingError
from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.frame_notices import counted
from adibas.pipeline.session import calibration_of, wanted_frames
from adibas.progress import Progress
from adibas.recordings import open_recording
from adibas.recordings.decoding import decode_color
from adibas.recordings.ports import RecordingReader
from adibas.texts import Message, message

INCOMPLETE = message("The frame lacks depth or colour.")
BACKWARD = message("The frame is not after the one before.")
FULL = message("The surface is too large: parts of it were left out. Choose fewer frames.")
FEWEST_PLACED = 2
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
    tracking : KeyFrameParams
    surfels : SurfelParams
    """

    recording: Path
    calibration: Path | None = None
    frames: tuple[int, int | None] = (0, None)
    tracking: KeyFrameParams = field(default_factory=KeyFrameParams)
    surfels: SurfelParams = field(default_factory=SurfelParams)


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


def map_recording(request: MapRequest, progress: Progress) -> MappedRecording:
    """Find the camera's path, then fuse all frames into one surface.

    Raises
    ------
    RecordingError
        It is missing, broken, or has no such frames, or no two of them fit together.
    CalibrationError
        There is none of both cameras, or one for another resolution.
    """
    with open_recording(request.recording) as recording:
        wanted = wanted_frames(recording, request.frames)
        calibration = calibration_of(recording, request.calibration)
        if calibration.color is None or calibration.depth is None:
            raise CalibrationError(
                "A map takes the calibration of both cameras. Give one with --calibration FILE."
            )
        frames = _Frames(recording, wanted, calibration)
        tracker = Tracker(request.tracking)
        for number, (_, depth_m, color_rgb) in enumerate(frames, 1):
            sight = see(depth_m, color_rgb, calibration)
            tracker.add(Moment(sight, request.tracking.pairing.features))
            progress(number, 2 * len(wanted))
        track = tracker.track()
        n_placed = sum(pose is not None for pose in track.world_from)
        if n_placed < FEWEST_PLACED:
            raise RecordingError(
                "No two frames could be put together in {file}. {reason}",
                file=request.recording.name,
                reason=_first_reason(frames, track),
            )
        surfels = SurfelMap(request.surfels)
        times_ns: list[int] = []
        for number, (time_ns, depth_m, color_rgb) in enumerate(frames, 1):
            pose = track.world_from[number - 1]
            if pose is not None:
                view = prepare_view(depth_m, calibration.depth, FINEST)
                surfels.add(view, color_rgb, calibration, pose)
                times_ns.append(time_ns)
            progress(len(wanted) + number, 2 * len(wanted))
        notices = _notices(recording, frames, track, len(wanted))
        if surfels.was_full:
            notices = (*notices, Sentence(FULL))
    placed = tuple(pose for pose in track.world_from if pose is not None)
    return MappedRecording(
        np.array(times_ns, np.int64),
        placed,
        surfels.surface(),
        path_length_m(placed),
        len(wanted),
        track.n_key_frames,
        track.n_loops,
        track.n_wrong_loops,
        notices,
    )


class _Frames:
    """The whole frames of a recording, in order; can be gone through again."""

    def __init__(
        self, recording: RecordingReader, wanted: range, calibration: RgbdCalibration
    ) -> None:
        self._recording = recording
        self._wanted = wanted
        self._calibration = calibration
        self.left_out: Counter[Message] = Counter()

    def __iter__(self) -> Iterator[tuple[int, Float32Array, UInt8Array]]:
        """Yield time (nanoseconds), corrected depth (metres) and colour picture."""
        self.left_out.clear()
        last_ns = None
        for index in self._wanted:
            frame = self._recording.read(index)
            if frame.depth_raw is None or frame.color is None:
                self.left_out[INCOMPLETE] += 1
                continue
            if last_ns is not None and frame.timestamp_ns <= last_ns:
                self.left_out[BACKWARD] += 1
                continue
            color_rgb = decode_color(frame.color, frame.sequence)
            depth_m = depth_in_metres(frame.depth_raw, self._recording.info.depth_unit_m)
            if last_ns is None:
                check_fits(self._calibration, color_rgb.shape[:2], depth_m.shape)
            last_ns = frame.timestamp_ns
            depth_m = np.ascontiguousarray(self._calibration.corrected_depth(depth_m), np.float32)
            yield frame.timestamp_ns, depth_m, color_rgb


def _notices(
    recording: RecordingReader, frames: _Frames, track: Track, total: int
) -> tuple[Sentence, ...]:
    """Return what was left out, and why."""
    said = Counter(frames.left_out)
    said.update(TEXTS[problem] for problem in track.problems.values())
    notices = (
        [Sentence(message("{notice}"), {"notice": recording.notice})] if recording.notice else []
    )
    notices += counted(said.most_common(), total)
    if track.n_wrong_loops:
        notices.append(
            Sentence(
                message("Loops that did not fit the rest and count nothing: {n}."),
                {"n": track.n_wrong_loops},
            )
        )
    return tuple(notices)


def _first_reason(frames: _Frames, track: Track) -> Message | str:
    """Return why frames were not placed, the most frequent one."""
    reasons = Counter(frames.left_out)
    reasons.update(TEXTS[problem] for problem in track.problems.values())
    return reasons.most_common(1)[0][0] if reasons else ""
