"""The same view in the earlier session and in this one: side by side, and overlaid."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from adibas.arrays import UInt8Array
from adibas.clock import day_here
from adibas.data.markers import Marker
from adibas.data.posture import PostureAnalysis
from adibas.data.report import CaptureReport, PictureChoice, SessionComparison, SessionReport
from adibas.data.views import VIEWS
from adibas.pipeline.picture_overlay import (
    OverlayWay,
    PictureOverlay,
    PlacedMarkers,
    lay_over,
    mixed,
)
from adibas.reports.facts import view_name
from adibas.reports.pictures import draw_markers, picture_of
from adibas.texts import message

GAP_PX = 12
WHITE = 255
HALF = 0.5
EARLIER_RGB = (204, 121, 167)
"""Of the palette of `adibas.reports.pictures`, and of none of its rings."""
OVERLAY_LEGEND = message("Purple rings: the earlier markers; lines go to where they are now.")
LINE_SHARE = 1 / 500
"""Of the picture's height."""


@dataclass(frozen=True, slots=True, eq=False)
class PicturePair:
    """One view before and now, (H, W, 3) pixels with the markers; the days are ISO dates.

    Attributes
    ----------
    both_rgb : (H, W, 3) uint8 array
        The earlier picture laid over the one of now, with the markers of both.
    way : OverlayWay
        What lies on one another in it.
    """

    name: str
    before_rgb: UInt8Array
    now_rgb: UInt8Array
    before_day: str
    now_day: str
    both_rgb: UInt8Array
    way: OverlayWay

    @property
    def beside_rgb(self) -> UInt8Array:
        """Return both in one picture of equal heights, the earlier at the left."""
        gap = np.full((self.now_rgb.shape[0], GAP_PX, 3), WHITE, np.uint8)
        return np.hstack([self.before_rgb, gap, self.now_rgb])


def picture_pairs(report: SessionReport, height_px: int) -> tuple[PicturePair, ...]:
    """Return the views that both sessions have; of several captures of one the last counts.

    Raises
    ------
    ReportError
        The pictures cannot be as the report asks.
    """
    compared = report.comparison
    if compared is None or report.started_utc is None:
        return ()
    before = {one.analysis.view: one for one in compared.earlier}
    now = {one.analysis.view: one for one in report.captures}

    def drawn(capture: CaptureReport, rotation_deg: int) -> UInt8Array:
        picture = picture_of(capture.analysis, report.pictures, rotation_deg, is_cropped=True)
        return draw_markers(picture, height_px)

    return tuple(
        PicturePair(
            view_name(view),
            drawn(before[view], compared.earlier_rotation_deg),
            drawn(now[view], report.rotation_deg),
            day_here(compared.since_utc).isoformat(),
            day_here(report.started_utc).isoformat(),
            *_overlaid(report, compared, (before[view], now[view]), height_px),
        )
        for view in ("", *VIEWS)
        if view in before and view in now
    )


def _overlaid(
    report: SessionReport,
    compared: SessionComparison,
    captures: tuple[CaptureReport, CaptureReport],
    height_px: int,
) -> tuple[UInt8Array, OverlayWay]:
    """Return both pictures of a view in one, as the report wants them, and what lies on what."""
    before, now = (one.analysis for one in captures)
    overlay = lay_over(
        PlacedMarkers(before.markers, before.calibration, compared.earlier_rotation_deg),
        PlacedMarkers(now.markers, now.calibration, report.rotation_deg),
    )
    before_rgb = _as_taken(before, report.pictures, compared.earlier_rotation_deg)
    now_rgb = _as_taken(now, report.pictures, report.rotation_deg)
    both_rgb = mixed(overlay.laid(before_rgb, now_rgb.shape), now_rgb, HALF)
    _draw_earlier(both_rgb, overlay, before.markers, now.markers)
    shown = replace(now, picture_rgb=both_rgb)
    picture = picture_of(shown, rotation_deg=report.rotation_deg, is_cropped=True)
    return draw_markers(picture, height_px), overlay.way


def _as_taken(analysis: PostureAnalysis, choice: PictureChoice, rotation_deg: int) -> UInt8Array:
    """Return the picture as the reader wants it, turned as the camera took it."""
    upright = picture_of(analysis, choice, rotation_deg).pixels_rgb
    return np.ascontiguousarray(np.rot90(upright, rotation_deg // 90))


def _draw_earlier(
    both_rgb: UInt8Array,
    overlay: PictureOverlay,
    before: tuple[Marker, ...],
    now: tuple[Marker, ...],
) -> None:
    """Draw a ring about each earlier marker, and a line to the one of the same name."""
    places = {one.label: (round(one.u), round(one.v)) for one in now}
    width = max(1, round(both_rgb.shape[0] * LINE_SHARE))
    for one in before:
        u, v = (round(value) for value in overlay.moved(one.u, one.v))
        if one.label in places:
            cv2.line(both_rgb, (u, v), places[one.label], EARLIER_RGB, width, cv2.LINE_AA)
        radius = max(2, round(one.radius_px))
        cv2.circle(both_rgb, (u, v), radius, EARLIER_RGB, width, cv2.LINE_AA)
