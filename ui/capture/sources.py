"""Which sources of frames there are to choose from. Knows nothing of Qt."""

from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from adibas.data.posture import VIEWS
from adibas.errors import SensorError
from adibas.sensors import openni2_modes, realsense_library
from adibas.sensors.ports import SensorDescription
from adibas.sensors.sources import source_of
from adibas.texts import message
from adibas.texts import translate as _
from ui.view_names import TURN, VIEW_NAMES

SIMULATOR = "simulator"
Sizes: TypeAlias = tuple[tuple[int, int], ...]
SIZES: Sizes = ((1280, 1024), (640, 480))
"""Of the colour image, (width, height), where a sensor was not asked."""


@dataclass(frozen=True, slots=True)
class SourceChoice:
    """A line of the list: its name, translated where it is shown, and the text that opens it.

    `sizes` are those of its colour image, (width, height); empty where it has the one it has.
    """

    title: str
    source: str
    sizes: Sizes = SIZES
    is_sensor: bool = False


def find_sources(recent: tuple[str, ...]) -> tuple[SourceChoice, ...]:
    """Look for sensors (a second or two), and add the simulator and recent recordings.

    A camera library that is missing or fails offers no sensor; the doctor page says why.
    """
    found = []
    for name, source, list_sensors in (
        ("OpenNI2", "openni2", openni2_modes.list_sensors),
        ("RealSense", "realsense", realsense_library.list_sensors),
    ):
        try:
            sensors = list_sensors()
        except SensorError:
            continue
        found += [
            SourceChoice(
                _sensor_title(sensor, name, is_alone=len(sensors) == 1),
                source_of(source, sensor, sensors),
                color_sizes(sensor),
                True,
            )
            for sensor in sensors
        ]
    return (*found, *usual_sources(recent))


def usual_sources(recent: tuple[str, ...]) -> tuple[SourceChoice, ...]:
    """Return what is there without looking for sensors."""
    recordings = (SourceChoice(Path(path).name, path, sizes=()) for path in recent)
    return (SourceChoice(message("Simulated patient (demo sensor)"), SIMULATOR), *recordings)


def color_sizes(sensor: SensorDescription) -> Sizes:
    """Return what the sensor says that its colour image can be, largest first."""
    sizes = {(mode.width, mode.height) for mode in sensor.modes if mode.stream == "color"}
    return tuple(sorted(sizes, reverse=True)) or SIZES


def _sensor_title(sensor: SensorDescription, library: str, *, is_alone: bool) -> str:
    """Return a sensor's name; of several also what is written on it, or where it is plugged in."""
    name = sensor.name or library
    told = name if is_alone else f"{name} {sensor.serial or sensor.uri}"
    return f"{told} ({library})"


def source_for_view(source: str, view: str) -> str:
    """Return what to open for a view: the simulated patient turns with it."""
    return f"{SIMULATOR}:{view}" if source == SIMULATOR and view in (*VIEWS, TURN) else source


def view_title(view: str) -> str:
    """Return the name of a view for the user."""
    return _(VIEW_NAMES[view])
