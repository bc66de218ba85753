"""The plots of a calibration's report, as figures without any bitmap (see `vector_figures`).

Each function takes its size on the page in points. Numbers are written as the language in use
writes them while the figure is drawn.
"""

import textwrap
from collections.abc import Sequence
from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import FuncFormatter, MaxNLocator

from adibas.calibration.quality import map_residuals
from adibas.data.calibration import CameraCalibration
from adibas.data.calibration_report import CalibrationReport
from adibas.data.camera_fit import CameraFit
from adibas.reports.calibration_facts import plain_number
from adibas.reports.calibration_rows import MM_PER_M, SURE, image_rows, uncertainty_map
from adibas.reports.vector_figures import POINTS_PER_INCH, new_figure
from adibas.texts import decimal_text
from adibas.texts import translate as _

INK, FAINT, EMPTY = "#16212B", "#C3CCD4", "#FBE3C6"
BLUE, ORANGE, GREEN = "#0072B2", "#E69F00", "#009E73"
SMALL_PT, TITLE_PT = 6.0, 7.5
MOST_DOTS = 4000
MOST_TICKS = 25
BRIGHTEST = 0.85
"""Of the image's darkest blue: numbers on it must be read."""

PLACE_M = 2.0
"""Where the map of uncertainty is drawn for: a patient stands there."""

FINE_CELLS = (31, 41)
N_CONTOURS = 6
LARGEST_ARROW = 0.45
"""Of a cell's width, for the longest arrow."""

LEAST_POLAR_DEG = 50.0
HEADROOM = 1.25
"""Over the greatest value, for a legend."""

LONGEST_TITLE = 0.26
"""Characters of a title in a point of the figure's width."""


def coverage_figure(fit: CameraFit, width_pt: float, height_pt: float) -> Figure:
    """Draw how many corners were seen in each part of the image."""
    figure, axes = _image_axes(fit.camera, width_pt, height_pt)
    counts = map_residuals(fit).counts
    step_u, step_v = _steps(fit.camera, counts.shape)
    most = max(int(counts.max()), 1)
    for (row, column), count in np.ndenumerate(counts):
        corner = (column * step_u - 0.5, row * step_v - 0.5)
        color = _blue(BRIGHTEST * count / most) if count else EMPTY
        axes.add_patch(
            Rectangle(corner, step_u, step_v, facecolor=color, edgecolor=FAINT, linewidth=0.3)
        )
        axes.text(
            corner[0] + step_u / 2,
            corner[1] + step_v / 2,
            str(count),
            ha="center",
            va="center",
            fontsize=SMALL_PT,
            color=INK,
        )
    _set_title(axes, _("Corners in each part of the image"))
    return figure


def residual_map_figure(fit: CameraFit, width_pt: float, height_pt: float) -> Figure:
    """Draw the mean error of each part of the image as an arrow, and its size as a shade."""
    figure, axes = _image_axes(fit.camera, width_pt, height_pt)
    found = map_residuals(fit)
    step_u, step_v = _steps(fit.camera, found.counts.shape)
    greatest = float(np.nanmax(found.rms_px))
    for (row, column), rms_px in np.ndenumerate(found.rms_px):
        if np.isfinite(rms_px):
            corner = (column * step_u - 0.5, row * step_v - 0.5)
            shade = _blue(BRIGHTEST * rms_px / greatest)
            axes.add_patch(Rectangle(corner, step_u, step_v, facecolor=shade, linewidth=0))
    means = found.means_px.reshape(-1, 2)
    rows, columns = np.divmod(np.arange(len(means)), found.counts.shape[1])
    longest = float(np.nanmax(np.hypot(*means.T)))
    arrows = means * LARGEST_ARROW * min(step_u, step_v) / longest
    is_seen = np.isfinite(means).all(axis=1)
    for row, column, (du, dv) in zip(
        rows[is_seen], columns[is_seen], arrows[is_seen].tolist(), strict=True
    ):
        middle = ((column + 0.5) * step_u - 0.5, (row + 0.5) * step_v - 0.5)
        axes.annotate(
            "",
            (middle[0] + du, middle[1] + dv),
            (middle[0] - du, middle[1] - dv),
            arrowprops={
                "arrowstyle": "->",
                "color": INK,
                "linewidth": 0.6,
                "mutation_scale": 4,
                "shrinkA": 0,
                "shrinkB": 0,
            },
        )
    text = _("Error left [px]: longest arrow {mean}, darkest part {rms} (rms)").format(
        mean=decimal_text(longest, 3), rms=decimal_text(greatest, 3)
    )
    _set_title(axes, text)
    return figure


def uncertainty_figure(fit: CameraFit, width_pt: float, height_pt: float) -> Figure:
    """Draw where a point that is seen at a patient's distance is, plus or minus, as contours."""
    figure, axes = _image_axes(fit.camera, width_pt, height_pt)
    found = uncertainty_map(fit, PLACE_M, FINE_CELLS)
    sure_mm = np.ma.masked_invalid(MM_PER_M * SURE * found.sd_m)
    us, vs = found.pixels[0, :, 0], found.pixels[:, 0, 1]
    low, high = float(sure_mm.min()), float(sure_mm.max())
    levels = np.geomspace(max(low, 1e-3), max(high, 2e-3), N_CONTOURS + 2)
    colors = [_blue(shade) for shade in np.linspace(0.05, BRIGHTEST, N_CONTOURS + 1)]
    axes.contourf(us, vs, sure_mm, levels=levels, colors=colors)
    lines = axes.contour(us, vs, sure_mm, levels=levels[1:-1], colors=[INK], linewidths=0.5)
    axes.clabel(lines, fontsize=SMALL_PT, fmt=lambda value: decimal_text(value, 2))
    text = _("Where a point seen at {distance} m is: 95 %, plus or minus [mm]").format(
        distance=decimal_text(PLACE_M, 0)
    )
    _set_title(axes, text)
    return figure


def tilt_figure(report: CalibrationReport, width_pt: float, height_pt: float) -> Figure:
    """Draw every board by its tilt (from the middle) and by where it leans away to."""
    figure = new_figure(width_pt, height_pt)
    axes = cast("PolarAxes", figure.add_subplot(projection="polar"))
    rows = [row for row in image_rows(report) if row.tilt_deg is not None]
    tilts = [row.tilt_deg or 0.0 for row in rows]
    leans = np.radians([row.lean_deg or 0.0 for row in rows])
    axes.plot(leans, tilts, "o", color=BLUE, markersize=3, clip_on=False)
    _label_sides(axes, max([LEAST_POLAR_DEG, *tilts]))
    _set_title(axes, _("Tilt of each board [deg], and where it leans away to"))
    return figure


def image_error_figure(report: CalibrationReport, width_pt: float, height_pt: float) -> Figure:
    """Draw the error of every image, by its number: rms as a bar, the largest as a dash."""
    figure, axes = plain_axes(width_pt, height_pt, _("Error of each image [px], by its number"))
    rows = [row for row in image_rows(report) if row.rms_px is not None]
    kinds = ((BLUE, _("rms"), False), (ORANGE, _("rms, took no part"), True))
    for color, name, is_outlier in kinds:
        some = [row for row in rows if row.is_outlier is is_outlier]
        if some:
            heights = [row.rms_px or 0.0 for row in some]
            axes.bar([row.number for row in some], heights, color=color, label=name, width=0.7)
    largest = [row.max_px or 0.0 for row in rows]
    numbers = [row.number for row in rows]
    axes.plot(
        numbers, largest, "_", color=INK, markersize=5, markeredgewidth=0.8, label=_("largest")
    )
    axes.set_ylim(0.0, HEADROOM * max([*largest, 1e-3]))
    axes.set_xlim(0.4, max(len(report.images), 1) + 0.6)
    axes.set_xticks(_some(numbers))
    axes.legend(fontsize=SMALL_PT, frameon=False, ncols=3, loc="upper right", borderaxespad=0.1)
    return figure


def residual_scatter_figure(fit: CameraFit, width_pt: float, height_pt: float) -> Figure:
    """Draw the error of every corner that took part, found minus computed."""
    figure, axes = plain_axes(width_pt, height_pt, _("Error of each corner [px]: right and down"))
    residuals = np.concatenate([view.residuals_px[view.is_used] for view in fit.used_views])
    shown = residuals[:: -(-len(residuals) // MOST_DOTS)]
    axes.plot(*shown.T, "s", color=BLUE, markersize=0.9, markeredgewidth=0)
    limit = 1.05 * float(np.abs(residuals).max())
    axes.axhline(0.0, color=FAINT, linewidth=0.5, zorder=0)
    axes.axvline(0.0, color=FAINT, linewidth=0.5, zorder=0)
    axes.set_xlim(-limit, limit)
    axes.set_ylim(limit, -limit)
    axes.set_aspect("equal", adjustable="box")
    return figure


def q_figure(report: CalibrationReport, width_pt: float, height_pt: float) -> Figure:
    """Draw Q_k of every image by its distance."""
    figure, axes = plain_axes(
        width_pt, height_pt, _("Error on the board, Q_k [mm], by distance [m]")
    )
    rows = [row for row in image_rows(report) if row.q_mm is not None]
    places = [row.distance_m or 0.0 for row in rows]
    sizes = [row.q_mm or 0.0 for row in rows]
    axes.plot(places, sizes, "o", color=GREEN, markersize=3)
    axes.set_ylim(0.0, HEADROOM * max([*sizes, 1e-3]))
    return figure


def plain_axes(width_pt: float, height_pt: float, title: str) -> tuple[Figure, Axes]:
    """Return axes with a title, small numbers, and nothing that is not needed."""
    figure = new_figure(width_pt, height_pt)
    axes = figure.add_subplot()
    _set_title(axes, title)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(6))
        axis.set_major_formatter(FuncFormatter(lambda value, _at: plain_number(value)))
    axes.tick_params(labelsize=SMALL_PT, colors=INK, length=2, width=0.4)
    for name, spine in axes.spines.items():
        spine.set_visible(name in {"left", "bottom"})
        spine.set_color(FAINT)
    axes.grid(visible=True, axis="y", color=FAINT, linewidth=0.3)
    axes.set_axisbelow(True)
    return figure, axes


def _set_title(axes: Axes, text: str) -> None:
    """Write a title, in several lines where one has no room."""
    figure = axes.get_figure(root=True)
    width_pt = figure.get_figwidth() * POINTS_PER_INCH if figure is not None else 0.0
    lines = textwrap.fill(text, max(int(LONGEST_TITLE * width_pt), 1))
    axes.set_title(lines, fontsize=TITLE_PT, color=INK)


def _image_axes(
    camera: CameraCalibration, width_pt: float, height_pt: float
) -> tuple[Figure, Axes]:
    """Return axes that are the image: v down, its pixels square."""
    figure = new_figure(width_pt, height_pt)
    axes = figure.add_subplot()
    axes.set_xlim(-0.5, camera.width - 0.5)
    axes.set_ylim(camera.height - 0.5, -0.5)
    axes.set_aspect("equal", adjustable="box")
    axes.set_xticks([0, camera.width - 1])
    axes.set_yticks([0, camera.height - 1])
    axes.tick_params(labelsize=SMALL_PT, colors=INK, length=2, width=0.4)
    for spine in axes.spines.values():
        spine.set_color(FAINT)
    return figure, axes


def _label_sides(axes: PolarAxes, largest_deg: float) -> None:
    """Turn polar axes as the image lies, and name its sides."""
    axes.set_theta_direction(-1)
    axes.set_rlim(0.0, 1.05 * largest_deg)
    axes.set_thetagrids(
        (0, 90, 180, 270), (_("to the right"), _("down"), _("to the left"), _("up"))
    )
    axes.set_rgrids(
        tuple(np.arange(15.0, largest_deg, 15.0)), angle=-45, fontsize=SMALL_PT, color=INK
    )
    axes.tick_params(labelsize=SMALL_PT, colors=INK, pad=5)
    axes.grid(color=FAINT, linewidth=0.4)
    axes.spines["polar"].set_color(FAINT)


def _steps(camera: CameraCalibration, shape: Sequence[int]) -> tuple[float, float]:
    """Return width and height of a cell in pixels."""
    return camera.width / shape[1], camera.height / shape[0]


def _some(numbers: Sequence[int]) -> list[int]:
    """Return as many of the numbers as can be written side by side."""
    step = -(-max(len(numbers), 1) // MOST_TICKS)
    return list(numbers)[::step]


def _blue(share: float) -> tuple[float, float, float]:
    """Return white for 0 and the blue of the reports for 1."""
    white, blue = np.ones(3), np.array([0x4A, 0x90, 0xC8]) / 255.0
    red, green, full = (white + share * (blue - white)).tolist()
    return red, green, full
