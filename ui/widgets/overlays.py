"""What is drawn over a picture, in the picture's own pixels; without Qt."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from adibas.arrays import BoolArray

Role = Literal[
    "marker",
    "selected",
    "rejected",
    "corrected",
    "outline",
    "plumb",
    "measure",
    "focus",
    "earlier",
    "later",
    "bone",
    "markerless",
]


@dataclass(frozen=True, slots=True)
class Dot:
    """A marker: a circle about it, and its name.

    `is_movable` dots can be dragged, `is_pickable` ones only chosen; a press is told with `name`.
    `radius_px` is the marker's own.
    """

    u: float
    v: float
    radius_px: float
    label: str = ""
    role: Role = "marker"
    is_movable: bool = False
    tooltip: str = ""
    is_pickable: bool = False
    key: str = ""
    """Tells dots without a label apart."""

    @property
    def name(self) -> str:
        """What the dot is called in signals."""
        return self.key or self.label


@dataclass(frozen=True, slots=True)
class Line:
    """From one pixel to another, with a text at its middle."""

    u1: float
    v1: float
    u2: float
    v2: float
    role: Role = "measure"
    text: str = ""


@dataclass(frozen=True, slots=True)
class Curve:
    """From pixel (u, v) to pixel, with a text at its middle."""

    points: tuple[tuple[float, float], ...]
    role: Role = "measure"
    text: str = ""


@dataclass(frozen=True, slots=True)
class Text:
    """Words at a pixel."""

    u: float
    v: float
    text: str
    role: Role = "measure"


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """The pixels of a (H, W) mask of the picture's size: its outline, or tinted."""

    pixels: BoolArray
    role: Role = "outline"
    is_filled: bool = False


Overlay: TypeAlias = Dot | Line | Curve | Text | Region
