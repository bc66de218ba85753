"""The streams of one OpenNI2 device, opened and set up for us."""

import logging
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from adibas.data.calibration import CameraCalibration
from adibas.errors import SensorError
from adibas.sensors.openni2_library import openni2_errors
from adibas.sensors.openni2_modes import (
    COLOR_FORMATS,
    DEPTH_SIZE,
    DEPTH_UNITS_M,
    INFRARED_FORMATS,
    SENSOR_TYPES,
    apply_mode,
    as_mode,
    choose_mode,
    nominal_camera,
    stream_modes,
)
from adibas.sensors.ports import STREAM_TEXTS, SensorOptions, StreamName, VideoMode

logger = logging.getLogger(__name__)

REGISTRATION_OFF = 0
REGISTRATION_DEPTH_TO_COLOR = 1
UNIT_TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class OpenStream:
    """A stream that is set up.

    Attributes
    ----------
    handle : openni.openni2.VideoStream
        The library's stream.
    mode : VideoMode
        What it delivers.
    is_mirrored : bool
        Its images are still mirrored: the device cannot switch that off.
    """

    handle: Any
    mode: VideoMode
    is_mirrored: bool

    def nominal_camera(self) -> CameraCalibration | None:
        """Return the camera of the device's own field of view; None where it tells none."""
        from openni.utils import OpenNIError

        try:
            fov_rad = self.handle.get_horizontal_fov()
        except OpenNIError:  # many .oni files lack it
            return None
        return nominal_camera(self.mode.width, self.mode.height, fov_rad)


def open_stream(
    openni2: ModuleType, device: Any, name: StreamName, options: SensorOptions
) -> OpenStream:
    """Create a stream of a live device in the mode that `options` ask for.

    Raises
    ------
    SensorError
        The device has no such stream or mode.
    """
    mode = _wished_mode(device, name, options)
    handle = _create(device, name)
    apply_mode(openni2, handle, mode)
    return OpenStream(handle, mode, _leave_mirrored(handle))


def open_file_stream(device: Any, name: StreamName) -> OpenStream:
    """Create a stream of a file, in the one mode that was recorded."""
    handle = _create(device, name)
    with openni2_errors("The recording does not tell its video mode: {reason}. Use its copy."):
        mode = as_mode(name, handle.get_video_mode())
    return OpenStream(handle, mode, _leave_mirrored(handle))


def has_stream(device: Any, name: StreamName) -> bool:
    """Tell whether the device can deliver this stream."""
    return device.get_sensor_info(SENSOR_TYPES[name]) is not None


def set_registration(device: Any, *, is_wanted: bool) -> bool:
    """Switch the device's own registration on or off; return whether it is on.

    Raises
    ------
    SensorError
        It is wanted and the device cannot do it.
    """
    if is_wanted and not device.is_image_registration_mode_supported(REGISTRATION_DEPTH_TO_COLOR):
        raise SensorError(
            "This sensor cannot register depth to colour itself. Record without its registration: "
            "the program registers with the calibration."
        )
    if device.is_image_registration_mode_supported(REGISTRATION_DEPTH_TO_COLOR):
        with openni2_errors(
            "The sensor refuses to change its registration: {reason}. Plug it in anew."
        ):
            device.set_image_registration_mode(
                REGISTRATION_DEPTH_TO_COLOR if is_wanted else REGISTRATION_OFF
            )
    return is_wanted


def synchronise(device: Any) -> None:
    """Let depth and colour be exposed together, where the device can do that."""
    from openni.utils import OpenNIError

    try:
        device.set_depth_color_sync_enabled(True)
    except OpenNIError:  # the timestamps tell which images belong together
        logger.debug("the sensor does not synchronise depth and colour")


def _create(device: Any, name: StreamName) -> Any:
    with openni2_errors(
        "The sensor's {stream} cannot be opened: {reason}. Close other programs that use it.",
        stream=STREAM_TEXTS[name],
    ):
        return device.create_stream(SENSOR_TYPES[name])


def _wished_mode(device: Any, name: StreamName, options: SensorOptions) -> VideoMode:
    modes = stream_modes(device, name)
    formats: tuple[str, ...] = {"color": COLOR_FORMATS, "infrared": INFRARED_FORMATS}.get(
        name, ()
    ) or _depth_formats(options.depth_unit_m)
    size = options.color_size if name == "color" else DEPTH_SIZE
    mode = choose_mode(modes, size, formats)
    if mode is None:
        raise SensorError(
            "This sensor gives no {stream} images in a format that can be used ({formats}). Choose "
            "another sensor or another depth unit.",
            stream=STREAM_TEXTS[name],
            formats=", ".join(formats),
        )
    return mode


def _depth_formats(unit_m: float) -> tuple[str, ...]:
    for name, format_unit_m in DEPTH_UNITS_M.items():
        if abs(unit_m - format_unit_m) < UNIT_TOLERANCE:
            return (name,)
    raise SensorError(
        "OpenNI2 sensors measure depth in units of 1 mm or 0.1 mm, not {unit:g} mm.",
        unit=unit_m * 1000,
    )


def _leave_mirrored(handle: Any) -> bool:
    """Switch mirroring off; return True where the images stay mirrored all the same."""
    from openni.utils import OpenNIError

    try:
        handle.set_mirroring_enabled(False)
    except OpenNIError:
        logger.debug("the sensor does not let its mirroring be switched off")
    try:
        return bool(handle.get_mirroring_enabled())
    except OpenNIError:  # a device that knows no mirroring does none
        return False
