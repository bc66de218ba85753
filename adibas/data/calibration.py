"""A calibrated RGB-D sensor: two cameras, how they stand to each other, and how sure that is."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from adibas.arrays import Float32Array, FloatArray, check_shape, read_only
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import IDENTITY, RigidTransform

DISTORTION_LENGTHS = (0, 4, 5, 8, 12)
IMAGE_TERM_LENGTHS = (0, 2, 5, 9)
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
    """The device's own depth error: true depth = a + b z + (c + image term) z^2.

    A structured-light sensor errs smoothly in disparity, which is z^2 times as much in depth;
    hence the part that depends on the place in the image goes with z^2.

    Source: Herrera, Kannala & Heikkila, Joint depth and color camera calibration with distortion
    correction, PAMI 34 (2012); Khoshelham & Elberink, Sensors 12 (2012).

    Attributes
    ----------
    a, b, c : float
        z and a in metres, c in 1/metres.
    image_term : tuple of 0, 2, 5 or 9 floats
        1/metres, of x, y; x^2, xy, y^2; x^3, x^2 y, x y^2, y^3, where x = (u - cx) / fx and
        y = (v - cy) / fy of the depth camera's pixel, whatever its lens. Empty: none.
    """

    a: float = 0.0
    b: float = 1.0
    c: float = 0.0
    image_term: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if len(self.image_term) not in IMAGE_TERM_LENGTHS:
            raise ValueError(
                f"image_term must have one of {IMAGE_TERM_LENGTHS} values, "
                f"got {len(self.image_term)}"
            )
        if not all(math.isfinite(value) for value in (self.a, self.b, self.c, *self.image_term)):
            raise ValueError("depth_bias must be finite")

    def square_term_per_m(self, camera: CameraCalibration) -> Float32Array:
        """Return the (H, W) factor of z^2 in the depth camera's image, 1/metres; read-only."""
        return _square_term_per_m(self.c, self.image_term, camera)

    def correct(
        self, depth_m: Float32Array, camera: CameraCalibration | None = None
    ) -> Float32Array:
        """Return the corrected depth.

        Parameters
        ----------
        depth_m : (H, W) float32 array
            As measured, metres; NaN stays NaN.
        camera : CameraCalibration or None
            That took it; only an image term needs it, which has another value in each pixel.

        Raises
        ------
        ValueError
            There is an image term and no camera, or another size of image.
        """
        if (self.a, self.b, self.c) == (0.0, 1.0, 0.0) and not any(self.image_term):
            return depth_m
        a, b = np.float32(self.a), np.float32(self.b)
        square: np.float32 | Float32Array = np.float32(self.c)
        if any(self.image_term):
            if camera is None:
                raise ValueError("an image term needs the depth camera")
            square = self.square_term_per_m(camera)
            check_shape("depth_m", depth_m, square.shape)
        corrected: Float32Array = a + depth_m * (b + square * depth_m)
        return corrected


def image_polynomial(x: FloatArray, y: FloatArray, n_terms: int) -> tuple[FloatArray, ...]:
    """Return the first `n_terms` of what `DepthBias.image_term` multiplies, at x and y."""
    terms = (x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y)
    return terms[:n_terms]


@lru_cache(maxsize=8)
def _square_term_per_m(
    c: float, image_term: tuple[float, ...], camera: CameraCalibration
) -> Float32Array:
    k = camera.intrinsics
    x: FloatArray = (np.arange(float(camera.width)) - k.cx) / k.fx
    y: FloatArray = ((np.arange(float(camera.height)) - k.cy) / k.fy)[:, None]
    total: FloatArray = np.full((camera.height, camera.width), c)
    for factor, term in zip(image_term, image_polynomial(x, y, len(image_term)), strict=True):
        total += factor * term
    square_term = total.astype(np.float32)
    read_only(square_term)
    return square_term


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
    gravity_sd_rad, floor_flatness_m : float or None
        Standard deviation of the angle of `gravity`, and root mean square of the floor about its
        plane; None where unknown.
    sensor_serial, created_utc : str
        Empty where unknown.
    valid_region : mapping
        Where the images of the calibration had points; kept, and applied by nothing.
    corner_method : str
        What counted as a corner of the board: ``edges`` or ``gradient``; empty where unknown.
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
    gravity_sd_rad: float | None = None
    floor_flatness_m: float | None = None
    sensor_serial: str = ""
    created_utc: str = ""
    valid_region: Mapping[str, object] = field(default_factory=dict)
    corner_method: str = ""

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

    def corrected_depth(self, depth_m: Float32Array) -> Float32Array:
        """Return the (H, W) depth in metres without the device's own error; NaN stays NaN."""
        return self.depth_bias.correct(depth_m, self.depth)
