"""The joints of a moving patient, by the names of the markers."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.data.calibration import RgbdCalibration
from adibas.data.joints import JOINT_NAMES
from adibas.data.sentence import Sentence
from adibas.data.skeleton_track import SkeletonTrack
from adibas.pipeline.movement_frames import MovementFrames, SeenFrame
from adibas.pipeline.movement_markers import FrameMarkers, doubts_about_frames
from adibas.pipeline.posture import MarkerTarget, PostureParams, Sight
from adibas.pipeline.seen_body import body_odds, see_body, upright_from_depth
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.progress import Progress
from adibas.recordings.ports import RecordingReader
from adibas.skeleton.body_marks import BodyOdds
from adibas.skeleton.first_view import FirstView, first_view
from adibas.skeleton.namer import Namer
from adibas.skeleton.prototype_search import LEAST_POINTS
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
VIEW_FOUND = message(
    "The patient is seen {side} at first, as the markers of {n} frames tell. If that is wrong, say "
    "it with --view."
)
SIDES = {
    "anterior": message("from the front"),
    "posterior": message("from behind"),
    "right_lateral": message("from the right"),
    "left_lateral": message("from the left"),
}

EARLY_S, STEP_S, N_EARLY = 10.0, 0.1, 30
"""Who declared no view: it is looked for in so many frames of the first ten seconds."""


@dataclass(frozen=True, slots=True, eq=False)
class MarkedJoints:
    """What the markers of a recording tell.

    Attributes
    ----------
    track : SkeletonTrack
        In the colour camera's axes.
    n_markers : int
        In all frames together, named or not.
    doubts : tuple of Sentence
        What the reader must know of them.
    names : mapping
        By what they were named, plain JSON values: the model, which side is seen in the first
        frame, how many frames told it where nobody declared it, and in how many the body that the
        depth shows was known.
    """

    track: SkeletonTrack
    n_markers: int
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
        Which side is seen in the first frame; empty: the names are asked for it, and where they do
        not tell it the bodies tell nothing.

    Raises
    ------
    CalibrationError
        It is for another resolution.
    MarkerError
        The colour model fits everything.
    RecordingError
        A frame cannot be read.
    """
    film = MovementFrames(recording, calibration, target, params)
    namer, bodies = shipped_namer(), _Bodies(calibration, params.rotation_deg)
    told = None if view else _first_view(namer, film)
    view = view if told is None else told.view
    seen: list[FrameMarkers] = []

    def moving(frames: Iterable[SeenFrame]) -> Iterator[MovingPoints]:
        for one in frames:
            seen.append(one.markers)
            progress(len(seen), len(film.times_s))
            yield MovingPoints(one.upright_m, one.time_s, body=bodies.of(one.person))

    with film.seen() as frames:
        named = name_movement(namer, moving(frames), view)
    return MarkedJoints(
        _track(film.timestamps_ns, [one.points_m for one in seen], named),
        sum(len(one.points_m) for one in seen),
        (*_about_view(told), *_spare(named, view), *doubts_about_frames(seen)),
        {
            "model": namer.identity,
            "view": view,
            "n_frames_that_told_view": 0 if told is None else told.n_telling,
            "n_frames_with_body": bodies.n_known,
        },
    )


def _first_view(namer: Namer, film: MovementFrames) -> FirstView | None:
    """Return which side is seen at first, by the names of markers in some of the first frames.

    They are looked at anew afterwards: with their pictures, for the bodies, they would fill memory.
    """
    steps = np.floor(film.times_s / STEP_S)
    is_early = (np.diff(steps, prepend=-1.0) > 0.0) & (film.times_s < EARLY_S)
    with film.seen(np.flatnonzero(is_early)) as frames:
        moving = (
            MovingPoints(one.upright_m, one.time_s)
            for one in frames
            if len(one.upright_m) >= LEAST_POINTS
        )
        return first_view(namer, islice(moving, N_EARLY))


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


def _about_view(told: FirstView | None) -> Iterator[Sentence]:
    if told is not None:
        yield Sentence(VIEW_FOUND, {"side": SIDES[told.view], "n": told.n_telling})


def _spare(named: Sequence[TrackedNames], view: str) -> Iterator[Sentence]:
    if n_unnamed := sum(None in one.names for one in named):
        yield Sentence(SPARE_MARKERS, {"percent": 100.0 * n_unnamed / len(named)}, decimals=0)
        if not view:
            yield Sentence(VIEW_HELPS)
