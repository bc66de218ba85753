"""The same view in the earlier session and in this one, side by side."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import UInt8Array
from adibas.data.report import CaptureReport, SessionReport
from adibas.data.views import VIEWS
from adibas.reports.facts import view_name
from adibas.reports.pictures import draw_markers, picture_of

GAP_PX = 12
WHITE = 255


@dataclass(frozen=True, slots=True, eq=False)
class PicturePair:
    """One view before and now, (H, W, 3) pixels with the markers; the days are ISO dates."""

    name: str
    before_rgb: UInt8Array
    now_rgb: UInt8Array
    before_day: str
    now_day: str

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
            compared.since_utc.date().isoformat(),
            report.started_utc.date().isoformat(),
        )
        for view in ("", *VIEWS)
        if view in before and view in now
    )
