"""Joint angles and their speeds over time, the sides of one joint in one small plot."""

import io
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from adibas.arrays import FloatArray, UInt8Array
from adibas.data.movement import AngleCurve, Movement
from adibas.reports.movement_texts import JOINT_MOTIONS, SIDES, by_motion, split_side
from adibas.reports.vector_figures import new_figure
from adibas.texts import translate as _

LEFT, RIGHT, MIDDLE, FAINT = "#0072B2", "#D55E00", "#16212B", "#C3CCD4"
COLORS = {"left": LEFT, "right": RIGHT, "": MIDDLE}
STYLES = {"left": "-", "right": "--", "": "-"}
"""Sides differ in grey print, too."""
N_ACROSS = 2
FONT_PT, TITLE_PT = 6.0, 7.0
DOTS_PER_INCH = 130


@dataclass(frozen=True, slots=True)
class Quantity:
    """What is drawn of each curve.

    Attributes
    ----------
    of_curve : callable
        The (T,) values of a curve.
    unit : str
        Behind the name of the motion.
    least_span : float
        An axis shows no less, so that noise does not look like movement.
    """

    of_curve: Callable[[AngleCurve], FloatArray]
    unit: str
    least_span: float


ANGLE = Quantity(lambda curve: curve.deg, "°", 20.0)
SPEED = Quantity(lambda curve: curve.speed_deg_s, "°/s", 40.0)


def movement_figure(
    movement: Movement, width_pt: float, height_pt: float, quantity: Quantity = ANGLE
) -> Figure:
    """Draw every motion that is known anywhere, by seconds.

    Speeds have a band about zero: as fast as noise alone makes the noisier of the two sides.
    """
    figure = new_figure(width_pt, height_pt)
    motions = {
        motion: curves
        for motion, curves in by_motion(movement).items()
        if any(np.isfinite(quantity.of_curve(curve)).any() for curve in curves)
    }
    n_down = max(-(-len(motions) // N_ACROSS), 1)
    for place, (motion, curves) in enumerate(motions.items(), 1):
        axes = figure.add_subplot(n_down, N_ACROSS, place)
        _draw(axes, movement.times_s, curves, quantity)
        if quantity is SPEED:
            _draw_noise(axes, movement, curves)
        axes.set_title(
            f"{_(JOINT_MOTIONS[motion])} [{quantity.unit}]", fontsize=TITLE_PT, color=MIDDLE
        )
        if place > len(motions) - N_ACROSS:
            axes.set_xlabel(_("Time [s]"), fontsize=FONT_PT)
    return figure


def movement_picture(
    movement: Movement, width_pt: float, height_pt: float, quantity: Quantity = ANGLE
) -> UInt8Array:
    """Return the same as (H, W, 3) pixels."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    figure = movement_figure(movement, width_pt, height_pt, quantity)
    FigureCanvasAgg(figure)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DOTS_PER_INCH)
    picture: UInt8Array = np.array(Image.open(file).convert("RGB"))
    return picture


def _draw(
    axes: Axes, times_s: FloatArray, curves: Sequence[AngleCurve], quantity: Quantity
) -> None:
    for curve in curves:
        side, _motion = split_side(curve.name)
        axes.plot(
            times_s,
            quantity.of_curve(curve),
            STYLES[side],
            color=COLORS[side],
            linewidth=0.9,
            label=_(SIDES[side]) if side else None,
        )
    low, high = axes.get_ylim()
    middle, half = (low + high) / 2, max(high - low, quantity.least_span) / 2
    axes.set_ylim(middle - half, middle + half)
    axes.axhline(0.0, color=FAINT, linewidth=0.5, zorder=0)
    axes.grid(visible=True, color=FAINT, linewidth=0.3)
    axes.tick_params(labelsize=FONT_PT, length=2)
    for spine in axes.spines.values():
        spine.set_linewidth(0.4)
    if len(curves) > 1:
        axes.legend(fontsize=FONT_PT, frameon=False, loc="best", handlelength=2.4)


def _draw_noise(axes: Axes, movement: Movement, curves: Sequence[AngleCurve]) -> None:
    names = {curve.name for curve in curves}
    known = [
        one.noise_deg_s
        for one in movement.ranges
        if one.name in names and math.isfinite(one.noise_deg_s)
    ]
    if known:
        axes.axhspan(-max(known), max(known), color=FAINT, alpha=0.4, linewidth=0.0, zorder=0)
