"""From the corners of a board in several images to a camera with intervals.

Homographies, closed form, joint refinement; then images and corners that contradict the rest are
left out, and the lens gets the terms that the rest supports.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import BoolArray, FloatArray
from adibas.calibration.closed_form import closed_forms, pose_from_homography
from adibas.calibration.homography import fit_homography
from adibas.calibration.lens_models import (
    BROWN_5,
    CANDIDATES,
    FEW_VIEWS,
    RADIAL_2,
    LensModel,
)
from adibas.calibration.model_choice import calibrated_camera, choose, fit_models
from adibas.calibration.refinement import (
    Estimate,
    Loss,
    Observations,
    Refinement,
    RefinementParams,
    observe,
    refine,
    residuals_of,
)
from adibas.calibration.uncertainty import Uncertainty, skew_of, uncertainty_of
from adibas.data.board import Board, BoardCorners
from adibas.data.camera_fit import CameraFit, ViewFit
from adibas.geometry.rigid import RigidTransform

NO_COVARIANCE = float("nan")
LEAST_VIEWS = 2
"""One gives eight equations, for four numbers of the camera and six of its pose."""


@dataclass(frozen=True, slots=True)
class FittingParams:
    """How a camera is fitted.

    Attributes
    ----------
    model : LensModel or None
        Fixed terms; None chooses among `CANDIDATES` by leaving out views.
    refinement : RefinementParams
        Of the last refinement; with squares nothing is left out.
    views_for_choice : int
        Fewer views than this get k1 and k2 at most: 5.
    greatest_image_ratio : float
        An image is an outlier if its median error is this many times that of all: 3.
    is_weighted : bool
        Trust the finder's own standard deviations of the corners, up to a common factor.
    """

    model: LensModel | None = None
    refinement: RefinementParams = field(default_factory=RefinementParams)
    views_for_choice: int = 5
    greatest_image_ratio: float = 3.0
    is_weighted: bool = False


def fit_camera(
    board: Board, images: Sequence[BoardCorners], params: FittingParams | None = None
) -> CameraFit | None:
    """Calibrate a camera.

    Parameters
    ----------
    board : Board
        What was shown.
    images : sequence of BoardCorners
        All of one size.
    params : FittingParams or None
        How.

    Returns
    -------
    fit : CameraFit or None
        None where fewer than two images have corners enough for a homography.

    Raises
    ------
    ValueError
        The images have different sizes, or another number of corners than the board.
    """
    params = params or FittingParams()
    size = _common_size(board, images)
    points_m = board.points_m()
    homographies = [fit_homography(points_m[:, :2], image.pixels) for image in images]
    usable = [i for i, homography in enumerate(homographies) if homography is not None]
    if len(usable) < LEAST_VIEWS:
        return None
    chosen = [images[i] for i in usable]
    sigmas = np.stack([_shares(image.sigma_px) for image in chosen]) if params.is_weighted else None
    observations = observe(points_m, np.stack([image.pixels for image in chosen]), sigmas)
    start = start_from(observations, [h for h in homographies if h is not None], size)
    is_kept, start = _consistent(observations, start, params)
    kept = _selected(observations, is_kept)
    model, start = _model(kept, _selected_poses(start, is_kept), size, params)
    refined = refine(kept, start, model, params.refinement)
    return _result(board, chosen, is_kept, kept, refined, model)


def start_from(
    observations: Observations, homographies: Sequence[FloatArray], size: tuple[int, int]
) -> Estimate:
    """Return the camera in closed form, with the poses, that explains the corners best.

    Parameters
    ----------
    observations : Observations
        Corners.
    homographies : sequence of (3, 3) arrays
        Of the same views.
    size : (height, width)
        Of the images.
    """
    tried = []
    for form in closed_forms(homographies, size):
        poses = [pose_from_homography(homography, form.matrix) for homography in homographies]
        camera = np.zeros(17)
        camera[:4] = form.matrix[0, 0], form.matrix[1, 1], form.matrix[0, 2], form.matrix[1, 2]
        tried.append(
            Estimate(
                camera,
                np.stack([pose.rotation for pose in poses]),
                np.stack([pose.translation_m for pose in poses]),
            )
        )
    errors = [np.nanmedian(np.abs(residuals_of(observations, estimate))) for estimate in tried]
    return tried[int(np.argmin(errors))]


def _common_size(board: Board, images: Sequence[BoardCorners]) -> tuple[int, int]:
    sizes = {(image.height, image.width) for image in images}
    if len(sizes) != 1:
        raise ValueError(f"images must be of one size, got {sorted(sizes)}")
    if any(len(image.pixels) != board.n_corners for image in images):
        raise ValueError(f"images must have {board.n_corners} corners each")
    return sizes.pop()


def _shares(sigma_px: FloatArray) -> FloatArray:
    return sigma_px / np.nanmedian(sigma_px)


def _consistent(
    observations: Observations, start: Estimate, params: FittingParams
) -> tuple[BoolArray, Estimate]:
    """Leave out, one after the other, images that contradict the rest."""
    is_kept = np.ones(len(observations.pixels), bool)
    model = _rough_model(len(is_kept), params)
    if params.refinement.loss is Loss.SQUARES:
        return is_kept, start
    while True:
        part = _selected(observations, is_kept)
        refined = refine(
            part, _selected_poses(start, is_kept), model, RefinementParams(loss=Loss.HUBER)
        )
        start = _with_poses(start, is_kept, refined.estimate)
        lengths_px = np.hypot(*np.moveaxis(refined.residuals_px, -1, 0))
        medians_px = np.nanmedian(lengths_px, axis=1)
        worst = int(np.argmax(medians_px))
        limit_px = params.greatest_image_ratio * float(np.median(medians_px))
        is_small = is_kept.sum() <= len(is_kept) / 2 or is_kept.sum() <= 3  # noqa: PLR2004
        if is_small or medians_px[worst] <= limit_px:
            return is_kept, start
        is_kept[np.flatnonzero(is_kept)[worst]] = False


def _rough_model(n_views: int, params: FittingParams) -> LensModel:
    """Return a model that leaves little unexplained."""
    if params.model is not None:
        return params.model
    return BROWN_5 if n_views >= params.views_for_choice else RADIAL_2


def _model(
    observations: Observations, start: Estimate, size: tuple[int, int], params: FittingParams
) -> tuple[LensModel, Estimate]:
    if params.model is not None:
        return params.model, start
    n_views = len(observations.pixels)
    rough = _rough_model(n_views, params)
    refined = refine(observations, start, rough, params.refinement)
    clean = observe(
        observations.points_m,
        np.where(refined.weights[..., None] > 0, observations.pixels, np.nan),
        observations.sigmas,
    )
    models = CANDIDATES if n_views >= params.views_for_choice else FEW_VIEWS
    best = choose(fit_models(clean, refined.estimate, models), size)
    return (rough, refined.estimate) if best is None else (best.model, best.estimate)


def _selected(observations: Observations, is_kept: BoolArray) -> Observations:
    return Observations(
        observations.points_m,
        np.ascontiguousarray(observations.pixels[is_kept]),
        np.ascontiguousarray(observations.sigmas[is_kept]),
    )


def _selected_poses(estimate: Estimate, is_kept: BoolArray) -> Estimate:
    return Estimate(
        estimate.camera,
        np.ascontiguousarray(estimate.rotations[is_kept]),
        np.ascontiguousarray(estimate.translations_m[is_kept]),
    )


def _with_poses(whole: Estimate, is_kept: BoolArray, part: Estimate) -> Estimate:
    rotations, translations_m = whole.rotations.copy(), whole.translations_m.copy()
    rotations[is_kept], translations_m[is_kept] = part.rotations, part.translations_m
    return Estimate(part.camera, rotations, translations_m)


def _result(
    board: Board,
    images: Sequence[BoardCorners],
    is_kept: BoolArray,
    kept: Observations,
    refined: Refinement,
    model: LensModel,
) -> CameraFit:
    is_squares = not (refined.weights[np.isfinite(refined.weights)] != 1.0).any()
    cut_sigmas = np.inf if is_squares else RefinementParams().cut_sigmas
    found = uncertainty_of(kept, refined, model, cut_sigmas)
    skew_px, skew_sd_px = skew_of(kept, refined, model)
    n = len(model.parameters)
    known = found or Uncertainty(
        np.full((n, n), np.nan),
        np.full((len(kept.pixels), 6, 6), np.nan),
        np.zeros((6, n)),
        np.nan,
        np.nan,
    )
    return CameraFit(
        camera=calibrated_camera(
            refined.estimate.camera, model, (images[0].height, images[0].width)
        ),
        board=board,
        model=model.name,
        skew_px=skew_px,
        skew_sd_px=skew_sd_px,
        parameter_names=model.parameters,
        covariance=known.covariance,
        implied_moves=known.implied_moves,
        views=_views(board, images, is_kept, refined, known),
        sigma_px=known.sigma_px,
        birge_ratio=known.birge_ratio,
        is_settled=refined.has_converged and found is not None,
    )


def _views(
    board: Board,
    images: Sequence[BoardCorners],
    is_kept: BoolArray,
    refined: Refinement,
    known: Uncertainty,
) -> tuple[ViewFit, ...]:
    places = np.cumsum(is_kept) - 1
    return tuple(
        ViewFit(
            image.image,
            RigidTransform(
                refined.estimate.rotations[place], refined.estimate.translations_m[place]
            ),
            known.pose_covariances[place].copy(),
            image.pixels,
            refined.residuals_px[place].copy(),
            refined.weights[place].copy(),
        )
        if is_used
        else _outlier(board, image, refined.estimate.camera)
        for image, is_used, place in zip(images, is_kept, places, strict=True)
    )


def _outlier(board: Board, image: BoardCorners, camera: FloatArray) -> ViewFit:
    """Return an image that took no part, with the pose that suits it best all the same."""
    observations = observe(board.points_m(), image.pixels[None])
    homography = fit_homography(board.points_m()[:, :2], image.pixels)
    if homography is None:
        raise ValueError("an outlier was found by its homography")
    matrix = np.array([[camera[0], 0.0, camera[2]], [0.0, camera[1], camera[3]], [0.0, 0.0, 1.0]])
    pose = pose_from_homography(homography, matrix)
    estimate = Estimate(camera, pose.rotation[None].copy(), pose.translation_m[None].copy())
    return ViewFit(
        image.image,
        pose,
        np.full((6, 6), np.nan),
        image.pixels,
        residuals_of(observations, estimate)[0],
        np.where(np.isnan(image.sigma_px), np.nan, 0.0),
        is_outlier=True,
    )
