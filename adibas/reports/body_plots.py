"""The back in pictures: its asymmetry in colours, the profile, deviation and rotation."""

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from adibas.arrays import FloatArray
from adibas.pipeline.back import Back
from adibas.reports.vector_figures import new_figure
from adibas.surface.asymmetry import asymmetry_m
from adibas.texts import translate as _

LINE, FAINT, DARK, ACCENT = "#16212B", "#C3CCD4", "#0072B2", "#D55E00"
FONT_PT, TITLE_PT = 6.5, 7.5
MM_PER_M = 1000.0
LARGEST_MM = 20.0
"""Asymmetry at which the colours end."""
TANGENT_M = 0.06
STEP_M = 0.004
HALF_WIDTH_MM = 210.0
NARROW_LETTERS = 18
LEAST_ASIDE_MM, LEAST_TURN_DEG = 15.0, 6.0
"""An axis shows no less, so that noise does not look like a deformity."""


def back_figure(back: Back, width_pt: float, height_pt: float) -> Figure:
    """Draw the asymmetry map, the profile from the side, and what deviates."""
    figure = new_figure(width_pt, height_pt)
    whole, side, behind, turned = figure.subplots(
        1, 4, sharey=True, width_ratios=[1.5, 1.0, 0.7, 0.7]
    )
    image = _map(whole, back)
    # Below all of them, so that a height is at the same place of the page in each.
    bar = figure.colorbar(
        image, ax=(whole, side, behind, turned), location="bottom", shrink=0.35, anchor=(0.0, 0.0)
    )
    bar.set_label(_("further back than the other side [mm]"), fontsize=FONT_PT)
    bar.ax.tick_params(labelsize=FONT_PT)
    _profile(side, back)
    y_m = back.profile.heights_m(STEP_M)
    _curve(behind, (1e3 * back.line.at(y_m), y_m), LEAST_ASIDE_MM)
    behind.set_xlabel(_narrow(_("to the right [mm]")), fontsize=FONT_PT)
    finish(behind, _narrow(_("Line of the spine")))
    _curve(turned, (np.degrees(back.profile.rotation_rad(y_m)), y_m), LEAST_TURN_DEG)
    turned.set_xlabel(_narrow(_("right side back [°]")), fontsize=FONT_PT)
    finish(turned, _narrow(_("Surface rotation")))
    whole.set_ylabel(_("Height over the floor [m]"), fontsize=FONT_PT)
    return figure


def _map(axes: Axes, back: Back) -> AxesImage:
    grid = back.grid
    image = axes.imshow(
        1e3 * asymmetry_m(grid, back.line),
        extent=(1e3 * grid.x_m[0], 1e3 * grid.x_m[-1], grid.y_m[-1], grid.y_m[0]),
        cmap="RdBu_r",
        vmin=-LARGEST_MM,
        vmax=LARGEST_MM,
        aspect="auto",
    )
    axes.plot(1e3 * back.line.x_m, back.line.y_m, color=LINE, linewidth=1.0)
    for marker in back.markers.values():
        axes.plot(*(marker.position_m[:2] * (1e3, 1.0)), "o", color=ACCENT, markersize=3)
    finish(axes, _("Asymmetry, seen from behind"))
    # So wide, or as the height of the page asks for.
    axes.set_xlim(-HALF_WIDTH_MM, HALF_WIDTH_MM, auto=True)
    axes.set_aspect(MM_PER_M, adjustable="datalim")
    return image


def _profile(axes: Axes, back: Back) -> None:
    profile = back.profile
    y_m = profile.heights_m(STEP_M)
    axes.plot(1e3 * profile.back_m(y_m), y_m, color=DARK, linewidth=1.2)
    shape = back.shape
    if shape is not None:
        for name, at_m, is_turn in shape.places:
            at = np.array([at_m])
            back_m, slope = float(profile.back_m(at)[0]), float(profile.inclination(at)[0])
            axes.plot(1e3 * back_m, at_m, "o", color=ACCENT, markersize=3)
            axes.annotate(
                name, (1e3 * back_m, at_m), (4, 2), textcoords="offset points", fontsize=FONT_PT
            )
            if is_turn:
                ends_m = np.array([at_m - TANGENT_M, at_m + TANGENT_M])
                axes.plot(
                    1e3 * (back_m + slope * (ends_m - at_m)), ends_m, color=ACCENT, linewidth=0.7
                )
    axes.set_xlabel(_("to the back [mm]"), fontsize=FONT_PT)
    finish(axes, _("Profile of the spine"))


def _curve(axes: Axes, points: tuple[FloatArray, FloatArray], least: float) -> None:
    axes.plot(*points, color=DARK, linewidth=1.2)
    axes.axvline(0.0, color=FAINT, linewidth=0.6, zorder=0)
    reach = max(least, 1.1 * float(np.abs(points[0]).max()))
    axes.set_xlim(-reach, reach)


def _narrow(text: str) -> str:
    """Return a text in lines that a narrow plot has room for."""
    return textwrap.fill(text, NARROW_LETTERS)


def finish(axes: Axes, title: str) -> None:
    """Give axes their title, a grid and small numbers."""
    axes.set_title(title, fontsize=TITLE_PT, color=LINE)
    axes.grid(visible=True, color=FAINT, linewidth=0.3)
    axes.tick_params(labelsize=FONT_PT, length=2)
