"""OpenNI2's sensors, what they can deliver, and which of it we take."""

import ctypes
import math
from collections.abc import Sequence
from types import ModuleType
from typing import Any

from adibas.data.calibration import CameraCalibration
from adibas.errors import SensorError
from adibas.geometry.pinhole import Intrinsics
from adibas.sensors.answering import TimeLimit
from adibas.sensors.openni2_library import leave_running, load_openni2, openni2_errors
from adibas.sensors.ports import SensorDescription, StreamName, VideoMode

# Values of OniSensorType and OniPixelFormat (OniCEnums.h).
SENSOR_TYPES: dict[StreamName, int] = {"infrared": 1, "color": 2, "depth": 3}
PIXEL_FORMATS = {
    100: "DEPTH_1_MM",
    101: "DEPTH_100_UM",
    102: "SHIFT_9_2",
    103: "SHIFT_9_3",
    200: "RGB888",
    201: "YUV422",
    202: "GRAY8",
    203: "GRAY16",
    204: "JPEG",
    205: "YUYV",
}
DEPTH_UNITS_M = {"DEPTH_1_MM": 0.001, "DEPTH_100_UM": 0.0001}
COLOR_FORMATS = ("RGB888", "YUYV", "YUV422", "GRAY8")
INFRARED_FORMATS = ("GRAY16", "GRAY8")
DEPTH_SIZE = (640, 480)
WISHED_RATE_HZ = 30.0
SERIAL_PROPERTY = 3
SERIAL_BYTES = 256

_OPENNI2 = TimeLimit("OpenNI2", gave_up=leave_running)
_played: set[bytes] = set()


def list_sensors() -> tuple[SensorDescription, ...]:
    """Return OpenNI2's sensors that are plugged in; modes are empty where it may not be opened.

    Raises
    ------
    SensorError
        The library is missing, fails, or does not answer.
    """
    return _OPENNI2.ask(_list)


def _list() -> tuple[SensorDescription, ...]:
    openni2 = load_openni2()
    return tuple(describe_uri(openni2, uri) for uri in sensor_uris(openni2))


def sensor_uris(openni2: ModuleType) -> tuple[bytes, ...]:
    """Return the addresses of the sensors that are plugged in.

    OpenNI2 counts every file that it ever played in this process among its devices.

    Raises
    ------
    SensorError
        The library fails.
    """
    with openni2_errors("OpenNI2 cannot list its sensors: {reason}. Unplug them and try again."):
        uris = openni2.Device.enumerate_uris()
    return tuple(uri for uri in map(bytes, uris) if uri not in _played)


def open_recorded(openni2: ModuleType, uri: bytes) -> Any:
    """Open a file as a device, which from then on is no sensor."""
    _played.add(uri)
    return openni2.Device(uri)


def describe_uri(openni2: ModuleType, uri: bytes) -> SensorDescription:
    """Return what the sensor with this address says of itself."""
    from openni.utils import OpenNIError

    try:
        device = openni2.Device(uri)
    except OpenNIError:  # no permission, or another program uses it: it is still there
        return SensorDescription("", "", "", text_of(uri))
    with device:
        return describe_device(device)


def describe_device(device: Any) -> SensorDescription:
    """Return what an open device says of itself."""
    info = device.get_device_info()
    modes: list[VideoMode] = []
    for stream in SENSOR_TYPES:
        modes.extend(stream_modes(device, stream))
    return SensorDescription(
        text_of(info.name), text_of(info.vendor), _serial(device), text_of(info.uri), tuple(modes)
    )


def stream_modes(device: Any, stream: StreamName) -> tuple[VideoMode, ...]:
    """Return the modes of one stream; none where the device has no such stream."""
    sensor = device.get_sensor_info(SENSOR_TYPES[stream])
    return () if sensor is None else tuple(as_mode(stream, mode) for mode in sensor.videoModes)


def as_mode(stream: StreamName, mode: Any) -> VideoMode:
    """Turn the library's description of a mode into ours."""
    number = int(mode.pixelFormat)
    return VideoMode(
        stream,
        int(mode.resolutionX),
        int(mode.resolutionY),
        float(mode.fps),
        PIXEL_FORMATS.get(number, str(number)),
    )


def choose_mode(
    modes: Sequence[VideoMode], size: tuple[int, int], formats: Sequence[str]
) -> VideoMode | None:
    """Return the mode of this (width, height), else the largest, in the first format there is.

    Of several rates the one nearest 30 Hz is taken. None where no mode has any of `formats`.
    """
    usable = [mode for mode in modes if mode.pixel_format in formats]
    return min(
        usable,
        key=lambda mode: (
            (mode.width, mode.height) != size,
            -mode.width * mode.height,
            formats.index(mode.pixel_format),
            abs(mode.frame_rate_hz - WISHED_RATE_HZ),
        ),
        default=None,
    )


def apply_mode(openni2: ModuleType, stream: Any, mode: VideoMode) -> None:
    """Switch `stream` to `mode`."""
    number = next(key for key, name in PIXEL_FORMATS.items() if name == mode.pixel_format)
    with openni2_errors(
        "The sensor refuses {width} x {height} pixels at {rate:g} frames/s: {reason}. Plug it in "
        "anew, into a USB port of its own, and try again.",
        width=mode.width,
        height=mode.height,
        rate=mode.frame_rate_hz,
    ):
        stream.set_video_mode(
            openni2.VideoMode(
                pixelFormat=number,
                resolutionX=mode.width,
                resolutionY=mode.height,
                fps=int(mode.frame_rate_hz),
            )
        )


def nominal_camera(width: int, height: int, horizontal_fov_rad: float) -> CameraCalibration:
    """Return the camera that the field of view describes: square pixels, no distortion.

    PrimeSense sensors read a 4:3 image out of the top of their 5:4 colour chip: the optical axis
    meets row 3/8 of the width in both shapes.

    Source: ROS openni2_camera, getDefaultCameraInfo.
    """
    if not 0 < horizontal_fov_rad < math.pi:
        raise SensorError(
            "The sensor gives an impossible field of view ({degrees:.1f} degrees). Plug it in anew "
            "and try again.",
            degrees=math.degrees(horizontal_fov_rad),
        )
    focal_px = width / 2 / math.tan(horizontal_fov_rad / 2)
    center_v = min(width * 3 / 8, height / 2) - 0.5
    return CameraCalibration(
        width, height, Intrinsics(focal_px, focal_px, width / 2 - 0.5, center_v)
    )


def text_of(raw: bytes) -> str:
    """Return the text of a C string."""
    return raw.decode("utf-8", errors="replace")


def _serial(device: Any) -> str:
    from openni.utils import OpenNIError

    try:
        raw = device.get_property(SERIAL_PROPERTY, ctypes.c_char * SERIAL_BYTES)
    except OpenNIError:  # files and some sensors have none
        return ""
    return text_of(raw.value)
