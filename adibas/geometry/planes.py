"""Planes, and the floor among them.

Source: Fischler & Bolles, Random sample consensus, CACM 24 (1981), for the robust search.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray, check_shape, read_only

POINTS_OF_A_PLANE = 3
# Points whose spread in a second direction is below this share of the first lie on a line.
DEGENERATE_SHARE = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """Points p with ``normal . p + offset_m = 0``; the sum is the signed distance from it.

    Attributes
    ----------
    normal : (3,) array
        Unit length; of a floor it points up, so that the signed distance is the height.
    offset_m : float
        Signed distance of the origin, metres; of a floor the camera's height above it.
    """

    normal: FloatArray
    offset_m: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "normal", np.array(self.normal, float))
        check_shape("normal", self.normal, (3,))
        if not abs(np.linalg.norm(self.normal) - 1.0) < 1e-6:  # noqa: PLR2004  (rounding)
            raise ValueError(f"normal must have length 1, got {np.linalg.norm(self.normal)}")
        read_only(self.normal)

    def signed_distance_m(self, points_m: FloatArray) -> FloatArray:
        """Return the (...) signed distances of (..., 3) points, metres; NaN stays NaN."""
        distances: FloatArray = np.asarray(points_m, float) @ self.normal + self.offset_m
        return distances

    def project(self, points_m: FloatArray) -> FloatArray:
        """Return the nearest points of the plane to (..., 3) points, metres; NaN stays NaN."""
        points_m = np.asarray(points_m, float)
        return points_m - self.signed_distance_m(points_m)[..., None] * self.normal

    def tilt_rad(self, direction: FloatArray) -> float:
        """Return the angle between the normal and a (3,) direction of any length, 0 ... pi."""
        sine = np.linalg.norm(np.cross(self.normal, direction))
        return float(np.arctan2(sine, self.normal @ direction))


@dataclass(frozen=True, slots=True)
class PlaneSearch:
    """How a plane is sought among other things.

    Attributes
    ----------
    tolerance_m : float
        Points nearer than this belong to the plane: three times the depth noise at 2.5 m.
    smallest_share : float
        Of the points that must belong to it for the plane to count.
    n_trials : int
        Planes tried. Where a share s of the points belongs to the plane, no trial is good with a
        chance of (1 - s^3)^n_trials: 0.007 at a share of 0.1, 1e-7 at 0.15.
    n_scored : int
        Points, drawn at random, that vote on each trial.
    largest_tilt_rad : float
        Between its normal and the direction given as up.
    """

    tolerance_m: float = 0.03
    smallest_share: float = 0.1
    n_trials: int = 5000
    n_scored: int = 500
    largest_tilt_rad: float = np.pi / 4


@dataclass(frozen=True, slots=True, eq=False)
class FoundPlane:
    """A plane found in a set of points, and which of them lie on it: (N,) bool."""

    plane: Plane
    is_on_plane: BoolArray


def fit_plane(
    points_m: FloatArray,
    weights: FloatArray | None = None,
    *,
    up: FloatArray | None = None,
) -> Plane:
    """Fit a plane by least squares of the distances from it.

    Parameters
    ----------
    points_m : (N, 3) array
        Metres; points with a NaN are left out.
    weights : (N,) array, optional
        Not negative, such as the inverse variances; equal if left out.
    up : (3,) array, optional
        The normal points to this side; to the origin's (the camera's) if left out.

    Raises
    ------
    ValueError
        Fewer than three points, or all on one line: no plane is fixed.
    """
    points_m = np.asarray(points_m, float)
    check_shape("points_m", points_m, (None, 3))
    share = np.ones(len(points_m)) if weights is None else np.asarray(weights, float)
    check_shape("weights", share, (len(points_m),))
    if not (np.isfinite(share).all() and (share >= 0).all()):
        raise ValueError("weights must be finite and not negative")
    kept = (share > 0) & ~np.isnan(points_m).any(axis=1)
    if kept.sum() < POINTS_OF_A_PLANE:
        raise ValueError(f"a plane needs three points, got {kept.sum()}")
    share, points_m = share[kept], points_m[kept]
    centre_m = share @ points_m / share.sum()
    moved = (points_m - centre_m) * np.sqrt(share)[:, None]
    _, spread, axes = np.linalg.svd(moved, full_matrices=False)
    if not spread[1] > DEGENERATE_SHARE * spread[0]:
        raise ValueError("points on one line do not fix a plane")
    return _facing(axes[2], centre_m, up)


def find_plane(
    points_m: FloatArray,
    rng: np.random.Generator,
    *,
    up: FloatArray | None = None,
    search: PlaneSearch | None = None,
) -> FoundPlane | None:
    """Find the plane on which most points lie, whatever else is there: a floor in a room.

    Parameters
    ----------
    points_m : (N, 3) array
        Metres; points with a NaN lie on no plane.
    rng : numpy.random.Generator
        Draws the trials.
    up : (3,) array, optional
        Only planes whose normal is within `PlaneSearch.largest_tilt_rad` of it are sought, and
        the normal points to its side; any plane, and to the origin's side, if left out.
    search : PlaneSearch, optional
        Tolerances.

    Returns
    -------
    found : FoundPlane or None
        Fitted to all its points; None where no plane has enough of them.
    """
    points_m = np.asarray(points_m, float)
    check_shape("points_m", points_m, (None, 3))
    search = search or PlaneSearch()
    known_m = points_m[~np.isnan(points_m).any(axis=1)]
    if len(known_m) < POINTS_OF_A_PLANE:
        return None
    normals, anchors_m = _try_planes(known_m, rng, search.n_trials)
    if up is not None:
        is_level = np.abs(normals @ up) >= np.cos(search.largest_tilt_rad) * np.linalg.norm(up)
        normals, anchors_m = normals[is_level], anchors_m[is_level]
    if len(normals) == 0:
        return None
    voters_m = rng.choice(known_m, min(search.n_scored, len(known_m)), replace=False)
    offsets_m = -np.einsum("ij,ij->i", normals, anchors_m)
    distances_m = np.abs(voters_m @ normals.T + offsets_m)
    best = int((distances_m < search.tolerance_m).sum(axis=0).argmax())
    plane = _facing(normals[best], anchors_m[best], up)
    return _refine(points_m, plane, up, search)


def _try_planes(
    points_m: FloatArray, rng: np.random.Generator, n_trials: int
) -> tuple[FloatArray, FloatArray]:
    """Return the normals of planes through random triples, and a point on each."""
    corners_m = points_m[rng.integers(len(points_m), size=(n_trials, POINTS_OF_A_PLANE))]
    sides_m = corners_m[:, 1:] - corners_m[:, :1]
    normals = np.cross(sides_m[:, 0], sides_m[:, 1])
    lengths = np.linalg.norm(normals, axis=1)
    is_plane = lengths > DEGENERATE_SHARE * (sides_m**2).sum(axis=(1, 2))
    return normals[is_plane] / lengths[is_plane, None], corners_m[is_plane, 0]


def _refine(
    points_m: FloatArray, plane: Plane, up: FloatArray | None, search: PlaneSearch
) -> FoundPlane | None:
    """Fit `plane` to the points near it, twice; None where they are too few."""
    n_known = int((~np.isnan(points_m).any(axis=1)).sum())
    for _ in range(2):
        is_on_plane = np.abs(plane.signed_distance_m(points_m)) < search.tolerance_m
        if is_on_plane.sum() < max(search.smallest_share * n_known, POINTS_OF_A_PLANE):
            return None
        plane = fit_plane(points_m[is_on_plane], up=up)
    return FoundPlane(plane, np.abs(plane.signed_distance_m(points_m)) < search.tolerance_m)


def _facing(normal: FloatArray, point_m: FloatArray, up: FloatArray | None) -> Plane:
    """Return the plane through `point_m`, its normal turned to the side of `up` or the origin."""
    normal = normal / np.linalg.norm(normal)
    side = -(normal @ point_m) if up is None else normal @ up
    normal = -normal if side < 0 else normal
    return Plane(normal, float(-(normal @ point_m)))
