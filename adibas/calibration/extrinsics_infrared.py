"""Pose of the depth camera from boards in pairs of a colour and an infrared image.

The depth camera of a structured-light sensor is its infrared camera. Each pair of images gives
the board's pose in both cameras, so the pose of one camera in the other; the pairs are averaged by
what their corners know of it.

With X = (R, t) for ``color_from_depth`` and a board at (R_i, t_i) in infrared, the board stands at
(R R_i, R t_i + t) in colour. A small turn w of R moves that by the turn w and the shift w x R t_i.
Given the infrared camera, the noise of a pose is independent of the camera's own error, so that
both simply add up.

Source: Zhang, PAMI 22 (2000), for the poses; Birge, Phys. Rev. 40 (1932), for pairs that
contradict one another more than their corners explain; Gauss and Newton for the rest.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from adibas.arrays import BoolArray, FloatArray, check_shape, read_only
from adibas.calibration.extrinsics_model import EXTRINSIC_NAMES, N_EXTRINSIC
from adibas.calibration.extrinsics_pose import BoardPose
from adibas.geometry.projection import CAMERA_PARAMETERS
from adibas.geometry.rigid import RigidTransform, rotation_from_vector, rotation_vector

N_ROUNDS = 12
LEAST_PAIRS = 3
SURE = 0.95


@dataclass(frozen=True, slots=True)
class InfraredParams:
    """When a pair is left out.

    Attributes
    ----------
    largest_distance : float
        Squared standard deviations of its six numbers: 40 (chance 4e-7), but see below.
    outlier_factor : float
        And so many times what the other pairs show: 8.
    largest_share : float
        Of the pairs; where more contradict the rest, nobody knows which are wrong: 1/3.
    """

    largest_distance: float = 40.0
    outlier_factor: float = 8.0
    largest_share: float = 1.0 / 3.0


@dataclass(frozen=True, slots=True, eq=False)
class InfraredPair:
    """One place of a board.

    Attributes
    ----------
    name : str
        For the reader.
    color, infrared : BoardPose
        In each camera.
    """

    name: str
    color: BoardPose
    infrared: BoardPose


@dataclass(frozen=True, slots=True, eq=False)
class InfraredFit:
    """The pose of the depth camera.

    Attributes
    ----------
    color_from_depth : RigidTransform
        Best estimate.
    covariance : (6, 6) array
        Of `EXTRINSIC_NAMES`, by the noise of the corners.
    by_color, by_infrared : (6, 17) arrays
        How they go with the `CAMERA_PARAMETERS` of the two cameras, whose errors come on top.
    birge_ratio : float
        How much more the pairs contradict one another than their corners explain, as a ratio of
        variances; where it is clearly above 1 it is a factor of `covariance`.
    turns_rad, shifts_m : (N,) arrays
        By how much each pair is off.
    outliers : tuple of str
        Pairs that contradict the others and took no part: the board was moved in between.
    """

    color_from_depth: RigidTransform
    covariance: FloatArray
    by_color: FloatArray
    by_infrared: FloatArray
    birge_ratio: float
    turns_rad: FloatArray
    shifts_m: FloatArray
    outliers: tuple[str, ...]

    def __post_init__(self) -> None:
        n = len(EXTRINSIC_NAMES)
        check_shape("covariance", self.covariance, (n, n))
        check_shape("by_color", self.by_color, (n, len(CAMERA_PARAMETERS)))
        check_shape("by_infrared", self.by_infrared, (n, len(CAMERA_PARAMETERS)))
        for array in (self.covariance, self.by_color, self.by_infrared):
            read_only(array)


def fit_infrared(
    pairs: Sequence[InfraredPair], params: InfraredParams | None = None
) -> InfraredFit | None:
    """Find ``color_from_depth`` from boards that both cameras saw at the same place.

    Parameters
    ----------
    pairs : sequence of InfraredPair
        The covariances of their poses up to one factor for each camera.

    Returns
    -------
    fit : InfraredFit or None
        None for fewer than three pairs.
    """
    params = params or InfraredParams()
    if len(pairs) < LEAST_PAIRS:
        return None
    factors = _factor([p.color for p in pairs]), _factor([p.infrared for p in pairs])
    everything = np.ones(len(pairs), bool)
    steps = _settled(pairs, everything, factors)
    kept = _kept(steps.distances, params)
    if not kept.all():
        steps = _settled(pairs, kept, factors)
    n_free = N_EXTRINSIC * (int(kept.sum()) - 1)
    squares = float(steps.distances[kept].sum())
    birge = squares / n_free
    is_more = squares > chi2.ppf(SURE, n_free)
    inverse = np.asarray(np.linalg.inv(steps.normal), float)
    return InfraredFit(
        color_from_depth=steps.pose,
        covariance=inverse * (birge if is_more else 1.0),
        by_color=inverse @ steps.by_color,
        by_infrared=inverse @ steps.by_infrared,
        birge_ratio=birge,
        turns_rad=np.linalg.norm(steps.residuals[:, :3], axis=1),
        shifts_m=np.linalg.norm(steps.residuals[:, 3:], axis=1),
        outliers=tuple(pair.name for pair, is_kept in zip(pairs, kept, strict=True) if not is_kept),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Steps:
    """The pairs seen from one guess: normal matrix, slope, and what each pair says."""

    pose: RigidTransform
    normal: FloatArray
    slope: FloatArray
    by_color: FloatArray
    by_infrared: FloatArray
    residuals: FloatArray
    distances: FloatArray


def _factor(poses: Sequence[BoardPose]) -> float:
    """Return the variance of the corners by their own account: 1 where their sigmas are right."""
    n_degrees = sum(pose.n_degrees for pose in poses)
    return max(sum(pose.squares for pose in poses) / max(n_degrees, 1), 1e-12)


def _settled(
    pairs: Sequence[InfraredPair], kept: BoolArray, factors: tuple[float, float]
) -> _Steps:
    pose = _middle(pairs, kept)
    for _ in range(N_ROUNDS):
        steps = _steps(pairs, kept, factors, pose)
        step = np.asarray(np.linalg.solve(steps.normal, steps.slope), float)
        left, _, right = np.linalg.svd(rotation_from_vector(step[:3]) @ pose.rotation)
        pose = RigidTransform(left @ right, pose.translation_m + step[3:])
    return _steps(pairs, kept, factors, pose)


def _middle(pairs: Sequence[InfraredPair], kept: BoolArray) -> RigidTransform:
    """Return the pair that most others agree with: a start that no outlier moves."""
    found = [
        pair.color.camera_from_board @ pair.infrared.camera_from_board.inverse()
        for pair, is_kept in zip(pairs, kept, strict=True)
        if is_kept
    ]
    vectors = np.array(
        [np.concatenate([rotation_vector(p.rotation), p.translation_m]) for p in found]
    )
    away = np.median(np.linalg.norm(vectors[:, None] - vectors[None], axis=-1), axis=1)
    return found[int(np.argmin(away))]


def _steps(
    pairs: Sequence[InfraredPair],
    kept: BoolArray,
    factors: tuple[float, float],
    pose: RigidTransform,
) -> _Steps:
    normal, slope = np.zeros((N_EXTRINSIC, N_EXTRINSIC)), np.zeros(N_EXTRINSIC)
    by_color = np.zeros((N_EXTRINSIC, len(CAMERA_PARAMETERS)))
    by_infrared = np.zeros_like(by_color)
    turned = np.kron(np.eye(2), pose.rotation)
    residuals, distances = np.empty((len(pairs), N_EXTRINSIC)), np.empty(len(pairs))
    for index, (pair, is_kept) in enumerate(zip(pairs, kept, strict=True)):
        color, infrared = pair.color, pair.infrared
        residual = _residual(color.camera_from_board, pose @ infrared.camera_from_board)
        variance = factors[0] * color.covariance
        variance = variance + factors[1] * turned @ infrared.covariance @ turned.T
        information = np.asarray(np.linalg.inv(variance), float)
        residuals[index] = residual
        distances[index] = residual @ information @ residual
        if is_kept:
            slopes = _slopes(pose.rotation @ infrared.camera_from_board.translation_m)
            pull = slopes.T @ information
            normal += pull @ slopes
            slope += pull @ residual
            by_color += pull @ color.by_camera
            by_infrared -= pull @ turned @ infrared.by_camera
    return _Steps(pose, normal, slope, by_color, by_infrared, residuals, distances)


def _residual(seen: RigidTransform, expected: RigidTransform) -> FloatArray:
    """Return the turn and shift from where the board is expected to where it is seen."""
    turn = rotation_vector(seen.rotation @ expected.rotation.T)
    return np.concatenate([turn, seen.translation_m - expected.translation_m])


def _slopes(moved_m: FloatArray) -> FloatArray:
    """Return the (6, 6) derivatives of the expected pose by a turn and a shift of the camera."""
    x, y, z = moved_m
    slopes = np.eye(N_EXTRINSIC)
    slopes[3:, :3] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return slopes


def _kept(distances: FloatArray, params: InfraredParams) -> BoolArray:
    usual = max(1.0, float(np.median(distances)) / N_EXTRINSIC)
    limit = max(params.largest_distance, params.outlier_factor * N_EXTRINSIC * usual)
    kept: BoolArray = distances <= limit
    return kept if (~kept).mean() < params.largest_share else np.ones(len(distances), bool)


def joint_covariance(
    fit: InfraredFit,
    color: tuple[Sequence[str], FloatArray],
    infrared: tuple[Sequence[str], FloatArray],
) -> tuple[tuple[str, ...], FloatArray]:
    """Return names and covariance of both cameras and the pose between them.

    Parameters
    ----------
    color, infrared : (names, (n, n) array)
        Of the parameters of each camera, named as in `CAMERA_PARAMETERS`.

    Returns
    -------
    names, covariance
        ``color.*``, ``depth.*``, then the pose.
    """
    slopes = np.concatenate(
        [_columns(fit.by_color, color[0]), _columns(fit.by_infrared, infrared[0])], axis=1
    )
    n_color, n_cameras = len(color[0]), slopes.shape[1]
    cameras = np.zeros((n_cameras, n_cameras))
    cameras[:n_color, :n_color], cameras[n_color:, n_color:] = color[1], infrared[1]
    covariance = np.zeros((n_cameras + N_EXTRINSIC,) * 2)
    covariance[:n_cameras, :n_cameras] = cameras
    covariance[n_cameras:, :n_cameras] = slopes @ cameras
    covariance[:n_cameras, n_cameras:] = covariance[n_cameras:, :n_cameras].T
    covariance[n_cameras:, n_cameras:] = fit.covariance + slopes @ cameras @ slopes.T
    names = (
        *(f"color.{name}" for name in color[0]),
        *(f"depth.{name}" for name in infrared[0]),
        *EXTRINSIC_NAMES,
    )
    return names, covariance


def _columns(by_camera: FloatArray, names: Sequence[str]) -> FloatArray:
    return by_camera[:, [CAMERA_PARAMETERS.index(name) for name in names]]
