"""Pictures with the markers drawn, for reports."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from adibas.arrays import BoolArray, UInt8Array
from adibas.data.landmark_texts import landmark_text
from adibas.data.posture import PostureAnalysis
from adibas.data.report import PictureChoice
from adibas.files import printable
from adibas.reports.fonts import picture_font
from adibas.reports.privacy import blurred, depth_picture, see_patient

# Okabe & Ito's palette: told apart by colour-blind readers too.
WITH_POSITION_RGB = (0, 158, 255)
WITHOUT_POSITION_RGB = (230, 159, 0)
OUTLINE_RGB = (0, 0, 0)
TEXT_RGB = (255, 255, 255)
SMALLEST_TEXT_PX = 12
TEXT_SHARE = 1 / 48
"""Height of names as a share of the picture's."""
STROKES_PX = 6
MARGIN_SHARE = 0.06
"""Around the patient where a picture is cropped, as a share of the larger side."""

LEAST_ASPECT = 0.55
"""Width of a cropped picture as a share of its height: room for names."""

Box = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Spot:
    """A marker in a picture: centre (u, v) and radius in pixels, and whether it was measured."""

    label: str
    u: float
    v: float
    radius_px: float
    has_position: bool


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """An upright (H, W, 3) uint8 picture without anything drawn, and the markers in it."""

    pixels_rgb: UInt8Array
    spots: tuple[Spot, ...]


def picture_of(
    analysis: PostureAnalysis,
    choice: PictureChoice = PictureChoice.AS_IS,
    rotation_deg: int = 0,
    *,
    is_cropped: bool = False,
) -> Picture:
    """Return the picture of a capture as the reader wants it, turned upright.

    Parameters
    ----------
    rotation_deg : int
        How far the picture is turned clockwise to be upright.
    is_cropped : bool
        Only the part that shows the patient and every marker, with some margin; the whole picture
        where the patient is not seen in the depth.

    Raises
    ------
    ReportError
        The face is to be hidden and no head is found, or no depth was kept.
    """
    match choice:
        case PictureChoice.AS_IS:
            pixels_rgb = analysis.picture_rgb
        case PictureChoice.BLURRED:
            pixels_rgb = blurred(analysis, rotation_deg)
        case PictureChoice.DEPTH:
            pixels_rgb = depth_picture(analysis, rotation_deg)
    n_turns = rotation_deg // 90
    spots = tuple(
        Spot(
            landmark_text(marker.label),
            *_turned(marker.u, marker.v, pixels_rgb.shape, n_turns),
            marker.radius_px,
            marker.position_m is not None,
        )
        for marker in analysis.markers
    )
    upright = Picture(np.ascontiguousarray(np.rot90(pixels_rgb, -n_turns)), spots)
    if not is_cropped or analysis.surface_per_m is None:
        return upright
    sight = see_patient(analysis, rotation_deg)
    return upright if sight is None else _cropped(upright, np.rot90(sight.outline, -n_turns))


def _turned(u: float, v: float, shape: tuple[int, ...], n_turns: int) -> tuple[float, float]:
    """Return where a pixel of an image (height, width, ...) lies after clockwise quarter turns."""
    last_v, last_u = shape[0] - 1, shape[1] - 1
    return ((u, v), (last_v - v, u), (last_u - u, last_v - v), (v, last_u - u))[n_turns]


def _cropped(picture: Picture, outline: BoolArray) -> Picture:
    """Return the part with the patient, whose (H, W) outline is given, and every marker."""
    shown = outline.copy()
    height, width = shown.shape
    for spot in picture.spots:
        row, column = round(spot.v), round(spot.u)
        shown[min(max(row, 0), height - 1), min(max(column, 0), width - 1)] = True
    columns, rows = (np.flatnonzero(shown.any(axis=axis)) for axis in (0, 1))
    if not rows.size:
        return picture
    margin = round(MARGIN_SHARE * max(np.ptp(columns), np.ptp(rows)))
    lacking = round(LEAST_ASPECT * np.ptp(rows) - np.ptp(columns)) // 2
    beside = max(margin, lacking)
    left, top = max(int(columns[0]) - beside, 0), max(int(rows[0]) - margin, 0)
    part = picture.pixels_rgb[top : rows[-1] + margin + 1, left : columns[-1] + beside + 1]
    spots = tuple(replace(spot, u=spot.u - left, v=spot.v - top) for spot in picture.spots)
    return Picture(np.ascontiguousarray(part), spots)


def draw_markers(picture: Picture, height_px: int) -> UInt8Array:
    """Return the picture, `height_px` high, with a named ring around every marker.

    Blue rings have a position in space, orange ones have none. A name stands where it hides no
    other name or marker, as far as there is room.
    """
    pixels_rgb = picture.pixels_rgb
    scale = height_px / pixels_rgb.shape[0]
    size = (max(1, round(pixels_rgb.shape[1] * scale)), height_px)
    method = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    canvas = cv2.resize(pixels_rgb, size, interpolation=method).astype(np.uint8)
    rings = [_ring(spot, scale) for spot in picture.spots]
    for spot, (u, v, radius) in zip(picture.spots, rings, strict=True):
        color = WITH_POSITION_RGB if spot.has_position else WITHOUT_POSITION_RGB
        for ring_rgb, thickness in ((OUTLINE_RGB, 3), (color, 1)):
            cv2.circle(canvas, (u, v), radius, ring_rgb, thickness, cv2.LINE_AA)
    return _with_names(canvas, [spot.label for spot in picture.spots], rings)


def _ring(spot: Spot, scale: float) -> tuple[int, int, int]:
    """Return centre and radius; a pixel's centre is at whole numbers: shift when scaling."""
    u, v = (round((value + 0.5) * scale - 0.5) for value in (spot.u, spot.v))
    return u, v, max(6, round(spot.radius_px * scale) + 4)


def _with_names(
    canvas: UInt8Array, names: Sequence[str], rings: Sequence[tuple[int, int, int]]
) -> UInt8Array:
    """Write each name beside its ring."""
    height, width = canvas.shape[:2]
    font = picture_font(max(SMALLEST_TEXT_PX, round(height * TEXT_SHARE)))
    image = Image.fromarray(canvas)
    pen = ImageDraw.Draw(image)
    taken: list[Box] = [(u - r, v - r, u + r, v + r) for u, v, r in rings]
    for name, ring in zip(names, rings, strict=True):
        text = _shortened(printable(name), font, width)
        left, top, right, bottom = pen.textbbox((0, 0), text, font=font, stroke_width=2)
        size = (right - left, bottom - top)
        places = [_inside(box, (width, height)) for box in _places(ring, size)]
        box = min(places, key=lambda box: _hidden(box, taken))
        taken.append(box)
        place = (box[0] - left, box[1] - top)
        pen.text(place, text, TEXT_RGB, font, stroke_width=2, stroke_fill=OUTLINE_RGB)
    return np.ascontiguousarray(image, np.uint8)


def _places(ring: tuple[int, int, int], size: tuple[float, float]) -> Iterator[Box]:
    """Yield the boxes where a text of `size` may stand, the best place first."""
    u, v, radius = ring
    width, height = size
    for down in (-0.5, -1.1, 0.1, -1.7, 0.7, -2.3, 1.3):
        for left in (u + radius + 1, u - radius - 1 - width):
            top = v + down * height
            yield left, top, left + width, top + height


def _inside(box: Box, size: tuple[int, int]) -> Box:
    """Return the box moved into a picture of (width, height)."""
    right = min(max(box[0], 0.0), size[0] - (box[2] - box[0])) - box[0]
    down = min(max(box[1], 0.0), size[1] - (box[3] - box[1])) - box[1]
    return box[0] + right, box[1] + down, box[2] + right, box[3] + down


def _shortened(text: str, font: ImageFont.FreeTypeFont, width: int) -> str:
    """Return the text, or as much of its beginning as is no wider than the picture."""
    shown = text
    while len(shown) > 1 and font.getlength(shown) > width - STROKES_PX:
        text = text[:-1]
        shown = f"{text}\N{HORIZONTAL ELLIPSIS}"
    return shown


def _hidden(box: Box, taken: Sequence[Box]) -> float:
    """Return the area of other boxes that a box hides."""
    return sum(_overlap(box, other) for other in taken)


def _overlap(a: Box, b: Box) -> float:
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    return max(width, 0.0) * max(height, 0.0)
