"""Draws the landmarks of each protocol on a body, view by view: ``make figures``.

The places come from the protocol's file and the simulator's body, and the numbers are those of
the table that the page has. They go to ``docs/manual/figures``, small enough to be kept there.
"""

import io
import sys
from collections.abc import Iterator, Sequence
from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from PIL import Image, ImageColor

from adibas.arrays import BoolArray, FloatArray
from adibas.data.joints import PARENT_OF
from adibas.measures.protocol_store import find_protocol
from adibas.simulation.clothing import OUTFITS, covering_fields
from installers.bundle import ROOT
from installers.manual.landmarks import (
    PROTOCOLS,
    RIGHTWARDS,
    Numbered,
    figure_views,
    numbered,
    standing_model,
)

FOLDER = ROOT / "docs" / "manual" / "figures"
DOWN = np.array([0.0, 1.0, 0.0])
DOTS_PER_INCH = 160
M_PER_INCH = 0.22
MARGIN_M = 0.06
COLUMN_M = 0.1
"""Between the body and the numbers beside it."""
LEAST_STEP_M = 0.034
"""Between numbers, or they would lie on one another."""
DARKEST, LIGHTEST = 0.55, 0.97
OUTFIT, GARMENTS, CLOTH = "shorts_and_bra_top", (1, 2), 0.2
"""What patients are measured in, its columns of top and bottom, and how much darker it is."""

N_GREYS, N_TINTS = 40, 10
"""Of the palette: greys, and steps of each colour towards the grey of the skin."""
SKIN = 225
TRUNK_END = 0.55
"""Of the body's height: what a figure of the trunk shows."""
DOT, LINE, BONE, INK = "#B3261E", "#6B6B6B", "#0B57A4", "#111111"


def main() -> int:
    """Draw all figures; return 0."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, image in all_figures():
        path = FOLDER / f"{name}.png"
        image.save(path, optimize=True)
        sys.stdout.write(f"{path.relative_to(ROOT)}\n")
    return 0


def all_figures() -> Iterator[tuple[str, Image.Image]]:
    """Yield the name of each figure and its picture."""
    for protocol_id in PROTOCOLS:
        for view in figure_views(find_protocol(protocol_id)):
            yield f"{protocol_id}-{view}", drawn(protocol_id, view)


def drawn(protocol_id: str, view: str) -> Image.Image:
    """Return the body as one view shows it, with the protocol's landmarks and their numbers."""
    landmarks = numbered(protocol_id, view)
    triangles_m, shades = body_seen(view)
    lowest_m = triangles_m[..., 1].max()
    highest_m = triangles_m[..., 1].min()
    if max(one.down_m for one in landmarks) < highest_m + 0.5 * (lowest_m - highest_m):
        lowest_m = highest_m + TRUNK_END * (lowest_m - highest_m)
    across_m = (triangles_m[..., 0].min(), triangles_m[..., 0].max())
    edges_m = (across_m[0] - COLUMN_M - MARGIN_M, across_m[1] + COLUMN_M + MARGIN_M)
    axes = _sheet(edges_m, (highest_m - MARGIN_M, lowest_m + MARGIN_M))
    axes.add_collection(
        PolyCollection(triangles_m, facecolors=[str(shade) for shade in shades], edgecolors="face")
    )
    if protocol_id == "joints-15":
        _draw_bones(axes, landmarks)
    _draw_landmarks(axes, landmarks, across_m)
    return _painted(axes.figure)


def body_seen(view: str) -> tuple[FloatArray, FloatArray]:
    """Return the triangles that face a view, far ones first, and how bright each is.

    Returns
    -------
    corners_m : (T, 3, 2) array
        Right and down on the figure.
    shades : (T,) array
        0 black, 1 white.
    """
    body = standing_model()
    right = RIGHTWARDS[view]
    look = np.cross(right, DOWN)
    corners = body.vertices_m[body.body.model.triangles]
    normals = body.vertex_normals[body.body.model.triangles].mean(axis=1)
    facing = -(normals @ look)
    order = np.argsort(-(corners @ look).mean(axis=1))
    order = order[facing[order] > 0.0]
    flat = np.stack([corners @ right, corners @ DOWN], axis=-1)
    shades = DARKEST + (LIGHTEST - DARKEST) * np.sqrt(np.minimum(facing[order], 1.0))
    shades -= CLOTH * is_clothed()[order]
    return flat[order], np.round(shades, 3)


@cache
def is_clothed() -> BoolArray:
    """Return which triangles shorts and, on a woman, a top of the simulator's cover."""
    body = standing_model().body
    covers = covering_fields(body, OUTFITS[OUTFIT])[:, list(GARMENTS)]
    return np.asarray((covers[body.model.triangles].min(axis=1) > 0.0).any(axis=1))


def _sheet(across_m: tuple[float, float], down_m: tuple[float, float]) -> Axes:
    size = [(high - low) / M_PER_INCH for low, high in (across_m, down_m)]
    figure = Figure(figsize=(size[0], size[1]), dpi=DOTS_PER_INCH)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_xlim(*across_m)
    axes.set_ylim(down_m[1], down_m[0])
    axes.axis("off")
    return axes


def _draw_bones(axes: Axes, landmarks: Sequence[Numbered]) -> None:
    places = {one.landmark.landmark_id: (one.right_m, one.down_m) for one in landmarks}
    bones = [(places[one], places[other]) for one, other in PARENT_OF.items() if other in places]
    axes.add_collection(LineCollection(bones, colors=BONE, linewidths=2.2, alpha=0.8))


def _draw_landmarks(
    axes: Axes, landmarks: Sequence[Numbered], across_m: tuple[float, float]
) -> None:
    middle_m = float(np.median([one.right_m for one in landmarks]))
    right = [one for one in landmarks if _is_at_right(one, middle_m)]
    left = [one for one in landmarks if not _is_at_right(one, middle_m)]
    for column, edge_m, side in ((left, across_m[0], -1.0), (right, across_m[1], 1.0)):
        ordered = sorted(column, key=lambda one: (one.down_m, one.number))
        heights = spread([one.down_m for one in ordered], LEAST_STEP_M)
        for one, height_m in zip(ordered, heights, strict=True):
            text_m = edge_m + side * COLUMN_M
            axes.plot(
                [one.right_m, text_m - side * 0.02], [one.down_m, height_m], color=LINE, lw=0.5
            )
            axes.text(
                text_m, height_m, str(one.number), color=INK, ha="center", va="center", fontsize=8
            )
    axes.plot(
        [one.right_m for one in landmarks],
        [one.down_m for one in landmarks],
        "o",
        color=DOT,
        markersize=4.2,
        markeredgecolor="white",
        markeredgewidth=0.6,
    )


def _is_at_right(one: Numbered, middle_m: float) -> bool:
    """Say in which column a landmark's number stands; those of the midline take turns."""
    is_middle = abs(one.right_m - middle_m) < 1e-3  # noqa: PLR2004
    return one.number % 2 == 0 if is_middle else one.right_m > middle_m


def spread(heights: Sequence[float], least: float) -> list[float]:
    """Return rising heights moved apart to a least step, none farther than it must."""
    groups: list[list[float]] = []
    for height in heights:
        groups.append([height])
        while len(groups) > 1 and _start(groups[-1], least) < _end(groups[-2], least) + least:
            last = groups.pop()
            groups[-1] += last
    return [
        _start(group, least) + number * least for group in groups for number in range(len(group))
    ]


def _start(group: Sequence[float], least: float) -> float:
    return sum(group) / len(group) - 0.5 * least * (len(group) - 1)


def _end(group: Sequence[float], least: float) -> float:
    return _start(group, least) + least * (len(group) - 1)


def _painted(figure: Figure) -> Image.Image:
    FigureCanvasAgg(figure)
    file = io.BytesIO()
    figure.savefig(file, format="png", facecolor="white")
    return Image.open(file).convert("RGB").quantize(palette=_palette(), dither=Image.Dither.NONE)


@cache
def _palette() -> Image.Image:
    """Return the few colours of all figures: one that is chosen by a picture loses the red."""
    colors = [(round(grey),) * 3 for grey in np.linspace(0, 255, N_GREYS)]
    for ink in (DOT, BONE):
        tones = np.linspace(ImageColor.getrgb(ink), (SKIN,) * 3, N_TINTS, endpoint=False)
        colors += [tuple(tone) for tone in tones.round().astype(int).tolist()]
    palette = Image.new("P", (1, 1))
    palette.putpalette([value for color in colors for value in color])
    return palette


if __name__ == "__main__":
    raise SystemExit(main())
