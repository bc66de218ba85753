"""The joined surface in pictures, from its four sides: its shape in grey, so that no face is seen.

A report is handed on, and colours of a picture would show who it is; the file of the surface alone
holds them.
"""

from collections.abc import Sequence

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from adibas.arrays import Float32Array, FloatArray
from adibas.pipeline.body import MeasuredBody
from adibas.pipeline.body_landmarks import Landmark
from adibas.reports.body_plots import ACCENT, FAINT, FONT_PT, finish
from adibas.reports.facts import view_name
from adibas.reports.vector_figures import new_figure
from adibas.surface.merging import BodySurface
from adibas.texts import translate as _

CELL_M = 0.007
"""A little more than what points are averaged over, so that a surface has few holes."""
FEWEST_AROUND = 5
"""Of a hole's eight neighbours that fill it, where they are known."""
DARKEST = 0.25
"""Grey of what is seen at a slant; 1 is white, and what is seen squarely is nearly so."""
SQUAREST = 0.9
LOOKS: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "anterior": ((-1.0, 0.0, 0.0), (0.0, 0.0, -1.0)),
    "right_lateral": ((0.0, 0.0, -1.0), (1.0, 0.0, 0.0)),
    "posterior": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "left_lateral": ((0.0, 0.0, 1.0), (-1.0, 0.0, 0.0)),
}
"""What lies to the right in the picture, and towards the reader; patient axes."""


def looks_figure(body: MeasuredBody, width_pt: float, height_pt: float) -> Figure:
    """Draw the surface from the four sides, with the landmarks that each side's view saw."""
    surface = body.whole.surface
    figure = new_figure(width_pt, height_pt)
    sides = figure.subplots(1, len(LOOKS), sharey=True)
    for axes, view in zip(sides, LOOKS, strict=True):
        _draw(axes, surface, view, body.landmarks)
        axes.set_aspect("equal")
        axes.set_xticks([])
        finish(axes, view_name(view))
    half_m = max(np.ptp(axes.get_xlim()) for axes in sides) / 2.0
    for axes in sides:  # the same room, and so the same scale, for each
        middle_m = np.mean(axes.get_xlim())
        axes.set_xlim(middle_m - half_m, middle_m + half_m)
    figure.axes[0].set_ylabel(_("Height over the floor [m]"), fontsize=FONT_PT)
    return figure


def _draw(axes: Axes, surface: BodySurface, view: str, landmarks: Sequence[Landmark]) -> None:
    across, towards = (np.array(axis) for axis in LOOKS[view])
    shades, extent = shades_of(surface, across, towards)
    axes.imshow(shades, extent=extent, cmap="gray", vmin=0.0, vmax=1.0, aspect="auto")
    axes.axhline(0.0, color=FAINT, linewidth=0.6)
    for mark in landmarks:
        if view in mark.places_m:
            place_m = mark.places_m[view]
            axes.plot(place_m @ across, place_m[1], "o", color=ACCENT, markersize=2)


def shades_of(
    surface: BodySurface, across: FloatArray, towards: FloatArray
) -> tuple[Float32Array, tuple[float, float, float, float]]:
    """Return (H, W) greys of the nearest points, NaN beside the body, and its edges in metres.

    Parameters
    ----------
    across, towards : (3,) arrays
        What lies to the right, and towards the reader.
    """
    faces = surface.normals @ towards
    seen = faces > 0.0
    points_m = surface.points_m[seen]
    low_m = np.array([(surface.points_m @ across).min(), surface.points_m[:, 1].min()])
    places_m = np.column_stack([points_m @ across, points_m[:, 1]])
    columns, rows = np.floor((places_m - low_m) / CELL_M).astype(int).T
    n_columns, n_rows = (
        int((values.max() - low) / CELL_M) + 1
        for values, low in zip(
            (surface.points_m @ across, surface.points_m[:, 1]), low_m.tolist(), strict=True
        )
    )
    shades = np.full((n_rows, n_columns), np.nan, np.float32)
    order = np.argsort(points_m @ towards)  # what is nearest is painted last
    shades[n_rows - 1 - rows[order], columns[order]] = (
        DARKEST + (SQUAREST - DARKEST) * faces[seen][order]
    )
    shades = _filled(shades)
    left_m, bottom_m = low_m.tolist()
    right_m, top_m = left_m + n_columns * CELL_M, bottom_m + n_rows * CELL_M
    return shades, (left_m, right_m, bottom_m, top_m)


def _filled(shades: Float32Array) -> Float32Array:
    """Return the greys with the mean of its neighbours in each small hole."""
    known = np.isfinite(shades)
    around = np.ones((3, 3), np.float32)
    total = cv2.filter2D(
        np.where(known, shades, np.float32(0.0)), -1, around, borderType=cv2.BORDER_CONSTANT
    )
    count = cv2.filter2D(known.astype(np.float32), -1, around, borderType=cv2.BORDER_CONSTANT)
    mean = total / np.maximum(count, np.float32(1.0))
    return np.asarray(np.where(~known & (count >= FEWEST_AROUND), mean, shades), np.float32)
