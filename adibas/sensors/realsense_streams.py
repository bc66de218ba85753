"""RealSense's streams: which of them we take, and their images as arrays of our own."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from adibas.arrays import UInt8Array
from adibas.errors import SensorError
from adibas.sensors.pairing import StreamImage
from adibas.sensors.ports import STREAM_TEXTS, SensorOptions, StreamName, VideoMode

DEPTH_SIZE = (848, 480)
"""What D400 sensors measure depth best at (RealSense tuning guide)."""

WISHED_RATE_HZ = 30.0
NS_PER_MS = 1_000_000
LEFT_INFRARED = 1
"""Infrared image 1 is the left one, seen by the camera that the depth belongs to."""

FORMATS: dict[StreamName, tuple[str, ...]] = {
    "depth": ("z16",),
    "color": ("rgb8", "bgr8", "yuyv", "uyvy"),
    "infrared": ("y16", "y8"),
}


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """One way in which one of the device's sensors delivers a stream."""

    sensor: Any
    handle: Any
    mode: VideoMode


def find_profiles(device: Any) -> tuple[Profile, ...]:
    """Return everything of use that `device` can deliver."""
    return tuple(
        Profile(sensor, handle, mode)
        for sensor in device.query_sensors()
        for handle in sensor.get_stream_profiles()
        if (mode := _mode(handle)) is not None
    )


def choose_profiles(
    profiles: Sequence[Profile], options: SensorOptions
) -> dict[StreamName, Profile]:
    """Return depth, and colour or infrared as `options` say, in the sizes nearest to the wish.

    Raises
    ------
    SensorError
        There is no depth, or no infrared although it is asked for.
    """
    second: StreamName = "infrared" if options.is_infrared else "color"
    sizes = {"depth": DEPTH_SIZE, "color": options.color_size, "infrared": DEPTH_SIZE}
    chosen: dict[StreamName, Profile] = {}
    names: tuple[StreamName, ...] = ("depth", second)
    for name in names:
        usable = [profile for profile in profiles if profile.mode.stream == name]
        if usable:
            chosen[name] = min(usable, key=lambda profile: _distance(profile.mode, sizes[name]))
    if "depth" not in chosen or (options.is_infrared and second not in chosen):
        raise SensorError(
            "This RealSense gives no {stream} images. Use another one.",
            stream=STREAM_TEXTS[second if "depth" in chosen else "depth"],
        )
    return chosen


def copy_image(frame: Any) -> StreamImage:
    """Return a copy of the library's frame: RGB for colour, else uint16."""
    pixels = np.array(frame.as_video_frame().get_data())
    profile = frame.get_profile()
    timestamp_ns = round(frame.get_timestamp() * NS_PER_MS)
    if profile.stream_type().name == "color":
        pixels = _rgb(pixels, profile.format().name, len(pixels))
    elif pixels.dtype == np.uint8:
        pixels = pixels.astype(np.uint16)
    return StreamImage(int(frame.get_frame_number()), timestamp_ns, pixels)


def _rgb(pixels: npt.NDArray[Any], name: str, height: int) -> UInt8Array:
    if name == "rgb8":
        return np.asarray(pixels, np.uint8)
    import cv2

    if name == "bgr8":
        return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB), np.uint8)
    code = cv2.COLOR_YUV2RGB_YUYV if name == "yuyv" else cv2.COLOR_YUV2RGB_UYVY
    pairs = pixels.view(np.uint8).reshape(height, -1, 2)
    return np.asarray(cv2.cvtColor(pairs, code), np.uint8)


def _mode(handle: Any) -> VideoMode | None:
    """Return the mode of a profile that can be used, else None."""
    if not handle.is_video_stream_profile():
        return None
    name, pixel_format = handle.stream_type().name, handle.format().name
    if pixel_format not in FORMATS.get(name, ()):
        return None
    if name == "infrared" and handle.stream_index() not in (0, LEFT_INFRARED):
        return None
    video = handle.as_video_stream_profile()
    return VideoMode(name, video.width(), video.height(), float(handle.fps()), pixel_format)


def _distance(mode: VideoMode, size: tuple[int, int]) -> tuple[bool, int, float, int]:
    return (
        (mode.width, mode.height) != size,
        abs(mode.width * mode.height - size[0] * size[1]),
        abs(mode.frame_rate_hz - WISHED_RATE_HZ),
        FORMATS[mode.stream].index(mode.pixel_format),
    )
