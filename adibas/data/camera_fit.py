"""What a calibration of one camera found, and how sure it is."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray, check_shape, read_only
from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration
from adibas.geometry.rigid import RigidTransform

N_POSE = 6


@dataclass(frozen=True, slots=True, eq=False)
class ViewFit:
    """One image of the board.

    Attributes
    ----------
    image : str
        Its name.
    camera_from_board : RigidTransform
        Where the board stood.
    pose_covariance : (6, 6) array
        Of a small turn about the camera's axes through the board's origin (radians), then of the
        translation (metres).
    pixels : (N, 2) array
        Corners as found, in the order of `Board.points_m`; NaN where hidden.
    residuals_px : (N, 2) array
        Found minus computed; NaN where hidden.
    weights : (N,) array
        What part each corner took, 0 (an outlier) to 1; NaN where hidden.
    is_outlier : bool
        The whole image contradicts the others and took no part.
    """

    image: str
    camera_from_board: RigidTransform
    pose_covariance: FloatArray
    pixels: FloatArray
    residuals_px: FloatArray
    weights: FloatArray
    is_outlier: bool = False

    def __post_init__(self) -> None:
        n_corners = len(self.pixels)
        check_shape("pose_covariance", self.pose_covariance, (N_POSE, N_POSE))
        check_shape("pixels", self.pixels, (None, 2))
        check_shape("residuals_px", self.residuals_px, (n_corners, 2))
        check_shape("weights", self.weights, (n_corners,))
        for array in (self.pose_covariance, self.pixels, self.residuals_px, self.weights):
            read_only(array)

    @property
    def is_used(self) -> BoolArray:
        """Say of each of the (N,) corners whether it took part."""
        return np.asarray(self.weights > 0)

    @property
    def outlier_corners(self) -> tuple[int, ...]:
        """Indices of the corners that contradict the rest and took no part."""
        return tuple(np.flatnonzero(self.weights == 0.0).tolist())

    @property
    def rms_px(self) -> float:
        """Root mean square over all corners that the image shows; NaN if it shows none."""
        squares = (self.residuals_px**2).sum(axis=1)
        is_seen = ~np.isnan(squares)
        return float(np.sqrt(squares[is_seen].mean())) if is_seen.any() else float("nan")


@dataclass(frozen=True, slots=True, eq=False)
class CameraFit:
    """A calibrated camera with intervals.

    Attributes
    ----------
    camera : CameraCalibration
        Best estimate.
    board : Board
        What was shown.
    model : str
        The distortion terms in use, such as ``k1 k2``; ``none`` without any.
    skew_px, skew_sd_px : float
        Skew that the images would ask for, and its standard deviation; the camera has none.
    parameter_names : tuple of str
        Such as ``fx`` and ``k1``.
    covariance : (n, n) array
        Of these, in squared units; what the noise of the corners makes of them.
    implied_moves : (6, n) array
        The turn (radians, about the optical centre) and shift (metres) of the camera's frame that
        make up best, over the boards, for a change of each parameter by one.
    views : tuple of ViewFit
        One for each image with a board.
    sigma_px : float
        Standard deviation of one coordinate of one corner.
    birge_ratio : float
        How much more the views contradict one another than the corners' noise explains, as a
        ratio of variances; where it is clearly above 1 it is a factor of `covariance`.
    is_settled : bool
        False where the search for the parameters did not end: they mean nothing then.
    """

    camera: CameraCalibration
    board: Board
    model: str
    skew_px: float
    skew_sd_px: float
    parameter_names: tuple[str, ...]
    covariance: FloatArray
    implied_moves: FloatArray
    views: tuple[ViewFit, ...]
    sigma_px: float
    birge_ratio: float = 1.0
    is_settled: bool = True

    def __post_init__(self) -> None:
        n_parameters = len(self.parameter_names)
        check_shape("covariance", self.covariance, (n_parameters, n_parameters))
        check_shape("implied_moves", self.implied_moves, (N_POSE, n_parameters))
        read_only(self.covariance)
        read_only(self.implied_moves)

    @property
    def used_views(self) -> tuple[ViewFit, ...]:
        """The images that took part."""
        return tuple(view for view in self.views if not view.is_outlier)

    @property
    def rms_px(self) -> float:
        """Root mean square over the corners that took part: points, as OpenCV counts."""
        squares = [(view.residuals_px[view.is_used] ** 2).sum(axis=1) for view in self.used_views]
        joined = np.concatenate(squares) if squares else np.empty(0)
        return float(np.sqrt(joined.mean())) if joined.size else float("nan")

    @property
    def standard_deviations(self) -> FloatArray:
        """Of the (n,) parameters."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def values(self) -> FloatArray:
        """The (n,) parameters."""
        k, lens = self.camera.intrinsics, self.camera.distortion
        known = {"fx": k.fx, "fy": k.fy, "cx": k.cx, "cy": k.cy}
        names = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4")
        known |= dict(zip(names, lens, strict=False))
        return np.array([known[name] for name in self.parameter_names])
