"""What this machine has and lacks for the program, and how to get it."""

import importlib.util
import os
import platform
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from adibas.errors import SensorError
from adibas.sensors.ports import SensorDescription
from adibas.texts import decimal_text, describe
from adibas.texts import translate as _

GIGABYTE = 1_000_000_000
ENOUGH_DISK_BYTES = 10 * GIGABYTE
"""Ten minutes of depth and lossless colour."""

ENOUGH_CORES = 2


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that the program needs or can use.

    Attributes
    ----------
    name : str
        Of the thing.
    ok : bool
        It is there and suffices.
    detail : str
        What was found.
    remedy : str
        What to do; empty where all is well.
    """

    name: str
    ok: bool
    detail: str
    remedy: str = ""


def findings(folder: Path | None = None) -> tuple[Finding, ...]:
    """Look at this machine, in a second or two, without opening a window.

    Parameters
    ----------
    folder : Path, optional
        Whose disk is looked at; the current folder by default.
    """
    from adibas.sensors import openni2_modes, realsense_library

    return (
        _package("Qt", "PySide6", "PySide6-Essentials"),
        _package("OpenCV", "cv2", "opencv-python-headless"),
        _package("numba", "numba", "numba"),
        _sensors("OpenNI2", openni2_modes.list_sensors),
        _sensors("RealSense", realsense_library.list_sensors),
        _disk(folder or Path()),
        _cores(),
    )


def _package(name: str, module: str, distribution: str) -> Finding:
    if importlib.util.find_spec(module) is None:
        remedy = _("Install it: pip install {package}.").format(package=distribution)
        return Finding(name, ok=False, detail=_("not installed"), remedy=remedy)
    try:
        found = version(distribution)
    except PackageNotFoundError:  # as in a frozen program
        found = _("installed")
    return Finding(name, ok=True, detail=found)


def _sensors(name: str, list_sensors: Callable[[], tuple[SensorDescription, ...]]) -> Finding:
    try:
        sensors = list_sensors()
    except SensorError as error:
        return Finding(name, ok=False, detail=_("not usable"), remedy=describe(error))
    if not sensors:
        return Finding(
            name,
            ok=True,
            detail=_("installed, no sensor found"),
            remedy=_("Plug a sensor into a USB port of its own if you want to record with it."),
        )
    closed = [sensor for sensor in sensors if not sensor.modes]
    return Finding(
        name,
        ok=not closed,
        detail="; ".join(_describe_sensor(sensor) for sensor in sensors),
        remedy=_("Close other programs that use the sensor, or plug it in anew.") if closed else "",
    )


def _describe_sensor(sensor: SensorDescription) -> str:
    if not sensor.modes:
        return _("{uri} (cannot be opened)").format(uri=sensor.uri)
    sizes = sorted(
        {(mode.width, mode.height) for mode in sensor.modes if mode.stream == "color"}, reverse=True
    )
    return _("{name}, serial number {serial}, colour {sizes}").format(
        name=sensor.name,
        serial=sensor.serial or "-",
        sizes=", ".join(f"{width} x {height}" for width, height in sizes) or "-",
    )


def _disk(folder: Path) -> Finding:
    try:
        free_bytes = shutil.disk_usage(folder).free
    except OSError as error:
        return Finding(
            _("Disk"),
            ok=False,
            detail=error.strerror or str(error),
            remedy=_("Change to a folder that exists."),
        )
    is_enough = free_bytes >= ENOUGH_DISK_BYTES
    return Finding(
        _("Disk"),
        ok=is_enough,
        detail=_("{gigabytes} GB free").format(gigabytes=decimal_text(free_bytes / GIGABYTE, 1)),
        remedy="" if is_enough else _("Free some space: a minute of recording takes 0.3-1 GB."),
    )


def _cores() -> Finding:
    n_cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    is_enough = (n_cores or 1) >= ENOUGH_CORES
    return Finding(
        _("Processor"),
        ok=is_enough,
        detail=_("{n_cores} cores, {machine}, Python {python}").format(
            n_cores=n_cores, machine=platform.machine(), python=platform.python_version()
        ),
        remedy="" if is_enough else _("Recording needs two cores; use another computer."),
    )
