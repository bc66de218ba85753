"""The surface about a marker: a robust quadratic fit of disparity, with an honest variance.

The noise of neighbouring pixels is not independent: the sensor matches its pattern over a window,
so their errors share most of that window. The fit knows this correlation; without it the variance
would come out ten times too small.

Source: generalised least squares, Aitken 1935; window and noise of the structured-light sensor,
Khoshelham & Elberink, Sensors 12 (2012), 1437; biweight, Beaton & Tukey 1974.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from adibas.arrays import BoolArray, FloatArray

N_TERMS = 6
BIWEIGHT_CUT = 4.685
"""Of Tukey's biweight: 95 % efficient for normal noise."""
MAD_OF_NORMAL = 1.4826


@dataclass(frozen=True, slots=True)
class DisparityNoise:
    """How the depth sensor errs, in 1/z.

    Attributes
    ----------
    frame_sd_per_m : float
        Standard deviation of one pixel in one frame, 1/m. Default: sigma_z = 1.425e-3 z^2 (z in
        metres), Khoshelham & Elberink 2012.
    step_per_m : float
        Quantisation step, 1/m. Default: 1/8 pixel at 75 mm baseline and 580 px, so 2.87e-3.
    static_sd_per_m : float
        Of the fixed pattern, which no averaging over frames removes, 1/m. Default: 2 mm at 2 m
        ("a few mm", Boehm 2014).
    window_px : (float, float)
        Width and height of the matching window: 9 x 7, Konolige & Mihelich.
    frames_per_sample : float
        Neighbouring frames are not independent; so many count as one. Assumed: 2.
    """

    frame_sd_per_m: float = 1.425e-3
    step_per_m: float = 2.87e-3
    static_sd_per_m: float = 5.0e-4
    window_px: tuple[float, float] = (9.0, 7.0)
    frames_per_sample: float = 2.0

    def covariance(self, pixels: FloatArray, n_readings: FloatArray) -> FloatArray:
        """Return the (N, N) covariance of the mean disparity of (N, 2) pixels (u, v).

        `n_readings` (N,) frames went into each. Two pixels share their matching windows in
        proportion to the overlap; rounding is each pixel's own.
        """
        across, down = (
            np.maximum(0.0, 1.0 - np.abs(axis[:, None] - axis) / length)
            for axis, length in zip(pixels.T, self.window_px, strict=True)
        )
        n_samples = np.maximum(1.0, n_readings / self.frames_per_sample)
        sd = self.frame_sd_per_m / np.sqrt(n_samples)
        shared: FloatArray = across * down * (np.outer(sd, sd) + self.static_sd_per_m**2)
        own = self.step_per_m**2 / 12.0 / n_samples
        shared[np.diag_indices_from(shared)] += own
        return shared


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceFit:
    """Disparity about one place: ``w0 + gradient . d + ...`` for an offset d in pixels.

    Attributes
    ----------
    disparity_per_m : float
        At the place, 1/m.
    gradient : (2,) array
        Per pixel in u and v, 1/m.
    variance : float
        Of `disparity_per_m`, instrument only.
    n_pixels : int
        That took part.
    misfit : float
        Root mean square of the whitened residuals; 1 where noise and model are as assumed.
    """

    disparity_per_m: float
    gradient: FloatArray
    variance: float
    n_pixels: int
    misfit: float


def fit_surface(
    offsets: FloatArray, disparity_per_m: FloatArray, n_readings: FloatArray, noise: DisparityNoise
) -> SurfaceFit | None:
    """Fit a quadratic to the disparity of the pixels around a place.

    Parameters
    ----------
    offsets : (N, 2) array
        Pixels (u, v) minus the place.
    disparity_per_m, n_readings : (N,) arrays
        1/z of each, and the frames behind it.
    noise : DisparityNoise
        Of the sensor.

    Returns
    -------
    SurfaceFit or None
        None where fewer than twice as many pixels as terms are left after the outliers.
    """
    terms = _terms(offsets)
    kept = _inliers(terms, disparity_per_m, noise.frame_sd_per_m / np.sqrt(n_readings.mean()))
    if kept.sum() < 2 * N_TERMS:
        return None
    terms, values = terms[kept], disparity_per_m[kept]
    factor = cho_factor(noise.covariance(offsets[kept], n_readings[kept]), lower=True)
    normal = terms.T @ cho_solve(factor, terms)
    coefficients: FloatArray = np.linalg.solve(normal, terms.T @ cho_solve(factor, values))
    residuals = values - terms @ coefficients
    degrees_of_freedom = len(values) - N_TERMS
    misfit2 = float(residuals @ cho_solve(factor, residuals)) / degrees_of_freedom
    return SurfaceFit(
        disparity_per_m=float(coefficients[0]),
        gradient=coefficients[1:3],
        variance=float(np.linalg.inv(normal)[0, 0]),
        n_pixels=int(kept.sum()),
        misfit=float(np.sqrt(misfit2)),
    )


def _terms(offsets: FloatArray) -> FloatArray:
    u, v = offsets.T
    return np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=1)


def _inliers(terms: FloatArray, values: FloatArray, least_scale: float) -> BoolArray:
    """Return which pixels belong to one smooth surface, by a few rounds of Tukey's biweight."""
    weights = np.ones(len(values))
    residuals = values - np.median(values)
    for _ in range(5):
        root = np.sqrt(weights)[:, None]
        coefficients, *_ = np.linalg.lstsq(terms * root, values * root[:, 0], rcond=None)
        residuals = values - terms @ coefficients
        scale = max(least_scale, MAD_OF_NORMAL * float(np.median(np.abs(residuals))))
        weights = np.maximum(0.0, 1.0 - (residuals / (BIWEIGHT_CUT * scale)) ** 2) ** 2
    inliers: BoolArray = weights > 0.0
    return inliers
