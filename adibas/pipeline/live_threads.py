"""The threads of one opened source, from opening to closing."""

import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

from adibas.errors import SensorError
from adibas.pipeline.acquisition import Acquisition, Arrival, Opener, Source
from adibas.pipeline.burst_recording import Burst, BurstRecording
from adibas.pipeline.live_frames import SensorState
from adibas.pipeline.newest import Newest


class LiveThreads:
    """Reads in one thread, looks in another, and writes bursts in a third.

    What is raised in the first two is a bug: it ends both and goes to `threading.excepthook`.

    Parameters
    ----------
    source : Source
        What is read.
    opener : callable
        Opens it.
    look : callable
        Takes the newest arrival, in the looking thread; may be slow.
    tell : callable
        Takes every new state, in the reading thread; ``closed`` is the last thing that is told.
    """

    def __init__(
        self,
        source: Source,
        opener: Opener,
        look: Callable[[Arrival], None],
        tell: Callable[[SensorState], None],
    ) -> None:
        self._look = look
        self._tell = tell
        self._stop = threading.Event()
        self._newest: Newest[Arrival] = Newest()
        self._lock = threading.Lock()
        self._state = SensorState("opening")
        self._burst: BurstRecording | None = None
        self._acquisition = Acquisition(
            source, opener, self._arrive, self._change_state, self._note_restart, self._stop
        )
        # Daemons: a program that fails without closing the view must still be able to end.
        self._reading = threading.Thread(target=self._read_all, name="live-read", daemon=True)
        self._looking = threading.Thread(target=self._look_always, name="live-look", daemon=True)
        self._writing = ThreadPoolExecutor(1, thread_name_prefix="live-write")

    def start(self) -> None:
        """Begin."""
        self._looking.start()
        self._reading.start()

    def close(self) -> None:
        """End all threads."""
        self._stop.set()
        self._reading.join()
        self._looking.join()
        self._writing.shutdown(wait=True)

    @property
    def state(self) -> SensorState:
        """How the sensor fares."""
        return self._state

    def begin_burst(self, burst: BurstRecording) -> Future[Burst]:
        """Give the next frames to `burst`; see `LiveView.capture`."""
        with self._lock:
            if self._state.kind != "live":
                raise SensorError("No sensor is live. Choose a source and wait for its picture.")
            if self._burst is not None and not self._burst.is_done:
                raise ValueError("a burst is being taken already")
            self._burst = burst
            return burst.start(self._writing)

    def cancel_burst(self) -> None:
        """Give up the burst that is being taken."""
        with self._lock:
            if self._burst is not None:
                self._burst.cancel()

    def _arrive(self, arrival: Arrival) -> None:
        burst = self._burst
        if burst is not None:
            burst.take(arrival.frame, arrival.info)
        self._newest.put(arrival)

    def _note_restart(self) -> None:
        if self._burst is not None:
            self._burst.note_restart()

    def _change_state(self, state: SensorState) -> None:
        with self._lock:
            self._state = state
            if self._burst is not None and state.kind != "live":
                self._burst.fail(state.error or _stopped(state))
        self._tell(state)

    def _read_all(self) -> None:
        try:
            self._acquisition.run()
        finally:
            self._stop.set()
            self._newest.close()
            self._looking.join()
            self._change_state(SensorState("closed"))

    def _look_always(self) -> None:
        try:
            while (arrival := self._newest.take()) is not None:
                self._look(arrival)
        finally:
            self._stop.set()


def _stopped(state: SensorState) -> SensorError:
    if state.kind == "ended":
        return SensorError(
            "The recording ended before the burst was whole. Choose a longer one, or fewer frames."
        )
    return SensorError("The burst was stopped, because its source was closed.")
