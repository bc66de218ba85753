"""The sensor of the core, told to the window in the window's own thread."""

from PySide6.QtCore import QObject

from adibas.pipeline.live import LiveFrame, LiveView, SensorState
from adibas.pipeline.posture import MarkerTarget
from adibas.sensors.ports import SensorOptions
from ui.events import Event
from ui.frame_bridge import CallBridge, NewestBridge


class QtLiveSource(QObject):
    """Owns the live core; frames drop where the window is slow, states never."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.frame_arrived: Event[[LiveFrame]] = Event()
        self.state_changed: Event[[SensorState]] = Event()
        self._newest: LiveFrame | None = None
        self._frames = NewestBridge(self._on_frame, self)
        self._states = CallBridge(self._on_state, self)
        self._view = LiveView(_Listener(self._frames, self._states))
        self._state = SensorState("closed")

    @property
    def newest(self) -> LiveFrame | None:
        """The newest frame; None before the first and after the last."""
        return self._newest

    @property
    def state(self) -> SensorState:
        """What the sensor does."""
        return self._state

    @property
    def view(self) -> LiveView:
        """The core behind it."""
        return self._view

    def open(self, source: str, options: SensorOptions) -> None:
        """Show another source from now on."""
        self._newest = None
        self._view.open(source, options)

    def set_target(self, target: MarkerTarget | None) -> None:
        """Look for these markers."""
        self._view.set_target(target)

    def close(self) -> None:
        """Let go of the sensor and end its threads."""
        self._view.close()
        self._newest = None

    def _on_frame(self, frame: object) -> None:
        if isinstance(frame, LiveFrame):
            self._newest = frame
            self.frame_arrived.emit(frame)

    def _on_state(self, state: object) -> None:
        if isinstance(state, SensorState):
            self._state = state
            self.state_changed.emit(state)


class _Listener:
    """Hands over from the core's threads."""

    def __init__(self, frames: NewestBridge, states: CallBridge) -> None:
        self._frames = frames
        self._states = states

    def frame_arrived(self, frame: LiveFrame) -> None:
        """Take a frame."""
        self._frames.publish(frame)

    def state_changed(self, state: SensorState) -> None:
        """Take a state."""
        self._states.publish(state)
