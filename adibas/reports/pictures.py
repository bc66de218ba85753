"""Frames with the markers drawn, for reports."""

import cv2
import numpy as np

from adibas.arrays import UInt8Array
from adibas.data.posture import PostureAnalysis

# Okabe & Ito's palette: told apart by colour-blind readers too.
WITH_POSITION_RGB = (0, 158, 255)
WITHOUT_POSITION_RGB = (230, 159, 0)
OUTLINE_RGB = (0, 0, 0)
TEXT_RGB = (255, 255, 255)
FONT = cv2.FONT_HERSHEY_SIMPLEX


def draw_markers(analysis: PostureAnalysis, height_px: int) -> UInt8Array:
    """Return the burst's picture, `height_px` high, with a named ring around every marker.

    Blue rings have a position in space, orange ones have none.
    """
    picture = analysis.picture_rgb
    scale = height_px / picture.shape[0]
    size = (round(picture.shape[1] * scale), height_px)
    canvas = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    for marker in analysis.markers:
        color = WITHOUT_POSITION_RGB if marker.position_m is None else WITH_POSITION_RGB
        # A pixel's centre is at whole numbers: shift by half a pixel when scaling.
        centre = (
            round((marker.u + 0.5) * scale - 0.5),
            round((marker.v + 0.5) * scale - 0.5),
        )
        radius = max(6, round(marker.radius_px * scale) + 4)
        place = (centre[0] + radius + 3, centre[1] + 5)
        for ring_rgb, text_rgb, thickness in ((OUTLINE_RGB, OUTLINE_RGB, 3), (color, TEXT_RGB, 1)):
            cv2.circle(canvas, centre, radius, ring_rgb, thickness, cv2.LINE_AA)
            cv2.putText(canvas, marker.label, place, FONT, 0.5, text_rgb, thickness, cv2.LINE_AA)
    return np.ascontiguousarray(canvas, np.uint8)
