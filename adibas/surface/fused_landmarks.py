"""One place of a landmark that several joined views saw, and what its error shares with others.

Each view tells the place with its own covariance and with that of how the view lies. The best
linear mean takes both; errors of how views lie, and of the calibration, go through all landmarks
together, so that a distance between two of them is surer than either place.

Source: Aitken's generalised least squares; of correlated parts each view's total covariance is
inverted alone, which stays unbiased and is at most slightly less sure.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only
from adibas.surface.view_joining import N_UNKNOWNS, JoinedViews


@dataclass(frozen=True, slots=True, eq=False)
class SeenPlace:
    """A landmark in one view, axes of the joined body.

    Attributes
    ----------
    view : int
        In the order in which views were joined.
    position_m : (3,) array
    own_m2 : (3, 3) array
        Covariance of what no other landmark shares.
    calibration_m : (3, n) array
        How the place moves under n causes of variance 1 that all views of one calibration share.
    """

    view: int
    position_m: FloatArray
    own_m2: FloatArray
    calibration_m: FloatArray

    def __post_init__(self) -> None:
        check_shape("position_m", self.position_m, (3,))
        check_shape("own_m2", self.own_m2, (3, 3))
        check_shape("calibration_m", self.calibration_m, (3, None))
        for array in (self.position_m, self.own_m2, self.calibration_m):
            read_only(array)


@dataclass(frozen=True, slots=True, eq=False)
class FusedPlace:
    """Where a landmark is, all views considered.

    Attributes
    ----------
    position_m : (3,) array
    covariance_m2 : (3, 3) array
        Of everything.
    shared_m : (3, m) array
        See `adibas.data.markers.Marker`: first the calibration's causes, then the views'.
    apart_sds : float
        How far the views are apart, over what their errors let expect: root mean square; 0 of one
        view alone.
    """

    position_m: FloatArray
    covariance_m2: FloatArray
    shared_m: FloatArray
    apart_sds: float

    def __post_init__(self) -> None:
        for array in (self.position_m, self.covariance_m2, self.shared_m):
            read_only(array)


def fuse_places(seen: Sequence[SeenPlace], joined: JoinedViews | None) -> FusedPlace:
    """Return the mean of what the views tell.

    Parameters
    ----------
    joined : JoinedViews or None
        None of one view alone.

    Raises
    ------
    ValueError
        No view saw it.
    """
    if not seen:
        raise ValueError("a landmark was seen by some view")
    n_causes = max(one.calibration_m.shape[1] for one in seen)
    shared_m = [
        np.hstack([_padded(one.calibration_m, n_causes), view_moves_m(one, joined)]) for one in seen
    ]
    totals_m2 = [
        one.own_m2 + moves_m @ moves_m.T for one, moves_m in zip(seen, shared_m, strict=True)
    ]
    information = [np.linalg.inv(total_m2) for total_m2 in totals_m2]
    mean_m2 = np.linalg.inv(np.sum(information, axis=0))
    weights = [mean_m2 @ one for one in information]
    position_m = np.sum([w @ one.position_m for w, one in zip(weights, seen, strict=True)], axis=0)
    fused_m = np.sum([w @ moves_m for w, moves_m in zip(weights, shared_m, strict=True)], axis=0)
    own_m2 = np.sum([w @ one.own_m2 @ w.T for w, one in zip(weights, seen, strict=True)], axis=0)
    off = [one.position_m - position_m for one in seen]
    squares = sum(float(o @ i @ o) for o, i in zip(off, information, strict=True))
    n_free = 3 * (len(seen) - 1)
    return FusedPlace(
        position_m,
        own_m2 + fused_m @ fused_m.T,
        fused_m,
        float(np.sqrt(squares / n_free)) if n_free else 0.0,
    )


def view_moves_m(seen: SeenPlace, joined: JoinedViews | None) -> FloatArray:
    """Return (3, m): how a place moves under the independent causes of how the views lie."""
    if joined is None:
        return np.zeros((3, 0))
    n_causes = len(joined.covariance)
    if seen.view == 0:  # gives the axes
        return np.zeros((3, n_causes))
    root = np.linalg.cholesky(joined.covariance)
    begin = N_UNKNOWNS * (seen.view - 1)
    by_turn = np.cross(np.eye(3), seen.position_m).T  # of w x p
    return np.asarray(np.hstack([by_turn, np.eye(3)]) @ root[begin : begin + N_UNKNOWNS], float)


def _padded(moves_m: FloatArray, n_causes: int) -> FloatArray:
    return np.pad(moves_m, ((0, 0), (0, n_causes - moves_m.shape[1])))
