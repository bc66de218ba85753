"""The joints of a moving patient, by the names of the markers."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.calibration.files import check_fits
from adibas.clock import NS_PER_S
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import RgbdFrame
from adibas.data.joints import JOINT_NAMES
from adibas.data.sentence import Sentence
from adibas.data.skeleton_track import SkeletonTrack
from adibas.measures.sight_plane import vertical_of
from adibas.pipeline.in_order import in_order
from adibas.pipeline.movement_markers import (
    FrameMarkers,
    doubts_about_frames,
    markers_of_frame,
)
from adibas.pipeline.posture import N_THREADS, MarkerTarget, PostureParams, Sight
from adibas.pipeline.put_together import PutTogether
from adibas.pipeline.seen_body import body_odds, see_body, upright_from_depth
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_names import upright_turn
from adibas.progress import Progress
from adibas.recordings.decoding import to_rgbd
from adibas.recordings.ports import RecordingReader
from adibas.skeleton.body_marks import BodyOdds
from adibas.skeleton.tracking import MovingPoints, SeenFrom, TrackedNames, name_movement
from adibas.texts import message

SPARE_MARKERS = message(
    "In {percent} % of the frames some markers have no name: they are none of the 15 joints, or "
    "which one is not sure. They are not in the angles."
)
VIEW_HELPS = message(
    "Say with --view which side is seen in the first frame: more markers get a name then, as the "
    "body is looked for in the depth, too."
)


_Found: TypeAlias = tuple[FrameMarkers, Sight | None]


@dataclass(frozen=True, slots=True, eq=False)
class MarkedJoints:
    """What the markers of a recording tell.

    Attributes
    ----------
    track : SkeletonTrack
        In the colour camera's axes.
    doubts : tuple of Sentence
        What the reader must know of them.
    names : mapping
        By what they were named, plain JSON values: the model, and in how many frames the body that
        the depth shows was known.
    """

    track: SkeletonTrack
    doubts: tuple[Sentence, ...]
    names: Mapping[str, object]


def joints_of_markers(
    recording: RecordingReader,
    calibration: RgbdCalibration,
    target: MarkerTarget,
    params: PostureParams,
    view: str,
    progress: Progress,
) -> MarkedJoints:
    """Find the markers in every frame, and name them by all.

    Parameters
    ----------
    view : str
        Which side is seen in the first frame; empty: not known, and the bodies tell nothing then.

    Raises
    ------
    CalibrationError
        It is for another resolution.
    MarkerError
        The colour model fits everything.
    RecordingError
        A frame cannot be read.
    """
    upright_from_camera = upright_turn(vertical_of(calibration, params.rotation_deg).up)
    every_ns = np.asarray(recording.timestamps_ns, np.int64)
    # A frame that is not after all before it has no place in a movement.
    kept = np.flatnonzero(np.diff(np.maximum.accumulate(every_ns), prepend=every_ns[0] - 1))
    timestamps_ns = every_ns[kept]
    times_s = (timestamps_ns - timestamps_ns[0]) / NS_PER_S
    bodies = _Bodies(calibration, params.rotation_deg)
    namer, seen = shipped_namer(), []

    def moving(found: Iterable[_Found]) -> Iterator[MovingPoints]:
        for time_s, (of_frame, person) in zip(times_s.tolist(), found, strict=True):
            seen.append(of_frame)
            progress(len(seen), len(kept))
            points_m = of_frame.points_m @ upright_from_camera.T
            yield MovingPoints(points_m, time_s, body=bodies.of(person))

    with _found_in(recording, kept, calibration, target, params) as found:
        named = name_movement(namer, moving(found), view)
    return MarkedJoints(
        _track(timestamps_ns, [one.points_m for one in seen], named),
        (*_spare(named, view), *doubts_about_frames(seen)),
        {"model": namer.identity, "n_frames_with_body": bodies.n_known},
    )


@contextmanager
def _found_in(
    recording: RecordingReader,
    kept: IntArray,
    calibration: RgbdCalibration,
    target: MarkerTarget,
    params: PostureParams,
) -> Iterator[Iterator[_Found]]:
    """Give what each frame shows, in their order.

    Frames are looked at side by side, each by itself; where less is seen of the person than a
    moment ago they are looked at again, together with that moment: who bends down falls apart.
    """

    def alone(frame: RgbdFrame) -> tuple[RgbdFrame, _Found]:
        return frame, markers_of_frame(frame, calibration, target, params)

    together = PutTogether()

    def one_after_the_other(looked: Iterable[tuple[RgbdFrame, _Found]]) -> Iterator[_Found]:
        for frame, by_itself in looked:
            found, moment = by_itself, together.moment_of(by_itself[1], frame.timestamp_ns)
            if moment is not None:
                found = markers_of_frame(frame, calibration, target, params, moment)
            together.saw(found[1], frame.timestamp_ns, by_itself=moment is None)
            yield found

    with in_order(alone, _frames(recording, calibration, kept), N_THREADS) as looked:
        yield one_after_the_other(looked)


class _Bodies:
    """What the bodies tell that the depth of a recording shows."""

    def __init__(self, calibration: RgbdCalibration, rotation_deg: int) -> None:
        self._calibration, self._rotation_deg = calibration, rotation_deg
        self._upright_from_depth = upright_from_depth(calibration, rotation_deg)
        self.n_known = 0

    def of(self, person: Sight | None) -> SeenFrom | None:
        """Return what tells of a frame's body, once the view is known."""
        return None if person is None else lambda view: self._told(person, view)

    def _told(self, person: Sight, view: str) -> BodyOdds | None:
        pixels = person.body.pixels
        body = see_body(person.depth_m, view, self._calibration, self._rotation_deg, pixels)
        if body is None:
            return None
        self.n_known += 1
        return body_odds(body, view, self._upright_from_depth)


def _track(
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


def _spare(named: Sequence[TrackedNames], view: str) -> Iterator[Sentence]:
    if n_unnamed := sum(None in one.names for one in named):
        yield Sentence(SPARE_MARKERS, {"percent": 100.0 * n_unnamed / len(named)}, decimals=0)
        if not view:
            yield Sentence(VIEW_HELPS)


def _frames(
    recording: RecordingReader, calibration: RgbdCalibration, kept: IntArray
) -> Iterator[RgbdFrame]:
    for index in kept.tolist():
        frame = to_rgbd(recording.read(index), recording.info)
        if index == kept[0]:
            check_fits(calibration, frame.color_rgb.shape[:2], frame.depth_m.shape)
        yield frame
