"""One moment of an RGB-D camera as alignment sees it: surfaces and a grey picture, one geometry."""

from dataclasses import dataclass

import cv2
import numpy as np

from adibas.alignment.registration import register_pixels
from adibas.alignment.views import View, ViewParams, prepare_view
from adibas.arrays import (
    BoolArray,
    Float32Array,
    FloatArray,
    Int32Array,
    UInt8Array,
    check_shape,
    read_only,
)
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.geometry.distortion import project_distorted, undistort_pixels


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """A moment, prepared.

    Attributes
    ----------
    view : View
        Of the depth camera, whose axes all motions are given in.
    gray : (H, W) uint8 array
        Brightness of the colour picture.
    source : (H, W) int32 array
        Which depth pixel (row * width + column) each pixel of colour sees; -1 where none.
    calibration : RgbdCalibration
    """

    view: View
    gray: UInt8Array
    source: Int32Array
    calibration: RgbdCalibration

    def __post_init__(self) -> None:
        for array in (self.gray, self.source):
            read_only(array)

    @property
    def color_camera(self) -> CameraCalibration:
        """The camera of `gray`."""
        return color_camera(self.calibration)

    def points_m(self, pixels: FloatArray) -> FloatArray:
        """Return (N, 3) points, in the depth camera's axes, that (N, 2) pixels of colour see.

        Each lies on its own pixel's ray, where this meets the plane that was fitted there; NaN
        where there is none.
        """
        calibration = self.calibration
        camera = self.color_camera
        back = calibration.color_from_depth.inverse()
        rays = np.ones((len(pixels), 3))
        rays[:, :2] = undistort_pixels(pixels, camera.intrinsics, camera.distortion)
        ways, origin = rays @ back.rotation.T, back.translation_m
        normals = self._planes(pixels)
        with np.errstate(invalid="ignore", divide="ignore"):
            along = (1.0 - normals @ origin) / (normals * ways).sum(axis=1)
            along = np.where(along > 0.0, along, np.nan)
        points: FloatArray = origin + along[:, None] * ways
        return points

    def pixels_of(self, points_m: FloatArray) -> FloatArray:
        """Return the (N, 2) pixels of colour where (N, 3) points of the depth camera are seen."""
        return color_pixels(points_m, self.calibration)

    def _planes(self, pixels: FloatArray) -> FloatArray:
        """Return the (N, 3) planes at pixels of colour; NaN where no surface is seen."""
        height, width = self.gray.shape
        level = self.view.levels[0]
        with np.errstate(invalid="ignore"):
            columns, rows = np.rint(pixels).T
            is_inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
        at = np.where(is_inside, rows * width + columns, 0).astype(int)
        found = np.where(is_inside, self.source.ravel()[at], -1)
        depth_rows, depth_columns = np.divmod(np.maximum(found, 0), self.view.camera.width)
        n_rows, n_columns, _ = level.planes.shape
        cell = level.cell_px
        planes = level.planes[
            np.minimum(depth_rows // cell, n_rows - 1),
            np.minimum(depth_columns // cell, n_columns - 1),
        ].astype(float)
        planes[found < 0] = np.nan
        known: FloatArray = planes
        return known


def see(
    depth_m: Float32Array,
    color_rgb: UInt8Array,
    calibration: RgbdCalibration,
    mask: BoolArray | None = None,
    params: ViewParams | None = None,
) -> Sight:
    """Prepare a moment for alignment.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Bias corrected, metres; NaN where not measured.
    color_rgb : (H', W', 3) uint8 array
        Of the same moment.
    mask : (H, W) bool array or None
        What takes part; everything if None.

    Raises
    ------
    ValueError
        The calibration lacks a camera, or a size does not fit it.
    """
    camera = color_camera(calibration)
    check_shape("color_rgb", color_rgb, (camera.height, camera.width, 3))
    if mask is not None:
        depth_m = np.where(mask, depth_m, np.float32(np.nan))
    view = prepare_view(depth_m, depth_camera(calibration), params)
    gray = np.asarray(cv2.cvtColor(color_rgb, cv2.COLOR_RGB2GRAY), np.uint8)
    source = register_pixels(depth_m, calibration).source
    return Sight(view, gray, source, calibration)


def color_pixels(points_m: FloatArray, calibration: RgbdCalibration) -> FloatArray:
    """Return the (N, 2) pixels of colour where (N, 3) points of the depth camera are seen."""
    camera = color_camera(calibration)
    pixels: FloatArray = project_distorted(
        calibration.color_from_depth.apply(points_m), camera.intrinsics, camera.distortion
    )
    return pixels


def color_camera(calibration: RgbdCalibration) -> CameraCalibration:
    """Return the colour camera of a calibration.

    Raises
    ------
    ValueError
        It has none.
    """
    if calibration.color is None:
        raise ValueError("the calibration has no colour camera")
    return calibration.color


def depth_camera(calibration: RgbdCalibration) -> CameraCalibration:
    """Return the depth camera of a calibration.

    Raises
    ------
    ValueError
        It has none.
    """
    if calibration.depth is None:
        raise ValueError("the calibration has no depth camera")
    return calibration.depth
