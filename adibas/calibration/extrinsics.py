"""Pose and depth error of a depth camera, from boards that both cameras see and from flat walls.

All shots are fitted together: the pose of the depth camera, its depth bias, and the plane of every
shot, which for a board the colour camera knows and for a wall nothing. Weights follow the noise of
corners and depth; the covariance is that of the estimate under the scatter that the residuals
really show, neighbouring cells and the sensor's fixed pattern included.

A wall tells nothing of `a`, `b`, `c` and the terms x and y: up to its noise, a device with these
errors sees another plane. It fixes the bending terms, and boards the rest.

Source: Herrera, Kannala & Heikkila, Joint depth and color camera calibration with distortion
correction, PAMI 34 (2012); Zhang & Zhang, ICME (2011); Basso, Menegatti & Pretto, Robust intrinsic
and extrinsic calibration of RGB-D cameras, IEEE Transactions on Robotics 34 (2018).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from adibas.arrays import BoolArray, FloatArray, check_shape, read_only
from adibas.calibration.extrinsics_descent import (
    DepthFitParams,
    DepthStart,
    Problem,
    pose_problem,
    settled,
    start_state,
    suspects_of,
)
from adibas.calibration.extrinsics_model import (
    DepthState,
    board_rows,
    corrected_inverse,
    global_names,
    rays_of,
    with_terms,
)
from adibas.calibration.extrinsics_uncertainty import uncertainty_of
from adibas.calibration.shots import BoardShot, WallShot, fit_inverse_plane, plane_of
from adibas.data.calibration import CameraCalibration, DepthBias
from adibas.geometry.rigid import RigidTransform

__all__ = ["DepthFit", "DepthFitParams", "DepthStart", "ShotFit", "fit_depth"]


@dataclass(frozen=True, slots=True, eq=False)
class ShotFit:
    """What one shot says in the end.

    Attributes
    ----------
    name : str
        Of the shot.
    time_s : float
        When it was taken.
    distance_m : float
        Of the plane along the middle of its cells.
    error_per_m : float
        Mean 1/z of depth minus that of the colour camera's own plane; NaN of walls.
    sigma_per_m : float
        What that may be by the noise of the corners.
    rms_m : float
        Of the cells about their plane, as depth.
    n_cells : int
        How many.
    is_outlier : bool
        It contradicts the others and took no part.
    """

    name: str
    time_s: float
    distance_m: float
    error_per_m: float
    sigma_per_m: float
    rms_m: float
    n_cells: int
    is_outlier: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class DepthFit:
    """A calibrated depth camera.

    Attributes
    ----------
    color_from_depth : RigidTransform
        As it was given where there are walls alone.
    bias : DepthBias
        Best estimate.
    camera : CameraCalibration
        The depth camera, as it was given or refined.
    parameter_names : tuple of str
        What was estimated.
    covariance : (n, n) array
        Of these, by the noise of depth and corners.
    by_camera : (n, 17) array
        How they go with the colour camera's `CAMERA_PARAMETERS` as they were given, whose error
        comes on top.
    sigma_per_m : float
        Standard deviation of a full cell's 1/z.
    pattern_share : float
        Of its variance that is the device's fixed pattern, the same in all shots.
    corner_variance : float
        Squared factor on the corners' own standard deviations.
    shots : tuple of ShotFit
        Boards, then walls.
    """

    color_from_depth: RigidTransform
    bias: DepthBias
    camera: CameraCalibration
    parameter_names: tuple[str, ...]
    covariance: FloatArray
    by_camera: FloatArray
    sigma_per_m: float
    pattern_share: float
    corner_variance: float
    shots: tuple[ShotFit, ...]

    def __post_init__(self) -> None:
        n = len(self.parameter_names)
        check_shape("covariance", self.covariance, (n, n))
        check_shape("by_camera", self.by_camera, (n, None))
        read_only(self.covariance)
        read_only(self.by_camera)

    @property
    def standard_deviations(self) -> FloatArray:
        """Of the (n,) parameters, by the noise of depth and corners."""
        return np.sqrt(np.diag(self.covariance))


def fit_depth(
    depth: DepthStart,
    boards: Sequence[BoardShot],
    walls: Sequence[WallShot] = (),
    start: RigidTransform | None = None,
    params: DepthFitParams | None = None,
) -> DepthFit:
    """Find pose and depth bias of the depth camera.

    Parameters
    ----------
    depth : DepthStart
        The depth camera; walls alone leave all but the bending terms of its bias as it is.
    boards, walls : sequences of shots
        One at least.
    start : RigidTransform or None
        The maker's ``color_from_depth``, or an earlier one; None: from the planes in closed form,
        or, where they are too parallel, two cameras side by side.

    Raises
    ------
    ValueError
        No shot at all.
    """
    params = params or DepthFitParams()
    if not boards and not walls:
        raise ValueError("a calibration of the depth needs a board or a wall")
    depth = replace(depth, bias=with_terms(depth.bias, params.n_image_terms))
    problem = pose_problem(boards, walls, start, depth, params)
    state, weights = settled(problem, start_state(problem, start))
    suspects = suspects_of(problem, state, weights)
    if suspects.any():
        kept = [shot for shot, is_out in zip(boards, suspects, strict=True) if not is_out]
        problem = pose_problem(kept, walls, start, depth, params)
        state, weights = settled(problem, start_state(problem, state.color_from_depth))
    sure = uncertainty_of(problem, state, weights)
    names = global_names(params.n_image_terms)
    return DepthFit(
        color_from_depth=state.color_from_depth,
        bias=state.bias,
        camera=state.camera,
        parameter_names=tuple(names[index] for index in problem.free if index < len(names)),
        covariance=sure.covariance,
        by_camera=sure.by_camera,
        sigma_per_m=sure.sigma_per_m,
        pattern_share=sure.pattern_share,
        corner_variance=problem.corner_variance,
        shots=tuple(_described(boards, walls, problem, state, suspects)),
    )


def _described(
    boards: Sequence[BoardShot],
    walls: Sequence[WallShot],
    problem: Problem,
    state: DepthState,
    suspects: BoolArray,
) -> list[ShotFit]:
    found = [
        _of_board(shot, problem, state, is_outlier=bool(is_outlier))
        for shot, is_outlier in zip(boards, suspects, strict=True)
    ]
    return [*found, *(_of_wall(shot, state) for shot in walls)]


def _of_wall(shot: BoardShot | WallShot, state: DepthState) -> ShotFit:
    cells = shot.cells
    inverse, rays = corrected_inverse(cells, state.bias, state.camera), rays_of(cells, state.camera)
    own = fit_inverse_plane(rays[:, :2], inverse, cells.shares)
    distance_m = 1.0 / float(cells.shares @ (rays @ own) / cells.shares.sum())
    spread = float(np.sqrt(np.mean((inverse - rays @ own) ** 2)))
    return ShotFit(
        name=shot.name,
        time_s=shot.time_s,
        distance_m=distance_m,
        error_per_m=float("nan"),
        sigma_per_m=float("nan"),
        rms_m=spread * distance_m**2,
        n_cells=len(cells),
    )


def _of_board(shot: BoardShot, problem: Problem, state: DepthState, *, is_outlier: bool) -> ShotFit:
    plane, cells = plane_of(shot.pose), shot.cells
    rows = board_rows(cells, plane.m, state)
    shares = cells.shares / cells.shares.sum()
    gain = shares @ rows.by_plane
    variance = float(gain @ plane.covariance @ gain) * problem.corner_variance
    return replace(
        _of_wall(shot, state),
        error_per_m=float(shares @ rows.residuals),
        sigma_per_m=float(np.sqrt(variance)),
        is_outlier=is_outlier,
    )
