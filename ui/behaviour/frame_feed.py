"""Reads frames in a thread of its own and brings them to the window's."""

import threading
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from adibas.data.frames import SensorFrame, SourceInfo, depth_in_metres
from adibas.errors import AdibasError, RecordingError
from adibas.pipeline.newest import Newest
from adibas.recordings.decoding import decode_color
from ui.behaviour.ports import FrameFeed, Picture
from ui.events import Event
from ui.frame_bridge import NewestBridge

if TYPE_CHECKING:
    from adibas.recordings.ports import RecordingReader


class QtFrameFeed(FrameFeed):
    """One thread for each recording: a reader is of one thread at a time."""

    def __init__(self, parent: QObject | None = None) -> None:
        self.arrived: Event[[int, Picture]] = Event()
        self.failed: Event[[int, AdibasError]] = Event()
        self._bridge = NewestBridge(self._tell, parent)
        self._reading: _Reading | None = None

    def show(self, reader: "RecordingReader | None") -> None:
        """Read from this recording from now on, and close the one before."""
        if self._reading is not None:
            self._reading.close()
        self._reading = None if reader is None else _Reading(reader, self._bridge)

    def ask(self, index: int) -> None:
        """Read a frame as soon as it can be."""
        if self._reading is not None:
            self._reading.wanted.put(index)

    def close(self) -> None:
        """End, and wait until no thread is left."""
        self.show(None)

    def _tell(self, thing: object) -> None:
        if not isinstance(thing, _Read) or thing.reading is not self._reading:
            return  # of a recording that was left
        if isinstance(thing.found, AdibasError):
            self.failed.emit(thing.index, thing.found)
        else:
            self.arrived.emit(thing.index, thing.found)


class _Reading:
    """The thread that reads one recording."""

    def __init__(self, reader: "RecordingReader", bridge: NewestBridge) -> None:
        self.wanted: Newest[int] = Newest()
        self._reader = reader
        self._bridge = bridge
        self._thread = threading.Thread(target=self._run, name="frames", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread and close the recording."""
        self.wanted.close()
        self._thread.join()

    def _run(self) -> None:
        with self._reader as reader:
            while (index := self.wanted.take()) is not None:
                self._bridge.publish(_Read(self, index, _read(reader, index)))


class _Read:
    """A frame, or why there is none."""

    def __init__(self, reading: _Reading, index: int, found: Picture | AdibasError) -> None:
        self.reading = reading
        self.index = index
        self.found = found


def _read(reader: "RecordingReader", index: int) -> Picture | AdibasError:
    try:
        return picture_of(reader.read(index), reader.info)
    except AdibasError as error:
        return error


def picture_of(frame: SensorFrame, info: SourceInfo) -> Picture:
    """Return the colours of a frame, or its depth in metres where it has none.

    Raises
    ------
    RecordingError
        It is damaged, or holds neither.
    """
    if frame.color is not None:
        return decode_color(frame.color, frame.sequence)
    if frame.depth_raw is None:
        raise RecordingError("Frame {sequence} holds no picture.", sequence=frame.sequence)
    return depth_in_metres(frame.depth_raw, info.depth_unit_m)
