"""Where names stand beside what they name, so that none is read as another's; without Qt.

A name touches no ring and no other name. It stands beside its own ring where that is clearly the
nearest one, else farther away, with a line that leads to it past all others, else nowhere.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, TypeAlias

import numpy as np

from adibas.arrays import BoolArray, FloatArray

Box: TypeAlias = tuple[float, float, float, float]
"""Left, top, right and bottom, in pixels; of a line x and y of its start and of its end."""
Size: TypeAlias = tuple[float, float]
GAP_PX = 3.0
"""Between a name and a ring."""
NAMES_GAP_PX = 2.0
"""Between names, and between a line and the names and rings that it passes."""
CLEARER_HEIGHTS = 0.4
"""How much nearer a name without a line is to its own ring than to others, in its heights."""
LED_HEIGHTS, LEAST_LEADER_PX = 0.6, 6.0
"""How far a name with a line is from other rings, in its heights, and from its own."""
LEVELS = (0.0, 0.5, -0.5, 1.0, -1.0)
"""How far down a name stands beside its ring; the last first for values, or they hid lines."""
ROWS = (0.0, *(sign * n for n in (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0) for sign in (-1, 1)))
COLUMNS = (0.5, 1.5, 3.0)
"""How far up or down, and to a side, a line leads to a name, in its heights."""
INWARD_HEIGHTS = 3.0
"""By how much a line to the outer side may be longer than one to the inner side."""
ROUNDS_HEIGHTS = (2.0, 5.0, np.inf)
"""Short lines are placed before long ones, which bar the way to others."""


@dataclass(frozen=True, slots=True)
class Ring:
    """A circle about (x, y), in pixels.

    Rings with the same `owner` belong to one marker, unless it is "". What a value tells of has a
    ring that is not drawn: names may cover it, and are not mistaken for values.
    """

    x: float
    y: float
    radius: float
    owner: str = ""
    kind: Literal["marker", "value"] = "marker"


@dataclass(frozen=True, slots=True)
class Named:
    """A ring, and the size of the name that it wants, in pixels."""

    ring: Ring
    width: float
    height: float


@dataclass(frozen=True, slots=True)
class Label:
    """Where a name stands, and the line from its ring to it; None where it stands beside it."""

    box: Box
    leader: Box | None = None


@lru_cache(maxsize=16)
def place_labels(
    things: tuple[Named, ...], window: Size, rings: tuple[Ring, ...] = ()
) -> tuple[Label | None, ...]:
    """Return where each name stands; None where every place would mislead, or out of sight.

    Names of markers are placed before values, and what can stand beside its ring before what
    needs a line; else in the order given. The side away from the other markers comes first.
    `rings` are those without a name, `window` is (width, height).
    """
    if not things:
        return ()
    scene = _Scene(things, window, rings)
    for kind in ("marker", "value"):
        wanted = [i for i, thing in enumerate(things) if _is_seen(thing.ring, kind, window)]
        left = [index for index in wanted if not _place_beside(scene, index)]
        places = {index: _places_apart(scene, index) for index in left}
        for limit in ROUNDS_HEIGHTS:
            left = [index for index in left if not _place_apart(scene, index, places[index], limit)]
    return tuple(scene.labels.get(index) for index in range(len(things)))


class _Scene:
    """All R rings, of the N things first, and what has been placed among them so far."""

    def __init__(self, things: tuple[Named, ...], window: Size, rings: tuple[Ring, ...]) -> None:
        n, known = len(things), [*(thing.ring for thing in things), *rings]
        codes: dict[str | int, int] = {}
        owners = np.array([codes.setdefault(r.owner or i, i) for i, r in enumerate(known)])
        is_value = np.array([ring.kind == "value" for ring in known])
        self.window = np.array([window], float).T
        self.sizes = np.array([(thing.width, thing.height) for thing in things], float).T
        self.circles = np.array([(ring.x, ring.y, ring.radius) for ring in known], float).T
        self.levels = np.where(is_value[:n, None], LEVELS[::-1], LEVELS)
        self.is_own = owners[:n, None] == owners
        self.is_kept_free = ~is_value | is_value[:n, None]
        self.is_rival = (is_value[:n, None] == is_value) & ~self.is_own
        is_about = _distances(self.circles[[0, 1, 0, 1], :n], self.circles) < self.circles[2, :n]
        self.is_own |= is_value[:n, None] & ~is_value & is_about.T  # a line begins in these
        self.outward = _outward(self.circles)[:n]
        self.sides = _sides(self)
        self.is_clear = _are_clear(self)
        self.labels: dict[int, Label] = {}
        self.names: list[Box] = []
        self.leaders: list[Box] = []

    def put(self, index: int, label: Label) -> None:
        """Place a thing's name."""
        self.labels[index] = label
        self.names.append(_grown(np.array(label.box)).tolist())
        if label.leader is not None:
            self.leaders.append(label.leader)


_Places: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]
"""(4, C) boxes, (4, C) lines that lead there and their (C,) costs in pixels, the least first."""


def _is_seen(ring: Ring, kind: str, window: Size) -> bool:
    return ring.kind == kind and 0 <= ring.x <= window[0] and 0 <= ring.y <= window[1]


def _outward(circles: FloatArray) -> FloatArray:
    """Return 1 for (3, R) circles whose outer side is the right one, else -1.

    What stands about in the middle has the right one: a small movement does not change it.
    """
    x, _y, radius = circles
    spread = np.abs(x - x.mean()).mean()
    return np.where(x < x.mean() - np.maximum(spread / 2, radius), -1.0, 1.0)


def _sides(scene: _Scene) -> FloatArray:
    """Return (4, N, S) boxes beside rings: at the outer side, the inner one, above and below."""
    x, y, radius = scene.circles[:, : scene.sizes.shape[1], None]
    width, height = scene.sizes[..., None]
    away, reach = radius + GAP_PX, (radius + height) / 2
    side = scene.outward[:, None] * np.repeat((1.0, -1.0), len(LEVELS))
    middle = x + side * (away + width / 2)
    level = y + np.tile(scene.levels, 2) * reach
    above, below = y - away - height / 2, y + away + height / 2
    return _boxes(np.hstack([middle, x, x]), np.hstack([level, above, below]), width, height)


def _boxes(x: FloatArray, y: FloatArray, width: FloatArray, height: FloatArray) -> FloatArray:
    """Return (4, ...) boxes about their middles."""
    return np.array([x - width / 2, y - height / 2, x + width / 2, y + height / 2])


def _are_clear(scene: _Scene) -> BoolArray:
    """Say which of the (N, S) sides touch no ring and are clearly nearest to their own."""
    _four, n, n_sides = scene.sides.shape
    boxes = scene.sides.reshape(4, -1)
    distances = _distances(boxes, scene.circles)
    owners = np.arange(n).repeat(n_sides)
    clearer = distances[owners, np.arange(len(owners))] + CLEARER_HEIGHTS * scene.sizes[1, owners]
    is_free = (distances > 0.99 * GAP_PX) | ~scene.is_kept_free.T[:, owners]
    is_nearest = (distances > clearer) | ~scene.is_rival.T[:, owners]
    is_clear = (is_free & is_nearest).all(axis=0) & _fit(boxes, scene)
    return np.reshape(is_clear, (n, n_sides))


def _place_beside(scene: _Scene, index: int) -> bool:
    """Place a name at the first side that is free, and say whether there is one."""
    sides = scene.sides[:, index, scene.is_clear[index]]
    if scene.leaders:
        over = _meet(_columns(scene.leaders)[..., None], _grown(sides)[:, None])
        sides = sides[:, ~over.any(axis=0)]
    apart = (box for box in sides.T.tolist() if not any(_overlap(box, n) for n in scene.names))
    if box := next(apart, None):
        scene.put(index, Label(tuple(box)))
    return box is not None


def _overlap(one: Box, other: Box) -> bool:
    """Say whether two boxes overlap: for few boxes quicker than with arrays."""
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def _places_apart(scene: _Scene, index: int) -> _Places:
    """Return where a line would lead from a thing to its name past all other rings."""
    boxes = _boxes_apart(scene, index)
    distances, led_px = _distances(boxes, scene.circles), LED_HEIGHTS * scene.sizes[1, index]
    least_px = np.where(scene.is_rival[index], max(GAP_PX, led_px), GAP_PX)
    least_px[~scene.is_kept_free[index]] = -np.inf
    least_px[index] = LEAST_LEADER_PX
    is_clear = (distances >= least_px[:, None]).all(axis=0)
    boxes, away_px = boxes[:, is_clear], distances[index, is_clear]
    leaders = _leaders(scene.circles[:, index], boxes)
    is_inward = (leaders[2] - leaders[0]) * scene.outward[index] < 0
    costs_px = away_px + is_inward * INWARD_HEIGHTS * scene.sizes[1, index]
    passed = scene.circles[:, scene.is_kept_free[index] & ~scene.is_own[index]]
    costs_px[_go_through(leaders, passed).any(axis=0)] = np.inf
    order = costs_px.argsort(kind="stable")[: np.isfinite(costs_px).sum()]
    return boxes[:, order], leaders[:, order], costs_px[order]


def _boxes_apart(scene: _Scene, index: int) -> FloatArray:
    """Return (4, C) boxes in the window: at both sides, beside all rings, above and below."""
    x, y, radius = scene.circles[:, index]
    width, height = scene.sizes[:, index]
    away = radius + width / 2 + height * np.array(COLUMNS)
    least, most = width / 2, scene.window[0, 0] - width / 2
    wanted = x, least, most, *(x - away), *(x + away)
    columns = sorted({min(max(column, least), most) for column in wanted})
    rows = y + height * np.array(ROWS)
    boxes = _boxes(np.tile(columns, len(rows)), np.repeat(rows, len(columns)), width, height)
    return boxes[:, _fit(boxes, scene)]


def _leaders(circle: FloatArray, boxes: FloatArray) -> FloatArray:
    """Return (4, C) lines from a circle's edge to boxes: to the middle half of their near side."""
    center = circle[:2, None]
    nearest = np.minimum(np.maximum(center, boxes[:2]), boxes[2:])
    quarter = (boxes[2:] - boxes[:2]) / 4
    inner = np.minimum(np.maximum(center, boxes[:2] + quarter), boxes[2:] - quarter)
    is_beside = nearest[0] != center[0]
    ends = np.where([is_beside, ~is_beside], nearest, inner)
    return np.vstack([center + (ends - center) * (circle[2] / np.hypot(*(ends - center))), ends])


def _place_apart(scene: _Scene, index: int, places: _Places, limit_heights: float) -> bool:
    """Place a name where it and a line so long are free, and say whether there is a place."""
    boxes, leaders, costs_px = places
    n = costs_px.searchsorted(limit_heights * scene.sizes[1, index], side="right")
    is_free = _are_free(boxes[:, :n], leaders[:, :n], scene)
    if is_free.any():
        first = is_free.argmax()
        box, leader = boxes[:, first].tolist(), leaders[:, first].tolist()
        scene.put(index, Label(tuple(box), tuple(leader)))
    return bool(is_free.any())


def _are_free(boxes: FloatArray, leaders: FloatArray, scene: _Scene) -> BoolArray:
    """Say which (4, C) boxes and lines touch no name and no line that has been placed."""
    names, others = _columns(scene.names)[..., None], _columns(scene.leaders)[..., None]
    boxes, lines = boxes[:, None], leaders[:, None]
    upon = ((boxes[:2] < names[2:]) & (names[:2] < boxes[2:])).all(axis=0)
    across = _part(lines, others) & _part(others, lines)
    touched = [upon, across, _meet(lines, names), _meet(others, _grown(boxes))]
    return np.asarray(~np.vstack(touched).any(axis=0))


def _columns(rows: list[Box]) -> FloatArray:
    return np.array(rows, float).reshape(-1, 4).T


def _grown(boxes: FloatArray) -> FloatArray:
    return np.concatenate([boxes[:2] - NAMES_GAP_PX, boxes[2:] + NAMES_GAP_PX])


def _fit(boxes: FloatArray, scene: _Scene) -> BoolArray:
    """Say which (4, C) boxes lie in the window."""
    return np.asarray(((boxes[:2] >= 0) & (boxes[2:] <= scene.window)).all(axis=0))


def _distances(boxes: FloatArray, circles: FloatArray) -> FloatArray:
    """Return (R, C): how far (4, C) boxes are from (3, R) circles; negative within them."""
    x, y, radius = circles[..., None]
    left, top, right, bottom = boxes
    across = np.maximum(np.maximum(left - x, x - right), 0)
    down = np.maximum(np.maximum(top - y, y - bottom), 0)
    return np.asarray(np.sqrt(across * across + down * down) - radius)


def _go_through(lines: FloatArray, circles: FloatArray) -> BoolArray:
    """Say which (3, R) circles are touched by which (4, C) lines, (R, C)."""
    x, y, radius = circles[..., None]
    x1, y1, x2, y2 = lines
    dx, dy = x2 - x1, y2 - y1
    share = ((x - x1) * dx + (y - y1) * dy) / (dx * dx + dy * dy)
    share = np.minimum(np.maximum(share, 0), 1)
    across, down = x - x1 - share * dx, y - y1 - share * dy
    return np.asarray(across * across + down * down < (radius + NAMES_GAP_PX) ** 2)


def _meet(lines: FloatArray, boxes: FloatArray) -> BoolArray:
    """Say whether (4, ...) lines touch (4, ...) boxes: no side of a box and no line parts them."""
    (dx, dy), (width, height) = lines[2:] - lines[:2], boxes[2:] - boxes[:2]
    x, y = lines[:2] + lines[2:] - boxes[:2] - boxes[2:]
    far, deep = np.abs(dx), np.abs(dy)
    is_near = (np.abs(x) < far + width) & (np.abs(y) < deep + height)
    return np.asarray(is_near & (np.abs(dx * y - dy * x) < far * height + deep * width))


def _part(lines: FloatArray, others: FloatArray) -> BoolArray:
    """Say whether the ends of (4, ...) others lie at both sides of (4, ...) lines."""
    x, y, x2, y2 = lines
    start = (x2 - x) * (others[1] - y) - (y2 - y) * (others[0] - x)
    end = (x2 - x) * (others[3] - y) - (y2 - y) * (others[2] - x)
    return np.asarray(start * end < 0)
