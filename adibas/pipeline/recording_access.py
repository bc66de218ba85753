"""How recordings are reached: as files, or sealed in the store of sessions."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from adibas.recordings import open_recording
from adibas.recordings.checksum import recording_sha256
from adibas.recordings.ports import RecordingReader


@dataclass(frozen=True, slots=True)
class RecordingAccess:
    """How a recording is opened, and what its checksum is.

    Attributes
    ----------
    open : callable
        Takes what names the recording: its path, or its id in a store.
    sha256 : callable
        The same.
    """

    open: Callable[[Path], RecordingReader] = open_recording
    sha256: Callable[[Path], str] = recording_sha256


FILES = RecordingAccess()
