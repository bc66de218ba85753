"""A calibrated RGB-D sensor: two cameras, how they stand to each other, and how sure that is."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import Float32Array, FloatArray, check_shape, read_only
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import IDENTITY, RigidTransform

DISTORTION_LENGTHS = (0, 4, 5, 8, 12)
LARGEST_SIDE_PX = 65_535
UNIT_TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True)
class CameraCalibration:
    """One camera: image size in pixels, pin-hole part, lens distortion in OpenCV's order."""

    width: int
    height: int
    intrinsics: Intrinsics
    distortion: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if self.width <= 0 or self.height <= 0:
            raise ValueError(f"image size must be positive: {self.width} x {self.height}")
        if max(self.width, self.height) > LARGEST_SIDE_PX:
            raise ValueError(f"image size is beyond {LARGEST_SIDE_PX} pixels a side")
        if len(self.distortion) not in DISTORTION_LENGTHS:
            raise ValueError(
                f"distortion must have one of {DISTORTION_LENGTHS} values, "
                f"got {len(self.distortion)}"
            )
        if not all(math.isfinite(value) for value in self.distortion):
            raise ValueError("distortion must be finite")


@dataclass(frozen=True, slots=True)
class DepthBias:
    """The device's own depth error: true depth = a + b z + c z^2 (z and a in metres)."""

    a: float = 0.0
    b: float = 1.0
    c: float = 0.0

    def correct(self, depth_m: Float32Array) -> Float32Array:
        """Return the (H, W) corrected depth in metres; NaN stays NaN."""
        if (self.a, self.b, self.c) == (0.0, 1.0, 0.0):
            return depth_m
        a, b, c = np.float32(self.a), np.float32(self.b), np.float32(self.c)
        corrected: Float32Array = a + depth_m * (b + c * depth_m)
        return corrected


@dataclass(frozen=True, slots=True, eq=False)
class RgbdCalibration:
    """Everything that is known of one sensor; parts that are not known are None.

    Attributes
    ----------
    color, depth : CameraCalibration or None
        Either may stand alone.
    color_from_depth : RigidTransform
        Depth-camera points into colour-camera points.
    depth_unit_m : float
        Metres in one count of raw depth.
    depth_bias : DepthBias
        Applied to measured depth, in metres.
    rms_px : float or None
        Reprojection error as a root mean square over points.
    parameter_names, covariance
        Names such as ``color.fx`` and their (n, n) covariance in squared units; None if unknown.
    gravity : (3,) array or None
        Unit vector that points down, in the depth camera's axes.
    floor : Plane or None
        In the depth camera's axes, normal up.
    sensor_serial, created_utc : str
        Empty where unknown.
    valid_region : mapping
        Where the images of the calibration had points; kept, and applied by nothing.
    """

    color: CameraCalibration | None = None
    depth: CameraCalibration | None = None
    color_from_depth: RigidTransform = IDENTITY
    depth_unit_m: float = 0.001
    depth_bias: DepthBias = field(default_factory=DepthBias)
    rms_px: float | None = None
    parameter_names: tuple[str, ...] = ()
    covariance: FloatArray | None = None
    gravity: FloatArray | None = None
    floor: Plane | None = None
    sensor_serial: str = ""
    created_utc: str = ""
    valid_region: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not 0 < self.depth_unit_m < math.inf:
            raise ValueError(f"depth_unit_m must be positive, got {self.depth_unit_m}")
        if self.covariance is not None:
            n_parameters = len(self.parameter_names)
            check_shape("covariance", self.covariance, (n_parameters, n_parameters))
            read_only(self.covariance)
        if self.gravity is not None:
            check_shape("gravity", self.gravity, (3,))
            if not abs(np.linalg.norm(self.gravity) - 1.0) < UNIT_TOLERANCE:
                raise ValueError("gravity must have length 1")
            read_only(self.gravity)
