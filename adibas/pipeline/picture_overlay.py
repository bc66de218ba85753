"""Two pictures of one view laid over one another: where a pixel of the earlier is in the later.

The body may stand nearer, the camera may be turned or hang lower. What is taken away is place,
size and roll: a similarity. What the camera's other height or look does to the picture stays, and
so does the bend of its lens, a few pixels at the border.
"""

import math
from dataclasses import dataclass
from enum import Enum

import cv2
import numpy as np

from adibas.arrays import FloatArray, UInt8Array, check_shape, read_only
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.markers import Marker
from adibas.data.protocol_measures import VerticalOrigin
from adibas.geometry.pinhole import Intrinsics, project
from adibas.measures.sight_plane import vertical_of
from adibas.texts import Message, message

LEAST_SHARED = 2
"""Markers of one name with a position in both pictures."""
STEP_M = 0.1
"""Along the vertical, to see where it goes in the picture."""


class OverlayWay(Enum):
    """What lies on one another."""

    FLOOR = "floor"
    """The plumb line through the body's middle, and the floor beneath it; at one scale."""
    MIDDLE = "middle"
    """The middle of the shared markers and the vertical; at one scale."""
    PICTURE = "picture"
    """The pictures as they were taken."""


WAYS: dict[OverlayWay, Message] = {
    OverlayWay.FLOOR: message(
        "Laid over one another by the floor and the plumb line through the body's middle, at the "
        "same scale."
    ),
    OverlayWay.MIDDLE: message(
        "Laid over one another by the body's middle and the vertical, at the same scale. The floor "
        "is not known in both sessions."
    ),
    OverlayWay.PICTURE: message(
        "Laid over one another as they were taken: fewer than two markers of one name have a "
        "position in both sessions."
    ),
}
"""Of each, a sentence for the reader."""


@dataclass(frozen=True, slots=True)
class PlacedMarkers:
    """The markers in a picture, as corrected, and the calibration that they were measured with."""

    markers: tuple[Marker, ...]
    calibration: RgbdCalibration
    rotation_deg: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class PictureOverlay:
    """How the earlier picture is moved onto the later one.

    Attributes
    ----------
    way : OverlayWay
        What lies on one another then.
    later_from_earlier : (2, 3) array
        Moves (u, v, 1) of the earlier picture to (u, v) of the later one.
    """

    way: OverlayWay
    later_from_earlier: FloatArray

    def __post_init__(self) -> None:
        check_shape("later_from_earlier", self.later_from_earlier, (2, 3))
        read_only(self.later_from_earlier)

    def moved(self, u: float, v: float) -> tuple[float, float]:
        """Return where a pixel of the earlier picture lies in the later one."""
        place = self.later_from_earlier @ (u, v, 1.0)
        return float(place[0]), float(place[1])

    def laid(self, earlier_rgb: UInt8Array, shape: tuple[int, ...]) -> UInt8Array:
        """Return the earlier picture in the pixels of the later one, of (height, width, ...)."""
        laid = cv2.warpAffine(earlier_rgb, self.later_from_earlier, (shape[1], shape[0]))
        return np.asarray(laid, np.uint8)


def mixed(laid_rgb: UInt8Array, later_rgb: UInt8Array, share: float) -> UInt8Array:
    """Return two pictures of the same pixels in one; `share` of the later one, 0 to 1."""
    return np.asarray(cv2.addWeighted(laid_rgb, 1.0 - share, later_rgb, share, 0.0), np.uint8)


@dataclass(frozen=True, slots=True, eq=False)
class _Anchor:
    """A pixel, the direction of up there, and how many pixels a metre has at the body."""

    pixel: FloatArray
    up: FloatArray
    px_per_m: float


def lay_over(earlier: PlacedMarkers, later: PlacedMarkers) -> PictureOverlay:
    """Return how an earlier picture is laid over a later one.

    The markers that both have by name, with a position, say where the body is. Where fewer than
    two are shared nothing is moved but the size of the picture.
    """
    old, new = earlier.calibration.color, later.calibration.color
    if old is None or new is None:
        return PictureOverlay(OverlayWay.PICTURE, np.eye(2, 3))
    first, second = _shared(earlier, later)
    if len(first) < LEAST_SHARED:
        return PictureOverlay(OverlayWay.PICTURE, _resized(old, new))
    has_floor = all(
        one.calibration.floor is not None
        and vertical_of(one.calibration).origin is not VerticalOrigin.UNKNOWN
        for one in (earlier, later)
    )
    anchors = [
        _anchor(positions_m.mean(axis=0), seen, camera, on_floor=has_floor)
        for positions_m, seen, camera in (
            (first, earlier, old.intrinsics),
            (second, later, new.intrinsics),
        )
    ]
    way = OverlayWay.FLOOR if has_floor else OverlayWay.MIDDLE
    return PictureOverlay(way, _similarity(*anchors))


def _shared(earlier: PlacedMarkers, later: PlacedMarkers) -> tuple[FloatArray, FloatArray]:
    """Return the (n, 3) positions of the markers that both have, in the same order."""
    places = [
        {one.label: one.position_m for one in seen.markers if one.position_m is not None}
        for seen in (earlier, later)
    ]
    names = [name for name in places[0] if name in places[1]]
    first, second = (np.array([place[name] for name in names]) for place in places)
    return first, second


def _anchor(
    middle_m: FloatArray, seen: PlacedMarkers, camera: Intrinsics, *, on_floor: bool
) -> _Anchor:
    """Return where the body stands; `middle_m` is in the colour camera's axes."""
    calibration = seen.calibration
    up = vertical_of(calibration, seen.rotation_deg).up
    place_m = middle_m
    floor = calibration.floor
    if on_floor and floor is not None:
        color_from_depth = calibration.color_from_depth
        place_m = color_from_depth.apply(floor.project(color_from_depth.inverse().apply(middle_m)))
    pixel, above = project(np.stack([middle_m, middle_m + STEP_M * up]), camera)
    along = above - pixel
    return _Anchor(
        project(place_m, camera),
        along / np.linalg.norm(along),
        math.sqrt(camera.fx * camera.fy) / float(middle_m[2]),
    )


def _similarity(earlier: _Anchor, later: _Anchor) -> FloatArray:
    """Return the (2, 3) matrix that lays one anchor on the other."""
    scale = later.px_per_m / earlier.px_per_m
    cosine = float(earlier.up @ later.up)
    sine = float(earlier.up[0] * later.up[1] - earlier.up[1] * later.up[0])
    turn = scale * np.array([[cosine, -sine], [sine, cosine]])
    return np.column_stack([turn, later.pixel - turn @ earlier.pixel])


def _resized(first: CameraCalibration, second: CameraCalibration) -> FloatArray:
    """Return the (2, 3) matrix that makes one picture as large as the other, middle on middle."""
    scale = min(second.width / first.width, second.height / first.height)
    offset = [
        (second.width - 1 - scale * (first.width - 1)) / 2,
        (second.height - 1 - scale * (first.height - 1)) / 2,
    ]
    return np.array([[scale, 0.0, offset[0]], [0.0, scale, offset[1]]])
