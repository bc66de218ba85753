"""Axes of a standing patient: x to the patient's right, y up from the floor, z to the back."""

import numpy as np

from adibas.arrays import FloatArray
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform, rotation_from_vector

UP = np.array([0.0, 1.0, 0.0])


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
