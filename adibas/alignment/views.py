"""What one depth image offers to alignment: inverse depth and planes at several resolutions."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from adibas.alignment.inverse_plane_kernels import fit_planes, halved
from adibas.arrays import Float32Array, FloatArray, check_shape, read_only
from adibas.data.calibration import CameraCalibration
from adibas.geometry.distortion import undistort_pixels


@dataclass(frozen=True, slots=True)
class ViewParams:
    """How depth images are prepared.

    Attributes
    ----------
    n_levels : int
        Resolutions, each half of the one before: 3.
    half_px : int
        Of the window of a plane at each resolution: 3, seven pixels a side.
    gate_per_m : float
        Neighbours that differ by more are another surface: 0.012, four steps of disparity of a
        PrimeSense sensor (see `RegistrationParams`).
    least_share : float
        Of a window's pixels on the surface: 0.5.
    """

    n_levels: int = 3
    half_px: int = 3
    gate_per_m: float = 0.012
    least_share: float = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Level:
    """One resolution.

    Attributes
    ----------
    inverse_per_m : (H, W) float32 array
        NaN where not measured.
    rays : (H, W, 2) float32 array
    planes : (h, w, 3) float32 array
    cell_px : int
        Pixels of the full image that share one plane, along a side.
    reduction : int
        Pixels of the full image in one of this level, along a side.
    """

    inverse_per_m: Float32Array
    rays: Float32Array
    planes: Float32Array
    cell_px: int
    reduction: int

    def __post_init__(self) -> None:
        for array in (self.inverse_per_m, self.rays, self.planes):
            read_only(array)


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A depth image, prepared.

    Attributes
    ----------
    camera : CameraCalibration
        Of the full resolution.
    levels : tuple of Level
        The finest first.
    """

    camera: CameraCalibration
    levels: tuple[Level, ...]

    @property
    def middle_m(self) -> FloatArray:
        """The (3,) mean of all points that are seen, the camera's axes; 0 where none is."""
        level = self.levels[-1]
        known = level.inverse_per_m > 0  # false for NaN
        if not known.any():
            return np.zeros(3)
        z = 1.0 / level.inverse_per_m[known].astype(float)
        middle: FloatArray = np.append((level.rays[known] * z[:, None]).mean(axis=0), z.mean())
        return middle


def prepare_view(
    depth_m: Float32Array,
    camera: CameraCalibration,
    params: ViewParams | None = None,
) -> View:
    """Prepare a depth image for alignment.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Bias corrected, metres; NaN where not measured.
    """
    params = params or ViewParams()
    check_shape("depth_m", depth_m, (camera.height, camera.width))
    with np.errstate(divide="ignore"):
        inverse = np.ascontiguousarray(1.0 / depth_m, np.float32)
    least_px = round(params.least_share * (2 * params.half_px + 1) ** 2)
    levels = []
    for number in range(params.n_levels):
        if number:
            inverse = halved(inverse, params.gate_per_m)
        reduction = 2**number
        rays = _rays(camera, reduction)
        step_px = 2 if number == 0 else 1
        planes = fit_planes(inverse, rays, params.half_px, step_px, params.gate_per_m, least_px)
        levels.append(Level(inverse, rays, planes, step_px * reduction, reduction))
    return View(camera, tuple(levels))


@lru_cache(maxsize=16)
def _rays(camera: CameraCalibration, reduction: int) -> Float32Array:
    """Return the rays of pixels that are means of `reduction` x `reduction` of the camera's."""
    height, width = camera.height // reduction, camera.width // reduction
    rows, columns = np.indices((height, width), dtype=np.float64)
    middle = (reduction - 1) / 2
    pixels = np.stack([columns * reduction + middle, rows * reduction + middle], axis=-1)
    rays = undistort_pixels(pixels, camera.intrinsics, camera.distortion)
    table = np.ascontiguousarray(rays, np.float32)
    read_only(table)
    return table
