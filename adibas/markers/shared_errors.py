"""What an uncertain calibration does to the places of markers: the same mistake for all of them.

A colour camera whose focal length is a little wrong sees every marker a little wrong, all in the
same way. Distances and angles need to know that, so that a place is given with its moves under a
few independent causes of unit variance, common to all markers of the calibration.

Source: first-order propagation with the covariance that the calibration holds; the moves by hand,
where the marker's ray meets the plane of the skin, and of a depth pixel by the theorem of implicit
functions: what the projection gains, the point gives back.
"""

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.calibration import CameraCalibration, RgbdCalibration, image_polynomial
from adibas.geometry.pinhole import normalise
from adibas.geometry.projection import CAMERA_PARAMETERS, camera_numbers, project_with_slopes
from adibas.geometry.rigid import RigidTransform

TURNS = tuple(f"color_from_depth.{name}" for name in ("rx", "ry", "rz"))
SHIFTS = tuple(f"color_from_depth.{name}" for name in ("tx", "ty", "tz"))
BIAS = ("depth_bias.a", "depth_bias.b", "depth_bias.c")
N_IMAGE_TERMS = 9


class SharedErrors:
    """Moves markers by the uncertain parameters of one calibration.

    Parameters
    ----------
    calibration : RgbdCalibration
        Of both cameras. Its parameters are named ``color.fx``, ``depth.fx`` and so on,
        ``color_from_depth.rx`` to ``tz`` (a small turn about the colour camera's axes after the
        rotation, and the shift), ``depth_bias.a``, ``b``, ``c`` and ``depth_bias.image_term.0``
        and so on; others move nothing.
    """

    def __init__(self, calibration: RgbdCalibration) -> None:
        color, depth = calibration.color, calibration.depth
        if color is None or depth is None:
            raise ValueError("markers are seen by a colour camera and measured by a depth camera")
        self._names = calibration.parameter_names
        self._causes = _causes(calibration)
        self._color = camera_numbers(color.intrinsics, color.distortion)
        self._depth: CameraCalibration = depth
        self._color_from_depth: RigidTransform = calibration.color_from_depth

    def moves(self, point_m: FloatArray, normal: FloatArray, within: FloatArray) -> FloatArray:
        """Return how a marker's place moves.

        Parameters
        ----------
        point_m : (3,) array
            The place, colour axes.
        normal : (3,) array
            Of the skin, of any length, colour axes.
        within : (3, 2) array
            How the place moves on the skin with the pixel, metres a pixel.

        Returns
        -------
        moves_m : (3, n) array
            One column for each cause; n is 0 where the calibration knows no covariance.
        """
        if self._causes.shape[1] == 0:
            return np.zeros((3, 0))
        slopes = project_with_slopes(point_m[None], self._color)
        # A pixel stays where it is seen: what the projection gains, the place gives back.
        by_camera = -within @ slopes.by_camera[0]
        ray = point_m / point_m[2]
        by_surface = np.outer(ray, normal) / (normal @ ray)
        known = {
            f"color.{name}": move for name, move in zip(CAMERA_PARAMETERS, by_camera.T, strict=True)
        }
        known |= self._surface_moves(point_m, by_surface)
        nothing = np.zeros(3)
        by_parameter = np.stack([known.get(name, nothing) for name in self._names], axis=-1)
        return np.asarray(by_parameter @ self._causes)

    def _surface_moves(self, point_m: FloatArray, by_surface: FloatArray) -> dict[str, FloatArray]:
        """Return what moves the skin that the depth camera measured, by name (see `DepthBias`)."""
        x, y, z = point_m - self._color_from_depth.translation_m
        turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        known = dict(zip(TURNS, (by_surface @ turned).T, strict=True))
        known |= dict(zip(SHIFTS, by_surface.T, strict=True))
        seen_m = self._color_from_depth.inverse().apply(point_m)
        depth = self._depth
        slopes = project_with_slopes(
            seen_m[None], camera_numbers(depth.intrinsics, depth.distortion)
        )
        # Its depth is measured, so that the point of a pixel gives back in x and y alone. The image
        # term goes along with the pixel's place, by some hundredths of a millimetre: left out.
        aside = -np.linalg.solve(slopes.by_point[0, :, :2], slopes.by_camera[0])
        by_camera = by_surface @ self._color_from_depth.rotation[:, :2] @ aside
        known |= {
            f"depth.{name}": move for name, move in zip(CAMERA_PARAMETERS, by_camera.T, strict=True)
        }
        depth_m = seen_m[2]
        longer = by_surface @ np.array([x, y, z]) / depth_m
        known |= {name: longer * depth_m**power for power, name in enumerate(BIAS)}
        across, along = normalise(slopes.pixels[0], depth.intrinsics)
        terms = image_polynomial(across, along, N_IMAGE_TERMS)
        return known | {
            f"depth_bias.image_term.{number}": longer * depth_m**2 * term
            for number, term in enumerate(terms)
        }


def _causes(calibration: RgbdCalibration) -> FloatArray:
    """Return the (n, k) moves of the parameters under k independent causes of variance 1."""
    if calibration.covariance is None:
        return np.zeros((len(calibration.parameter_names), 0))
    # Scaled, since focal lengths and coefficients differ by orders of magnitude.
    sds = np.sqrt(np.maximum(np.diag(calibration.covariance), 0.0))
    scale = np.where(sds > 0, sds, 1.0)
    sizes, axes = np.linalg.eigh(calibration.covariance / np.outer(scale, scale))
    return np.asarray(scale[:, None] * axes * np.sqrt(np.maximum(sizes, 0.0)))
