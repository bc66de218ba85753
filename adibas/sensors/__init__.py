"""Cameras: the port, its adapters, and the text that names one."""

from adibas.sensors.ports import (
    DEFAULT_OPTIONS,
    DepthCamera,
    SensorDescription,
    SensorOptions,
    VideoMode,
)
from adibas.sensors.sources import open_source

__all__ = [
    "DEFAULT_OPTIONS",
    "DepthCamera",
    "SensorDescription",
    "SensorOptions",
    "VideoMode",
    "open_source",
]
