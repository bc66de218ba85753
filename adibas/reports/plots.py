"""Plots for reports, drawn by matplotlib's Figure; pyplot's global state is never used."""

import io
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from adibas.arrays import FloatArray, UInt8Array
from adibas.data.landmark_texts import landmark_text
from adibas.data.report import CaptureReport
from adibas.measures.sight_plane import to_the_right, vertical_of
from adibas.reports.fonts import REGULAR, font_path
from adibas.reports.rows import MM_PER_M
from adibas.texts import translate as _

if TYPE_CHECKING:
    from matplotlib.axes import Axes

POINTS_PER_INCH = 72
DOTS_PER_INCH = 200
GRID_MM = 100.0
FONT_PT = 6.0
INK, PLUMB, MARKER, MEASURE = "#16212B", "#E69F00", "#0072B2", "#009E73"
MARGIN_MM = 60.0
EMPTY_BOX = "\N{WHITE SQUARE}"


def marker_plot(
    capture: CaptureReport, width_pt: float, height_pt: float, rotation_deg: int = 0
) -> UInt8Array | None:
    """Draw the markers upright and to scale, with a grid of 100 mm and a plumb line.

    Parameters
    ----------
    capture : CaptureReport
        Its free measures are drawn as lines.
    width_pt, height_pt : float
        Size on the page, points.
    rotation_deg : int
        How far the picture is turned clockwise to be upright.

    Returns
    -------
    picture : (H, W, 3) uint8 array or None
        None where fewer than two markers have a position.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image

    places_mm = upright_places_mm(capture, rotation_deg)
    if len(places_mm) < 2:  # noqa: PLR2004  (a single point has no scale)
        return None
    figure = Figure((width_pt / POINTS_PER_INCH, height_pt / POINTS_PER_INCH), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.axvline(0.0, color=PLUMB, linestyle="--", linewidth=0.8)
    for measure in capture.measures:
        corners = [places_mm[label] for label in measure.labels if label in places_mm]
        if len(corners) == len(measure.labels):
            axes.plot(*np.transpose(corners), color=MEASURE, linewidth=1.0)
    for label, (across_mm, up_mm) in places_mm.items():
        axes.plot(across_mm, up_mm, "o", color=MARKER, markersize=2.5)
        axes.annotate(
            _drawable(landmark_text(label)),
            (across_mm, up_mm),
            (3, 1),
            textcoords="offset points",
            fontsize=FONT_PT,
            parse_math=False,
        )
    _scale(axes, np.array(list(places_mm.values())), width_pt / height_pt)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DOTS_PER_INCH)
    picture: UInt8Array = np.array(Image.open(file).convert("RGB"))
    return picture


def upright_places_mm(
    capture: CaptureReport, rotation_deg: int = 0
) -> dict[str, tuple[float, float]]:
    """Return where the markers are across (to the picture's right) and up, millimetres.

    Both are counted from the middle of the markers, in the vertical plane that the camera looks at
    squarely. Up is the vertical of the measures; where it is not known, the upper side of the
    picture as it is shown.
    """
    measured = [m for m in capture.analysis.markers if m.position_m is not None]
    if not measured:
        return {}
    up = vertical_of(capture.analysis.calibration, rotation_deg).up
    across = to_the_right(up)
    places_m = np.array([marker.position_m for marker in measured]) @ np.stack([across, up], axis=1)
    places_mm = MM_PER_M * (places_m - places_m.mean(axis=0))
    return {
        marker.label: (float(place[0]), float(place[1]))
        for marker, place in zip(measured, places_mm, strict=True)
    }


def _drawable(label: str) -> str:
    """Return a label with an empty box for what the font lacks, as in the rest of a report."""
    known = _characters()
    return "".join(one if ord(one) in known else EMPTY_BOX for one in label)


@cache
def _characters() -> frozenset[int]:
    from matplotlib.ft2font import FT2Font

    return frozenset(FT2Font(str(font_path(REGULAR))).get_charmap())


def _scale(axes: "Axes", places_mm: FloatArray, aspect: float) -> None:
    """Give both axes one scale, a grid and their unit; fill a box of that width over height."""
    from matplotlib.ticker import MultipleLocator

    low, high = places_mm.min(axis=0) - MARGIN_MM, places_mm.max(axis=0) + MARGIN_MM
    middle, half = (low + high) / 2, (high - low) / 2
    half = np.array([max(half[0], aspect * half[1]), max(half[1], half[0] / aspect)])
    axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
    axes.set_aspect("equal", adjustable="box")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MultipleLocator(2 * GRID_MM))
        axis.set_minor_locator(MultipleLocator(GRID_MM))
    axes.grid(visible=True, which="both", color="#C3CCD4", linewidth=0.3)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=FONT_PT, colors=INK, length=2)
    axes.set_title(_("Markers upright and to scale [mm]"), fontsize=FONT_PT + 1, color=INK)
    for spine in axes.spines.values():
        spine.set_color("#C3CCD4")
