"""Intel's RealSense library: loaded when asked for; its sensors; its errors in our words."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any

from adibas.errors import SensorError
from adibas.sensors.answering import TimeLimit
from adibas.sensors.ports import SensorDescription
from adibas.sensors.realsense_streams import find_profiles

_REALSENSE = TimeLimit("RealSense")
_NO_UPLOAD = {"RS2_RUM_CLOUD_ENABLED": "0"}
"""No statistics of use leave this computer, whatever was agreed to in another program of Intel's.

Source: librealsense, doc/rum.md, Consent and control.
"""


def load_realsense() -> ModuleType:
    """Return the module ``pyrealsense2``, which may not hand on statistics of use.

    Raises
    ------
    SensorError
        It is not installed.
    """
    os.environ.update(_NO_UPLOAD)
    try:
        import pyrealsense2
    except ImportError as error:
        raise SensorError(
            "The RealSense library is not installed. Install it: pip install pyrealsense2."
        ) from error
    loaded: ModuleType = pyrealsense2
    return loaded


def list_sensors() -> tuple[SensorDescription, ...]:
    """Return the RealSense sensors that are plugged in.

    Raises
    ------
    SensorError
        The library is missing, fails, or does not answer.
    """
    return _REALSENSE.ask(_list)


def _list() -> tuple[SensorDescription, ...]:
    library = load_realsense()
    with realsense_errors("RealSense sensors cannot be listed: {reason}. Plug them in anew."):
        return tuple(describe_device(library, device) for device in library.context().devices)


def describe_device(library: ModuleType, device: Any) -> SensorDescription:
    """Return what a device says of itself."""
    modes = tuple(profile.mode for profile in find_profiles(device))
    names = library.camera_info
    name, serial = (_text(device, info) for info in (names.name, names.serial_number))
    return SensorDescription(name, "Intel", serial, serial, modes)


@contextmanager
def realsense_errors(message_id: str, **fields: object) -> Iterator[None]:
    """Turn an error of the library into a SensorError with this sentence; {reason} is its own."""
    try:
        yield
    except RuntimeError as error:  # the library's only kind
        reason = " ".join(str(error).split()).rstrip(".")
        raise SensorError(message_id, **fields, reason=reason) from error


def _text(device: Any, info: Any) -> str:
    return str(device.get_info(info)) if device.supports(info) else ""
