"""Sensors with the newest calibration that was made of them on this computer."""

from contextlib import ExitStack
from dataclasses import replace

from adibas.calibration.kept import KeptCalibrations, sensor_key, sizes_of
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.sensors.ports import DEFAULT_OPTIONS, READ_TIMEOUT_S, DepthCamera, SensorOptions
from adibas.sensors.sources import open_source

SIMULATOR = "simulator"


class CalibratedOpener:
    """Opens sources as `open_source` does; sensors bring the calibration that was kept of them.

    A recording keeps its own: it was made with it.

    Parameters
    ----------
    kept : KeptCalibrations
        Of this computer.
    """

    def __init__(self, kept: KeptCalibrations) -> None:
        self._kept = kept

    def __call__(self, text: str, options: SensorOptions = DEFAULT_OPTIONS) -> DepthCamera:
        """Open a source.

        Raises
        ------
        CalibrationError
            A calibration of this sensor is damaged.
        SensorError, RecordingError
            As `open_source`.
        """
        camera = open_source(text, options)
        if not (camera.is_live or text.partition(":")[0] == SIMULATOR):
            return camera
        with ExitStack() as if_that_fails:
            if_that_fails.callback(camera.close)
            info = self._calibrated(camera.info)
            if_that_fails.pop_all()
        return camera if info is camera.info else CalibratedCamera(camera, info)

    def _calibrated(self, info: SourceInfo) -> SourceInfo:
        if info.is_depth_registered:  # by the sensor's own calibration, which is in the images
            return info
        sizes = None if info.calibration is None else sizes_of(info.calibration)
        newest = self._kept.newest(sensor_key(info), sizes)
        if newest is None:
            return info
        return replace(info, calibration=_as_it_stands(newest.calibration, info.calibration))


def _as_it_stands(kept: RgbdCalibration, opened: RgbdCalibration | None) -> RgbdCalibration:
    """Return a kept calibration with the vertical that the sensor itself tells, or with none.

    The one that was kept is of where the sensor stood then: it may stand elsewhere today.
    """
    today = opened or RgbdCalibration()
    return replace(
        kept,
        gravity=today.gravity,
        floor=today.floor,
        gravity_sd_rad=today.gravity_sd_rad,
        floor_flatness_m=today.floor_flatness_m,
    )


class CalibratedCamera(DepthCamera):
    """A camera with another header.

    Parameters
    ----------
    camera : DepthCamera
        Closed with this one.
    info : SourceInfo
        What holds for its frames.
    """

    def __init__(self, camera: DepthCamera, info: SourceInfo) -> None:
        self._camera = camera
        self._info = info

    @property
    def info(self) -> SourceInfo:
        """The header, with the calibration that was kept."""
        return self._info

    @property
    def is_live(self) -> bool:
        """As the camera."""
        return self._camera.is_live

    def read(self, timeout_s: float = READ_TIMEOUT_S) -> SensorFrame | None:
        """Return the camera's next frame."""
        return self._camera.read(timeout_s)

    def close(self) -> None:
        """Close the camera."""
        self._camera.close()
