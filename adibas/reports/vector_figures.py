"""matplotlib's figures as vector graphics in a PDF: its drawing calls on reportlab's canvas.

Nothing is a picture: lines stay sharp on every screen and printer, and text can be searched.
"""

from typing import Any

import numpy as np
from matplotlib.backend_bases import GraphicsContextBase, RendererBase
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.transforms import IdentityTransform, Transform
from reportlab.pdfgen.canvas import FILL_NON_ZERO, Canvas
from reportlab.platypus import Flowable

from adibas.files import printable
from adibas.reports.fonts import BOLD, REGULAR

POINTS_PER_INCH = 72
BOLD_FROM = 600
CAPS = {"butt": 0, "round": 1, "projecting": 2}
JOINS = {"miter": 0, "round": 1, "bevel": 2}
N_ALPHA = 4


def new_figure(width_pt: float, height_pt: float) -> Figure:
    """Return an empty figure of that size on the page, in points, that lays itself out."""
    size = (width_pt / POINTS_PER_INCH, height_pt / POINTS_PER_INCH)
    return Figure(size, dpi=POINTS_PER_INCH, layout="constrained")


class FigureFlowable(Flowable):  # type: ignore[misc]  # reportlab has no types
    """A figure among the paragraphs and tables of a page."""

    def __init__(self, figure: Figure) -> None:
        super().__init__()
        self._figure = figure
        self.width, self.height = (side * POINTS_PER_INCH for side in figure.get_size_inches())

    def wrap(self, _width: float, _height: float) -> tuple[float, float]:
        """Return its size, which is fixed."""
        return self.width, self.height

    def draw(self) -> None:
        """Draw the figure with its lower left corner at the origin."""
        self._figure.draw(_CanvasRenderer(self.canv, self.width, self.height))


class _CanvasRenderer(RendererBase):
    """Draws paths and text; a figure for this must have no bitmaps."""

    def __init__(self, canvas: Canvas, width_pt: float, height_pt: float) -> None:
        super().__init__()
        self._canvas = canvas
        self._size = (width_pt, height_pt)

    def flipy(self) -> bool:
        return False

    def get_canvas_width_height(self) -> tuple[float, float]:
        return self._size

    def points_to_pixels(self, points: Any) -> Any:
        return points

    def draw_path(
        self,
        gc: GraphicsContextBase,
        path: Path,
        transform: Transform,
        rgbFace: Any = None,  # noqa: N803  (matplotlib's name)
    ) -> None:
        canvas = self._canvas
        color = gc.get_rgb()
        is_stroked = gc.get_linewidth() > 0 and _alpha(color) > 0
        is_filled = rgbFace is not None and _alpha(rgbFace) > 0
        if not (is_stroked or is_filled):
            return
        canvas.saveState()
        self._clip(gc)
        if is_filled:
            canvas.setFillColorRGB(*rgbFace[:3], alpha=_alpha(rgbFace))
        if is_stroked:
            canvas.setStrokeColorRGB(*color[:3], alpha=_alpha(color))
            self._prepare_line(gc)
        canvas.drawPath(
            self._traced(path, transform),
            stroke=int(is_stroked),
            fill=int(is_filled),
            fillMode=FILL_NON_ZERO,
        )
        canvas.restoreState()

    def draw_markers(
        self,
        gc: GraphicsContextBase,
        marker_path: Path,
        marker_trans: Transform,
        path: Path,
        trans: Transform,
        rgbFace: Any = None,  # noqa: N803
    ) -> None:
        """Draw all markers as one path: thousands of small ones make a large file else."""
        marker = marker_trans.transform_path(marker_path)
        places = np.asarray(trans.transform(path.vertices))
        corners = np.asarray(marker.vertices)
        codes = marker.codes
        if codes is None:
            codes = np.array([Path.MOVETO, *[Path.LINETO] * (len(corners) - 1)])
        everywhere = (places[:, None] + corners).reshape(-1, 2)
        joined = Path(everywhere, np.tile(codes, len(places)))
        self.draw_path(gc, joined, IdentityTransform(), rgbFace)

    def draw_text(  # noqa: PLR0913, PLR0917  (matplotlib's)
        self,
        gc: GraphicsContextBase,
        x: float,
        y: float,
        s: str,
        prop: Any,
        angle: float,
        ismath: Any = False,  # noqa: ARG002
        mtext: Any = None,  # noqa: ARG002
    ) -> None:
        canvas = self._canvas
        canvas.saveState()
        self._clip(gc)
        canvas.translate(x, y)
        canvas.rotate(angle)
        canvas.setFillColorRGB(*gc.get_rgb()[:3], alpha=_alpha(gc.get_rgb()))
        weight = prop.get_weight()
        is_bold = weight == "bold" or (isinstance(weight, int) and weight >= BOLD_FROM)
        canvas.setFont(BOLD if is_bold else REGULAR, prop.get_size_in_points())
        canvas.drawString(0, 0, printable(s))
        canvas.restoreState()

    def _prepare_line(self, gc: Any) -> None:
        canvas = self._canvas
        canvas.setLineWidth(gc.get_linewidth())
        canvas.setLineCap(CAPS[gc.get_capstyle()])
        canvas.setLineJoin(JOINS[gc.get_joinstyle()])
        offset, dashes = gc.get_dashes()
        if dashes is not None:
            canvas.setDash(list(map(float, dashes)), float(offset))

    def _clip(self, gc: Any) -> None:
        rectangle = gc.get_clip_rectangle()
        if rectangle is not None:
            box = self._canvas.beginPath()
            box.rect(*(float(side) for side in rectangle.bounds))
            self._canvas.clipPath(box, stroke=0, fill=0)
        path, transform = gc.get_clip_path()
        if path is not None:
            self._canvas.clipPath(self._traced(path, transform), stroke=0, fill=0)

    def _traced(self, path: Path, transform: Any) -> Any:
        """Return a path of reportlab; its curves are cubic alone."""
        traced = self._canvas.beginPath()
        last = (0.0, 0.0)
        for numbers, code in path.iter_segments(transform, simplify=False):
            points = [float(number) for number in numbers]
            if code == Path.MOVETO:
                traced.moveTo(*points)
            elif code == Path.LINETO:
                traced.lineTo(*points)
            elif code == Path.CURVE3:
                traced.curveTo(*_cubic(last, points))
            elif code == Path.CURVE4:
                traced.curveTo(*points)
            else:
                traced.close()
                continue
            last = (points[-2], points[-1])
        return traced


def _cubic(start: tuple[float, float], points: list[float]) -> list[float]:
    """Return the control points and the end of a quadratic curve as a cubic one."""
    u, v, end_u, end_v = points
    first = [start[0] + 2 / 3 * (u - start[0]), start[1] + 2 / 3 * (v - start[1])]
    return [*first, end_u + 2 / 3 * (u - end_u), end_v + 2 / 3 * (v - end_v), end_u, end_v]


def _alpha(color: Any) -> float:
    return float(color[3]) if len(color) == N_ALPHA else 1.0
