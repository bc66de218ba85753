"""Intel RealSense sensors, and the files of their library (.db3, .bag)."""

import queue
import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Any

from adibas.clock import NS_PER_S
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import SensorError
from adibas.sensors.pairing import FramePairer, StreamImage, join_images
from adibas.sensors.ports import (
    DEFAULT_OPTIONS,
    READ_TIMEOUT_S,
    DepthCamera,
    SensorOptions,
    StreamName,
)
from adibas.sensors.realsense_calibration import factory_calibration
from adibas.sensors.realsense_library import (
    describe_device,
    load_realsense,
    realsense_errors,
)
from adibas.sensors.realsense_streams import (
    Profile,
    choose_profiles,
    copy_image,
    find_profiles,
)

WAIT_SLICE_S = 0.1
"""Unplugging, Ctrl-C and the end of a file are noticed this often while waiting."""

QUEUE_IMAGES = 16


def open_realsense(
    file: Path | None = None,
    sensor: str | None = None,
    options: SensorOptions = DEFAULT_OPTIONS,
) -> "RealSenseCamera":
    """Open a file of the library, or the sensor with this serial number, or else the first one.

    Raises
    ------
    SensorError
        The library, the sensor or the file is missing, or it is refused.
    """
    library = load_realsense()
    if options.is_depth_registered:
        raise SensorError(
            "A RealSense does not register depth to colour itself. Record without its "
            "registration: the program registers with the calibration."
        )
    context = library.context()
    if file is not None:
        return RealSenseCamera(_load_file(context, file), options)
    with realsense_errors("RealSense sensors cannot be listed: {reason}. Plug them in anew."):
        devices = list(context.query_devices())
    if not devices:
        raise SensorError(
            "No RealSense is found. Plug it into a USB 3 port and try again; adibas doctor says "
            "what this computer has."
        )
    return RealSenseCamera(_chosen(library, devices, sensor), options)


def _chosen(library: ModuleType, devices: Sequence[Any], sensor: str | None) -> Any:
    if sensor is None:
        return devices[0]
    for device in devices:
        if describe_device(library, device).serial == sensor:
            return device
    raise SensorError(
        "The sensor {sensor} is not plugged in. Plug it in, or look for sensors and choose one.",
        sensor=sensor,
    )


class RealSenseCamera(DepthCamera):
    """A device of the RealSense library: a live sensor, a file that it plays, a software device.

    The library calls from threads of its own; images wait in a short queue. A file waits for room
    in it, a live sensor loses the image, and its count shows the gap.

    Parameters
    ----------
    device : pyrealsense2.device
        Not yet streaming.
    options : SensorOptions
        A file is played as it was recorded.

    Raises
    ------
    SensorError
        The device gives no depth, or does not start.
    """

    def __init__(self, device: Any, options: SensorOptions = DEFAULT_OPTIONS) -> None:
        library = load_realsense()
        self._device = device
        self._playback = device.as_playback() if device.is_playback() else None
        self._is_closing = threading.Event()
        self._images: queue.Queue[tuple[StreamName, StreamImage]] = queue.Queue(QUEUE_IMAGES)
        self._open_sensors: list[Any] = []
        with realsense_errors(
            "The RealSense does not start: {reason}. Close other programs that use it, plug it "
            "into a USB 3 port and try again."
        ):
            self._profiles = choose_profiles(find_profiles(device), options)
            self._info = _describe_source(library, device, self._profiles)
            self._pairer = FramePairer(
                NS_PER_S / self._profiles["depth"].mode.frame_rate_hz,
                is_depth_alone=len(self._profiles) == 1,
            )
            self._start()

    @property
    def info(self) -> SourceInfo:
        """What holds for every frame, with the factory's calibration."""
        return self._info

    @property
    def is_live(self) -> bool:
        """True for a sensor, False for a file."""
        return self._playback is None

    def read(self, timeout_s: float = READ_TIMEOUT_S) -> SensorFrame | None:
        """Return the next frame; None at the end of a file.

        Raises
        ------
        SensorError
            The sensor was unplugged or is silent.
        """
        deadline_s = time.monotonic() + timeout_s
        while (frame := self._next_frame(is_final=False)) is None:
            taken = self._take(deadline_s)
            if taken is None:
                return self._next_frame(is_final=True)
            name, image = taken
            if name == "depth":
                self._pairer.add_depth(image)
            else:
                self._pairer.add_second(image)
        return frame

    def close(self) -> None:
        """Stop the sensors; calling it twice does no harm."""
        self._is_closing.set()
        while self._open_sensors:
            sensor = self._open_sensors.pop()
            for end in (sensor.stop, sensor.close):
                with suppress(RuntimeError):  # a sensor that is gone cannot be told to stop
                    end()

    def _start(self) -> None:
        if self._playback is not None:
            self._playback.set_real_time(False)
            # A file is read from the first sensor's start on; what it holds of the others is
            # thrown away until they have started.
            self._playback.pause()
        try:
            for sensor, handles in _by_sensor(self._profiles):
                sensor.open(handles)
                self._open_sensors.append(sensor)
            for sensor in self._open_sensors:
                sensor.start(self._on_frame)
            if self._playback is not None:
                self._playback.resume()
        except RuntimeError:
            self.close()
            raise

    def _on_frame(self, frame: Any) -> None:
        """Take a copy; called by the library's threads, which must not wait after `close`."""
        name: StreamName = frame.get_profile().stream_type().name
        taken = (name, copy_image(frame))
        while not self._is_closing.is_set():
            try:
                self._images.put(taken, timeout=0 if self.is_live else WAIT_SLICE_S)
            except queue.Full:
                if self.is_live:
                    return
            else:
                return

    def _take(self, deadline_s: float) -> tuple[StreamName, StreamImage] | None:
        """Return the next image of any stream; None at the end of a file."""
        while True:
            has_ended = self._has_ended()
            left_s = max(0.0, deadline_s - time.monotonic())
            try:
                return self._images.get(timeout=min(WAIT_SLICE_S, left_s))
            except queue.Empty:
                if has_ended:
                    return None
                if self.is_live and not self._device.is_connected():
                    raise self._fault(
                        "The sensor {sensor} was unplugged. Plug it in again and try again."
                    ) from None
                if left_s == 0.0:
                    raise self._fault(
                        "The sensor {sensor} sends no pictures. Check its cable, plug it into a "
                        "USB 3 port, and try again."
                    ) from None

    def _next_frame(self, *, is_final: bool) -> SensorFrame | None:
        pair = self._pairer.next_pair(is_final=is_final)
        return (
            None if pair is None else join_images(*pair, is_infrared="infrared" in self._profiles)
        )

    def _has_ended(self) -> bool:
        if self._playback is None:
            return False
        return bool(self._playback.current_status() == load_realsense().playback_status.stopped)

    def _fault(self, message_id: str) -> SensorError:
        return SensorError(message_id, sensor=self._info.sensor_name)


def _load_file(context: Any, file: Path) -> Any:
    if not file.is_file():
        raise SensorError("{file} is not there. Check the name and the folder.", file=file.name)
    with realsense_errors(
        "{file} is no recording of the RealSense library, or it is damaged: {reason}. Use its "
        "copy.",
        file=file.name,
    ):
        return context.load_device(str(file.resolve()))


def _describe_source(
    library: ModuleType, device: Any, profiles: Mapping[StreamName, Profile]
) -> SourceInfo:
    sensor = describe_device(library, device)
    # Single precision: 0.001 comes as 0.0010000000475.
    scale = profiles["depth"].sensor.as_depth_sensor().get_depth_scale()
    unit_m = float(f"{scale:.6g}")
    return SourceInfo(
        depth_unit_m=unit_m,
        frame_rate_hz=min(profile.mode.frame_rate_hz for profile in profiles.values()),
        sensor_name=sensor.name,
        sensor_serial=sensor.serial,
        calibration=factory_calibration(library, profiles, unit_m, sensor.serial),
    )


def _by_sensor(profiles: Mapping[StreamName, Profile]) -> list[tuple[Any, list[Any]]]:
    """Return every sensor of the device once, with the profiles that it is opened with."""
    grouped: dict[str, tuple[Any, list[Any]]] = {}
    for profile in profiles.values():
        grouped.setdefault(profile.sensor.name, (profile.sensor, []))[1].append(profile.handle)
    return list(grouped.values())
