"""Sensors of the PrimeSense family (Carmine, Xtion, ...), and .oni files, by OpenNI2."""

import atexit
from contextlib import ExitStack
from pathlib import Path

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.sensors.openni2_device import OpenNI2Device
from adibas.sensors.permanent_threads import LentThreads, PermanentThread, wait_for
from adibas.sensors.ports import DEFAULT_OPTIONS, READ_TIMEOUT_S, DepthCamera, SensorOptions

_THREADS = LentThreads()


class OpenNI2Camera(DepthCamera):
    """A live OpenNI2 sensor, or a .oni file played by OpenNI2.

    All calls of the library are made by a thread that does not end; see `permanent_threads`.

    Images of two streams are joined by their timestamps; `SensorFrame.sequence` is the count of
    the colour (or infrared) stream where there is one, else of the depth.

    Parameters
    ----------
    file : Path, optional
        A .oni file; without it the sensor that is plugged in.
    sensor : str, optional
        Which of several sensors: `SensorDescription.uri` or `.serial`; the first one by default.
    options : SensorOptions
        For sensors; a file is played as it was recorded.

    Raises
    ------
    SensorError
        The library, the sensor or the file is missing, or refuses what `options` ask for.
    """

    def __init__(
        self,
        file: Path | None = None,
        sensor: str | None = None,
        options: SensorOptions = DEFAULT_OPTIONS,
    ) -> None:
        self._is_live = file is None
        self._thread: PermanentThread | None = _THREADS.borrow()
        opening = self._thread.begin(lambda: OpenNI2Device(file, sensor, options))
        with ExitStack() as if_that_fails:
            if_that_fails.callback(self._give_thread_back)
            # Ctrl-C does not stop what opens the sensor.
            if_that_fails.callback(self._thread.begin, lambda: opening.result().close())
            self._device = wait_for(opening)
            # Before the library is unloaded, which fails where a stream is still waited for.
            atexit.register(self.close)
            if_that_fails.pop_all()

    @property
    def info(self) -> SourceInfo:
        """What holds for every frame; the calibration is nominal, from the field of view."""
        return self._device.info

    @property
    def is_live(self) -> bool:
        """True for a sensor, False for a file."""
        return self._is_live

    def read(self, timeout_s: float = READ_TIMEOUT_S) -> SensorFrame | None:
        """Return the next frame; None at the end of a file.

        Raises
        ------
        SensorError
            The sensor was unplugged or is silent, or the file is damaged.
        """
        thread = self._thread  # another thread may be closing the camera
        if thread is None:
            raise ValueError("the camera is closed")
        return thread.call(lambda: self._device.read(timeout_s))

    def close(self) -> None:
        """Stop the streams and give the device back; calling it twice does no harm."""
        if self._thread is not None:
            atexit.unregister(self.close)
            self._device.stop_waiting()  # Ctrl-C may have left a `read` behind
            self._thread.call(self._device.close)
            self._give_thread_back()

    def _give_thread_back(self) -> None:
        thread, self._thread = self._thread, None
        if thread is not None:
            _THREADS.give_back(thread)
