"""A slow turn before the sensor, cut into the four standing views.

The person is followed through the recording. Where a side faces the sensor, the moments around it
are moved to where the body stood in the middle one, and averaged there: a view like one of
somebody who stood still for as many frames.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from adibas.alignment.turn import TurnParams, TurnTracker, seen_after
from adibas.alignment.views import View, ViewParams, prepare_view
from adibas.arrays import Float32Array, FloatArray
from adibas.body.mask import find_body, heights_over
from adibas.calibration.files import check_fits
from adibas.data.calibration import DepthBias, RgbdCalibration
from adibas.data.frames import depth_in_metres
from adibas.data.sentence import Sentence
from adibas.errors import BodyError
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform
from adibas.markers.disparity import DisparitySum
from adibas.pipeline.body_views import (
    LEAST_SHARE,
    BodyView,
    ViewRequest,
    depth_camera_of,
    floor_in,
    no_depth,
    nobody,
    picture_of,
    touches_top,
)
from adibas.pipeline.session import calibration_of, wanted_frames
from adibas.progress import Progress
from adibas.recordings import open_recording
from adibas.recordings.ports import RecordingReader
from adibas.texts import message

TO_THE_LEFT = ("posterior", "left_lateral", "anterior", "right_lateral")
"""What the sensor sees one after the other of somebody who turns to the own left."""
LOST = message("In {n} of {total} frames of the turn the person was not seen or not followed.")
QUARTER_RAD = 0.5 * np.pi
ONE_LEVEL = ViewParams(n_levels=1)


@dataclass(frozen=True, slots=True)
class CutParams:
    """Settings.

    Attributes
    ----------
    tracking : TurnParams
    half_rad : float
        Moments turned by at most so much from the middle one make a view: 12 degrees, so that the
        same side of the body is seen in all.
    most_frames : int
        Of a view, evenly chosen: 40.
    late_rad : float
        By how much a turn may end before a side faces the sensor squarely: 10 degrees.
    legs : float
        What lies lower, as a share of the stature, tells nothing about the turn: 0.45; somebody
        who turns on the spot takes steps.
    greatest_sd_per_m : float
        Of a pixel's 1/z over the moments of a view: 0.005, three times the sensor's noise (half a
        step of disparity and its rounding); more scatters what did not move with the trunk.
    most_lost : int
        Frames one after the other in which the person is not found again: 15.
    """

    tracking: TurnParams = field(default_factory=TurnParams)
    half_rad: float = 0.2094
    most_frames: int = 40
    late_rad: float = 0.1745
    legs: float = 0.45
    greatest_sd_per_m: float = 0.005
    most_lost: int = 15


@dataclass(frozen=True, slots=True, eq=False)
class SeenTurn:
    """What a turn gives.

    Attributes
    ----------
    views : tuple of BodyView
    frames : mapping
        The middle frame of each view, by its name.
    turned_rad : float
        From the first frame to the last, positive to the patient's left.
    n_lost : int
        Frames in which the person was not found or not followed.
    wanted : range
        The frames that were looked at.
    """

    views: tuple[BodyView, ...]
    frames: Mapping[str, int]
    turned_rad: float
    n_lost: int
    wanted: range

    @property
    def n_frames(self) -> int:
        """Return how many frames were looked at."""
        return len(self.wanted)

    def middle_of(self, view: str) -> tuple[int, int]:
        """Return the first of the frames in the middle of a view, and one past the last.

        They are the middle one and its neighbours, where these are wanted, too.
        """
        frame = self.frames[view]
        return max(frame - 1, self.wanted.start), min(frame + 2, self.wanted.stop)

    @property
    def notices(self) -> tuple[Sentence, ...]:
        """What is to be told of the frames that were left out."""
        lost = Sentence(LOST, {"n": self.n_lost, "total": self.n_frames})
        return (lost,) if self.n_lost else ()


def see_turn(request: ViewRequest, progress: Progress, params: CutParams | None = None) -> SeenTurn:
    """Follow somebody who turns, and return the views that come by.

    Parameters
    ----------
    request : ViewRequest
        Its view is the one with which the turn begins.

    Raises
    ------
    RecordingError
        It is missing, broken, or has no such frames, or no depth.
    CalibrationError
        There is none of the depth camera, or one for another resolution.
    BodyError
        Nobody is seen, no floor, the person is lost, or does not turn.
    """
    with open_recording(request.recording) as recording:
        wanted = wanted_frames(recording, request.frames, request.recording.name)
        calibration = calibration_of(recording, request.calibration)
        turn = RecordedTurn(
            *(recording, calibration, wanted, request.recording.name, request.view),
            request.rotation_deg,
        )
        return follow_turn(turn, progress, params)


@dataclass(frozen=True, slots=True, eq=False)
class RecordedTurn:
    """An open recording of a turn.

    Attributes
    ----------
    recording : RecordingReader
    calibration : RgbdCalibration
    wanted : range
        The frames that are looked at.
    name : str
        What the recording is called in errors.
    begins : str
        The view with which the turn begins.
    rotation_deg : int
        How far the picture is turned clockwise to be upright.
    """

    recording: RecordingReader
    calibration: RgbdCalibration
    wanted: range
    name: str
    begins: str = TO_THE_LEFT[0]
    rotation_deg: int = 0


def follow_turn(
    turn: RecordedTurn, progress: Progress, params: CutParams | None = None
) -> SeenTurn:
    """Return the views that come by in an open recording; errors as of `see_turn`."""
    params = params or CutParams()
    moments = _Moments(turn)
    n_wanted = len(turn.wanted)
    total = n_wanted + len(TO_THE_LEFT) * params.most_frames
    path = _followed(moments, turn.wanted, lambda done: progress(done, total), params)
    sides = _sides(path, turn.begins, params)
    if len(sides) == 1:
        raise _too_little(path, turn.name, turn.recording.notice)
    views, frames = [], {}
    for number, (name, index) in enumerate(sides.items()):
        views.append(moments.view(name, index, path, params))
        frames[name] = index
        progress(n_wanted + (number + 1) * params.most_frames, total)
    progress(total, total)
    return SeenTurn(
        tuple(views), MappingProxyType(frames), float(path.turned_rad[-1]), path.n_lost, turn.wanted
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Path:
    """Where the person stood: of the frames that were followed."""

    indices: Sequence[int]
    first_from_camera: Sequence[RigidTransform]
    turned_rad: FloatArray
    n_lost: int

    @property
    def furthest_rad(self) -> float:
        """The greatest turn away from the first frame, positive to the patient's left."""
        return float(self.turned_rad[int(np.abs(self.turned_rad).argmax())])

    def around(self, index: int, params: CutParams) -> list[int]:
        """Return places in the path that are turned little against that of a frame."""
        low, high = self._span(index, params)
        n = min(high - low + 1, params.most_frames)
        return sorted({round(at) for at in np.linspace(low, high, n)})

    def n_around(self, index: int, params: CutParams) -> int:
        """Return how many there are."""
        low, high = self._span(index, params)
        return high - low + 1

    def _span(self, index: int, params: CutParams) -> tuple[int, int]:
        """Return the first and the last place that follow one another without a gap."""
        middle = self.indices.index(index)
        far = np.abs(self.turned_rad - self.turned_rad[middle]) > params.half_rad
        before, after = np.flatnonzero(far[:middle]), np.flatnonzero(far[middle:])
        low = int(before[-1]) + 1 if len(before) else 0
        return low, middle + int(after[0]) - 1 if len(after) else len(far) - 1


class _Moments:
    """Frames of the recording, the person alone."""

    def __init__(self, turn: RecordedTurn) -> None:
        self._recording, self._calibration = turn.recording, turn.calibration
        self._camera = depth_camera_of(turn.calibration)
        self.name, self._rotation_deg = turn.name, turn.rotation_deg
        self._floor: Plane | None = turn.calibration.floor
        self.has_depth = False

    @property
    def floor(self) -> Plane:
        """In the depth camera's axes, once a frame was read."""
        if self._floor is None:
            raise ValueError("the floor is found in the first frame")
        return self._floor

    def person(self, index: int) -> Float32Array | None:
        """Return the depth of the person in a frame, else NaN; None where nobody is seen."""
        raw = self._recording.read(index).depth_raw
        if raw is None:
            return None
        self.has_depth = True
        depth_m = depth_in_metres(raw, self._recording.info.depth_unit_m)
        check_fits(self._calibration, None, depth_m.shape)
        depth_m = np.ascontiguousarray(self._calibration.corrected_depth(depth_m), np.float32)
        if self._floor is None:
            self._floor = floor_in(depth_m, self._calibration, self.name, self._rotation_deg)
        mask = find_body(depth_m, self._camera, self._floor)
        return None if mask is None else np.where(mask.pixels, depth_m, np.float32(np.nan))

    def above_legs(self, depth_m: Float32Array, params: CutParams) -> View:
        """Return trunk, arms and head of the person who is all that an image shows."""
        heights_m = heights_over(depth_m, self._camera, self.floor)
        with np.errstate(invalid="ignore"):
            is_upper = heights_m >= params.legs * np.nanmax(heights_m)
        return prepare_view(np.where(is_upper, depth_m, np.float32(np.nan)), self._camera)

    def view(self, name: str, index: int, path: _Path, params: CutParams) -> BodyView:
        """Return one side: the moments around it, where the body stood in frame `index`."""
        camera_from_first = path.first_from_camera[path.indices.index(index)].inverse()
        total = DisparitySum(DepthBias())
        for place in path.around(index, params):
            depth_m = self.person(path.indices[place])
            if depth_m is not None:
                motion = camera_from_first @ path.first_from_camera[place]
                moment = prepare_view(depth_m, self._camera, ONE_LEVEL)
                with np.errstate(divide="ignore"):
                    total.add(np.asarray(1.0 / seen_after(moment, motion), np.float32))
        surface = total.result(LEAST_SHARE, params.greatest_sd_per_m)
        body = np.isfinite(surface.mean_per_m)
        return BodyView(
            name,
            surface,
            body,
            self.floor,
            self._calibration,
            surface.n_frames,
            is_cut_above=touches_top(body, self.floor),
            notice=self._recording.notice,
            picture_rgb=picture_of(self._recording, index, self._calibration),
        )


def _followed(
    moments: _Moments, wanted: range, told: Callable[[int], None], params: CutParams
) -> _Path:
    """Follow the person from the first frame on.

    Raises
    ------
    RecordingError
        There is no depth.
    BodyError
        Nobody is seen, or the person is lost for good.
    """
    tracker: TurnTracker | None = None
    indices: list[int] = []
    poses: list[RigidTransform] = []
    n_lost = n_missing = 0
    for done, index in enumerate(wanted, 1):
        depth_m = moments.person(index)
        if depth_m is not None:
            tracker = tracker or TurnTracker(moments.floor, params.tracking)
            pose = tracker.follow(moments.above_legs(depth_m, params))
        if depth_m is None or pose is None:
            n_lost, n_missing = n_lost + 1, n_missing + 1
            if indices and n_missing > params.most_lost:
                raise BodyError(
                    "The person is lost in frame {index} of {file}. Let the patient turn slowly, "
                    "in 10 to 30 seconds, alone, with the arms hanging still.",
                    index=index,
                    file=moments.name,
                )
        else:
            n_missing = 0
            indices.append(index)
            poses.append(pose)
        told(done)
    if not moments.has_depth:
        raise no_depth(moments.name)
    if not indices:
        raise nobody(moments.name)
    return _Path(indices, poses, _turned_rad(poses, moments.floor), n_lost)


def _turned_rad(poses: Sequence[RigidTransform], floor: Plane) -> FloatArray:
    """Return by how much the body is turned to its own left since the first pose."""
    up = floor.normal
    ahead = np.array([0.0, 0.0, 1.0])
    ahead = ahead - up * (up @ ahead)
    aside = np.cross(up, ahead)
    # The camera goes round the body the other way.
    seen = [pose.rotation.T @ ahead for pose in poses]
    return np.unwrap([float(np.arctan2(one @ aside, one @ ahead)) for one in seen])


def _sides(path: _Path, begins: str, params: CutParams) -> dict[str, int]:
    """Return the frame in which each side faces the sensor most squarely, by name."""
    furthest = path.furthest_rad
    way = 1 if furthest > 0 else -1
    number = TO_THE_LEFT.index(begins)
    sides: dict[str, int] = {}
    # A turn shows the side with which it begins once more at its end, where it goes on enough.
    for quarter in range(int((abs(furthest) + params.late_rad) / QUARTER_RAD) + 1):
        off_rad = np.abs(way * path.turned_rad - quarter * QUARTER_RAD)
        index = path.indices[int(off_rad.argmin())]
        name = TO_THE_LEFT[(number + way * quarter) % len(TO_THE_LEFT)]
        if name not in sides or path.n_around(index, params) > path.n_around(sides[name], params):
            sides[name] = index
    return sides


def _too_little(path: _Path, name: str, notice: str | None) -> BodyError:
    """Return what is told of a turn by less than a quarter, and where the recording was cut."""
    told = {"deg": f"{np.degrees(abs(path.furthest_rad)):.0f}", "file": name}
    if notice:
        return BodyError(
            "{notice} What is left shows only {deg} degrees of a turn. Restore {file} from a copy, "
            "or record the turn again.",
            notice=notice,
            **told,
        )
    return BodyError(
        "Only {deg} degrees of a turn can be followed in {file}. Let the patient turn once "
        "around, slowly, in 10 to 30 seconds.",
        **told,
    )
