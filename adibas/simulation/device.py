"""One simulated sensor of the Kinect v1 / PrimeSense kind, different for every seed.

Two cameras look the same way, 25 mm apart; the infrared projector stands 75 mm beside the depth
camera. Focal lengths, principal points, lens distortion, the angle between the cameras and the
depth error are drawn around those of the real devices.
"""

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np

from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform

DEPTH_SIZE = (480, 640)
COLOR_SIZES = ((1024, 1280), (480, 640))
DEPTH_UNIT_M = 0.001
BIAS_REFERENCE_M = (2.0, 3.0)


@dataclass(frozen=True, slots=True)
class DeviceSpread:
    """How devices differ; standard deviations unless said otherwise.

    Attributes
    ----------
    depth_focal_px, color_focal_px : (float, float)
        Range at 640x480 and 1280x1024 (issue: 575-585; 1050-1060, double of 525-530).
    principal_px : float
        Of the principal point about the image centre, at 640 pixels' width.
    baseline_m : float
        From depth camera to colour camera, along x (25 mm; PEERS 3.4, general knowledge).
    baseline_sd_m, rotation_sd_rad : float
        Mounting tolerance (assumed).
    radial : (float, float)
        Mean k1 and k2 of the colour lens; a weak barrel, weaker than the thesis' own camera.
    bias_at_2_m, bias_at_3_m : (float, float)
        Range of the size of the depth error, metres; its sign is drawn (1-3 cm: Boehm 2014).
    bias_of_border_m : float
        What each quadratic term of the image adds to the depth error at 2 m at the middle of the
        image's border (some mm in the maps of Herrera et al. 2012); none by default.
    """

    depth_focal_px: tuple[float, float] = (575.0, 585.0)
    color_focal_px: tuple[float, float] = (1050.0, 1060.0)
    principal_px: float = 4.0
    baseline_m: float = 0.025
    baseline_sd_m: float = 0.0003
    rotation_sd_rad: float = math.radians(0.3)
    radial: tuple[float, float] = (0.05, -0.15)
    bias_at_2_m: tuple[float, float] = (0.008, 0.020)
    bias_at_3_m: tuple[float, float] = (0.015, 0.030)
    bias_of_border_m: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Device:
    """The true make-up of one sensor.

    Attributes
    ----------
    calibration : RgbdCalibration
        Exact, with the depth bias that brings measured depth back to the truth.
    disparity_offset : float
        Raw disparity at infinity, in 1/8 pixel (about 1090).
    seed : int
        What it was drawn from; the fixed pattern of its depth noise follows it.
    """

    calibration: RgbdCalibration
    disparity_offset: float
    seed: int

    @property
    def depth(self) -> CameraCalibration:
        """The depth camera."""
        return _known(self.calibration.depth)

    @property
    def color(self) -> CameraCalibration:
        """The colour camera."""
        return _known(self.calibration.color)

    def without_bias_correction(self) -> RgbdCalibration:
        """Return what a user has who never measured the depth bias."""
        return replace(self.calibration, depth_bias=DepthBias())


def draw_device(
    seed: int, color_size: tuple[int, int] = (1024, 1280), spread: DeviceSpread | None = None
) -> Device:
    """Return the device number `seed`; the same one whatever the colour mode."""
    if color_size not in COLOR_SIZES:
        raise ValueError(f"color_size must be one of {COLOR_SIZES}, got {color_size}")
    spread = spread or DeviceSpread()
    rng = np.random.default_rng([seed, 0xDE])
    depth = _camera(rng, DEPTH_SIZE, spread.depth_focal_px, spread.principal_px)
    full = _camera(rng, COLOR_SIZES[0], spread.color_focal_px, 2 * spread.principal_px)
    lens = (
        rng.normal(spread.radial[0], 0.01),
        rng.normal(spread.radial[1], 0.02),
        *rng.normal(0.0, 0.0005, 2),
        0.0,
    )
    full = replace(full, distortion=tuple(float(value) for value in lens))
    rotation, _ = cv2.Rodrigues(rng.normal(0.0, spread.rotation_sd_rad, 3))
    offset_m = rng.normal((-spread.baseline_m, 0.0, 0.0), spread.baseline_sd_m)
    bias = _bias(rng, spread)
    disparity_offset = float(rng.uniform(1085.0, 1095.0))
    if spread.bias_of_border_m > 0.0:
        bias = replace(bias, image_term=_image_term(rng, spread.bias_of_border_m, depth))
    return Device(
        calibration=RgbdCalibration(
            color=full if color_size == COLOR_SIZES[0] else _binned(full),
            depth=depth,
            color_from_depth=RigidTransform(np.asarray(rotation, float), offset_m),
            depth_unit_m=DEPTH_UNIT_M,
            depth_bias=bias,
            sensor_serial=f"SIM{seed:05d}",
        ),
        disparity_offset=disparity_offset,
        seed=seed,
    )


def _known(camera: CameraCalibration | None) -> CameraCalibration:
    if camera is None:
        raise ValueError("a simulated device has both cameras")
    return camera


def _camera(
    rng: np.random.Generator,
    size: tuple[int, int],
    focal_px: tuple[float, float],
    principal_px: float,
) -> CameraCalibration:
    height, width = size
    fx = rng.uniform(*focal_px)
    fy = fx * rng.normal(1.0, 0.001)
    cx, cy = rng.normal(((width - 1) / 2, (height - 1) / 2), principal_px)
    return CameraCalibration(width, height, Intrinsics(float(fx), float(fy), float(cx), float(cy)))


def _binned(full: CameraCalibration) -> CameraCalibration:
    """Return the 640x480 mode: 2x2 pixels of the middle 960 rows taken together."""
    height, width = COLOR_SIZES[1]
    skipped_rows = (COLOR_SIZES[0][0] - 2 * height) / 2
    k = full.intrinsics
    binned = Intrinsics(
        k.fx / 2, k.fy / 2, (k.cx + 0.5) / 2 - 0.5, (k.cy - skipped_rows + 0.5) / 2 - 0.5
    )
    return CameraCalibration(width, height, binned, full.distortion)


def _bias(rng: np.random.Generator, spread: DeviceSpread) -> DepthBias:
    """Draw the parabola through errors at 2 and 3 m and a small one at 0.5 m.

    The error is measured minus true, taken at the measured depth; `DepthBias` undoes it.
    """
    sign = rng.choice((-1.0, 1.0))
    z_m = np.array([0.5, *BIAS_REFERENCE_M])
    error_m = sign * np.array(
        [0.001, rng.uniform(*spread.bias_at_2_m), rng.uniform(*spread.bias_at_3_m)]
    )
    c, b, a = np.polyfit(z_m, z_m - error_m, 2)
    return DepthBias(float(a), float(b), float(c))


def _image_term(
    rng: np.random.Generator, sd_m: float, camera: CameraCalibration
) -> tuple[float, ...]:
    """Draw the terms x, y, x^2, xy, y^2, each of `sd_m` at 2 m at the image's border."""
    x, y = camera.width / (2 * camera.intrinsics.fx), camera.height / (2 * camera.intrinsics.fy)
    sizes = np.array([x, y, x * x, x * y, y * y]) * BIAS_REFERENCE_M[0] ** 2
    return tuple((rng.normal(0.0, sd_m, len(sizes)) / sizes).tolist())
