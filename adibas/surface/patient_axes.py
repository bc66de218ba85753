"""Axes of a standing patient: x to the patient's right, y up from the floor, z to the back."""

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from adibas.arrays import FloatArray
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform, rotation_from_vector

UP = np.array([0.0, 1.0, 0.0])
TURNS_RAD: Mapping[str, float] = MappingProxyType(
    {
        "posterior": 0.0,
        "right_lateral": math.pi / 2,
        "anterior": math.pi,
        "left_lateral": -math.pi / 2,
    }
)
"""By how much axes whose z points to the camera are turned, see `turned`, to be the patient's."""
LEVEL_CAMERA = np.diag([1.0, -1.0, -1.0])
"""Turns axes whose y is up and whose z points to the camera into the camera's: x to the right of
the picture, y down, z away."""
TRUNK = (0.5, 0.8)
"""Heights, as shares of the stature, whose outline says where the body's middle is."""
THICKNESS, WIDTH = 0.13, 0.26
"""Of the trunk with the arms, as shares of the stature, where no view shows them."""


def axes_of_back(points_m: FloatArray, floor: Plane) -> RigidTransform:
    """Return patient_from_camera of somebody whose back is turned to the camera.

    The origin lies on the floor under the middle of the points; the back is taken to face the
    camera squarely, see `turned`.

    Parameters
    ----------
    points_m : (N, 3) array
        Of the body, camera axes.
    floor : Plane
        In camera axes, normal up.
    """
    up = floor.normal
    sight = np.array([0.0, 0.0, 1.0])
    back = -(sight - up * (up @ sight))
    back /= np.linalg.norm(back)
    rotation = np.stack([np.cross(up, back), up, back])
    foot_m = floor.project(np.median(points_m, axis=0))
    return RigidTransform(rotation, -rotation @ foot_m)


def turned(patient_from_camera: RigidTransform, turn_rad: float) -> RigidTransform:
    """Return the axes after the patient is turned about the vertical through the origin.

    A positive turn brings what lies at the back to the patient's right.
    """
    turn = rotation_from_vector(turn_rad * UP)
    return RigidTransform(turn, np.zeros(3)) @ patient_from_camera


def level_camera_from_patient(view: str) -> FloatArray:
    """Return the (3, 3) turn into a level camera to which the patient shows a side squarely.

    Parameters
    ----------
    view : str
        The side, of `TURNS_RAD`.
    """
    return np.asarray(LEVEL_CAMERA @ rotation_from_vector(-TURNS_RAD[view] * UP))


def guessed_axes(views: Mapping[str, tuple[FloatArray, Plane]]) -> dict[str, RigidTransform]:
    """Return patient_from_camera of each standing view, as far as outlines tell.

    Each view is centred in its picture; how far the body's middle lies behind what is seen is
    half of what the views from the side see as its width.

    Parameters
    ----------
    views : mapping
        By name (`TURNS_RAD`): (N, 3) points in camera axes, and the floor.
    """
    facing = {name: axes_of_back(points_m, floor) for name, (points_m, floor) in views.items()}
    outlines = {name: _outline_m(facing[name].apply(views[name][0])) for name in views}
    guessed = {}
    for name, axes in facing.items():
        left_m, right_m, nearest_m, stature_m = outlines[name]
        is_frontal = name in ("posterior", "anterior")
        across = [
            outlines[other][1] - outlines[other][0]
            for other in views
            if (other in ("posterior", "anterior")) != is_frontal
        ]
        nominal_m = stature_m * (THICKNESS if is_frontal else WIDTH)
        deep_m = float(np.mean(across)) if across else nominal_m
        shift_m = -np.array([(left_m + right_m) / 2, 0.0, nearest_m - deep_m / 2])
        centred = RigidTransform(np.eye(3), shift_m) @ axes
        guessed[name] = turned(centred, TURNS_RAD[name])
    return guessed


def _outline_m(points_m: FloatArray) -> tuple[float, float, float, float]:
    """Return left and right border and nearest place of the trunk, and the stature."""
    stature_m = float(points_m[:, 1].max())
    low, high = TRUNK
    height = points_m[:, 1] / stature_m
    trunk_m = points_m[(height >= low) & (height <= high)]
    if not len(trunk_m):
        trunk_m = points_m
    left_m, right_m = np.quantile(trunk_m[:, 0], (0.01, 0.99))
    return float(left_m), float(right_m), float(np.quantile(trunk_m[:, 2], 0.99)), stature_m
