"""Everybody in live frames, found without markers, and where their joints lie in the pictures."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from adibas.arrays import Float32Array, FloatArray
from adibas.clock import NS_PER_S
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.joints import JOINT_NAMES
from adibas.data.sentence import Sentence
from adibas.geometry.distortion import project_distorted
from adibas.geometry.quarter_turns import QuarterTurn
from adibas.pipeline.person_judge import person_judge
from adibas.pipeline.pose_following import PersonNow, PoseEstimator, forest_segmenter
from adibas.pipeline.pose_model import joint_model_for
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.pipeline.upright import turn_to_upright, turned_camera, turned_floor, turned_pose

SET_BACK_S = 2.0
"""A clock that goes back so far belongs to a sensor that was opened anew."""

Places = Mapping[str, tuple[float, float]]
"""Pixel (u, v) of each joint that is seen and that the picture shows, by its name."""


@dataclass(frozen=True, slots=True, eq=False)
class LiveMoment:
    """Everybody in one live frame.

    Attributes
    ----------
    timestamp_ns : int
    run : int
        Numbers of people are the same from moment to moment of one run; a new one begins with
        another calibration and with a sensor that is opened anew.
    people : tuple of PersonNow
    unseen : Sentence or None
        Why there is nobody; None where somebody is.
    turn : QuarterTurn
        After which people stand upright in the picture; joints are in the camera's own axes.
    """

    timestamp_ns: int
    run: int
    people: tuple[PersonNow, ...]
    unseen: Sentence | None
    turn: QuarterTurn = field(default_factory=QuarterTurn)


@dataclass(frozen=True, slots=True, eq=False)
class LiveJoints:
    """The joints of somebody in the pictures of one frame, found without markers.

    Attributes
    ----------
    person : int
    n_seen : int
        Joints that have a place in space.
    is_view_sure : bool
        Whether it is known if the front or the back is seen, and so which joints are left.
    in_color, in_depth : dict
        Pixels of the colour and of the depth image; empty without a calibrated camera.
    """

    person: int
    n_seen: int
    is_view_sure: bool
    in_color: Places
    in_depth: Places


class LivePeople:
    """Takes the depth of a frame as often as there is time; for one thread at a time."""

    def __init__(self) -> None:
        self._calibration: RgbdCalibration | None = None
        self._rotation_deg = 0
        self._turn = QuarterTurn()
        self._estimator: PoseEstimator | None = None
        self._before_ns: int | None = None
        self._run = 0

    def look(
        self,
        depth_m: Float32Array,
        timestamp_ns: int,
        calibration: RgbdCalibration,
        rotation_deg: int = 0,
    ) -> LiveMoment | None:
        """Return everybody; None where a frame is left out, or the depth camera is not known.

        Parameters
        ----------
        depth_m : (H, W) float32 array
            Corrected, metres; NaN where not measured.
        timestamp_ns : int
            A frame that is not later than the one before is left out; where the clock was set
            back, as by a sensor that is opened anew, everybody is looked at anew.
        calibration : RgbdCalibration
            Of the sensor; with another one than before everybody is looked at anew.
        rotation_deg : int
            How far the picture is turned clockwise for showing: tells where up is where the
            calibration does not. With another one, too, everybody is looked at anew.
        """
        is_other = calibration is not self._calibration or rotation_deg != self._rotation_deg
        if is_other or self._is_set_back(timestamp_ns):
            self._begin(calibration, rotation_deg)
        is_old = self._before_ns is not None and timestamp_ns <= self._before_ns
        if self._estimator is None or is_old:
            return None
        self._before_ns = timestamp_ns
        now = self._estimator.look(self._turn.picture(depth_m), timestamp_ns / NS_PER_S)
        now = turned_pose(now, self._turn.inverse())
        # What is said last of somebody is what refuses them.
        unseen = None if now.people or not now.notices else now.notices[-1]
        return LiveMoment(timestamp_ns, self._run, tuple(now.people), unseen, self._turn)

    def _is_set_back(self, timestamp_ns: int) -> bool:
        if self._before_ns is None:
            return False
        return self._before_ns - timestamp_ns > SET_BACK_S * NS_PER_S

    def _begin(self, calibration: RgbdCalibration, rotation_deg: int) -> None:
        self._calibration, self._estimator, self._before_ns = calibration, None, None
        self._rotation_deg = rotation_deg
        self._turn = turn_to_upright(calibration, rotation_deg)
        self._run += 1
        if calibration.depth is not None:
            model = shipped_model()
            camera = turned_camera(calibration.depth, self._turn)
            self._estimator = PoseEstimator(
                camera,
                forest_segmenter(model, camera),
                turned_floor(calibration.floor, self._turn),
                joints=joint_model_for(model),
                judge=person_judge(model, camera),
            )


def joints_in_pictures(person: PersonNow, calibration: RgbdCalibration) -> LiveJoints:
    """Return where the pictures show somebody's joints."""
    joints_m = person.joints.joints_m
    in_color_m = calibration.color_from_depth.apply(joints_m)
    return LiveJoints(
        person.person,
        person.joints.n_seen,
        person.joints.is_view_sure,
        _places(in_color_m, calibration.color),
        _places(joints_m, calibration.depth),
    )


def _places(joints_m: FloatArray, camera: CameraCalibration | None) -> Places:
    if camera is None:
        return {}
    pixels = project_distorted(joints_m, camera.intrinsics, camera.distortion)
    return {
        name: (u, v)
        for name, (u, v) in zip(JOINT_NAMES, pixels.tolist(), strict=True)
        if 0.0 <= u <= camera.width - 1.0 and 0.0 <= v <= camera.height - 1.0
    }
