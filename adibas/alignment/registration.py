"""Depth registered to colour: which surface each colour pixel looks at.

Every depth pixel is moved into the colour camera and drawn there as the patch of surface that it
covers. Patches of one surface meet without gaps at any ratio of resolutions; across an edge of the
depth nothing is bridged. Where several patches fall onto one colour pixel the nearest wins, so
that a surface hidden from the colour camera does not shine through.

Source: thesis, equations 3.1-3.4 and section 5.2.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from adibas.alignment.registration_kernels import (
    Coefficients,
    draw_footprints,
    nearest_pixels,
    project_pixels,
)
from adibas.arrays import BoolArray, Float32Array, Int32Array, check_shape, read_only
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.geometry.distortion import pixel_rays

N_COEFFICIENTS = 12


@dataclass(frozen=True, slots=True)
class RegistrationParams:
    """Settings of the registration.

    Attributes
    ----------
    step_per_m : float
        Neighbouring depth pixels whose inverse depths (1/m) differ by more belong to two surfaces.
        Default 0.012: four steps of an eighth of a pixel of disparity (PrimeSense: 0.0029 each),
        48 mm at 2 m, more than noise or a surface at 75 degrees makes.
    step_m : float
        But never less than that in depth, 0.025: close by, slant counts for more than noise.
    """

    step_per_m: float = 0.012
    step_m: float = 0.025


@dataclass(frozen=True, slots=True, eq=False)
class Registration:
    """Depth in the colour image, and where each of its pixels came from.

    Attributes
    ----------
    depth_m : (H, W) float32 array
        Along the colour camera's z, metres, size of the colour image; NaN where nothing is seen.
    source : (H, W) int32 array
        row * width + column of the depth pixel seen there; -1 where there is none.
    """

    depth_m: Float32Array
    source: Int32Array

    def __post_init__(self) -> None:
        read_only(self.depth_m)
        read_only(self.source)

    def moved(self, pixels: BoolArray) -> BoolArray:
        """Move an (H, W) bool image of the depth camera into the colour image."""
        flat = np.append(pixels.ravel(), False)  # -1 reads the last one
        moved: BoolArray = np.take(flat, self.source)
        return moved


def register_depth(depth_m: Float32Array, calibration: RgbdCalibration) -> Float32Array:
    """Return the depth that each colour pixel sees.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Along the depth camera's z, metres; NaN where not measured.
    calibration : RgbdCalibration
        Of both cameras; distortion of both is taken into account.

    Returns
    -------
    registered_m : (H', W') float32 array
        Along the colour camera's z, metres, size of the colour image; NaN where the depth camera
        does not see what the colour camera sees.
    """
    return register_pixels(depth_m, calibration).depth_m


def register_pixels(
    depth_m: Float32Array,
    calibration: RgbdCalibration,
    params: RegistrationParams | None = None,
) -> Registration:
    """Return the depth of each colour pixel and the depth pixel behind it; see `register_depth`."""
    params = params or RegistrationParams()
    depth_camera, color_camera = _cameras(calibration)
    check_shape("depth_m", depth_m, (depth_camera.height, depth_camera.width))
    seen = project_pixels(
        np.ascontiguousarray(depth_m, np.float32),
        *_geometry(calibration),
        twelve_coefficients(color_camera),
    )
    spacing = np.array(
        [
            color_camera.intrinsics.fx / depth_camera.intrinsics.fx,
            color_camera.intrinsics.fy / depth_camera.intrinsics.fy,
        ],
        np.float32,
    )
    shape = (color_camera.height, color_camera.width)
    steps = np.array([params.step_per_m, params.step_m], np.float32)
    return Registration(*draw_footprints(seen, spacing, steps, shape))


def register_depth_nearest(depth_m: Float32Array, calibration: RgbdCalibration) -> Float32Array:
    """Move each depth pixel to the one nearest colour pixel, as `cv2.registerDepth` does.

    Leaves holes where the colour image is finer than the depth image. The colour camera must have
    no distortion.

    Raises
    ------
    ValueError
        The colour camera has distortion.
    """
    _, color_camera = _cameras(calibration)
    if any(color_camera.distortion):
        raise ValueError("register_depth_nearest needs a colour camera without distortion")
    return nearest_pixels(
        np.ascontiguousarray(depth_m, np.float32),
        *_geometry(calibration),
        (color_camera.height, color_camera.width),
    )


def _cameras(calibration: RgbdCalibration) -> tuple[CameraCalibration, CameraCalibration]:
    if calibration.depth is None or calibration.color is None:
        raise ValueError("registration needs the calibration of both cameras")
    return calibration.depth, calibration.color


def _geometry(calibration: RgbdCalibration) -> tuple[Float32Array, Float32Array, Float32Array]:
    depth_camera, color_camera = _cameras(calibration)
    rotation = calibration.color_from_depth.rotation
    table = _turned_rays(depth_camera, tuple(rotation.ravel().tolist()))
    shift_m = calibration.color_from_depth.translation_m.astype(np.float32)
    lens = color_camera.intrinsics
    return table, shift_m, np.array([lens.fx, lens.fy, lens.cx, lens.cy], np.float32)


def twelve_coefficients(camera: CameraCalibration) -> Coefficients:
    """Return twelve coefficients, with zeros for those that are left out."""
    padded = np.zeros(N_COEFFICIENTS)
    padded[: len(camera.distortion)] = camera.distortion
    k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = padded.tolist()
    return k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4


@lru_cache(maxsize=4)
def _turned_rays(camera: CameraCalibration, rotation: tuple[float, ...]) -> Float32Array:
    """Return (H, W, 3) rays of one metre of depth, turned by the nine numbers of `rotation`."""
    rays = np.ones((camera.height, camera.width, 3))
    rays[..., :2] = pixel_rays((camera.height, camera.width), camera.intrinsics, camera.distortion)
    turned = rays @ np.reshape(rotation, (3, 3)).T
    table = np.ascontiguousarray(turned, np.float32)
    read_only(table)
    return table
