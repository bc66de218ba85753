"""One picture held still, to learn a colour on and to see at once what it finds."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, Float32Array, UInt8Array
from adibas.data.calibration import RgbdCalibration
from adibas.markers.detection import DetectionParams, Detections, find_color_markers
from adibas.markers.led import LedParams, find_led_markers
from adibas.pipeline.live_frames import LiveFrame
from adibas.pipeline.posture import MarkerTarget

USUAL_FOCAL_SHARE = 0.82
"""Focal length over picture width of PrimeSense cameras, for a picture of unknown origin."""


@dataclass(frozen=True, slots=True, eq=False)
class FrozenPicture:
    """A colour picture and what is known of it.

    Attributes
    ----------
    color_rgb : (H, W, 3) uint8 array
        The picture.
    outline : (H, W) bool array or None
        The person; None where nobody is seen or no depth is known: markers may be anywhere.
    depth_in_color_m : (H, W) float32 array or None
        Depth registered to it, metres.
    focal_px : float
        Of its camera.
    """

    color_rgb: UInt8Array
    outline: BoolArray | None
    depth_in_color_m: Float32Array | None
    focal_px: float

    def find(self, target: MarkerTarget, params: DetectionParams) -> Detections:
        """Return the markers in it."""
        shape = self.color_rgb.shape[:2]
        inside = np.ones(shape, np.bool_) if self.outline is None else self.outline
        depth_m = self.depth_in_color_m
        if depth_m is None:
            depth_m = np.full(shape, np.nan, np.float32)
        if isinstance(target, LedParams):
            return find_led_markers(self.color_rgb, inside, depth_m, self.focal_px, target)
        return find_color_markers(self.color_rgb, inside, depth_m, self.focal_px, target, params)


def freeze(frame: LiveFrame, calibration: RgbdCalibration | None) -> FrozenPicture | None:
    """Hold a live frame still; None where it has no colour."""
    if frame.color_rgb is None:
        return None
    camera = None if calibration is None else calibration.color
    focal_px = usual_focal_px(frame.color_rgb) if camera is None else camera.intrinsics.fx
    return FrozenPicture(frame.color_rgb, frame.outline, frame.depth_in_color_m, focal_px)


def picture_alone(color_rgb: UInt8Array) -> FrozenPicture:
    """Hold a picture of a file still, of which nothing more is known."""
    return FrozenPicture(color_rgb, None, None, usual_focal_px(color_rgb))


def usual_focal_px(color_rgb: UInt8Array) -> float:
    """Return the focal length that depth cameras of this kind have, pixels."""
    larger_side: int = max(color_rgb.shape[:2])
    return USUAL_FOCAL_SHARE * larger_side
