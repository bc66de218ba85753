"""Where names stand beside what they name, so that they can be read; without Qt."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

Box: TypeAlias = tuple[float, float, float, float]
"""Left, top, right and bottom, in pixels."""

GAP_PX = 3.0


@dataclass(frozen=True, slots=True)
class Named:
    """A round thing at (x, y), and the size of the name that it wants; pixels."""

    x: float
    y: float
    radius: float
    width: float
    height: float


def place_labels(
    things: Sequence[Named], window: tuple[float, float], taken: Sequence[Box] = ()
) -> tuple[Box, ...]:
    """Return a box for each name: at the first of eight sides where it hides nothing.

    Things come first, names after them in the order given; where every side would hide something,
    the side that hides least many. `taken` is what else should be seen, `window` its
    (width, height).
    """
    blocked = [*taken, *(_about(thing) for thing in things if thing.radius > 0)]
    placed: list[Box] = []
    for thing in things:
        box = _best(thing, window, blocked)
        placed.append(box)
        blocked.append(box)
    return tuple(placed)


def _best(thing: Named, window: tuple[float, float], blocked: Sequence[Box]) -> Box:
    best, fewest = next(_sides(thing)), len(blocked) + 2
    for box in _sides(thing):
        n_hidden = _outside(box, window) + sum(_overlap(box, other) for other in blocked)
        if n_hidden < fewest:
            best, fewest = box, n_hidden
        if not fewest:
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


def _about(thing: Named) -> Box:
    return (
        thing.x - thing.radius,
        thing.y - thing.radius,
        thing.x + thing.radius,
        thing.y + thing.radius,
    )


def _overlap(one: Box, other: Box) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def _outside(box: Box, window: tuple[float, float]) -> bool:
    return box[0] < 0 or box[1] < 0 or box[2] > window[0] or box[3] > window[1]
