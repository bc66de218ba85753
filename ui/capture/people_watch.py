"""Follows everybody in the newest live frame without markers, in a thread of its own."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from PySide6.QtCore import QObject

from adibas.errors import AdibasError
from adibas.pipeline.newest import Newest
from ui.capture.people_presenter import PeopleWatch, Wanted
from ui.events import Event
from ui.frame_bridge import CallBridge

if TYPE_CHECKING:
    from adibas.data.calibration import RgbdCalibration
    from adibas.pipeline.live_frames import LiveFrame
    from adibas.pipeline.live_people import LiveJoints


class QtPeopleWatch(PeopleWatch):
    """One thread for each wish; it skips frames that come while it looks.

    Of another wish nothing is told any more, but the window does not wait for its thread: that
    may still compile what it runs.

    Parameters
    ----------
    calibration : callable
        Returns the calibration in use, None where there is none; called in that thread.
    """

    def __init__(
        self, calibration: "Callable[[], RgbdCalibration | None]", parent: QObject | None = None
    ) -> None:
        self.gesture_seen: Event[[str]] = Event()
        self.joints_seen: Event[[tuple[LiveJoints, ...]]] = Event()
        self.unseen: Event[[str]] = Event()
        self.failed: Event[[AdibasError]] = Event()
        self._calibration = calibration
        self._bridge = CallBridge(self._tell, parent)
        self._watching: _Watching | None = None
        self._ending: list[_Watching] = []

    def use(self, wanted: Wanted) -> None:
        """Look for this from now on."""
        if self._watching is not None:
            self._watching.end()
            running = [one for one in self._ending if one.is_running]
            self._ending = [*running, self._watching]
        is_any = wanted != Wanted()
        self._watching = _Watching(wanted, self._calibration, self._bridge) if is_any else None

    def put(self, frame: "LiveFrame") -> None:
        """Look at a frame as soon as there is time."""
        if self._watching is not None:
            self._watching.wanted.put(frame)

    def close(self) -> None:
        """End, and wait until no thread is left."""
        self.use(Wanted())
        for one in self._ending:
            one.wait()

    def _tell(self, told: object) -> None:
        if not isinstance(told, _Told) or told.watching is not self._watching:
            return  # of a wish that was left
        if isinstance(told.what, AdibasError):
            self.failed.emit(told.what)
        elif isinstance(told.what, _Unseen):
            self.unseen.emit(told.what.reason)
        elif isinstance(told.what, str):
            self.gesture_seen.emit(told.what)
        else:
            self.joints_seen.emit(told.what)


class _Watching:
    """The thread that follows people for one wish."""

    def __init__(
        self,
        wish: Wanted,
        calibration: "Callable[[], RgbdCalibration | None]",
        bridge: CallBridge,
    ) -> None:
        self.wanted: Newest[LiveFrame] = Newest()
        self._wish = wish
        self._calibration = calibration
        self._bridge = bridge
        self._thread = threading.Thread(target=self._run, name="people", daemon=True)
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
            self._publish(error)

    def _look(self) -> None:
        from adibas.gestures.model_file import read_model
        from adibas.pipeline.live_gestures import LiveGestures
        from adibas.pipeline.live_people import LivePeople, joints_in_pictures

        gestures = LiveGestures([read_model(path) for path in self._wish.gestures])
        everybody = LivePeople()
        said = ""
        while (frame := self.wanted.take()) is not None:
            calibration = self._calibration()
            if calibration is None or frame.depth_m is None:
                continue
            moment = everybody.look(
                frame.depth_m, frame.timestamp_ns, calibration, frame.rotation_deg
            )
            if moment is None:
                continue
            if self._wish.joints:
                self._publish(tuple(joints_in_pictures(one, calibration) for one in moment.people))
            for one in gestures.see(moment):
                self._publish(one.seen.label)
            reason = "" if moment.unseen is None else moment.unseen.text
            if reason != said:
                self._publish(_Unseen(reason))
            said = reason

    def _publish(self, what: "_What") -> None:
        self._bridge.publish(_Told(self, what))


@dataclass(frozen=True, slots=True)
class _Unseen:
    """Why nobody is followed; empty where somebody is again."""

    reason: str


_What: TypeAlias = "str | _Unseen | AdibasError | tuple[LiveJoints, ...]"


@dataclass(frozen=True, slots=True)
class _Told:
    """A gesture's name, everybody's joints, why there is nobody, or what failed; who tells it."""

    watching: _Watching
    what: _What
