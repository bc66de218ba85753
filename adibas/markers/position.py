"""A marker's place in space, from the surface around it.

The marker itself may have no depth (LEDs and glossy stickers leave holes), and its few pixels share
one matching window anyway. So the colour camera gives the direction, and the skin about the
marker, as the depth camera sees it, the distance.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.markers import Marker
from adibas.data.surface import BurstDisparity
from adibas.geometry.distortion import undistort_pixels
from adibas.markers.position_kernels import (
    NOTHING,
    Fit,
    Lens,
    Line,
    Patch,
    fit_skin,
    follow,
    pixel_of,
    point_on,
)
from adibas.markers.shared_errors import SharedErrors

N_COEFFICIENTS = 12
N_ASSUMED = 100
"""The noise model counts as much as so many residuals: about one patch of skin."""
LEAST_NOISE = 0.5
"""Share of the assumed variance that is never gone below: a sensor that smooths its depth hides its
noise."""


@dataclass(frozen=True, slots=True)
class DisparityNoise:
    """How the depth sensor errs, in 1/z.

    Attributes
    ----------
    frame_sd_per_m : float
        Standard deviation of one pixel in one frame, 1/m. Default: sigma_z = 1.425e-3 z^2 (z in
        metres), Khoshelham & Elberink 2012.
    quantum_per_m : float
        Quantisation step, 1/m. Default: 1/8 pixel at 75 mm baseline and 580 px, so 2.87e-3.
    static_sd_per_m : float
        Of the fixed pattern, which no averaging over frames removes, 1/m. Default: 2 mm at 2 m
        ("a few mm", Boehm 2014).
    window_px : (float, float)
        Width and height of the matching window, whose pixels share their errors: 9 x 7, Konolige
        & Mihelich.
    frames_per_sample : float
        Neighbouring frames are not independent; so many count as one. Assumed: 2.
    """

    frame_sd_per_m: float = 1.425e-3
    quantum_per_m: float = 2.87e-3
    static_sd_per_m: float = 5.0e-4
    window_px: tuple[float, float] = (9.0, 7.0)
    frames_per_sample: float = 2.0


@dataclass(frozen=True, slots=True)
class PositionParams:
    """How a position is measured.

    Attributes
    ----------
    patch_radius_rad, greatest_radius_m : float
        Skin that takes part, as seen from the depth camera: 0.02, so that it has as many pixels
        wherever it is; but no more than 60 mm.
    relief_m, relief_length_m : float
        What skin is beyond a quadratic: Matern's process of order 3/2, with a standard deviation
        of 2 mm and a length of 20 mm. The likeliest of 75 processes for the skin about 254
        simulated markers on three bodies that no benchmark measures (docs/skeleton.md).
    close_m : float
        So close to the marker the depth must be known, by the three conditions that follow: 25 mm.
    least_pixels : int
        Depth pixels that must take part.
    least_share : float
        Of the pixels that there would be without holes.
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

    patch_radius_rad: float = 0.02
    greatest_radius_m: float = 0.06
    close_m: float = 0.025
    relief_m: float = 0.002
    relief_length_m: float = 0.02
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
    """Where a marker is, in the colour camera's axes: (3,) metres and (3, 3) covariance.

    `shared_m` (3, n) is the part of its error that all markers share: see `Marker.shared_m`.
    """

    position_m: FloatArray
    covariance_m2: FloatArray
    shared_m: FloatArray


class PositionFinder:
    """Measures the markers of one burst.

    The skin is fitted by a quadratic in disparity: robust (Tukey's biweight), then by generalised
    least squares with the covariance of neighbouring pixels and of what skin is beyond a quadratic
    (universal kriging), so that near markers are not smoothed over, and the variance is honest.

    The noise model is that of all sensors of the kind; how much this one has is told by how far
    the depth lies off the fitted skin about all markers together.

    Source: Aitken 1935 (generalised least squares); Beaton & Tukey 1974 (biweight); Mikhail &
    Ackermann 1976 (a posteriori reference variance); Cressie, Statistics for Spatial Data, 1993,
    section 3.4 (universal kriging); Rasmussen & Williams, Gaussian Processes for Machine Learning,
    2006, equation 4.17 (Matern).

    Parameters
    ----------
    burst : BurstDisparity
        Of the depth camera, bias corrected.
    calibration : RgbdCalibration
        With both cameras.
    params : PositionParams
        How.
    seen_px : (N, 2) array, optional
        Colour pixels of the burst's markers, which tell of the noise; without any it is as assumed.

    Attributes
    ----------
    noise_share : float
        Variance of the disparity, as the residuals tell it, by that of the noise model.
    """

    def __init__(
        self,
        burst: BurstDisparity,
        calibration: RgbdCalibration,
        params: PositionParams,
        seen_px: FloatArray | None = None,
    ) -> None:
        if calibration.color is None or calibration.depth is None:
            raise ValueError("positions need both cameras")
        self._burst = burst
        self._color: CameraCalibration = calibration.color
        self._color_from_depth = calibration.color_from_depth
        self._depth_from_color = calibration.color_from_depth.inverse()
        self._lens = _lens(calibration.depth)
        self._params = params
        self._patch = _patch(params)
        self._shared = SharedErrors(calibration)
        self.noise_share = 1.0 if seen_px is None else self._learned_share(seen_px)

    def locate(self, pixel_uv: FloatArray, covariance_px2: FloatArray) -> Position | None:
        """Return where the colour pixel `pixel_uv` lies in space.

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
        ray = self._ray(pixel_uv)
        fit = self._fitted(ray)
        return None if fit is None else self._position(ray, fit, covariance_px2)

    def placed(self, marker: Marker) -> Marker:
        """Return a marker that is known in the picture alone with where it lies in space."""
        pixel_uv = np.array([marker.u, marker.v])
        found = self.locate(pixel_uv, marker.covariance_px2)
        if found is None:
            return replace(marker, rough_depth_m=self._rough_depth_m(pixel_uv))
        return replace(
            marker,
            position_m=found.position_m,
            covariance_m2=found.covariance_m2,
            shared_m=found.shared_m,
        )

    def is_between_surfaces(self, pixel_uv: FloatArray) -> bool:
        """Say whether the depth about the place where a ray ends is of more than one surface.

        Skin at 45 degrees is as deep as it is wide; what is deeper by a step is two.
        """
        line = self._line(self._ray(pixel_uv))
        start_per_m = self._met_per_m(line)
        if start_per_m is None:
            return False
        u, v = pixel_of(line, start_per_m, self._lens)
        reach = 1 + math.ceil(self._params.close_m * self._lens.fx * start_per_m)
        rows, columns = (slice(max(round(at) - reach, 0), round(at) + reach + 1) for at in (v, u))
        seen_per_m = self._burst.mean_per_m[rows, columns]
        seen_m = 1.0 / seen_per_m[seen_per_m > 0.0]
        deepest_m = 2.0 * self._params.close_m + self._params.step_m
        return bool(np.ptp(seen_m) > deepest_m)

    def _ray(self, pixel_uv: FloatArray) -> FloatArray:
        """Return the (3,) ray of a colour pixel, colour axes; NaN where the lens has none."""
        pixel_uv = np.asarray(pixel_uv, float)
        bearing = undistort_pixels(pixel_uv, self._color.intrinsics, self._color.distortion)
        return np.append(bearing, 1.0)

    def _line(self, ray: FloatArray) -> Line:
        return Line(
            np.ascontiguousarray(self._depth_from_color.translation_m),
            np.ascontiguousarray(self._depth_from_color.rotation @ ray),
        )

    def _met_per_m(self, line: Line) -> float | None:
        """Return the disparity of the first surface on a line; None where the depth has none."""
        start_per_m = follow(self._burst.mean_per_m, line, self._lens, self._patch)
        return None if start_per_m == NOTHING else start_per_m

    def _rough_depth_m(self, pixel_uv: FloatArray) -> float | None:
        """Return where a colour pixel's ray meets the first surface, along the camera's axis."""
        line = self._line(self._ray(pixel_uv))
        start_per_m = self._met_per_m(line)
        if start_per_m is None:
            return None
        in_color_m = self._color_from_depth.apply(np.array(point_on(line, start_per_m)))
        return float(in_color_m[2])

    def _fitted(self, ray: FloatArray) -> Fit | None:
        """Return the skin that a colour ray meets; None where there is none that is sure enough."""
        line = self._line(ray)
        start_per_m = self._met_per_m(line)
        if start_per_m is None:
            return None
        mean_per_m, readings = self._burst.mean_per_m, self._burst.n_readings
        fit = fit_skin(mean_per_m, readings, line, start_per_m, self._lens, self._patch)
        is_sure = fit.disparity > 0 and _sd_m(fit) <= self._params.greatest_sd_m
        return fit if is_sure else None

    def _learned_share(self, seen_px: FloatArray) -> float:
        """Return the a posteriori variance of unit weight over the skin about all pixels.

        The median of the patches: one with a fold or an outline in it tells nothing of the noise.
        """
        fits = [self._fitted(self._ray(pixel_uv)) for pixel_uv in seen_px]
        found = [fit for fit in fits if fit is not None]
        if not found:
            return 1.0
        n_free = sum(fit.n_free for fit in found)
        misfit = float(np.median([fit.misfit for fit in found]))
        return max((N_ASSUMED + n_free * misfit) / (N_ASSUMED + n_free), LEAST_NOISE)

    def _position(self, ray: FloatArray, fit: Fit, covariance_px2: FloatArray) -> Position:
        """Return where the ray meets the skin, colour axes, with its covariance.

        A wrong pixel moves the point within the skin; a wrong depth moves it along the ray.
        """
        k = self._color.intrinsics
        point_m = np.array(point_on(self._line(ray), fit.disparity))
        # The plane w = w0 + g . d of the pixels is n . p = 1 in space, n = (gu f, gv f, rest).
        n_x, n_y = fit.slope_u * self._lens.fx, fit.slope_v * self._lens.fy
        n_z = (1.0 - n_x * point_m[0] - n_y * point_m[1]) / point_m[2]
        normal = self._color_from_depth.rotation @ np.array([n_x, n_y, n_z])
        position_m = self._color_from_depth.apply(point_m)
        z_m = position_m[2]
        moved = np.array([[z_m / k.fx, 0.0], [0.0, z_m / k.fy], [0.0, 0.0]])
        within = moved - np.outer(ray, normal @ moved) / (normal @ ray)
        shared_m = self._shared.moves(position_m, normal, within)
        covariance_m2: FloatArray = within @ covariance_px2 @ within.T
        covariance_m2 = covariance_m2 + np.outer(ray, ray) * self.noise_share * _sd_m(fit) ** 2
        return Position(position_m, covariance_m2 + shared_m @ shared_m.T, shared_m)


def _sd_m(fit: Fit) -> float:
    return float(np.sqrt(fit.variance)) / fit.disparity**2


def _lens(camera: CameraCalibration) -> Lens:
    k = camera.intrinsics
    coefficients = np.zeros(N_COEFFICIENTS)
    coefficients[: len(camera.distortion)] = camera.distortion
    return Lens(float(k.fx), float(k.fy), float(k.cx), float(k.cy), coefficients)


def _patch(params: PositionParams) -> Patch:
    noise = params.noise
    return Patch(
        radius_rad=float(params.patch_radius_rad),
        greatest_radius_m=float(params.greatest_radius_m),
        close_m=float(params.close_m),
        least_pixels=int(params.least_pixels),
        least_share=float(params.least_share),
        greatest_gap_rad=float(params.greatest_gap_rad),
        nearest_m=float(params.nearest_m),
        farthest_m=float(params.farthest_m),
        step_m=float(params.step_m),
        frame_sd_per_m=float(noise.frame_sd_per_m),
        quantum_per_m=float(noise.quantum_per_m),
        static_sd_per_m=float(noise.static_sd_per_m),
        across_px=float(noise.window_px[0]),
        down_px=float(noise.window_px[1]),
        frames_per_sample=float(noise.frames_per_sample),
        relief_m=float(params.relief_m),
        relief_length_m=float(params.relief_length_m),
    )
