"""The vertical plane that projected measures lie in, and the patient's directions along it.

Seen from the front the patient's left is on the picture's right; from the right side the face is
on the picture's right. So a view and a plane give every direction, and left and right cannot be
exchanged by the order of points.
"""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape
from adibas.data.calibration import RgbdCalibration
from adibas.data.protocol_measures import VerticalOrigin
from adibas.data.protocols import UP
from adibas.geometry.angles import unit

TO_PICTURES_RIGHT = {
    ("anterior", "left"): 1.0,
    ("anterior", "right"): -1.0,
    ("posterior", "left"): -1.0,
    ("posterior", "right"): 1.0,
    ("right_lateral", "anterior"): 1.0,
    ("right_lateral", "posterior"): -1.0,
    ("left_lateral", "anterior"): -1.0,
    ("left_lateral", "posterior"): 1.0,
}
"""Whether a direction of the patient points to the right or the left of the upright picture."""

_OPTICAL_AXIS = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True, eq=False)
class Vertical:
    """Up in the colour camera's axes, and how sure that is.

    Attributes
    ----------
    up : (3,) array
        Unit vector.
    sd_rad : float
        Of its angle, in each of two directions; 0 where it is not known.
    origin : VerticalOrigin
        Where it comes from; `UNKNOWN` is the upper side of the picture as it is shown.
    is_sd_known : bool
        Whether `sd_rad` was measured.
    """

    up: FloatArray
    sd_rad: float
    origin: VerticalOrigin
    is_sd_known: bool

    def __post_init__(self) -> None:
        check_shape("up", self.up, (3,))

    def tilted(self, tilts_rad: FloatArray) -> FloatArray:
        """Return the (..., 3) verticals after (..., 2) small turns about two level axes."""
        level = unit(np.cross(self.up, np.eye(3)[int(np.argmin(np.abs(self.up)))]))
        axes = np.stack([level, np.cross(self.up, level)])
        return unit(self.up + tilts_rad @ axes)

    @property
    def covariance(self) -> FloatArray:
        """Return the (3, 3) covariance of `up`."""
        return np.asarray(self.sd_rad**2 * (np.eye(3) - np.outer(self.up, self.up)))


def up_of_picture(rotation_deg: int) -> FloatArray:
    """Return the unit vector to the upper side of a picture that is turned clockwise for showing.

    In its camera's axes; `rotation_deg` is a multiple of 90.
    """
    angle_rad = math.radians(rotation_deg)
    return np.array([-round(math.sin(angle_rad)), -round(math.cos(angle_rad)), 0.0])


def up_without_floor(calibration: RgbdCalibration, rotation_deg: int = 0) -> FloatArray:
    """Return up in the depth camera's axes, as it is known before a floor is seen.

    Against gravity where the sensor measured it, else to the upper side of the turned picture.
    """
    return up_of_picture(rotation_deg) if calibration.gravity is None else -calibration.gravity


def vertical_of(calibration: RgbdCalibration, rotation_deg: int = 0) -> Vertical:
    """Return the vertical that a calibration holds; else the upper side of the turned picture."""
    rotation = calibration.color_from_depth.rotation
    sd_rad = calibration.gravity_sd_rad
    is_known = sd_rad is not None
    if calibration.gravity is not None:
        up = -(rotation @ calibration.gravity)
        return Vertical(up, sd_rad or 0.0, VerticalOrigin.GRAVITY, is_known)
    if calibration.floor is not None:
        up = rotation @ calibration.floor.normal
        return Vertical(up, sd_rad or 0.0, VerticalOrigin.FLOOR, is_known)
    up = up_of_picture(rotation_deg)
    return Vertical(up, 0.0, VerticalOrigin.UNKNOWN, is_sd_known=False)


def to_the_right(up: FloatArray) -> FloatArray:
    """Return the (..., 3) level directions to the right of who looks along the optical axis."""
    ahead = unit(_OPTICAL_AXIS - up[..., 2:] * up)
    return np.asarray(np.cross(ahead, up))


def axis_along(
    axis: str, view: str, up: FloatArray, across_m: FloatArray | None, *, is_sideways: bool = True
) -> FloatArray:
    """Return a direction of the patient in the colour camera's axes.

    Parameters
    ----------
    axis : str
        ``left``, ``right``, ``anterior``, ``posterior`` or ``up``.
    view : str
        Of `VIEWS`.
    up : (..., 3) array
        Unit vectors.
    across_m : (..., 3) array or None
        From the patient's right to the left, or from back to front; None: the sensor's plane.
    is_sideways : bool
        Whether `across_m` goes from right to left.

    Returns
    -------
    direction : (..., 3) array
        Unit length, level unless it is up.
    """
    if axis == UP:
        return up
    if across_m is None:
        return TO_PICTURES_RIGHT[view, axis] * to_the_right(up)
    level = unit(across_m - (across_m * up).sum(axis=-1, keepdims=True) * up)
    left = level if is_sideways else np.cross(up, level)
    sign = 1.0 if axis in ("left", "anterior") else -1.0
    return np.asarray(sign * (left if axis in ("left", "right") else np.cross(left, up)))
