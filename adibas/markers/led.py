"""LED markers: bright blobs in an infrared-filtered, dark image.

Source: thesis, section 6.1.1.2.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array, UInt8Array, check_shape
from adibas.data.markers import RejectedBlob
from adibas.markers.blobs import Blob, BlobParams, connected_groups, judge, measure_blobs
from adibas.markers.detection import Detections, bounding_box


@dataclass(frozen=True, slots=True)
class LedParams:
    """How LEDs are found.

    Attributes
    ----------
    least_brightness : float
        Of an LED's brightest pixel over the scene's median, grey levels of 255: 60.
    rim_share : float
        Of the brightest pixel of the image; what is brighter belongs to an LED: 0.35.
    greatest_share : float
        Of the body; where more is that bright, the image is no dark one.
    blobs : BlobParams
        Size and shape; bloom makes LEDs look larger than they are.
    """

    least_brightness: float = 60.0
    rim_share: float = 0.35
    greatest_share: float = 0.05
    blobs: BlobParams = field(default_factory=BlobParams)


def find_led_markers(
    color_rgb: UInt8Array,
    body: BoolArray,
    depth_m: Float32Array,
    focal_px: float,
    params: LedParams,
) -> Detections:
    """Find the bright blobs on the body.

    Parameters
    ----------
    color_rgb : (H, W, 3) array
        The dark image.
    body : (H, W) bool array
        The person in it.
    depth_m : (H, W) array
        Depth registered to it, NaN = unknown: for the size of things.
    focal_px : float
        Of the colour camera.
    """
    check_shape("body", body, color_rgb.shape[:2])
    window = bounding_box(body)
    if window is None:
        return Detections((), (), 0.0)
    inside = body[window]
    brightness = color_rgb[window].max(axis=2).astype(np.float32)
    dark = float(np.median(brightness[inside]))
    brightest = float(brightness[inside].max())
    if brightest - dark < params.least_brightness:
        return Detections((), (), 0.0)
    level = dark + params.rim_share * (brightest - dark)
    bright = inside & (brightness > level)
    matched = float(bright[inside].mean())
    if matched > params.greatest_share:
        return Detections((), (), matched)
    return _judged(brightness, inside, bright, window, (depth_m, focal_px), params)


def _judged(
    brightness: Float32Array,
    inside: BoolArray,
    bright: BoolArray,
    window: tuple[slice, slice],
    size: tuple[Float32Array, float],
    params: LedParams,
) -> Detections:
    offset_uv = np.array([window[1].start, window[0].start], float)
    # A saturated LED is a plateau: the blur makes its middle the brightest place again.
    smooth = cv2.GaussianBlur(brightness, (0, 0), 1.0).astype(np.float32)[..., None]
    blobs: list[Blob] = []
    rejected: list[RejectedBlob] = []
    groups = connected_groups(bright, np.zeros(bright.shape, np.bool_))
    for blob in measure_blobs(smooth, 256.0 - smooth[..., 0], groups):
        found = judge(blob, offset_uv, *size, params.blobs)
        if isinstance(found, Blob):
            blobs.append(found)
        elif found is not None:
            rejected.append(found)
    return Detections(tuple(blobs), tuple(rejected), float(bright[inside].mean()))
