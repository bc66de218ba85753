"""Depth that the sensor itself moved into the colour image: its camera is the colour camera.

What such a sensor measured lies in the colour camera's grid, and nothing moves it there again.

Source: ROS depth_image_proc, point_cloud_xyzrgb, for images of two sizes: the depth image has the
whole width of the colour image, and as many of its rows, from the first one on, as it is high.
"""

from dataclasses import replace

import numpy as np

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import SourceInfo
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import IDENTITY, RigidTransform

OF_DEPTH_CAMERA = ("depth.", "color_from_depth.")


def in_color_image(
    calibration: RgbdCalibration, depth_size: tuple[int, int] | None = None
) -> RgbdCalibration:
    """Return the calibration of depth images that lie in the colour image.

    Parameters
    ----------
    calibration : RgbdCalibration
        Returned as it is where it is one already, or knows no colour camera. The covariance of its
        depth camera and of the pose is left out: it is not that of the sensor's registration.
    depth_size : (width, height) or None
        Of the depth image; None: as the calibration says, else as large as the colour image.
    """
    color, depth = calibration.color, calibration.depth
    if color is None:
        return calibration
    known = depth or color
    camera = _of_size(color, *(depth_size or (known.width, known.height)))
    if depth == camera and _is_identity(calibration.color_from_depth):
        return calibration
    plain = _in_color_axes(_without_covariance_of_depth_camera(calibration))
    return replace(plain, depth=camera, color_from_depth=IDENTITY)


def for_images_of(info: SourceInfo, calibration: RgbdCalibration) -> RgbdCalibration:
    """Return a calibration as it holds for the images of a source, whose own it may be."""
    if not info.is_depth_registered:
        return calibration
    own = None if info.calibration is None else info.calibration.depth
    return in_color_image(calibration, None if own is None else (own.width, own.height))


def would_move_again(info: SourceInfo, calibration: RgbdCalibration) -> bool:
    """Say whether a calibration has a depth camera whose depth the source has moved already."""
    return calibration.depth is not None and for_images_of(info, calibration) is not calibration


def _of_size(color: CameraCalibration, width: int, height: int) -> CameraCalibration:
    """Return the colour camera with images of another width, whose lower rows are cut off."""
    share, k = width / color.width, color.intrinsics
    # Pixels have their places at their centres: it is the border of the first one that stays.
    centre = ((c + 0.5) * share - 0.5 for c in (k.cx, k.cy))
    intrinsics = Intrinsics(k.fx * share, k.fy * share, *centre)
    return replace(color, width=width, height=height, intrinsics=intrinsics)


def _without_covariance_of_depth_camera(calibration: RgbdCalibration) -> RgbdCalibration:
    names, covariance = calibration.parameter_names, calibration.covariance
    kept = [i for i, name in enumerate(names) if not name.startswith(OF_DEPTH_CAMERA)]
    return replace(
        calibration,
        parameter_names=tuple(names[i] for i in kept),
        covariance=None if covariance is None else covariance[np.ix_(kept, kept)],
    )


def _in_color_axes(calibration: RgbdCalibration) -> RgbdCalibration:
    """Return the calibration with vertical and floor in the axes of the colour camera."""
    pose, gravity, floor = calibration.color_from_depth, calibration.gravity, calibration.floor
    if gravity is not None:
        gravity = pose.rotation @ gravity
    if floor is not None:
        normal = pose.rotation @ floor.normal
        floor = Plane(normal, float(floor.offset_m - normal @ pose.translation_m))
    return replace(calibration, gravity=gravity, floor=floor)


def _is_identity(transform: RigidTransform) -> bool:
    is_turned = not np.array_equal(transform.rotation, IDENTITY.rotation)
    return not (is_turned or transform.translation_m.any())
