"""The sensor of the core, told to the window in the window's own thread."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Lock
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from adibas.pipeline.live_frames import LiveFrame, Naming, SensorState
from adibas.sensors.ports import SensorOptions
from adibas.sensors.sources import open_source
from ui.events import Event
from ui.frame_bridge import CallBridge, NewestBridge

if TYPE_CHECKING:  # they bring the compiler along, and the window does without at its start
    from adibas.data.board import Board
    from adibas.pipeline.acquisition import Opener
    from adibas.pipeline.live import LiveView
    from adibas.pipeline.posture import MarkerTarget


class QtLiveSource(QObject):
    """Owns the live core; frames drop where the window is slow, states never.

    Closing a sensor waits for its last read, a second where it is silent: a thread of its own does
    that. Every order has a number, and what the core tells bears that of its own order.

    Parameters
    ----------
    opener : callable
        Opens a source; another one in tests.
    """

    def __init__(self, parent: QObject | None = None, opener: "Opener" = open_source) -> None:
        super().__init__(parent)
        self.frame_arrived: Event[[LiveFrame]] = Event()
        self.state_changed: Event[[SensorState]] = Event()
        self._newest: LiveFrame | None = None
        self._state = SensorState("closed")
        self._opened: tuple[str, SensorOptions] | None = None
        self._number = 0
        self._has_ended = False
        frames, states = NewestBridge(self._on_frame, self), CallBridge(self._on_state, self)
        self._listener = _Listener(frames, states)
        self._opener = opener
        self._core: LiveView | None = None
        self._core_lock = Lock()
        self._target: MarkerTarget | None = None
        self._naming: Naming | None = None
        self._rotation_deg = 0
        self._board: Board | None = None
        self._orders = ThreadPoolExecutor(1, thread_name_prefix="live-orders")

    @property
    def newest(self) -> LiveFrame | None:
        """The newest frame; None before the first and after the last."""
        return self._newest

    @property
    def state(self) -> SensorState:
        """What the source fares that was ordered last."""
        return self._state

    @property
    def opened(self) -> tuple[str, SensorOptions] | None:
        """What was opened last, also where it was closed since."""
        return self._opened

    @property
    def view(self) -> "LiveView":
        """The core behind it; made, and its modules loaded, when it is first asked for."""
        from adibas.pipeline.live import LiveView

        with self._core_lock:
            if self._core is None:
                self._core = LiveView(self._listener, opener=self._opener)
                self._core.set_target(self._target)
                self._core.set_naming(self._naming)
                self._core.set_rotation(self._rotation_deg)
                self._core.set_board(self._board)
            return self._core

    def open(self, source: str, options: SensorOptions) -> None:
        """Show another source from now on."""
        self._opened = (source, options)
        self._order(SensorState("opening"), lambda: self.view.open(source, options))

    def set_target(self, target: "MarkerTarget | None") -> None:
        """Look for these markers."""
        with self._core_lock:
            self._target = target
            if self._core is not None:
                self._core.set_target(target)

    def set_naming(self, naming: Naming | None) -> None:
        """Name markers after these landmarks."""
        with self._core_lock:
            self._naming = naming
            if self._core is not None:
                self._core.set_naming(naming)

    def set_rotation(self, rotation_deg: int) -> None:
        """Say how far the picture is turned for showing."""
        with self._core_lock:
            self._rotation_deg = rotation_deg
            if self._core is not None:
                self._core.set_rotation(rotation_deg)

    def set_board(self, board: "Board | None") -> None:
        """Look for this board in place of a person; None: for persons again."""
        with self._core_lock:
            self._board = board
            if self._core is not None:
                self._core.set_board(board)

    def close(self) -> None:
        """Let go of the sensor."""
        self._order(SensorState("closed"), None)

    def end(self) -> None:
        """Let go of the sensor and wait until no thread is left; a second call does nothing."""
        if not self._has_ended:
            self._has_ended = True
            self.close()
            self._orders.shutdown(wait=True)

    def _order(self, state: SensorState, action: Callable[[], None] | None) -> None:
        self._number += 1
        self._newest = None
        self._orders.submit(self._follow, self._number, action)
        self._state = state
        self.state_changed.emit(state)

    def _follow(self, number: int, action: Callable[[], None] | None) -> None:
        """Follow an order, in the thread of orders, unless a newer one waits behind it."""
        if number != self._number:
            return
        with self._core_lock:
            core = self._core
        if core is not None:
            core.close()
        self._listener.number = number
        if action is not None:
            action()

    def _on_frame(self, told: object) -> None:
        frame = self._current(told)
        if isinstance(frame, LiveFrame):
            self._newest = frame
            self.frame_arrived.emit(frame)

    def _on_state(self, told: object) -> None:
        state = self._current(told)
        if isinstance(state, SensorState):
            self._state = state
            self.state_changed.emit(state)

    def _current(self, told: object) -> object | None:
        """Return what was told, None where it comes of a source that was left."""
        return told.thing if isinstance(told, _Told) and told.number == self._number else None


class _Told:
    """A frame or a state, and the order that it comes of."""

    __slots__ = ("number", "thing")

    def __init__(self, number: int, thing: object) -> None:
        self.number, self.thing = number, thing


class _Listener:
    """Hands over from the core's threads."""

    def __init__(self, frames: NewestBridge, states: CallBridge) -> None:
        self._frames = frames
        self._states = states
        self.number = 0

    def frame_arrived(self, frame: LiveFrame) -> None:
        """Take a frame."""
        self._frames.publish(_Told(self.number, frame))

    def state_changed(self, state: SensorState) -> None:
        """Take a state."""
        self._states.publish(_Told(self.number, state))
