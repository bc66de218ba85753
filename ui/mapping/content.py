"""What the map dialog shows; without Qt."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from adibas.data.sentence import Sentence
from adibas.texts import message
from ui.widgets.space import Space

if TYPE_CHECKING:  # they bring the compiler along, and the window does without at its start
    from collections.abc import Callable

    from adibas.pipeline.map_preview import MapPicture
    from adibas.pipeline.mapping import MappedRecording
    from adibas.pipeline.recording_access import RecordingAccess

FACTS = message(
    "{points} points from {placed} of {frames} frames; the camera went {path} m; loops closed: "
    "{loops}."
)


@dataclass(frozen=True, slots=True)
class RecordingToMap:
    """What is mapped.

    Attributes
    ----------
    title : str
        For the reader.
    name : str
        What files are called after it.
    path : Path
        As `access` knows it.
    access : RecordingAccess
    note_export : callable
        Logs that something of a patient leaves the store; raises where nothing may leave.
    """

    title: str
    name: str
    path: Path
    access: "RecordingAccess"
    note_export: "Callable[[], None]"


@dataclass(frozen=True, slots=True)
class Standing:
    """How far mapping is.

    Attributes
    ----------
    is_running : bool
    has_begun : bool
        It was stopped, and can go on.
    has_map : bool
        It is done, and can be saved.
    """

    is_running: bool = False
    has_begun: bool = False
    has_map: bool = False


class MapView(Protocol):
    """The dialog, as its presenter needs it."""

    def show_standing(self, standing: Standing) -> None:
        """Offer what can be done now."""

    def show_progress(self, done: int, total: int) -> None:
        """Show how far it is; a total of 0 is not known."""

    def show_growing(self, space: Space) -> None:
        """Show the surface as far as it goes; it is looked at from where it was."""

    def show_told(self, sentences: tuple[str, ...], *, is_problem: bool) -> None:
        """Say what came of it, one sentence a line."""


def space_of(picture: "MapPicture") -> Space:
    """Return a map as the 3-D view shows it."""
    return Space(picture.discs, path_m=picture.path_m)


def told_of(mapped: "MappedRecording") -> tuple[Sentence, ...]:
    """Return what is told of a map."""
    from adibas.reports.map_files import motion_sentence

    facts = Sentence(
        FACTS,
        {
            "points": len(mapped.surface.points_m),
            "placed": len(mapped.world_from_camera),
            "frames": mapped.n_frames,
            "path": mapped.path_m,
            "loops": mapped.n_loops,
        },
    )
    motion = () if mapped.motion is None else (motion_sentence(mapped.motion),)
    return (facts, *motion, *mapped.notices)
