"""What the error of the depth does to the vertical that a floor gives.

A floor is a plane ``1/z = m . (x/z, y/z, 1)``. A depth camera whose correction is a little wrong
sees another 1/z in every place, and one whose focal length is wrong another ray; both tilt m, all
over the floor alike, so that its blocks do not scatter for it.

Source: Hartley & Zisserman, Multiple View Geometry, 2nd ed., section 5.2, for the propagation.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from adibas.arrays import FloatArray, check_shape
from adibas.calibration.vertical import Vertical
from adibas.data.calibration import CameraCalibration, RgbdCalibration, image_polynomial
from adibas.geometry.planes import Plane


def with_depth_error(
    vertical: Vertical, blocks_m: FloatArray, calibration: RgbdCalibration
) -> Vertical:
    """Return the vertical with the uncertainty of the depth camera on top of its own.

    Parameters
    ----------
    vertical : Vertical
        Of a floor; one of an accelerometer is returned as it is.
    blocks_m : (N, 3) array
        Of the floor, by which it was measured.
    calibration : RgbdCalibration
        That corrected them; without a covariance nothing comes on top.
    """
    check_shape("blocks_m", blocks_m, (None, 3))
    floor, depth, covariance = vertical.floor, calibration.depth, calibration.covariance
    if floor is None or depth is None or covariance is None:
        return vertical
    changes = _changes(blocks_m, floor, depth, len(calibration.depth_bias.image_term))
    names = [name for name in changes if name in calibration.parameter_names]
    if not names:
        return vertical
    at = [calibration.parameter_names.index(name) for name in names]
    rays = blocks_m / blocks_m[:, 2:]
    tilts = np.linalg.lstsq(rays, np.stack([changes[name] for name in names], axis=-1))[0]
    # The plane is m . p = 1, and m = -normal / offset.
    across = (np.eye(3) - np.outer(floor.normal, floor.normal)) * floor.offset_m
    moved = across @ tilts
    variance = np.linalg.eigvalsh(moved @ covariance[np.ix_(at, at)] @ moved.T)[-1]
    return replace(vertical, sd_rad=float(np.hypot(vertical.sd_rad, np.sqrt(max(variance, 0.0)))))


def _changes(
    blocks_m: FloatArray, floor: Plane, depth: CameraCalibration, n_terms: int
) -> Mapping[str, FloatArray]:
    """Return by how much (N,) 1/z, less m . ray, changes with each parameter of the depth."""
    x_m, y_m, z_m = blocks_m.T
    x, y = x_m / z_m, y_m / z_m
    k = depth.intrinsics
    across, along, _ = -floor.normal / floor.offset_m
    one = np.ones_like(z_m)
    changes = {
        "depth_bias.a": -1.0 / z_m**2,
        "depth_bias.b": -1.0 / z_m,
        "depth_bias.c": -one,
        "depth.fx": across * x / k.fx,
        "depth.fy": along * y / k.fy,
        "depth.cx": one * across / k.fx,
        "depth.cy": one * along / k.fy,
    }
    for number, term in enumerate(image_polynomial(x, y, n_terms)):
        changes[f"depth_bias.image_term.{number}"] = -term
    return changes
