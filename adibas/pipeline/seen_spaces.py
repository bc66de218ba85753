"""What a sensor's cameras see, as space in the colour camera's axes, which markers have."""

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.geometry.distortion import undistort_pixels
from adibas.geometry.rigid import IDENTITY, RigidTransform
from adibas.skeleton.seen_space import EVERYWHERE, SeenSpace


def seen_spaces(calibration: RgbdCalibration) -> tuple[SeenSpace, SeenSpace]:
    """Return the space that the colour camera sees, and the one that both cameras see.

    A camera that is not calibrated is taken to see everything.
    """
    in_color, in_depth = EVERYWHERE, EVERYWHERE
    if calibration.color is not None:
        in_color = _seen_by(calibration.color, IDENTITY)
    if calibration.depth is not None:
        in_depth = _seen_by(calibration.depth, calibration.color_from_depth.inverse())
    in_both = SeenSpace(
        np.concatenate([in_color.normals, in_depth.normals]),
        np.concatenate([in_color.offsets_m, in_depth.offsets_m]),
    )
    return in_color, in_both


def _seen_by(camera: CameraCalibration, camera_from_points: RigidTransform) -> SeenSpace:
    """Return the space between the planes through a camera and the borders of its picture.

    Lenses bend the borders a little: each is taken to be straight, through its own middle. One
    that the lens model does not reach is left out.
    """
    last_u, last_v = camera.width - 0.5, camera.height - 0.5
    u, v = 0.5 * (camera.width - 1), 0.5 * (camera.height - 1)
    pixels = np.array([[u, v], [-0.5, v], [last_u, v], [u, -0.5], [u, last_v]])
    rays = undistort_pixels(pixels, camera.intrinsics, camera.distortion)
    middle, *borders = np.column_stack([rays, np.ones(len(rays))])
    along = np.array([[0.0, 1, 0], [0, 1, 0], [1, 0, 0], [1, 0, 0]])
    normals: FloatArray = np.cross(along, borders)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    normals *= np.sign(normals @ middle)[:, None]
    normals = normals[np.isfinite(normals).all(axis=1)]
    return SeenSpace(
        normals @ camera_from_points.rotation, -normals @ camera_from_points.translation_m
    )
