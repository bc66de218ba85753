"""Markers and measures as overlays of the picture."""

import itertools
import math

from adibas.data.landmark_texts import landmark_text
from adibas.data.markers import Marker
from adibas.texts import translate as _
from ui.review.content import MeasureRow, Points
from ui.review.wording import value_text
from ui.widgets.bones import bones
from ui.widgets.overlays import Curve, Dot, Line, Overlay, Role

REFUSED_KEY = "\n"
"""Begins the key of a refused blob; no label holds it."""
REFUSED_RADIUS_PX = 5.0
ARC_SHARE, LARGEST_ARC_PX, N_ARC_POINTS = 0.35, 60.0, 25
Pixel = tuple[float, float]


def overlays_of(points: Points) -> tuple[Overlay, ...]:
    """Return what is drawn over the picture: measures below, markers above."""
    places = {one.label: (one.u, one.v) for one in points.markers}
    drawn: list[Overlay] = list(bones(places))
    for row in points.measures:
        if all(label in places for label in row.labels):
            drawn += _measure(row, [places[label] for label in row.labels])
    drawn += _picked(points, places)
    drawn += [
        Dot(
            blob.u,
            blob.v,
            REFUSED_RADIUS_PX,
            role="rejected",
            tooltip=_("Refused: {reason} Click to make a marker of it.").format(
                reason=_(blob.reason)
            ),
            is_pickable=points.can_edit and not points.mode.picks,
            key=f"{REFUSED_KEY}{index}",
        )
        for index, blob in enumerate(points.rejected)
    ]
    drawn += [_dot(marker, points) for marker in points.markers]
    return tuple(drawn)


def refused_index(name: str) -> int | None:
    """Return which refused blob a dot is; None for a marker."""
    return int(name[len(REFUSED_KEY) :]) if name.startswith(REFUSED_KEY) else None


def _dot(marker: Marker, points: Points) -> Dot:
    role: Role = "corrected" if marker.label in points.by_hand else "marker"
    if marker.label == points.selected or marker.label in points.picked:
        role = "selected"
    can_move = points.can_edit and not points.mode.picks
    return Dot(
        marker.u,
        marker.v,
        marker.radius_px,
        landmark_text(marker.label),
        role,
        is_movable=can_move,
        tooltip=_("No depth here: it is in no measure.") if marker.position_m is None else "",
        is_pickable=not can_move,
        key=marker.label,
    )


def _picked(points: Points, places: dict[str, Pixel]) -> list[Overlay]:
    """Join the markers of the measure that is being clicked."""
    corners = [places[label] for label in points.picked if label in places]
    return [Line(*start, *end) for start, end in itertools.pairwise(corners)]


def _measure(row: MeasureRow, corners: list[Pixel]) -> list[Overlay]:
    if not row.is_angle:
        return [Line(*corners[0], *corners[1], text=value_text(row))]
    a, vertex, c = corners
    return [
        Line(*vertex, *a),
        Line(*vertex, *c),
        Curve(_arc(a, vertex, c), text=value_text(row)),
    ]


def _arc(a: Pixel, vertex: Pixel, c: Pixel) -> tuple[Pixel, ...]:
    """Return the arc between two arms, the shorter way round."""
    begin = math.atan2(a[1] - vertex[1], a[0] - vertex[0])
    end = math.atan2(c[1] - vertex[1], c[0] - vertex[0])
    turn = math.remainder(end - begin, math.tau)
    shorter = min(math.dist(a, vertex), math.dist(c, vertex))
    radius = min(ARC_SHARE * shorter, LARGEST_ARC_PX)
    steps = (begin + turn * step / (N_ARC_POINTS - 1) for step in range(N_ARC_POINTS))
    return tuple(
        (vertex[0] + radius * math.cos(at), vertex[1] + radius * math.sin(at)) for at in steps
    )
