"""What is exactly so in a simulated frame."""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, UInt8Array, check_shape, read_only
from adibas.data.board import Board
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import SensorFrame
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform

STEEPEST_VISIBLE_RAD = math.radians(65.0)
"""Of a visible marker, from its normal (docs/conventions.md)."""
WHOLE = 0.97
"""Share of a disc from which it counts as whole: its rim is a matter of samples."""


@dataclass(frozen=True, slots=True, eq=False)
class MarkerTruth:
    """One marker of one frame.

    Attributes
    ----------
    name : str
        Landmark or joint.
    position_m : (3,) array
        Centre of the disc or ball in the colour camera's axes.
    normal : (3,) array
        Of the skin there, outward, in the colour camera's axes.
    radius_m : float
    u, v : float
        Where the centre is in the colour image as taken (with lens distortion); NaN behind it.
    view_angle_rad : float
        Between the normal and the line to the colour camera.
    visible_fraction : float
        Of the marker's picture: neither hidden nor outside the image.
    """

    name: str
    position_m: FloatArray
    normal: FloatArray
    radius_m: float
    u: float
    v: float
    view_angle_rad: float
    visible_fraction: float

    def __post_init__(self) -> None:
        check_shape("position_m", self.position_m, (3,))
        check_shape("normal", self.normal, (3,))
        read_only(self.position_m)
        read_only(self.normal)

    @property
    def is_in_view(self) -> bool:
        """Say whether the whole disc is seen, at whatever angle."""
        return self.view_angle_rad < math.pi / 2 and self.visible_fraction >= WHOLE

    @property
    def is_visible(self) -> bool:
        """Say whether the marker counts as visible: whole in view, at 65 degrees or less."""
        return self.is_in_view and self.view_angle_rad <= STEEPEST_VISIBLE_RAD


@dataclass(frozen=True, slots=True, eq=False)
class BoardTruth:
    """The calibration board of one frame.

    Attributes
    ----------
    board : Board
    camera_from_board : RigidTransform
        Into the colour camera's axes.
    corners_px : (rows * columns, 2) array
        Of the corners in the colour image, in the order of `Board.points_m`; NaN where hidden.
    station : int or None
        At which stop it is held; None on the way.
    """

    board: Board
    camera_from_board: RigidTransform
    corners_px: FloatArray
    station: int | None

    def __post_init__(self) -> None:
        check_shape("corners_px", self.corners_px, (self.board.n_corners, 2))
        read_only(self.corners_px)


@dataclass(frozen=True, slots=True, eq=False)
class FrameTruth:
    """Everything that is so in one frame.

    Attributes
    ----------
    joints_m : (15, 3) array
        In the depth camera's axes, order of `JOINT_NAMES`; no person: NaN.
    joints_color_m : (15, 3) array
        The same in the colour camera's axes.
    markers : tuple of MarkerTruth
        All markers on the person, seen or not.
    labels : (H, W) uint8 array
        Body part of each depth pixel: index in `BODY_PART_NAMES` + 1, 0 = no person.
    depth_m : (H, W) float32 array
        Without noise and shadow, metres.
    calibration : RgbdCalibration
        Of the device, exact.
    board : BoardTruth or None
        Of the scene with the calibration board.
    wall : Plane or None
        Of the scene with the flat wall, in the depth camera's axes.
    """

    joints_m: FloatArray
    joints_color_m: FloatArray
    markers: tuple[MarkerTruth, ...]
    labels: UInt8Array
    depth_m: Float32Array
    calibration: RgbdCalibration
    board: BoardTruth | None = None
    wall: Plane | None = None

    def __post_init__(self) -> None:
        for name in ("joints_m", "joints_color_m", "labels", "depth_m"):
            read_only(getattr(self, name))

    @property
    def body_mask(self) -> BoolArray:
        """Return the (H, W) pixels of the depth image that show the person."""
        return np.asarray(self.labels > 0)

    def marker(self, name: str) -> MarkerTruth:
        """Return the marker of that name."""
        return next(marker for marker in self.markers if marker.name == name)


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedFrame:
    """What the sensor gives, and the truth behind it."""

    sensor_frame: SensorFrame
    truth: FrameTruth
