"""A recording whose every frame shows its number, and a frame feed that is done at once."""

import numpy as np

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import AdibasError
from adibas.recordings import create_recording
from adibas.recordings.ports import RecordingOptions
from ui.behaviour.frame_feed import picture_of
from ui.events import Event

N_FRAMES = 90
FRAME_MS = 33
START_MS = 5000
INFO = SourceInfo(depth_unit_m=0.001, frame_rate_hz=30.0, sensor_name="test", sensor_serial="T1")


def time_ms(index):
    """Return when a frame was taken."""
    return START_MS + FRAME_MS * index


def make_frames(n_frames, *, color=True):
    """Return grey frames, each as bright as its number, after 255 from 0 again."""
    frames = []
    for index in range(n_frames):
        time_ns = time_ms(index) * 1_000_000
        frames.append(
            SensorFrame(
                sequence=index,
                timestamp_ns=time_ns,
                depth_raw=np.full((24, 32), 1000 + index, np.uint16),
                color=np.full((24, 32, 3), index % 256, np.uint8) if color else None,
                color_timestamp_ns=time_ns if color else None,
            )
        )
    return frames


def make_recording(path, n_frames=N_FRAMES, *, color=True):
    """Record such frames."""
    with create_recording(path, INFO, RecordingOptions(color="png")) as writer:
        for frame in make_frames(n_frames, color=color):
            writer.write(frame)
    return path


class InlineFeed:
    """Reads a frame when it is asked for, unless it is told to wait."""

    def __init__(self):
        self.arrived, self.failed = Event(), Event()
        self.reader = None
        self.waits = False
        self.asked = []
        self.is_closed = False

    def show(self, reader):
        if self.reader is not None:
            self.reader.close()
        self.reader = reader

    def ask(self, index):
        self.asked.append(index)
        if not self.waits:
            self.give(index)

    def give(self, index):
        """Let a frame arrive."""
        try:
            picture = picture_of(self.reader.read(index), self.reader.info)
        except AdibasError as error:
            self.failed.emit(index, error)
        else:
            self.arrived.emit(index, picture)

    def close(self):
        self.show(None)
        self.is_closed = True
