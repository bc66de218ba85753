"""Pose of the depth camera in closed form, from planes that both cameras see.

Source: Wahba, A least squares estimate of satellite attitude, SIAM Review 7 (1965), solved by
singular values (Markley 1988); Unnikrishnan & Hebert, Fast extrinsic calibration of a laser
rangefinder to a camera, CMU-RI-TR-05-09 (2005), for normals and distances.
"""

import numpy as np

from adibas.arrays import FloatArray, check_shape
from adibas.geometry.rigid import RigidTransform

LEAST_PLANES = 3
LEAST_SPREAD = 0.02
"""Of the normals' smallest direction against the largest: planes tilted by 8 degrees or so."""


def start_extrinsics(planes_color: FloatArray, planes_depth: FloatArray) -> RigidTransform | None:
    """Return ``color_from_depth`` from the same planes in both cameras.

    Parameters
    ----------
    planes_color, planes_depth : (S, 3) arrays
        Inverse planes (normal over distance, 1/metres).

    Returns
    -------
    color_from_depth : RigidTransform or None
        None for fewer than three planes, or planes that are too parallel for the shift.
    """
    check_shape("planes_color", planes_color, (None, 3))
    check_shape("planes_depth", planes_depth, planes_color.shape)
    if len(planes_color) < LEAST_PLANES:
        return None
    sizes_color = np.linalg.norm(planes_color, axis=1)
    sizes_depth = np.linalg.norm(planes_depth, axis=1)
    normals_color = planes_color / sizes_color[:, None]
    normals_depth = planes_depth / sizes_depth[:, None]
    spread = np.linalg.svd(normals_color, compute_uv=False)
    if not spread[2] > LEAST_SPREAD * spread[0]:
        return None
    left, _, right = np.linalg.svd(normals_color.T @ normals_depth)
    rotation = left @ np.diag([1.0, 1.0, np.linalg.det(left) * np.linalg.det(right)]) @ right
    # n_color . (R p + t) = d_color, and n_depth . p = d_depth.
    gained_m = 1.0 / sizes_color - 1.0 / sizes_depth
    return RigidTransform(rotation, np.linalg.lstsq(normals_color, gained_m)[0])
