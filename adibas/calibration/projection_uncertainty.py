"""What the uncertainty of a calibration does to a pixel and to a measured point.

A camera whose principal point is wrong by a pixel sees almost the same as one that is turned a
little. What counts is what is left when the frame of the camera makes up for the change of its
parameters as well as it can, over the boards that it was calibrated with.

Source: mrcal's documentation, "Projection uncertainty" (Kogan, mrcal.secretsauce.net): there, too,
the noise of the corners is propagated to where a point in space is projected, with the implied
transform of the camera's frame; here in first order, by `CameraFit.implied_moves`.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray, check_shape, read_only
from adibas.data.camera_fit import CameraFit
from adibas.geometry.distortion import project_distorted, undistort_pixels
from adibas.geometry.projection import CAMERA_PARAMETERS, camera_numbers, project_with_slopes

N_PLACES = 9
"""Rows and columns of the places where a length may begin."""


@dataclass(frozen=True, slots=True, eq=False)
class UncertaintyMap:
    """Uncertainty over the image, for points at one distance.

    Attributes
    ----------
    distance_m : float
        Along the optical axis.
    pixels : (R, C, 2) array
        Where.
    sd_px : (R, C) array
        Standard deviation of the projection in its worst direction; NaN where the lens model
        gives the pixel no direction.
    sd_m : (R, C) array
        Of the place, across the axis, of a point that is seen there at that known distance.
    """

    distance_m: float
    pixels: FloatArray
    sd_px: FloatArray
    sd_m: FloatArray

    def __post_init__(self) -> None:
        check_shape("sd_px", self.sd_px, self.pixels.shape[:2])
        check_shape("sd_m", self.sd_m, self.pixels.shape[:2])
        for array in (self.pixels, self.sd_px, self.sd_m):
            read_only(array)


def map_uncertainty(
    fit: CameraFit, distance_m: float, cells: tuple[int, int] = (13, 17)
) -> UncertaintyMap:
    """Return the uncertainty over the whole image.

    Parameters
    ----------
    fit : CameraFit
        Of the camera.
    distance_m : float
        Of the points, along the optical axis.
    cells : (rows, columns)
        Of the map; the first and the last lie on the image's border.
    """
    camera = fit.camera
    rows, columns = cells
    u = np.linspace(-0.5, camera.width - 0.5, columns)
    v = np.linspace(-0.5, camera.height - 0.5, rows)
    pixels = np.stack(np.meshgrid(u, v), axis=-1)
    rays = undistort_pixels(pixels.reshape(-1, 2), camera.intrinsics, camera.distortion)
    points_m = distance_m * np.concatenate([rays, np.ones((len(rays), 1))], axis=1)
    sd_px, sd_m = point_uncertainty(fit, points_m)
    return UncertaintyMap(distance_m, pixels, sd_px.reshape(cells), sd_m.reshape(cells))


def point_uncertainty(fit: CameraFit, points_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the uncertainty of points in space.

    Parameters
    ----------
    fit : CameraFit
        Of the camera.
    points_m : (N, 3) array
        In the camera's frame.

    Returns
    -------
    sd_px, sd_m : (N,) arrays
        See `UncertaintyMap`.
    """
    by_parameters, by_point = _slopes(fit, points_m)
    pixels = by_parameters @ fit.covariance @ by_parameters.swapaxes(1, 2)
    # The place moves against the projection: a seen pixel is where it is.
    across = np.full_like(by_point[:, :, :2], np.nan)
    is_known = np.isfinite(by_point).all(axis=(1, 2))
    across[is_known] = np.linalg.inv(by_point[is_known, :, :2])
    places = across @ pixels @ across.swapaxes(1, 2)
    return _worst(pixels), _worst(places)


def _slopes(fit: CameraFit, points_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (N, 2, n) slopes of pixels by the parameters, frame made up for, and (N, 2, 3)."""
    numbers = camera_numbers(fit.camera.intrinsics, fit.camera.distortion)
    slopes = project_with_slopes(points_m, numbers)
    free = [CAMERA_PARAMETERS.index(name) for name in fit.parameter_names]
    x, y, z = np.asarray(points_m, float).T
    zero = np.zeros_like(x)
    # w x p, then the shift.
    turns = np.stack([[zero, z, -y], [-z, zero, x], [y, -x, zero]]).transpose(2, 0, 1)
    moves = np.concatenate([turns, np.broadcast_to(np.eye(3), turns.shape)], axis=2)
    frame = slopes.by_point @ moves @ fit.implied_moves
    return slopes.by_camera[:, :, free] + frame, slopes.by_point


def _worst(covariances: FloatArray) -> FloatArray:
    """Return the (N,) largest standard deviations of (N, 2, 2) covariances; NaN stays NaN."""
    half_trace = 0.5 * (covariances[:, 0, 0] + covariances[:, 1, 1])
    half_gap = 0.5 * (covariances[:, 0, 0] - covariances[:, 1, 1])
    return np.asarray(np.sqrt(half_trace + np.hypot(half_gap, covariances[:, 0, 1])))


def distance_uncertainty(fit: CameraFit, distance_m: float, length_m: float) -> float:
    """Return how sure a length across the optical axis is, whose depth is known exactly.

    Parameters
    ----------
    fit : CameraFit
        Of the camera.
    distance_m : float
        Of the length from the camera.
    length_m : float
        Its own.

    Returns
    -------
    sd_m : float
        Standard deviation, metres, the worst of the lengths across and along the image whose
        ends are seen in its middle half, from top to bottom, where a patient stands; NaN where it
        fits nowhere.
    """
    seen_m = _seen_places_m(fit, distance_m)
    found = [np.nan]
    for step_m in (np.array([length_m, 0.0, 0.0]), np.array([0.0, length_m, 0.0])):
        starts_m = seen_m[_are_seen(fit, seen_m + step_m)]
        if len(starts_m) > 0:
            found.append(float(np.nanmax(_length_sds(fit, starts_m, step_m))))
    return float(np.nanmax(found)) if len(found) > 1 else float("nan")


def _seen_places_m(fit: CameraFit, distance_m: float) -> FloatArray:
    camera = fit.camera
    u = np.linspace(*_middle(fit), N_PLACES)
    v = np.linspace(0.0, camera.height - 1.0, N_PLACES)
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    rays = undistort_pixels(pixels, camera.intrinsics, camera.distortion)
    places_m = distance_m * np.concatenate([rays, np.ones((len(rays), 1))], axis=1)
    return np.asarray(places_m[np.isfinite(places_m).all(axis=1)])


def _are_seen(fit: CameraFit, places_m: FloatArray) -> BoolArray:
    camera = fit.camera
    pixels = project_distorted(places_m, camera.intrinsics, camera.distortion)
    left, right = _middle(fit)
    with np.errstate(invalid="ignore"):
        inside = (pixels >= (left, 0.0)) & (pixels <= (right, camera.height - 1.0))
    return np.asarray(inside.all(axis=1))


def _middle(fit: CameraFit) -> tuple[float, float]:
    """Return the first and the last column of the middle half of the image."""
    width = fit.camera.width
    return 0.25 * width - 0.5, 0.75 * width - 0.5


def _length_sds(fit: CameraFit, starts_m: FloatArray, step_m: FloatArray) -> FloatArray:
    """Return the (N,) standard deviations of the lengths between starts and starts + step."""
    numbers = camera_numbers(fit.camera.intrinsics, fit.camera.distortion)
    free = [CAMERA_PARAMETERS.index(name) for name in fit.parameter_names]
    moves = []
    for ends_m in (starts_m, starts_m + step_m):
        slopes = project_with_slopes(ends_m, numbers)
        across = np.linalg.inv(slopes.by_point[:, :, :2])
        moves.append(-across @ slopes.by_camera[:, :, free])
    along = step_m[:2] / np.linalg.norm(step_m)
    stretches = along @ (moves[1] - moves[0])
    return np.asarray(np.sqrt(np.einsum("ni,ij,nj->n", stretches, fit.covariance, stretches)))
