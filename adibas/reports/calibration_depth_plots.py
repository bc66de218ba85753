"""The plots of the depth camera in a calibration's report."""

from matplotlib.figure import Figure

from adibas.data.calibration_report import DepthReport
from adibas.reports.calibration_depth_rows import bias_rows, shot_rows
from adibas.reports.calibration_plots import BLUE, FAINT, ORANGE, SMALL_PT, plain_axes
from adibas.texts import translate as _

BAND = "#BFD9EA"


def bias_figure(depth: DepthReport, width_pt: float, height_pt: float) -> Figure:
    """Draw what is added to a measured depth, with its 95 % interval."""
    figure, axes = plain_axes(
        width_pt, height_pt, _("Added to a measured depth [mm], by depth [m], with 95 %")
    )
    rows = list(bias_rows(depth))
    places = [row.measured_m for row in rows]
    sure = [row for row in rows if row.low_mm is not None and row.high_mm is not None]
    axes.fill_between(
        [row.measured_m for row in sure],
        [row.low_mm or 0.0 for row in sure],
        [row.high_mm or 0.0 for row in sure],
        color=BAND,
        linewidth=0,
    )
    axes.plot(places, [row.added_mm for row in rows], color=BLUE, linewidth=1.0)
    axes.axhline(0.0, color=FAINT, linewidth=0.5)
    return figure


def shots_figure(depth: DepthReport, width_pt: float, height_pt: float) -> Figure:
    """Draw what is left of the error of each board's depth, by its distance."""
    figure, axes = plain_axes(
        width_pt, height_pt, _("Error of each board's depth that is left [mm], by distance [m]")
    )
    rows = [row for row in shot_rows(depth) if row.error_mm is not None]
    kinds = ((BLUE, _("took part"), False), (ORANGE, _("contradicts the others"), True))
    for color, name, is_outlier in kinds:
        some = [row for row in rows if row.is_outlier is is_outlier]
        if some:
            axes.errorbar(
                [row.distance_m for row in some],
                [row.error_mm or 0.0 for row in some],
                [row.noise_mm or 0.0 for row in some],
                fmt="o",
                color=color,
                markersize=3,
                elinewidth=0.6,
                label=name,
            )
    axes.axhline(0.0, color=FAINT, linewidth=0.5)
    if any(row.is_outlier for row in rows):
        axes.legend(fontsize=SMALL_PT, frameon=False)
    return figure
