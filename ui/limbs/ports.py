"""What the presenter of the limb editor needs of its page, without Qt."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol

from adibas.arrays import BoolArray, UInt8Array

if TYPE_CHECKING:
    from adibas.pipeline.limb_label_files import LabellingProgress
    from adibas.recordings.ports import RecordingReader

Tool = Literal["brush", "fill", "polygon"]
Corners = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class StoredRecording:
    """A recording of the store; its labelled images must leave the store to be trained on.

    Attributes
    ----------
    title : str
        For the reader.
    name : str
        What the folder of labels calls it.
    open : callable
        Opens it.
    note_export : callable
        Logs that images leave the store; raises where that cannot be logged.
    rotation_deg : int
        How far the pictures of its session are turned clockwise to be upright.
    """

    title: str
    name: str
    open: "Callable[[], RecordingReader]"
    note_export: Callable[[], None]
    rotation_deg: int = 0


@dataclass(frozen=True, slots=True)
class Allowed:
    """What can be done now."""

    is_open: bool = False
    is_busy: bool = False
    can_undo: bool = False
    can_redo: bool = False
    can_enclose: bool = False
    is_last: bool = True

    @property
    def can_edit(self) -> bool:
        """Whether a frame is there, and nothing runs."""
        return self.is_open and not self.is_busy


class LimbsView(Protocol):
    """The page, as its presenter needs it."""

    def ask_folder(self, title: str) -> None:
        """Ask where the labelled images of a recording of the store may lie, unsealed."""

    def show_recording(self, name: str, folder: str) -> None:
        """Show what is open, and where the images go."""

    def show_labels(self, names: tuple[str, ...], colors: UInt8Array) -> None:
        """Offer these labels; the first of (L + 1, 3) colours is that of none."""

    def show_picture(self, picture: UInt8Array, person: BoolArray) -> None:
        """Show the frame with its labels, and the outline of the person."""

    def show_corners(self, corners: Corners) -> None:
        """Show the polygon that is being drawn."""

    def show_under(self, name: str) -> None:
        """Tell which limb is under the mouse or the cross."""

    def show_progress(self, index: int, progress: "LabellingProgress") -> None:
        """Show which frame is seen, and how many are done."""

    def show_allowed(self, allowed: Allowed) -> None:
        """Offer what can be done now."""
