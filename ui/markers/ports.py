"""The learner's screen as its presenter needs it. Knows nothing of Qt."""

from dataclasses import dataclass
from typing import Literal, Protocol

from adibas.arrays import BoolArray, UInt8Array
from adibas.markers.detection import Detections

Mode = Literal["color", "led"]


@dataclass(frozen=True, slots=True)
class Shown:
    """What the learner's controls show.

    Attributes
    ----------
    mode : str
        ``color`` or ``led``.
    sensitivity, n_clusters, least_brightness : float, int
        Of the controls.
    regions : tuple of ((r, g, b), pixels)
        One for each click.
    swatches : tuple of (r, g, b)
        Colours of the centroids.
    has_picture, has_target : bool
        Whether a picture is held still, and whether there is something to look for.
    """

    mode: Mode
    sensitivity: float
    n_clusters: int
    least_brightness: float
    regions: tuple[tuple[tuple[int, int, int], int], ...]
    swatches: tuple[tuple[int, int, int], ...]
    has_picture: bool
    has_target: bool


class LearnerView(Protocol):
    """The screen, as this presenter needs it."""

    def show_picture(self, picture_rgb: UInt8Array | None, *, is_frozen: bool) -> None:
        """Show a live or a frozen picture; None where there is none yet."""

    def show_taken(self, taken: BoolArray | None) -> None:
        """Tint the pixels that the clicks took."""

    def show_found(self, found: Detections | None) -> None:
        """Draw and count the markers that are found so far."""

    def show_controls(self, shown: Shown) -> None:
        """Show regions, swatches and sliders."""
