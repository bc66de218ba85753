"""Markers found on the patient."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only

NUMBERED = re.compile(r"m(\d+)")


class InPicture(Protocol):
    """What has a place in the colour image: (u, v), in pixels."""

    @property
    def u(self) -> float:
        """Right."""

    @property
    def v(self) -> float:
        """Down."""


def pixels_uv(things: Iterable[InPicture]) -> FloatArray:
    """Return the (N, 2) pixels of things in the colour image."""
    return np.array([(one.u, one.v) for one in things], float).reshape(-1, 2)


def is_numbered(label: str) -> bool:
    """Say whether a label is only the program's number."""
    return NUMBERED.fullmatch(label) is not None


@dataclass(frozen=True, slots=True)
class AutomaticName:
    """Who gave a marker its name, where no hand did.

    Attributes
    ----------
    model : str
        Which: see `adibas.skeleton.namer.Namer.identity`.
    confidence : float
        In the name, 0 to 1.
    """

    model: str
    confidence: float


@dataclass(frozen=True, slots=True, eq=False)
class Marker:
    """One marker, in the colour image and, where the depth allows, in space.

    Attributes
    ----------
    label : str
        ``m01``, ``m02``, ... from top to bottom until it has a name.
    u, v : float
        Centre in the colour image, pixels.
    radius_px : float
        Half the long axis of the blob, as a sticker may be seen slantingly; of a marker that a hand
        moved, of the disc with its area.
    covariance_px2 : (2, 2) array
        Of (u, v).
    position_m : (3,) array or None
        In the colour camera's axes; None where the depth gives none.
    covariance_m2 : (3, 3) array or None
        Of `position_m`, instrument only.
    shared_m : (3, n) array or None
        How `position_m` moves under n independent causes of variance 1 that all markers of one
        calibration share; that part of `covariance_m2` is ``shared_m @ shared_m.T``. None where
        nothing is known of it.
    named_by : AutomaticName or None
        None where a hand gave the name, where it has none yet, and where nobody kept it.
    rough_depth_m : float or None
        About how far away it is along the colour camera's axis, where the depth about it is too
        little for a position. None with a position, and where no depth is near.
    """

    label: str
    u: float
    v: float
    radius_px: float
    covariance_px2: FloatArray
    position_m: FloatArray | None = None
    covariance_m2: FloatArray | None = None
    shared_m: FloatArray | None = None
    named_by: AutomaticName | None = None
    rough_depth_m: float | None = None

    def __post_init__(self) -> None:
        check_shape("covariance_px2", self.covariance_px2, (2, 2))
        read_only(self.covariance_px2)
        if (self.position_m is None) != (self.covariance_m2 is None):
            raise ValueError("position_m and covariance_m2 stand or lack together")
        if self.rough_depth_m is not None and self.position_m is not None:
            raise ValueError("what has a position has no rough depth")
        if self.position_m is not None and self.covariance_m2 is not None:
            check_shape("position_m", self.position_m, (3,))
            check_shape("covariance_m2", self.covariance_m2, (3, 3))
            read_only(self.position_m)
            read_only(self.covariance_m2)
        if self.shared_m is not None:
            check_shape("shared_m", self.shared_m, (3, None))
            read_only(self.shared_m)


@dataclass(frozen=True, slots=True)
class RejectedBlob:
    """Something of the marker's colour that cannot be a marker, and why.

    Attributes
    ----------
    u, v : float
        Centre in the colour image, pixels.
    reason : str
        A sentence for the user (a message id of the translations).
    """

    u: float
    v: float
    reason: str
