"""Looks for gestures in the newest live frame, in a thread of its own."""

import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from adibas.errors import AdibasError
from adibas.pipeline.newest import Newest
from ui.capture.gesture_presenter import GestureWatch
from ui.events import Event
from ui.frame_bridge import CallBridge

if TYPE_CHECKING:
    from adibas.data.calibration import RgbdCalibration
    from adibas.pipeline.live_frames import LiveFrame


class QtGestureWatch(GestureWatch):
    """One thread for each choice of models; it skips frames that come while it looks.

    Of another choice nothing is told any more, but the window does not wait for its thread: that
    may still compile what it runs.

    Parameters
    ----------
    calibration : callable
        Returns the calibration in use, None where there is none; called in that thread.
    """

    def __init__(
        self, calibration: "Callable[[], RgbdCalibration | None]", parent: QObject | None = None
    ) -> None:
        self.seen: Event[[str]] = Event()
        self.unseen: Event[[str]] = Event()
        self.failed: Event[[AdibasError]] = Event()
        self._calibration = calibration
        self._bridge = CallBridge(self._tell, parent)
        self._watching: _Watching | None = None
        self._ending: list[_Watching] = []

    def use(self, models: tuple[Path, ...]) -> None:
        """Look for the gestures of these models from now on; none: for nothing."""
        if self._watching is not None:
            self._watching.end()
            running = [one for one in self._ending if one.is_running]
            self._ending = [*running, self._watching]
        self._watching = _Watching(models, self._calibration, self._bridge) if models else None

    def put(self, frame: "LiveFrame") -> None:
        """Look at a frame as soon as there is time."""
        if self._watching is not None:
            self._watching.wanted.put(frame)

    def close(self) -> None:
        """End, and wait until no thread is left."""
        self.use(())
        for one in self._ending:
            one.wait()

    def _tell(self, told: object) -> None:
        if not isinstance(told, _Told) or told.watching is not self._watching:
            return  # of models that were left
        if isinstance(told.what, AdibasError):
            self.failed.emit(told.what)
        elif isinstance(told.what, _Unseen):
            self.unseen.emit(told.what.reason)
        else:
            self.seen.emit(told.what)


class _Watching:
    """The thread that looks for the gestures of some models."""

    def __init__(
        self,
        models: tuple[Path, ...],
        calibration: "Callable[[], RgbdCalibration | None]",
        bridge: CallBridge,
    ) -> None:
        self.wanted: Newest[LiveFrame] = Newest()
        self._models = models
        self._calibration = calibration
        self._bridge = bridge
        self._thread = threading.Thread(target=self._run, name="gestures", daemon=True)
        self._thread.start()

    @property
    def is_running(self) -> bool:
        """Whether the thread is there."""
        return self._thread.is_alive()

    def end(self) -> None:
        """Let the thread end after the frame that it looks at."""
        self.wanted.close()

    def wait(self) -> None:
        """Wait until it has ended."""
        self._thread.join()

    def _run(self) -> None:
        try:
            self._look()
        except AdibasError as error:
            self._bridge.publish(_Told(self, error))

    def _look(self) -> None:
        from adibas.gestures.model_file import read_model
        from adibas.pipeline.live_gestures import LiveGestures

        gestures = LiveGestures([read_model(path) for path in self._models])
        said = ""
        while (frame := self.wanted.take()) is not None:
            calibration = self._calibration()
            if calibration is not None and frame.depth_m is not None:
                for one in gestures.look(frame.depth_m, frame.timestamp_ns, calibration):
                    self._bridge.publish(_Told(self, one.seen.label))
                reason = "" if gestures.unseen is None else gestures.unseen.text
                if reason != said:
                    self._bridge.publish(_Told(self, _Unseen(reason)))
                said = reason


class _Unseen:
    """Why nobody is watched; empty where somebody is again."""

    __slots__ = ("reason",)

    def __init__(self, reason: str) -> None:
        self.reason = reason


class _Told:
    """A gesture's name, why nobody is watched, or what failed; and who tells it."""

    __slots__ = ("watching", "what")

    def __init__(self, watching: _Watching, what: str | _Unseen | AdibasError) -> None:
        self.watching, self.what = watching, what
