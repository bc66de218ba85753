"""A sensor that tests drive by hand, and a listener that they can ask what it was told."""

import queue
import threading
from dataclasses import replace

import numpy as np

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import SensorError
from adibas.sensors import DepthCamera

PERIOD_NS = 33_333_333
PATIENCE_S = 60.0
"""Only a test that fails waits so long."""

UNPLUGGED = SensorError("The sensor {sensor} was unplugged.", sensor="S")


def frame(sequence, size=(24, 32)):
    rng = np.random.default_rng(sequence)
    return SensorFrame(
        sequence=sequence,
        timestamp_ns=1_000_000 + sequence * PERIOD_NS,
        depth_raw=rng.integers(0, 5000, size, np.uint16),
        color=rng.integers(0, 256, (*size, 3), np.uint8),
        color_timestamp_ns=2_000_000 + sequence * PERIOD_NS,
    )


class DrivenCamera(DepthCamera):
    """Gives what is pushed: frames, None for the end, errors.

    It waits for a push as long as it takes, or, where `is_punctual`, for the time asked.
    """

    def __init__(self, given=(), *, is_live=True, is_punctual=False, info=None):
        self._given = queue.SimpleQueue()
        self._is_live = is_live
        self._is_punctual = is_punctual
        self._info = info or SourceInfo(sensor_name="S", frame_rate_hz=30.0)
        self.n_asked = 0
        self.is_closed = False
        self.push(*given)

    @property
    def info(self):
        return self._info

    @property
    def is_live(self):
        return self._is_live

    def push(self, *things):
        for thing in things:
            self._given.put(thing)

    def read(self, timeout_s=5.0):
        self.n_asked += 1
        try:
            thing = self._given.get(timeout=timeout_s if self._is_punctual else PATIENCE_S)
        except queue.Empty:
            raise SensorError("The sensor sends no pictures.") from None
        if isinstance(thing, Exception):
            raise thing
        return thing

    def close(self):
        self.is_closed = True


class Sources:
    """Opens the things given, one after the other: cameras, or errors; then waits for more."""

    def __init__(self, *things):
        self.things = list(things)
        self.opened = []
        self.options = []

    def __call__(self, text, options):
        self.opened.append(text)
        self.options.append(options)
        if not self.things:
            raise SensorError("There is no sensor.")
        thing = self.things.pop(0)
        if isinstance(thing, Exception):
            raise thing
        return thing


class Told:
    """A listener: what it was told, and a way to wait for it."""

    def __init__(self):
        self._changed = threading.Condition()
        self.frames = []
        self.states = []
        self.gate = threading.Event()
        self.gate.set()

    def frame_arrived(self, live_frame):
        with self._changed:
            self.frames.append(live_frame)
            self._changed.notify_all()
        assert self.gate.wait(PATIENCE_S)

    def state_changed(self, state):
        with self._changed:
            self.states.append(state)
            self._changed.notify_all()

    @property
    def kinds(self):
        return [state.kind for state in self.states]

    @property
    def sequences(self):
        return [live_frame.sequence for live_frame in self.frames]

    def wait_for(self, condition):
        with self._changed:
            assert self._changed.wait_for(condition, PATIENCE_S), (self.kinds, self.sequences)

    def wait_for_frame(self, sequence):
        self.wait_for(lambda: sequence in self.sequences)

    def wait_for_states(self, *kinds):
        self.wait_for(lambda: self.kinds == list(kinds))


def numbered(frames, first):
    """The same frames with numbers from `first` on."""
    return [replace(one, sequence=first + i) for i, one in enumerate(frames)]
