"""Where names stand beside what they name, so that they can be read; without Qt."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import TypeAlias

Box: TypeAlias = tuple[float, float, float, float]
"""Left, top, right and bottom, in pixels."""
Size: TypeAlias = tuple[float, float]
"""Width and height, in pixels."""

GAP_PX = 3.0
N_ROWS, N_COLUMNS = 6, 3
"""How far a name may go away, in half heights up or down and in half widths to the side."""


@dataclass(frozen=True, slots=True)
class Named:
    """A round thing at (x, y), and the size of the name that it wants; pixels."""

    x: float
    y: float
    radius: float
    width: float
    height: float


def place_labels(
    things: Sequence[Named], window: Size, taken: Sequence[Box] = ()
) -> tuple[Box | None, ...]:
    """Return a box for each name: at the first of eight sides where it hides nothing.

    Where every side would hide something it goes farther away, as near as there is room; where
    there is none, it stands where it hides least many things, but never another name: None
    where it would, and for a thing outside the window. Names are placed in the order given.
    `taken` is what else should be seen, `window` its (width, height).
    """
    hidden = [*taken, *(_about(thing) for thing in things if thing.radius > 0)]
    placed: list[Box | None] = []
    for thing in things:
        names = [box for box in placed if box is not None]
        placed.append(_best(thing, window, hidden, names))
    return tuple(placed)


def leader(thing: Named, box: Box) -> tuple[float, float] | None:
    """Return where a line from the thing to its name ends; None where the name stands beside it."""
    x, y = min(max(thing.x, box[0]), box[2]), min(max(thing.y, box[1]), box[3])
    is_beside = math.dist((x, y), (thing.x, thing.y)) <= 1.5 * (thing.radius + GAP_PX) + 1.0
    return None if is_beside else (x, y)


def _best(thing: Named, window: Size, hidden: Sequence[Box], names: Sequence[Box]) -> Box | None:
    """Return the first place that hides nothing, else the one that hides least."""
    if not (0 <= thing.x <= window[0] and 0 <= thing.y <= window[1]):
        return None
    best, fewest = None, math.inf
    for box in chain(_sides(thing), _farther(thing)):
        if not _is_within(box, window) or any(_overlap(box, name) for name in names):
            continue
        n_hidden = sum(_overlap(box, other) for other in hidden)
        if n_hidden < fewest:
            best, fewest = box, n_hidden
        if n_hidden == 0:
            break
    return best


def _sides(thing: Named) -> Iterator[Box]:
    """Right above, right, right below, left, left above, left below, above, below."""
    right, left = thing.x + thing.radius + GAP_PX, thing.x - thing.radius - GAP_PX - thing.width
    middle = thing.y - thing.height / 2
    high, low = middle - thing.radius - GAP_PX, middle + thing.radius + GAP_PX
    across = thing.x - thing.width / 2
    above = thing.y - thing.radius - GAP_PX - thing.height
    below = thing.y + thing.radius + GAP_PX
    for x, y in (
        *((right, high), (right, middle), (right, low)),
        *((left, middle), (left, high), (left, low)),
        *((across, above), (across, below)),
    ):
        yield x, y, x + thing.width, y + thing.height


def _farther(thing: Named) -> Iterator[Box]:
    """Return places at either side that a line has to lead to, the nearest first."""
    boxes = [
        (left, top, left + thing.width, top + thing.height)
        for top in (
            thing.y - thing.height / 2 + row * (thing.height + GAP_PX) / 2
            for row in range(-N_ROWS, N_ROWS + 1)
        )
        for column in range(N_COLUMNS)
        for left in _either_side(thing, thing.radius + 2 * GAP_PX + column * thing.width / 2)
    ]
    yield from sorted(boxes, key=lambda box: _distance(thing, box))


def _either_side(thing: Named, away: float) -> tuple[float, float]:
    return thing.x + away, thing.x - away - thing.width


def _distance(thing: Named, box: Box) -> float:
    return math.dist((thing.x, thing.y), ((box[0] + box[2]) / 2, (box[1] + box[3]) / 2))


def _about(thing: Named) -> Box:
    return (
        thing.x - thing.radius,
        thing.y - thing.radius,
        thing.x + thing.radius,
        thing.y + thing.radius,
    )


def _overlap(one: Box, other: Box) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def _is_within(box: Box, window: Size) -> bool:
    return box[0] >= 0 and box[1] >= 0 and box[2] <= window[0] and box[3] <= window[1]
