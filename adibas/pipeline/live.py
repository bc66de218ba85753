"""The live view: one thread reads the sensor, one looks at the newest frame, one writes bursts.

Reading never waits for looking or writing. Looking takes the newest frame and misses those that
came meanwhile. Writing drops nothing: a disk that is too slow is an error.
"""

import threading
from concurrent.futures import Future
from dataclasses import replace

from adibas.body.staying import Moment
from adibas.data.board import Board
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import SourceInfo
from adibas.errors import SensorError
from adibas.pipeline.acquisition import Arrival, Opener, Source
from adibas.pipeline.burst_recording import Burst, BurstRecording
from adibas.pipeline.live_frames import LiveFrame, LiveListener, Naming, SensorState
from adibas.pipeline.live_threads import LiveThreads
from adibas.pipeline.looking import Look, Looker
from adibas.pipeline.posture import MarkerTarget, PostureParams
from adibas.progress import Progress
from adibas.recordings import RecordingWriter
from adibas.sensors.ports import DEFAULT_OPTIONS, SensorOptions
from adibas.sensors.sources import open_source

__all__ = ["Burst", "LiveFrame", "LiveListener", "LiveView", "SensorState"]


class LiveView:
    """Frames of one source after the other, told to a listener.

    A sensor that is unplugged is tried again every second until it is back or the view is closed.
    All methods may be called from any thread but the listener's own calls.

    Parameters
    ----------
    listener : LiveListener
        Who is told.
    params : PostureParams or None
        Settings of the stages.
    opener : callable
        Opens a source; other than `open_source` in tests.
    """

    def __init__(
        self,
        listener: LiveListener,
        params: PostureParams | None = None,
        opener: Opener = open_source,
    ) -> None:
        self._listener = listener
        self._opener = opener
        self._look = Look(params=params or PostureParams())
        self._lock = threading.RLock()
        self._look_lock = threading.Lock()
        self._looker = Looker()
        self._running: LiveThreads | None = None

    @property
    def state(self) -> SensorState:
        """How the sensor fares; what the listener was told last."""
        running = self._running
        return SensorState("closed") if running is None else running.state

    @property
    def params(self) -> PostureParams:
        """Settings of the stages."""
        return self._look.params

    @property
    def target(self) -> MarkerTarget | None:
        """What is looked for."""
        return self._look.target

    @property
    def calibration(self) -> RgbdCalibration | None:
        """The one in use: the user's, else that of the sensor; None where there is none."""
        return self._look.calibration_of(self.state.info or SourceInfo())

    @property
    def person(self) -> Moment | None:
        """Who is in the newest frame that was looked at; None where nobody is."""
        return self._looker.person

    def open(
        self,
        source: str,
        options: SensorOptions = DEFAULT_OPTIONS,
        *,
        calibration: RgbdCalibration | None = None,
        is_looping: bool = True,
    ) -> None:
        """Begin to show a source, after closing what is open; returns at once.

        Whatever is no sensor is given at its own pace.

        Parameters
        ----------
        source : str
            As `adibas.sensors.open_source` takes it.
        options : SensorOptions
            How it is opened; `is_paced` is left aside.
        calibration : RgbdCalibration or None
            Takes the place of the source's own.
        is_looping : bool
            Whether a recording begins anew at its end; its numbers and times go on then.
        """
        with self._lock:
            self.close()
            with self._look_lock:
                self._look = replace(self._look, calibration=calibration)
                self._looker = Looker()
            self._running = LiveThreads(
                Source(source, options, is_looping),
                self._opener,
                self._show,
                self._tell,
            )
            self._running.start()

    def close(self) -> None:
        """Give the source back and end all threads; a burst that is being taken fails."""
        with self._lock:
            if self._running is not None:
                self._running.close()
                self._running = None

    def set_target(self, target: MarkerTarget | None) -> None:
        """Look for these markers from the next frame on; None looks for none."""
        with self._look_lock:
            self._look = replace(self._look, target=target)

    def set_naming(self, naming: Naming | None) -> None:
        """Name markers after these landmarks from the next frame on; None: not any more."""
        with self._look_lock:
            self._look = replace(self._look, naming=naming)

    def set_board(self, board: Board | None) -> None:
        """Look for this board in place of a person from the next frame on; None: as before."""
        with self._look_lock:
            self._look = replace(self._look, board=board)

    def set_rotation(self, rotation_deg: int) -> None:
        """Say how far the picture is turned clockwise for showing: 0, 90, 180 or 270."""
        with self._look_lock:
            params = replace(self._look.params, rotation_deg=rotation_deg)
            self._look = replace(self._look, params=params)

    def capture(
        self,
        n_frames: int,
        writer: RecordingWriter,
        progress: Progress | None = None,
        *,
        keeps_frames: bool = True,
    ) -> Future[Burst]:
        """Write the next `n_frames` frames.

        Parameters
        ----------
        n_frames : int
            At least 1.
        writer : RecordingWriter
            It stays open: whoever gave it closes or abandons it once the future is done, and
            not before.
        progress : callable or None
            Told (frames written, `n_frames`) in the writer's thread.
        keeps_frames : bool
            Whether the burst holds its frames, 4.5 MB each at 1280 x 1024, or is written only.

        Returns
        -------
        future : Future of Burst
            Ends with an AdibasError where the sensor is lost, the disk is full or too slow, or
            the view is closed; with `CancelledError` after `cancel_capture`.

        Raises
        ------
        SensorError
            No sensor is live.
        ValueError
            A burst is being taken already.
        """
        with self._lock:
            running = self._running
            if running is None:
                raise SensorError("No sensor is live. Choose a source and wait for its picture.")
            return running.begin_burst(
                BurstRecording(
                    n_frames, writer, self.calibration, progress, keeps_frames=keeps_frames
                )
            )

    def cancel_capture(self) -> None:
        """Give up the burst that is being taken, if there is one."""
        running = self._running
        if running is not None:
            running.cancel_burst()

    def _show(self, arrival: Arrival) -> None:
        self._listener.frame_arrived(self._looker.look(arrival, self._look))

    def _tell(self, state: SensorState) -> None:
        self._listener.state_changed(state)
