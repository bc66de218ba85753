"""What each view contributes to the camera, once its own pose is fitted.

With its pose eliminated (Schur) a view has an information matrix S about the camera and a pull r
towards other values; at the solution the pulls cancel. So what the camera were without a view,
and how well that camera explains it, need no fit of their own.

Source: Cook & Weisberg, Residuals and influence in regression (1982), section 2.2 (leaving out
rows, here blocks), exact where the model is linear near the solution; Birge, The calculation of
errors by the method of least squares, Physical Review 40 (1932), for the ratio.
"""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.calibration.refinement_kernels import Arrow

# Directions of the camera with less information than this share are not fixed by the views.
SINGULAR_SHARE = 1e-13


@dataclass(frozen=True, slots=True, eq=False)
class ViewShares:
    """Information and pulls of V views about the n parameters of a camera.

    Attributes
    ----------
    information : (V, n, n) array
        Symmetric; in 1 / parameter^2 where residuals count in their standard deviations.
    pulls : (V, n) array
        Their sum is 0 at the solution.
    b_over_c : (V, n, 6) array
        How a pose follows the camera.
    """

    information: FloatArray
    pulls: FloatArray
    b_over_c: FloatArray

    @property
    def scale(self) -> FloatArray:
        """What brings each of the (n,) parameters to a comparable size."""
        return np.asarray(1.0 / np.sqrt(np.einsum("vii->i", self.information)))

    def inverse(self) -> FloatArray | None:
        """Return the (n, n) inverse of the whole information; None where it is singular."""
        return _inverse(self.information.sum(axis=0), self.scale)


def view_shares(arrow: Arrow, pulling: Arrow | None = None) -> ViewShares | None:
    """Eliminate the poses; None where a view does not fix its own.

    Parameters
    ----------
    arrow : Arrow
        Normal equations at the solution.
    pulling : Arrow or None
        Where the pulls come from, if they are weighted otherwise.
    """
    pulling = pulling or arrow
    try:
        followed = np.linalg.solve(arrow.c, arrow.b.swapaxes(1, 2)).swapaxes(1, 2)
    except np.linalg.LinAlgError:
        return None
    information = arrow.a - followed @ arrow.b.swapaxes(1, 2)
    pulls = pulling.slope_a - np.einsum("vni,vi->vn", followed, pulling.slope_c)
    if not (np.einsum("vii->i", information) > 0).all():
        return None
    return ViewShares(
        0.5 * (information + information.swapaxes(1, 2)), pulls, np.asarray(followed, float)
    )


def left_out_losses(shares: ViewShares, losses: FloatArray) -> FloatArray:
    """Return the (V,) losses of the views under the camera that the others alone give.

    Parameters
    ----------
    shares : ViewShares
        At the solution of all views.
    losses : (V,) array
        Of each view there.

    Returns
    -------
    losses : (V,) array
        Infinite where the others do not fix the camera.
    """
    whole = shares.information.sum(axis=0)
    found = np.full(len(losses), np.inf)
    for v, (information, pull) in enumerate(zip(shares.information, shares.pulls, strict=True)):
        inverse = _inverse(whole - information, shares.scale)
        if inverse is not None:
            move = -inverse @ pull
            found[v] = losses[v] - 2.0 * pull @ move + move @ information @ move
    return found


def birge_ratio(shares: ViewShares, variance: float) -> tuple[float, float]:
    """Return how much more the views contradict one another than their corners' noise explains.

    Parameters
    ----------
    shares : ViewShares
        At the solution.
    variance : float
        Of what pulls: 1 if residuals count in their standard deviations.

    Returns
    -------
    ratio, sd : float
        A ratio of variances, 1 on average where only independent noise is at work, and its own
        standard deviation there; NaN where the camera is not fixed.
    """
    inverse = shares.inverse()
    if inverse is None:
        return float("nan"), float("nan")
    pulled = float(np.einsum("vn,nm,vm->", shares.pulls, inverse, shares.pulls))
    parts = inverse @ shares.information
    spreads = parts - parts @ parts
    expected = float(np.einsum("vnn->", spreads))
    if not expected > 0:
        return float("nan"), float("nan")
    sd = math.sqrt(2.0 * float(np.einsum("vnm,vmn->", spreads, spreads))) / expected
    return pulled / (variance * expected), sd


def _inverse(information: FloatArray, scale: FloatArray) -> FloatArray | None:
    scaled = information * np.outer(scale, scale)
    sizes, axes = np.linalg.eigh(scaled)
    if not sizes[0] > SINGULAR_SHARE * sizes[-1]:
        return None
    return np.asarray((axes / sizes) @ axes.T * np.outer(scale, scale))
