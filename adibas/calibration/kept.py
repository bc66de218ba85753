"""The calibrations that were made on this computer, sensor by sensor. Nothing of patients."""

import hashlib
import re
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

import platformdirs

from adibas.calibration.files import read_calibration, write_calibration
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import SourceInfo
from adibas.errors import CalibrationError

REMIND_AFTER = timedelta(days=180)
"""Lens mounts and projectors creep with heat and transport; half a year is what clinics give
their goniometers and scales."""

Sizes = tuple[tuple[int, int] | None, tuple[int, int] | None]
"""(width, height) of the colour image and of the depth image; None without such a camera."""

_UNSAFE = re.compile(r"[^A-Za-z0-9._-]+")
_LONGEST_NAME = 40


@dataclass(frozen=True, slots=True, eq=False)
class KeptCalibration:
    """One of them.

    Attributes
    ----------
    path : Path
        Where it lies.
    calibration : RgbdCalibration
        What it says.
    made_utc : datetime
        When it was made.
    """

    path: Path
    calibration: RgbdCalibration
    made_utc: datetime

    def is_old(self, now_utc: datetime, allowed: timedelta = REMIND_AFTER) -> bool:
        """Return whether it should be made anew because of its age."""
        return now_utc - self.made_utc > allowed


class KeptCalibrations:
    """A folder with one folder a sensor, one file a calibration.

    Parameters
    ----------
    folder : Path or None
        Made when the first is kept; None for that of this user.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self.folder = folder or platformdirs.user_data_path("adibas", appauthor=False) / (
            "calibrations"
        )

    def keep(self, calibration: RgbdCalibration) -> Path:
        """Write a calibration that names its sensor and its time, and return where it lies.

        Raises
        ------
        FileError
            The disk is full, or the folder cannot be written.
        """
        if not calibration.sensor_serial:
            raise ValueError("a calibration without a sensor cannot be found again")
        made_utc = _time(calibration.created_utc)
        name = f"{made_utc.strftime('%Y%m%dT%H%M%S%fZ')}.json"
        path = self._folder_of(calibration.sensor_serial) / name
        write_calibration(path, calibration)
        return path

    def of_sensor(self, sensor: str) -> tuple[KeptCalibration, ...]:
        """Return those of a sensor, newest first.

        Raises
        ------
        CalibrationError
            One of them is damaged.
        """
        return tuple(self._newest_first(sensor))

    def _newest_first(self, sensor: str) -> Iterator[KeptCalibration]:
        """Read one after the other, as far as they are asked for."""
        for path in sorted(self._folder_of(sensor).glob("[0-9]*.json"), reverse=True):
            calibration = read_calibration(path)
            if calibration.sensor_serial == sensor:
                yield KeptCalibration(path, calibration, _time(calibration.created_utc))

    def newest(self, sensor: str, sizes: Sizes | None = None) -> KeptCalibration | None:
        """Return the newest of a sensor for images of these sizes; None where there is none.

        Parameters
        ----------
        sensor : str
            As `sensor_key` tells it.
        sizes : pair of (int, int) or None
            None: of any size.

        Raises
        ------
        CalibrationError
            It is damaged, or a newer one for other sizes is.
        """
        kept = self._newest_first(sensor) if sensor else ()
        fitting = (one for one in kept if sizes is None or sizes_of(one.calibration) == sizes)
        return next(fitting, None)

    def pictures_folder(self, sensor: str, color_size: tuple[int, int]) -> Path:
        """Return where the pictures of a calibration in the making lie; it need not be there.

        Parameters
        ----------
        sensor : str
            As `sensor_key` tells it; '' for pictures of a sensor that nobody knows.
        color_size : (width, height)
            Of the pictures.
        """
        width, height = color_size
        return self._folder_of(sensor) / f"pictures-{width}x{height}"

    def _folder_of(self, sensor: str) -> Path:
        """Return a folder that no other sensor has, whatever characters its number is made of."""
        digest = hashlib.sha256(sensor.encode()).hexdigest()[:12]
        return self.folder / f"{_UNSAFE.sub('_', sensor)[:_LONGEST_NAME]}-{digest}"


def sensor_key(info: SourceInfo) -> str:
    """Return by what a sensor is known again: its serial number, else its name, else ''."""
    return info.sensor_serial or info.sensor_name


def sizes_of(calibration: RgbdCalibration) -> Sizes:
    """Return the (width, height) of the images that a calibration is for."""
    color, depth = calibration.color, calibration.depth
    return (
        None if color is None else (color.width, color.height),
        None if depth is None else (depth.width, depth.height),
    )


def _time(created_utc: str) -> datetime:
    try:
        made = datetime.fromisoformat(created_utc)
    except ValueError as error:
        raise CalibrationError(
            "The calibration does not say when it was made. Calibrate the sensor again."
        ) from error
    return made if made.tzinfo else made.replace(tzinfo=UTC)
