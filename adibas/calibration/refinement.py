"""Joint refinement of a camera and the poses of its boards, by Levenberg and Marquardt.

Source: thesis, equation 4.15, over all views at once as in Zhang, PAMI 22 (2000), section 3.2;
Madsen, Nielsen & Tingleff, Methods for non-linear least squares problems (2004), section 3.2, for
the damping; Huber, Robust statistics (1981), for scale and weights.
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from adibas.arrays import FloatArray, IntArray, check_shape, read_only
from adibas.calibration import refinement_kernels as kernels
from adibas.calibration.lens_models import LensModel

ROUNDING = float(np.finfo(float).eps)
"""Of a loss; gains below it cannot be told."""
# The median length of a plane vector whose coordinates have standard deviation 1.
MEDIAN_LENGTH = np.sqrt(2.0 * np.log(2.0))


class Loss(Enum):
    """What is minimised: squares, Huber's loss, or Tukey's biweight."""

    SQUARES = "squares"
    HUBER = "huber"
    BIWEIGHT = "biweight"


@dataclass(frozen=True, slots=True)
class RefinementParams:
    """How a camera is refined.

    Attributes
    ----------
    loss : Loss
        Squares are for comparison with other programs.
    cut_sigmas : float
        Length of a residual, in standard deviations of a coordinate, from which a corner has no
        weight: 5.12, at which the estimate keeps 95 % of the efficiency of squares in a plane.
    first_cut_sigmas : float
        Where Huber's loss, which finds the way for the biweight, turns linear: 2.
    least_scale_px : float
        Standard deviation of a coordinate below which residuals are rounding: 1e-6.
    n_scales : int
        How often the scale is taken anew: 3, after which it no longer moves.
    most_steps : int
        Of each descent: 200.
    done : float
        Share of the loss that the next step would gain, at which a descent ends: 1e-13.
    enough : float
        Likewise, where the steps run out: 1e-10. Descents with a robust loss may end in many
        small steps; what they would still gain is a thousandth of a standard deviation.
    """

    loss: Loss = Loss.BIWEIGHT
    cut_sigmas: float = 5.12
    first_cut_sigmas: float = 2.0
    least_scale_px: float = 1e-6
    n_scales: int = 3
    most_steps: int = 200
    done: float = 1e-13
    enough: float = 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class Observations:
    """The corners of one board in several views.

    Attributes
    ----------
    points_m : (P, 3) array
        In the board's frame.
    pixels : (V, P, 2) array
        NaN where hidden.
    sigmas : (V, P) array
        Standard deviations up to a common factor; infinite where hidden.
    """

    points_m: FloatArray
    pixels: FloatArray
    sigmas: FloatArray

    def __post_init__(self) -> None:
        check_shape("points_m", self.points_m, (None, 3))
        check_shape("pixels", self.pixels, (None, len(self.points_m), 2))
        check_shape("sigmas", self.sigmas, self.pixels.shape[:2])
        for array in (self.points_m, self.pixels):
            read_only(array)

    @property
    def n_seen(self) -> int:
        """How many corners are seen in all views together."""
        return int(np.isfinite(self.sigmas).sum())


def observe(
    points_m: FloatArray, pixels: FloatArray, sigmas: FloatArray | None = None
) -> Observations:
    """Return observations of (V, P, 2) pixels, NaN where hidden; equally sure without `sigmas`."""
    pixels = np.array(pixels, float)
    is_seen = np.isfinite(pixels).all(axis=-1)
    pixels[~is_seen] = np.nan
    shares = np.ones(is_seen.shape) if sigmas is None else np.asarray(sigmas, float)
    return Observations(np.array(points_m, float), pixels, np.where(is_seen, shares, np.inf))


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """A camera and where the boards stood.

    Attributes
    ----------
    camera : (17,) array
        `adibas.geometry.projection.CAMERA_PARAMETERS`.
    rotations : (V, 3, 3) array
    translations_m : (V, 3) array
        Of ``camera_from_board``.
    """

    camera: FloatArray
    rotations: FloatArray
    translations_m: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Refinement:
    """What the refinement found.

    Attributes
    ----------
    estimate : Estimate
        Camera and poses.
    residuals_px : (V, P, 2) array
        Observed minus projected; NaN where hidden.
    scale_px : float
        Standard deviation of a coordinate (where `Observations.sigmas` is 1).
    weights : (V, P) array
        0 (no part in the estimate) to 1 by the biweight, also after Huber's loss; 1 after squares;
        NaN where hidden.
    has_converged : bool
        False where the steps ran out, or the views do not fix the parameters.
    """

    estimate: Estimate
    residuals_px: FloatArray
    scale_px: float
    weights: FloatArray
    has_converged: bool


def refine(
    observations: Observations,
    start: Estimate,
    model: LensModel,
    params: RefinementParams | None = None,
) -> Refinement:
    """Find the camera and the poses that explain the corners best.

    Parameters
    ----------
    observations : Observations
        Corners; each view needs four.
    start : Estimate
        Such as the closed form; what `model` leaves out stays as it is there.
    model : LensModel
        Which terms of the lens are sought.
    params : RefinementParams or None
        How.
    """
    params = params or RefinementParams()
    descent = _Descent(observations, model.free(), params)
    estimate, has_converged = descent.run(start, 1.0, kernels.PLAIN, np.inf)
    if params.loss is Loss.SQUARES:
        residuals_px = residuals_of(observations, estimate)
        weights = np.where(np.isfinite(observations.sigmas), 1.0, np.nan)
        scale_px = _root_mean_square(observations, residuals_px, descent.n_unknowns)
        return Refinement(estimate, residuals_px, scale_px, weights, has_converged)
    biweight = [(kernels.TUKEY, params.cut_sigmas)] * params.n_scales
    for kind, cut in (
        (kernels.HUBER, params.first_cut_sigmas),
        *(biweight if params.loss is Loss.BIWEIGHT else ()),
    ):
        scale_px = max(_median_scale(observations, estimate), params.least_scale_px)
        estimate, has_converged = descent.run(estimate, scale_px, kind, cut)
    residuals_px = residuals_of(observations, estimate)
    lengths = np.hypot(*np.moveaxis(residuals_px, -1, 0)) / (scale_px * observations.sigmas)
    shares = 1.0 - np.minimum(lengths / params.cut_sigmas, 1.0) ** 2
    return Refinement(estimate, residuals_px, scale_px, shares**2, has_converged)


def refine_poses(
    observations: Observations, start: Estimate, params: RefinementParams | None = None
) -> Estimate:
    """Return the poses that explain the corners best, by least squares, with the camera as it is.

    Parameters
    ----------
    observations : Observations
        Corners; each view needs four.
    start : Estimate
        Camera, and poses near the answer.
    params : RefinementParams or None
        How.
    """
    descent = _Descent(observations, np.empty(0, np.int64), params or RefinementParams())
    return descent.run(start, 1.0, kernels.PLAIN, np.inf)[0]


def residuals_of(observations: Observations, estimate: Estimate) -> FloatArray:
    """Return the (V, P, 2) observed minus projected pixels; NaN where hidden."""
    return kernels.residuals_of(_views(observations, observations.sigmas), _guess(estimate))


def _median_scale(observations: Observations, estimate: Estimate) -> float:
    """Return the standard deviation of a coordinate from the median length of a residual."""
    lengths = np.hypot(*np.moveaxis(residuals_of(observations, estimate), -1, 0))
    return float(np.nanmedian(lengths / observations.sigmas) / MEDIAN_LENGTH)


def _root_mean_square(
    observations: Observations, residuals_px: FloatArray, n_unknowns: int
) -> float:
    squares = float(np.nansum((residuals_px / observations.sigmas[..., None]) ** 2))
    return float(np.sqrt(squares / max(2 * observations.n_seen - n_unknowns, 1)))


def empty_arrow(n_camera: int, n_views: int) -> kernels.Arrow:
    """Return normal equations of views that say nothing yet."""
    return kernels.Arrow(
        np.zeros((n_views, n_camera, n_camera)),
        np.zeros((n_views, n_camera, 6)),
        np.zeros((n_views, 6, 6)),
        np.zeros((n_views, n_camera)),
        np.zeros((n_views, 6)),
    )


class _Descent:
    """Levenberg and Marquardt on one set of observations and unknowns."""

    def __init__(
        self, observations: Observations, free: IntArray, params: RefinementParams
    ) -> None:
        self._observations = observations
        self._free = free
        self._params = params
        self._n_views = len(observations.pixels)
        self.n_unknowns = len(self._free) + 6 * self._n_views

    def run(self, start: Estimate, scale_px: float, kind: int, cut: float) -> tuple[Estimate, bool]:
        """Descend from `start`; return where it ended and whether it converged.

        From a start with seen points behind the camera there is no way down: it has no slope.
        """
        sigmas_px = self._observations.sigmas * scale_px
        best, tried = self._room(), self._room()
        estimate = start
        loss = self._loss(estimate, sigmas_px, (kind, cut), best)
        if not np.isfinite(loss):
            return start, False
        damping, growth, expected = 1e-3, 2.0, np.inf
        step_a, step_c = np.empty(len(self._free)), np.empty((self._n_views, 6))
        reduced = np.empty((len(self._free), len(self._free)))
        for _ in range(self._params.most_steps):
            if not kernels.solve_arrow(damping, best, reduced, step_a, step_c):
                damping, growth = damping * growth, growth * 2.0
                if not np.isfinite(damping):
                    break
                continue
            expected = _expected_gain(best, step_a, step_c, damping)
            if expected <= self._params.done * loss:
                return estimate, True
            candidate = self._moved(estimate, step_a, step_c)
            new_loss = self._loss(candidate, sigmas_px, (kind, cut), tried)
            if new_loss < loss:
                share = (loss - new_loss) / expected
                damping *= max(1.0 / 3.0, 1.0 - (2.0 * share - 1.0) ** 3)
                growth = 2.0
                estimate, loss, best, tried = candidate, new_loss, tried, best
            elif expected <= ROUNDING * loss:
                return estimate, True  # shorter steps would be refused as well, without end
            else:
                damping, growth = damping * growth, growth * 2.0
        return estimate, bool(expected <= self._params.enough * loss)

    def _room(self) -> kernels.Arrow:
        return empty_arrow(len(self._free), self._n_views)

    def _loss(
        self,
        estimate: Estimate,
        sigmas_px: FloatArray,
        loss: tuple[int, float],
        into: kernels.Arrow,
    ) -> float:
        return accumulated(self._observations, sigmas_px, estimate, self._free, loss, into)

    def _moved(self, estimate: Estimate, step_a: FloatArray, step_c: FloatArray) -> Estimate:
        camera = estimate.camera.copy()
        camera[self._free] += step_a
        rotations = np.empty_like(estimate.rotations)
        translations_m = kernels.turn(
            estimate.rotations, estimate.translations_m, step_c, rotations
        )
        return Estimate(camera, rotations, translations_m)


def accumulated(
    observations: Observations,
    sigmas_px: FloatArray,
    estimate: Estimate,
    free: IntArray,
    loss: tuple[int, float],
    into: kernels.Arrow,
) -> float:
    """Fill the normal equations and return the loss."""
    views = _views(observations, sigmas_px)
    return kernels.accumulate(views, _guess(estimate), free, *loss, into)


def _views(observations: Observations, sigmas_px: FloatArray) -> kernels.Views:
    return kernels.Views(observations.points_m, observations.pixels, sigmas_px)


def _guess(estimate: Estimate) -> kernels.Guess:
    return kernels.Guess(estimate.camera, estimate.rotations, estimate.translations_m)


def _expected_gain(
    arrow: kernels.Arrow, step_a: FloatArray, step_c: FloatArray, damping: float
) -> float:
    """Return what the linear model loses with the damped step: step' (slope + damping D step)."""
    poses, camera = np.einsum("vii->vi", arrow.c), np.einsum("vii->i", arrow.a)
    gain_a = step_a @ (arrow.slope_a.sum(axis=0) + damping * camera * step_a)
    gain_c = (step_c * (arrow.slope_c + damping * poses * step_c)).sum()
    return float(gain_a + gain_c)
