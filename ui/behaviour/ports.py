"""What the presenters of the behaviour screen need, without Qt."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeAlias

from adibas.arrays import Float32Array, UInt8Array
from adibas.errors import AdibasError
from ui.events import Event

if TYPE_CHECKING:
    from adibas.behaviour.editing import Draft, History
    from adibas.pipeline.coding_drafts import DraftPlace
    from adibas.pipeline.recording_access import RecordingAccess
    from adibas.recordings.ports import RecordingReader

Picture: TypeAlias = UInt8Array | Float32Array
"""(H, W, 3) colours, or (H, W) depth in metres where there is no colour."""


@dataclass(frozen=True, slots=True)
class Source:
    """A recording that can be coded.

    Attributes
    ----------
    title : str
        For the reader.
    name : str
        What codings call it: its file without endings, or the beginning of its id.
    path : Path
        Its file, or its id in the store.
    access : RecordingAccess
        How it is reached.
    place_for : callable
        Gives the place of a draft for the initials of a second observer; none for the first.
    session_id : str
        Of the session whose recording it is; empty for a file.
    parts : tuple of str
        Names of the recordings that are watched one after another; empty for a single one.
    rotation_deg : int
        How far the pictures of its session are turned clockwise to be upright.
    """

    title: str
    name: str
    path: Path
    access: "RecordingAccess"
    place_for: "Callable[[str], DraftPlace]"
    session_id: str = ""
    parts: tuple[str, ...] = ()
    rotation_deg: int = 0


class FrameFeed(Protocol):
    """Reads frames of a recording beside the window; what it tells arrives in its thread.

    Attributes
    ----------
    arrived : Event
        (index, picture): a frame that was asked for. Of several that were asked for meanwhile,
        the last one alone comes.
    failed : Event
        (index, error): a frame that cannot be read.
    """

    arrived: Event[[int, Picture]]
    failed: Event[[int, AdibasError]]

    def show(self, reader: "RecordingReader | None") -> None:
        """Read from this recording from now on, and close the one before."""

    def ask(self, index: int) -> None:
        """Read a frame as soon as it can be."""

    def close(self) -> None:
        """End, and wait until no thread is left."""


class Keeper(Protocol):
    """Keeps drafts beside the window: of one place the newest, in their order."""

    def keep(self, place: "DraftPlace", history: "History[Draft]", at_ms: int) -> None:
        """Write a draft and its steps as soon as it can be, in place of what still waits."""

    def flush(self) -> bool:
        """Wait until everything is on the disk; return whether it is."""

    def close(self) -> None:
        """Flush, and keep no more."""
