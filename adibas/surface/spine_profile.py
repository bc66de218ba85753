"""The profile of the back along the line of the spinous processes, with its covariance.

Heights to the back are fitted around the line by ``p(y) + a(y) t + c(y) t^2``, t aside from the
line: p is the profile over the spinous processes, a the slope to the side. All three are cubic
B-splines in y whose third derivatives are held back.

Source: Eilers & Marx, Flexible smoothing with B-splines and penalties, Statistical Science 11
(1996), section 4 for the penalty and its cut-off; the covariance is the linear smoother's.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_array, diags_array, hstack

from adibas.arrays import FloatArray, check_shape, read_only
from adibas.surface.symmetry_line import SymmetryLine

DEGREE = 3
N_PARTS = 3
OUTLIER_SDS = 4.0


@dataclass(frozen=True, slots=True)
class ProfileParams:
    """Settings of the fit.

    Attributes
    ----------
    reach_m : float
        To either side of the line that takes part: 30 mm.
    side_reach_m : float
        The same for `a`, the rotation: 55 mm, where a furrow beside the line counts little.
    knot_m : float
        Between knots: 15 mm.
    shortest_wave_m : float
        Waves of the profile of that length are halved: 0.13 m; half a lumbar curve is longer.
    side_wave_m : float
        The same of `a` and `c`: 0.13 m.
    window_m2 : float
        Area over which the sensor's noise is alike: 9 x 7 pixels at 2 m (3.4 mm each), as
        Konolige & Mihelich (2011) tell of structured light.
    """

    reach_m: float = 0.03
    side_reach_m: float = 0.055
    knot_m: float = 0.015
    shortest_wave_m: float = 0.13
    side_wave_m: float = 0.13
    window_m2: float = 63 * 0.0034**2


@dataclass(frozen=True, slots=True, eq=False)
class SpineProfile:
    """The fitted profile; a function of the height.

    Attributes
    ----------
    line : SymmetryLine
    knots : (K,) array
        Of the B-splines.
    coefficients : (3, N) array
        Of p, a and c.
    covariance, side_covariance : (N, N) arrays
        Of the coefficients of p, and of a.
    noise_m : float
        Standard deviation of one pixel from the fitted surface.
    top_m, bottom_m : float
        Heights between which the profile is known.
    """

    line: SymmetryLine
    knots: FloatArray
    coefficients: FloatArray
    covariance: FloatArray
    side_covariance: FloatArray
    noise_m: float
    top_m: float
    bottom_m: float

    def __post_init__(self) -> None:
        n = len(self.knots) - DEGREE - 1
        check_shape("coefficients", self.coefficients, (N_PARTS, n))
        check_shape("covariance", self.covariance, (n, n))
        check_shape("side_covariance", self.side_covariance, (n, n))
        for array in (self.knots, self.coefficients, self.covariance, self.side_covariance):
            read_only(array)

    def heights_m(self, step_m: float = 0.002) -> FloatArray:
        """Return heights from the top down, evenly."""
        count = int((self.top_m - self.bottom_m) / step_m) + 1
        return np.linspace(self.top_m, self.bottom_m, count)

    def back_m(self, y_m: FloatArray) -> FloatArray:
        """Return how far the profile reaches to the back at heights."""
        return np.asarray(self._spline(0)(y_m))

    def inclination(self, y_m: FloatArray) -> FloatArray:
        """Return dz/dy: positive where the upper part lies further back."""
        return np.asarray(self._spline(0).derivative()(y_m))

    def rotation_rad(self, y_m: FloatArray) -> FloatArray:
        """Return the surface's rotation about the vertical; see `SymmetryLine`."""
        return np.arctan(self.side_slope(y_m))

    def side_slope(self, y_m: FloatArray) -> FloatArray:
        """Return dz/dt beside the line: the tangent of the rotation."""
        return np.asarray(self._spline(1)(y_m))

    def weights(self, y_m: FloatArray, derivative: int = 0) -> FloatArray:
        """Return (M, N): times the coefficients of a part they give it, or its derivative."""
        n = self.coefficients.shape[1]
        basis = BSpline(self.knots, np.eye(n), DEGREE)
        return np.asarray(basis(y_m, nu=derivative))

    def _spline(self, part: int) -> BSpline:
        return BSpline(self.knots, self.coefficients[part], DEGREE)


def fit_profile(
    points_m: FloatArray, line: SymmetryLine, params: ProfileParams | None = None
) -> SpineProfile:
    """Fit the profile to the (N, 3) points of a back, patient axes.

    Raises
    ------
    ValueError
        No points lie about the line.
    """
    params = params or ProfileParams()
    top_m, bottom_m = float(line.y_m[0]), float(line.y_m[-1])
    knots = _knots(bottom_m, top_m, params.knot_m)
    near = _fit_within(points_m, line, knots, params.reach_m, params)
    wide = _fit_within(points_m, line, knots, params.side_reach_m, params)
    parts = near.parts.copy()
    parts[1] = wide.parts[1]
    covariances = near.covariances[0], wide.covariances[1]
    return SpineProfile(line, knots, parts, *covariances, near.noise_m, top_m, bottom_m)


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    parts: FloatArray
    covariances: tuple[FloatArray, FloatArray]
    noise_m: float


def _knots(bottom_m: float, top_m: float, apart_m: float) -> FloatArray:
    n_spans = max(round((top_m - bottom_m) / apart_m), 4)
    step_m = (top_m - bottom_m) / n_spans
    knots: FloatArray = bottom_m + step_m * np.arange(-DEGREE, n_spans + DEGREE + 1, dtype=float)
    return knots


def _fit_within(
    points_m: FloatArray,
    line: SymmetryLine,
    knots: FloatArray,
    reach_m: float,
    params: ProfileParams,
) -> _Fit:
    """Fit the three parts to what lies within reach of the line."""
    bottom_m, top_m = float(knots[DEGREE]), float(knots[-DEGREE - 1])
    t_m = points_m[:, 0] - line.at(points_m[:, 1])
    near = (np.abs(t_m) <= reach_m) & (points_m[:, 1] <= top_m) & (points_m[:, 1] >= bottom_m)
    t_m, y_m, z_m = t_m[near], points_m[near, 1], points_m[near, 2]
    if not len(y_m):
        raise ValueError("no points lie about the line")
    rows = BSpline.design_matrix(y_m, knots, DEGREE, extrapolate=True)
    aside = diags_array(t_m / reach_m)
    design = csr_array(hstack([rows, aside @ rows, aside @ aside @ rows]))
    penalty = _penalty(knots, len(y_m) / (top_m - bottom_m), params)
    kept = np.ones(len(y_m), bool)
    for _ in range(2):
        some = design[np.flatnonzero(kept)]
        gram: FloatArray = (some.T @ some).toarray()
        solved = np.linalg.solve(gram + penalty, some.T @ z_m[kept])
        off_m = z_m - design @ solved
        noise_m = 1.4826 * float(np.median(np.abs(off_m[kept])))
        kept = np.abs(off_m) <= OUTLIER_SDS * max(noise_m, 1e-6)
    inverse = np.linalg.inv(gram + penalty)
    n = rows.shape[1]
    density = len(y_m) / ((top_m - bottom_m) * 2.0 * reach_m)
    alike = max(density * params.window_m2, 1.0)
    covariance = noise_m**2 * alike * (inverse @ gram @ inverse)
    of_side = covariance[n : 2 * n, n : 2 * n] / reach_m**2
    parts = solved.reshape(N_PARTS, n) / np.array([[1.0], [reach_m], [reach_m**2]])
    return _Fit(parts, (covariance[:n, :n], of_side), noise_m)


def _penalty(knots: FloatArray, per_metre: float, params: ProfileParams) -> FloatArray:
    """Return the matrix that holds back third derivatives of the three parts."""
    n = len(knots) - DEGREE - 1
    step_m = float(knots[1] - knots[0])
    third = np.diff(np.eye(n), 3, axis=0) / step_m**3
    square = third.T @ third * step_m
    waves_m = np.array([params.shortest_wave_m, params.side_wave_m, params.side_wave_m])
    # The mean squares of 1, t and t^2 over the reach, t in units of it.
    shares = np.array([1.0, 1.0 / 3.0, 1.0 / 5.0])
    stiffness = per_metre * shares * (waves_m / (2.0 * np.pi)) ** 6
    return np.asarray(np.kron(np.diag(stiffness), square), float)
