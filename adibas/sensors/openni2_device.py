"""One open device of OpenNI2: a live sensor, or a .oni file that it plays."""

import threading
import time
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from types import ModuleType
from typing import Any

from adibas.clock import NS_PER_S
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import SensorError
from adibas.sensors.openni2_description import describe_source
from adibas.sensors.openni2_images import copy_image
from adibas.sensors.openni2_library import load_openni2, openni2_errors
from adibas.sensors.openni2_modes import (
    describe_device,
    describe_uri,
    open_recorded,
    sensor_uris,
    text_of,
)
from adibas.sensors.openni2_playback import Playback
from adibas.sensors.openni2_streams import (
    OpenStream,
    has_stream,
    open_file_stream,
    open_stream,
    set_registration,
    synchronise,
)
from adibas.sensors.pairing import FramePairer, join_images
from adibas.sensors.ports import (
    DEFAULT_OPTIONS,
    STREAM_TEXTS,
    SensorOptions,
    StreamName,
)

WAIT_SLICE_S = 0.1
"""Unplugging and closing are noticed this often while waiting."""

FRAME_BY_FRAME = -1.0
PLAYER_SETTLES_S = 0.05
ONI_MAGIC = b"NI10"


class OpenNI2Device:
    """What `OpenNI2Camera` does in its own thread.

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
        self._file = file
        self._unplugged, self._is_closing = threading.Event(), threading.Event()
        self._streams: dict[StreamName, OpenStream] = {}
        self._playback: Playback | None = None
        self._listener: Any = None
        openni2 = load_openni2()
        self._device = _open_file(openni2, file) if file else _open_sensor(openni2, sensor)
        with ExitStack() as undo:
            undo.callback(self.close)
            self._set_up(openni2, options)
            undo.pop_all()

    @property
    def info(self) -> SourceInfo:
        """What holds for every frame; the calibration is nominal, from the field of view."""
        return self._info

    def stop_waiting(self) -> None:
        """Let a `read` that waits return None soon; may be called by any thread."""
        self._is_closing.set()

    def read(self, timeout_s: float) -> SensorFrame | None:
        """Return the next frame; None at the end of a file.

        Raises
        ------
        SensorError
            The sensor was unplugged or is silent, or the file is damaged.
        """
        deadline_s = time.monotonic() + timeout_s
        while (frame := self._next_frame()) is None:
            if self._is_at_end() or self._is_closing.is_set():
                return None
            name = self._wait(deadline_s)
            if name is not None:
                self._fetch(name)
            elif not self._is_closing.is_set():
                self._give_up()
        return frame

    def close(self) -> None:
        """Stop the streams and give the device back; calling it twice does no harm."""
        from openni.utils import OpenNIError

        handles = [stream.handle for stream in self._streams.values()]
        for handle in handles:
            handle.stop()
        if self._file is not None and handles:
            # The player's thread goes through its list of streams without a lock, and crashes
            # where one is removed meanwhile; now that all are stopped, it soon sleeps.
            time.sleep(PLAYER_SETTLES_S)
        for thing in (*handles, self._listener, self._device):
            # A device that is gone cannot be told to stop.
            with suppress(OpenNIError):
                if thing is not None:
                    thing.close()
        self._listener, self._device = None, None
        self._streams.clear()

    def _set_up(self, openni2: ModuleType, options: SensorOptions) -> None:
        sensor = describe_device(self._device)
        is_registered = False
        if self._file is not None:
            self._open_recorded_streams(self._file)
        else:
            self._listener = _listen(openni2, sensor.uri, self._unplugged)
            is_registered = set_registration(self._device, is_wanted=options.is_depth_registered)
            for name in _live_streams(self._device, options):
                self._streams[name] = open_stream(openni2, self._device, name, options)
        self._info = describe_source(sensor, self._streams, is_registered=is_registered)
        self._pairer = FramePairer(
            NS_PER_S / self._streams["depth"].mode.frame_rate_hz,
            is_depth_alone=len(self._streams) == 1,
        )
        self._wait_for_any = openni2.wait_for_any_stream
        self._start()

    def _open_recorded_streams(self, file: Path) -> None:
        with openni2_errors("OpenNI2 cannot play this file: {reason}. Use its copy."):
            for name in _recorded_streams(self._device):
                self._streams[name] = open_file_stream(self._device, name)
            n_images = {
                name: stream.handle.get_number_of_frames() for name, stream in self._streams.items()
            }
            self._playback = Playback(file.name, n_images)
            self._device.playback.set_repeat_enabled(self._playback.knows_its_length)
            self._device.playback.set_speed(FRAME_BY_FRAME)

    def _start(self) -> None:
        rates = {stream.mode.frame_rate_hz for stream in self._streams.values()}
        if "color" in self._streams and len(rates) == 1 and self._file is None:
            synchronise(self._device)
        for name, stream in self._streams.items():
            with openni2_errors(
                "The sensor's {stream} does not start: {reason}. Close other programs that use it, "
                "plug it into a USB port of its own, and try again.",
                stream=STREAM_TEXTS[name],
            ):
                stream.handle.start()

    def _next_frame(self) -> SensorFrame | None:
        pair = self._pairer.next_pair(is_final=self._is_at_end())
        if pair is None:
            return None
        return join_images(*pair, is_infrared="infrared" in self._streams)

    def _is_at_end(self) -> bool:
        return self._playback is not None and self._playback.is_over

    def _wait(self, deadline_s: float) -> StreamName | None:
        """Return the stream that has an image; in slices, so that closing is not kept waiting."""
        names = list(self._streams)
        handles = [self._streams[name].handle for name in names]
        while True:
            if self._unplugged.is_set():
                raise SensorError(
                    "The sensor {sensor} was unplugged. Plug it in again and try again.",
                    sensor=self._info.sensor_name,
                )
            left_s = max(0.0, deadline_s - time.monotonic())
            with openni2_errors(
                "The sensor does not answer: {reason}. Check its cable, plug it in anew and try "
                "again."
            ):
                ready = self._wait_for_any(handles, min(WAIT_SLICE_S, left_s))
            if ready is not None:
                return names[handles.index(ready)]
            if left_s == 0.0 or self._is_closing.is_set():
                return None

    def _fetch(self, name: StreamName) -> None:
        """Take the image that waits in this stream into the pairer."""
        stream = self._streams[name]
        with openni2_errors(
            "The sensor sent no picture: {reason}. Check its cable, plug it in anew and try again."
        ):
            frame = stream.handle.read_frame()
        with frame:
            image = copy_image(frame, is_color=name == "color", is_mirrored=stream.is_mirrored)
        if self._playback is not None and not self._playback.accepts(name, image.index):
            return
        if name == "depth":
            self._pairer.add_depth(image)
        else:
            self._pairer.add_second(image)

    def _give_up(self) -> None:
        if self._playback is not None:
            self._playback.give_up()
            return
        raise SensorError(
            "The sensor {sensor} sends no pictures. Check its cable, plug it into a USB port of "
            "its own, and try again.",
            sensor=self._info.sensor_name,
        )


def _open_sensor(openni2: ModuleType, sensor: str | None) -> Any:
    uris = sensor_uris(openni2)
    if not uris:
        raise SensorError(
            "OpenNI2 finds no sensor. Plug it in, into a USB port of its own, and try again; "
            "adibas doctor says what this computer has."
        )
    with openni2_errors(
        "The sensor cannot be opened: {reason}. Close other programs that use it; on Linux the "
        "package libopenni2-0 gives the right to use it, after plugging it in anew."
    ):
        return openni2.Device(uris[0] if sensor is None else _address_of(openni2, sensor, uris))


def _address_of(openni2: ModuleType, sensor: str, uris: Sequence[bytes]) -> bytes:
    """Return the address of the sensor with this address, or else with this serial number."""
    if sensor.encode() in uris:
        return sensor.encode()
    for uri in uris:
        if describe_uri(openni2, uri).serial == sensor:
            return uri
    raise SensorError(
        "The sensor {sensor} is not plugged in. Plug it in, or look for sensors and choose one.",
        sensor=sensor,
    )


def _open_file(openni2: ModuleType, file: Path) -> Any:
    try:
        with file.open("rb") as opened:
            magic = opened.read(len(ONI_MAGIC))
    except OSError as error:
        raise SensorError(
            "{file} cannot be read: {reason}. Check the name and the folder.",
            file=file.name,
            reason=error.strerror or str(error),
        ) from error
    if magic != ONI_MAGIC:
        raise SensorError(
            "{file} is no OpenNI2 recording. Give a file that ends in .oni.", file=file.name
        )
    with openni2_errors(
        "{file} cannot be played by OpenNI2: {reason}. Use its copy.", file=file.name
    ):
        return open_recorded(openni2, bytes(file.resolve()))


def _listen(openni2: ModuleType, uri: str, unplugged: threading.Event) -> Any:
    """Return a listener that sets `unplugged` when this sensor goes."""
    base: Any = openni2.DeviceListener

    class Listener(base):  # type: ignore[misc]  # the binding has no types
        def on_disconnected(self, info: Any) -> None:
            if text_of(info.uri) == uri:
                unplugged.set()

    return Listener()


def _live_streams(device: Any, options: SensorOptions) -> tuple[StreamName, ...]:
    # A PrimeSense sensor reads one of colour and infrared, never both.
    second: StreamName = "infrared" if options.is_infrared else "color"
    if not has_stream(device, "depth"):
        raise SensorError("This sensor measures no depth. Use a depth camera.")
    if options.is_infrared and not has_stream(device, "infrared"):
        raise SensorError("This sensor gives no infrared images. Calibrate with colour instead.")
    return ("depth", second) if has_stream(device, second) else ("depth",)


def _recorded_streams(device: Any) -> tuple[StreamName, ...]:
    if not has_stream(device, "depth"):
        raise SensorError("This recording holds no depth. Use one of a depth camera.")
    seconds: tuple[StreamName, ...] = ("color", "infrared")
    found = [name for name in seconds if has_stream(device, name)]
    return ("depth", *found[:1])
