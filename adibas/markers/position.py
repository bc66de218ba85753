"""A marker's place in space, from the surface around it.

The marker itself may have no depth (LEDs and glossy stickers leave holes), and its few pixels share
one matching window anyway. So the colour camera gives the direction, and the skin within some
25 mm of the marker, as the depth camera sees it, the distance.
"""

from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.geometry.distortion import project_distorted, undistort_pixels
from adibas.markers.disparity import BurstDisparity
from adibas.markers.surface import DisparityNoise, SurfaceFit, fit_surface


@dataclass(frozen=True, slots=True)
class PositionParams:
    """How a position is measured.

    Attributes
    ----------
    patch_radius_m : float
        Skin that takes part: 25 mm; a limb's curvature is still a quadratic there.
    least_pixels : int
        Depth pixels that must take part.
    least_share : float
        Of the pixels that the patch would have without holes.
    greatest_gap_rad : float
        Greatest angle, seen from the marker, in which no depth was measured: 170 degrees. With
        more the fit would extrapolate.
    greatest_sd_m : float
        A depth less sure than this is none: 20 mm.
    nearest_m, farthest_m : float
        Where the ray is followed: 0.4 to 6 m.
    step_m : float
        Depth jump that separates two surfaces: 40 mm.
    noise : DisparityNoise
        Of the depth sensor.
    """

    patch_radius_m: float = 0.025
    least_pixels: int = 25
    least_share: float = 0.3
    greatest_gap_rad: float = np.deg2rad(170.0)
    greatest_sd_m: float = 0.02
    nearest_m: float = 0.4
    farthest_m: float = 6.0
    step_m: float = 0.04
    noise: DisparityNoise = field(default_factory=DisparityNoise)


@dataclass(frozen=True, slots=True, eq=False)
class Position:
    """Where a marker is, in the colour camera's axes: (3,) metres and (3, 3) covariance."""

    position_m: FloatArray
    covariance_m2: FloatArray


class PositionFinder:
    """Measures the markers of one burst.

    Parameters
    ----------
    burst : BurstDisparity
        Of the depth camera, bias corrected.
    calibration : RgbdCalibration
        With both cameras.
    params : PositionParams
        How.
    """

    def __init__(
        self, burst: BurstDisparity, calibration: RgbdCalibration, params: PositionParams
    ) -> None:
        if calibration.color is None or calibration.depth is None:
            raise ValueError("positions need both cameras")
        self._burst = burst
        self._color: CameraCalibration = calibration.color
        self._depth: CameraCalibration = calibration.depth
        self._color_from_depth = calibration.color_from_depth
        self._depth_from_color = calibration.color_from_depth.inverse()
        self._params = params

    def locate(self, pixel_uv: FloatArray, covariance_px2: FloatArray) -> Position | None:
        """Return where the colour pixel `pixel_uv` (2,) lies in space.

        Parameters
        ----------
        pixel_uv : (2,) array
            Centre of the marker in the colour image.
        covariance_px2 : (2, 2) array
            Of it.

        Returns
        -------
        Position or None
            None where the depth camera does not see that place: outside its picture, hidden, a
            hole too large, or too far from any measured surface.
        """
        ray = np.append(
            undistort_pixels(pixel_uv, self._color.intrinsics, self._color.distortion), 1.0
        )
        if not np.isfinite(ray).all():
            return None
        disparity = self._follow(ray)
        if disparity is None:
            return None
        return self._measure(ray, disparity, covariance_px2)

    def _point(self, ray: FloatArray, disparity: float) -> FloatArray:
        """Return the (3,) depth-camera point of the colour ray whose depth is 1/disparity."""
        origin = self._depth_from_color.translation_m
        direction = self._depth_from_color.rotation @ ray
        return origin + direction * ((1.0 / disparity - origin[2]) / direction[2])

    def _pixel(self, point_m: FloatArray) -> FloatArray:
        pixel: FloatArray = project_distorted(
            point_m, self._depth.intrinsics, self._depth.distortion
        )
        return pixel

    def _follow(self, ray: FloatArray) -> float | None:
        """Walk along the ray from the camera to the first surface; return its 1/z."""
        params = self._params
        ends = [self._pixel(self._point(ray, 1 / z)) for z in (params.nearest_m, params.farthest_m)]
        length_px = float(np.linalg.norm(ends[0] - ends[1]))
        if not np.isfinite(length_px):
            return None
        n_steps = 2 * int(np.ceil(length_px)) + 2
        tried = np.linspace(1 / params.nearest_m, 1 / params.farthest_m, n_steps)
        for disparity in tried:
            seen = self._nearby(self._pixel(self._point(ray, disparity)), disparity)
            if seen is not None and seen >= disparity:
                settled = self._settle(ray, disparity)
                if settled is not None:
                    return settled
        return None

    def _settle(self, ray: FloatArray, disparity: float) -> float | None:
        """Let ray and surface meet; None where the ray passes behind an outline instead."""
        for _ in range(6):
            seen = self._nearby(self._pixel(self._point(ray, disparity)), disparity)
            if seen is None:
                return None
            change_m = abs(1 / seen - 1 / disparity)
            disparity = seen
            if change_m < self._params.step_m / 8:
                return disparity
        return None

    def _nearby(self, pixel: FloatArray, disparity: float) -> float | None:
        """Return the median 1/z measured close to `pixel`, as near as there is any."""
        if not np.isfinite(pixel).all():
            return None
        radius_px = self._params.patch_radius_m * self._depth.intrinsics.fx * disparity
        for reach in (1, int(np.clip(radius_px / 2, 2, 12))):
            values = self._window(pixel, reach)[0]
            if np.isfinite(values).sum() >= 3:  # noqa: PLR2004  (a median of fewer is one pixel)
                return float(np.nanmedian(values))
        return None

    def _window(self, pixel: FloatArray, reach: int) -> tuple[FloatArray, tuple[slice, slice]]:
        column, row = np.rint(pixel).astype(int)
        height, width = self._burst.mean_per_m.shape
        rows = slice(min(max(row - reach, 0), height), max(min(row + reach + 1, height), 0))
        columns = slice(min(max(column - reach, 0), width), max(min(column + reach + 1, width), 0))
        return self._burst.mean_per_m[rows, columns].astype(float), (rows, columns)

    def _measure(
        self, ray: FloatArray, disparity: float, covariance_px2: FloatArray
    ) -> Position | None:
        gradient = np.zeros(2)
        fit: SurfaceFit | None = None
        for _ in range(4):
            pixel = self._pixel(self._point(ray, disparity))
            fit = self._fit(pixel, disparity, gradient)
            if fit is None or not fit.disparity_per_m > 0:
                return None
            disparity, gradient = fit.disparity_per_m, fit.gradient
        if fit is None or self._sd_m(fit) > self._params.greatest_sd_m:
            return None
        point_m = self._color_from_depth.apply(self._point(ray, disparity))
        return Position(point_m, self._covariance(ray, fit, covariance_px2))

    def _sd_m(self, fit: SurfaceFit) -> float:
        return float(np.sqrt(fit.variance)) / fit.disparity_per_m**2

    def _fit(self, pixel: FloatArray, disparity: float, gradient: FloatArray) -> SurfaceFit | None:
        """Fit the skin within the patch radius of the place at `pixel`, and see that it suffices.

        A pixel takes part if the surface fitted last passes it within the radius in space, and its
        own reading is on that surface.
        """
        params, k = self._params, self._depth.intrinsics
        radius_px = params.patch_radius_m * k.fx * disparity
        values, (rows, columns) = self._window(pixel, int(np.ceil(radius_px)) + 1)
        v, u = np.mgrid[rows, columns]
        du, dv = u - pixel[0], v - pixel[1]
        expected = np.maximum(disparity + gradient[0] * du + gradient[1] * dv, 0.1)
        across_m = np.hypot(du / k.fx, dv / k.fy) / expected
        along_m = 1 / expected - 1 / disparity
        is_near = across_m**2 + along_m**2 < params.patch_radius_m**2
        taken = is_near & (np.abs(1 / values - 1 / expected) < params.step_m)
        if taken.sum() < max(params.least_pixels, params.least_share * is_near.sum()):
            return None
        if _greatest_gap_rad(du[taken], dv[taken]) > params.greatest_gap_rad:
            return None
        readings = self._burst.n_readings[rows, columns][taken].astype(float)
        offsets = np.stack([du[taken], dv[taken]], axis=1)
        return fit_surface(offsets, values[taken], readings, params.noise)

    def _covariance(
        self, ray: FloatArray, fit: SurfaceFit, covariance_px2: FloatArray
    ) -> FloatArray:
        """Return the (3, 3) covariance of ray meets surface, colour axes.

        A wrong pixel moves the point within the surface; a wrong depth moves it along the ray.
        """
        k, depth_k = self._color.intrinsics, self._depth.intrinsics
        point_m = self._point(ray, fit.disparity_per_m)
        # The plane w = w0 + g . d, written as n . p = 1 in space: n = (gu f, gv f, c).
        n_x, n_y = fit.gradient[0] * depth_k.fx, fit.gradient[1] * depth_k.fy
        n_z = (1.0 - n_x * point_m[0] - n_y * point_m[1]) / point_m[2]
        normal = self._color_from_depth.rotation @ np.array([n_x, n_y, n_z])
        point_color_m = self._color_from_depth.apply(point_m)
        z_m = point_color_m[2]
        moved = np.array([[z_m / k.fx, 0.0], [0.0, z_m / k.fy], [0.0, 0.0]])
        within = moved - np.outer(ray, normal @ moved) / (normal @ ray)
        covariance: FloatArray = within @ covariance_px2 @ within.T
        return covariance + np.outer(ray, ray) * self._sd_m(fit) ** 2


def _greatest_gap_rad(du: FloatArray, dv: FloatArray) -> float:
    """Return the widest angle, seen from the origin, without any of the offsets."""
    angles = np.sort(np.arctan2(dv, du))
    gaps = np.diff(np.append(angles, angles[0] + 2 * np.pi))
    return float(gaps.max())
