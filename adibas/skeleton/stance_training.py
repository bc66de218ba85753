"""Learning how all joints of people who stand lie together; see `adibas.skeleton.stance`."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray, check_shape
from adibas.shapes.gaussian_mixture import fit_mixture
from adibas.skeleton.parts import LIMB_NAMES
from adibas.skeleton.stance import Stance
from adibas.skeleton.training import turned_about_y

_OTHER_SIDE = [limb ^ 1 for limb in range(len(LIMB_NAMES))]


@dataclass(frozen=True, slots=True)
class StanceParams:
    """Settings of the training.

    Attributes
    ----------
    n_components : int
        10.
    turn_rad : float
        How far at most people stand from the view that was declared: 0.35, 20 degrees.
    floor_m : float
        Least standard deviation of a coordinate: 7 mm, of places as they are measured.
    shift_m : float
        By which the middle of the joints may be beside that of the points that are seen: 0.5 m.
    least_bone_sd : float
        Of the logarithm of a bone's length: 0.1.
    least_side_sd : float
        Of the difference of such logarithms of both sides: 0.06, as those of two markers that are
        not put to just the same places of both arms.
    seed : int
        Of the turns and of the mixture's start.
    """

    n_components: int = 10
    turn_rad: float = 0.35
    floor_m: float = 0.007
    shift_m: float = 0.5
    least_bone_sd: float = 0.1
    least_side_sd: float = 0.06
    seed: int = 0


def learn_stance(
    names: tuple[str, ...], shapes_m: FloatArray, params: StanceParams | None = None
) -> Stance:
    """Learn from (S, N, 3) shapes of people who stand and face the camera, metres, y down."""
    params = params or StanceParams()
    check_shape("shapes_m", shapes_m, (None, len(names), 3))
    rng = np.random.default_rng(params.seed)
    turns_rad = rng.uniform(-params.turn_rad, params.turn_rad, len(shapes_m))
    turned = turned_about_y(shapes_m, turns_rad)
    rows = (turned - turned.mean(axis=1, keepdims=True)).reshape(len(turned), -1)
    floor = np.full(rows.shape[1], params.floor_m**2)
    mixture = fit_mixture(rows, params.n_components, floor, rng)
    shifts = np.tile(np.eye(3), len(names)) * params.shift_m
    limbs = np.array([[names.index(name) for name in limb] for limb in LIMB_NAMES])
    lengths = _log_lengths(shapes_m, limbs)
    bone_sds = np.maximum(lengths.std(axis=0), params.least_bone_sd)
    return Stance(
        weights=mixture.weights,
        means=mixture.means,
        covariances=mixture.covariances + shifts.T @ shifts,
        limbs=limbs,
        bone_means=lengths.mean(axis=0),
        bone_sds=bone_sds,
        bone_correlations=_correlations(lengths, bone_sds, params.least_side_sd),
    )


def _log_lengths(shapes_m: FloatArray, limbs: IntArray) -> FloatArray:
    """Return the (S, L, 2) logarithms of the lengths of both bones of each limb."""
    ends_m = shapes_m[:, limbs]
    return np.asarray(np.log(np.linalg.norm(np.diff(ends_m, axis=2), axis=3)))


def _correlations(lengths: FloatArray, sds: FloatArray, least_side_sd: float) -> FloatArray:
    """Return the (L, 2) correlations of a bone with that of the other side."""
    others = lengths[:, _OTHER_SIDE]
    apart = np.maximum((lengths - others).std(axis=0), least_side_sd)
    other_sds = sds[_OTHER_SIDE]
    alike = (sds**2 + other_sds**2 - apart**2) / (2.0 * sds * other_sds)
    return np.asarray(np.clip(alike, 0.0, None))
