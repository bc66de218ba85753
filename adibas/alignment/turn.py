"""Somebody who turns before a camera that stands still, followed by the surface alone.

Bare skin has no corners to hold on to, so nothing but the shape tells how far somebody turned. A
trunk is flat, not round: its shape tells it well as long as little happens between two moments,
and the floor tells that people neither lean nor rise much.

Source: Newcombe et al., KinectFusion (2011), for projective association; distances in inverse
depth and robust weights as in `adibas.alignment.joint_fit`.
"""

from dataclasses import dataclass, field

import numpy as np

from adibas.alignment.joint_fit import (
    Equations,
    JointFit,
    JointParams,
    cross_matrices,
    fit_views,
    goal_of,
)
from adibas.alignment.turn_kernels import moved_image
from adibas.alignment.views import View
from adibas.arrays import Float32Array, FloatArray
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import IDENTITY, RigidTransform, rotation_vector


@dataclass(frozen=True, slots=True)
class TurnParams:
    """Settings.

    Attributes
    ----------
    joint : JointParams
        Errors count up to 0.006 in 1/z at the finest level, 24 mm at 2 m: arms do not stand still.
    key_rad : float
        Moments that are turned by more against the last key moment become one: 15 degrees. Nearer
        ones share the sensor's fixed pattern, which tells that nothing moved.
    tilt_sd_rad, lift_sd_m : float
        How far somebody leans and rises between two moments: 1 degree and 5 mm.
    least_overlap : float
        Of the pixels that must lie on the surface of the key moment: 0.5.
    """

    joint: JointParams = field(
        default_factory=lambda: JointParams(
            strides_px=(2, 2, 1), rounds=(4, 3, 4), scales_per_m=(0.006, 0.012, 0.04)
        )
    )
    key_rad: float = 0.26
    tilt_sd_rad: float = 0.0175
    lift_sd_m: float = 0.005
    least_overlap: float = 0.5


class TurnTracker:
    """Follows a person from moment to moment.

    Parameters
    ----------
    floor : Plane
        In the camera's axes, normal up.
    """

    def __init__(self, floor: Plane, params: TurnParams | None = None) -> None:
        self._floor = floor
        self._params = params or TurnParams()
        self._key: tuple[View, RigidTransform] | None = None
        self._before = self._last = IDENTITY

    def follow(self, view: View) -> RigidTransform | None:
        """Return first_from_camera: where the body's points lay in the first moment.

        None where the person cannot be followed; the next moment is then tried from the same
        guess.
        """
        if self._key is None:
            self._key = view, IDENTITY
            return IDENTITY
        key, first_from_key = self._key
        guess = self._last @ self._before.inverse() @ self._last
        fitted = fit_turn(key, view, first_from_key.inverse() @ guess, self._floor, self._params)
        if fitted is None:
            return None
        pose = first_from_key @ fitted.target_from_source
        self._before, self._last = self._last, pose
        if turn_rad(fitted.target_from_source) > self._params.key_rad:
            self._key = view, pose
        return pose


def turn_rad(motion: RigidTransform) -> float:
    """Return the angle of a rotation."""
    return float(np.linalg.norm(rotation_vector(motion.rotation)))


def fit_turn(
    target: View,
    source: View,
    guess: RigidTransform,
    floor: Plane,
    params: TurnParams | None = None,
) -> JointFit | None:
    """Improve a guess of where the source lies; None where the surfaces do not fit.

    Parameters
    ----------
    target, source : View
        The person alone, of one camera.
    guess : RigidTransform
        Target from source.
    floor : Plane
        In the camera's axes.
    """
    params = params or TurnParams()
    if not (source.levels[-1].inverse_per_m > 0).any():
        return None
    middle_m = source.middle_m

    def held(motion: RigidTransform, _level: int) -> tuple[Equations, int]:
        return _held(motion, middle_m, floor, params), 0

    fit = fit_views(target, source, guess, params.joint, held)
    return None if fit is None or fit.overlap < params.least_overlap else fit


def seen_after(view: View, motion: RigidTransform) -> Float32Array:
    """Return the (H, W) 1/z of a view's person after a motion; NaN where nothing is seen."""
    level = view.levels[0]
    return moved_image(
        level.inverse_per_m,
        level.rays,
        goal_of(view, 0),
        np.hstack([motion.rotation, motion.translation_m[:, None]]),
    )


def _held(
    motion: RigidTransform, middle_m: FloatArray, floor: Plane, params: TurnParams
) -> Equations:
    """Return normal equations that hold a twist to the floor: no lean, no rise."""
    up = floor.normal
    leaned = motion.rotation @ up
    by_turn = -cross_matrices(leaned[None])[0]
    place_m = motion.apply(middle_m)
    rise = np.concatenate([np.cross(place_m, up), up])
    matrix, right = np.zeros((6, 6)), np.zeros(6)
    matrix[:3, :3] = by_turn.T @ by_turn / params.tilt_sd_rad**2
    right[:3] = -by_turn.T @ (leaned - up) / params.tilt_sd_rad**2
    matrix += np.outer(rise, rise) / params.lift_sd_m**2
    right -= rise * float(up @ (place_m - middle_m)) / params.lift_sd_m**2
    return matrix, right
