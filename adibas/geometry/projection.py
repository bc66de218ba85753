"""How a pixel moves with the camera's parameters and with the point that it shows.

Source: derivatives of thesis equations 3.1-3.3 and 4.1-4.5 by hand; see `project_distorted` for
the model itself.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from adibas.arrays import FloatArray, check_shape
from adibas.geometry import projection_kernels as kernels
from adibas.geometry.pinhole import Intrinsics

CAMERA_PARAMETERS = (
    *("fx", "fy", "cx", "cy", "skew"),
    *("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4"),
)
"""The order of the derivatives."""


class ProjectionSlopes(NamedTuple):
    """Pixels and their derivatives.

    Attributes
    ----------
    pixels : (N, 2) array
        (u, v).
    by_camera : (N, 2, 17) array
        By `CAMERA_PARAMETERS`.
    by_point : (N, 2, 3) array
        By the point, pixels a metre.
    """

    pixels: FloatArray
    by_camera: FloatArray
    by_point: FloatArray


def camera_numbers(intrinsics: Intrinsics, coefficients: Sequence[float]) -> FloatArray:
    """Return the (17,) `CAMERA_PARAMETERS` of a camera without skew."""
    numbers = np.zeros(kernels.N_NUMBERS)
    numbers[:4] = intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy
    numbers[kernels.LENS : kernels.LENS + len(coefficients)] = coefficients
    return numbers


def project_with_slopes(points_m: FloatArray, camera: FloatArray) -> ProjectionSlopes:
    """Project points with a distorting, perhaps skewed camera, and differentiate.

    Parameters
    ----------
    points_m : (N, 3) array
        Camera-frame points in metres.
    camera : (17,) array
        See `camera_numbers`.

    Returns
    -------
    slopes : ProjectionSlopes
        NaN for points that are not in front of the camera (z <= 0).
    """
    points_m = np.array(points_m, float)
    camera = np.ascontiguousarray(camera, float)
    check_shape("points_m", points_m, (None, 3))
    check_shape("camera", camera, (kernels.N_NUMBERS,))
    points_m[~(points_m[:, 2] > 0)] = np.nan
    n = len(points_m)
    slopes = ProjectionSlopes(
        np.empty((n, 2)), np.empty((n, 2, kernels.N_NUMBERS)), np.empty((n, 2, 3))
    )
    kernels.project_all_with_slopes(
        points_m, camera, slopes.by_camera, slopes.by_point, slopes.pixels
    )
    return slopes
