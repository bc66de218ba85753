"""Any recording as a camera."""

from dataclasses import replace
from pathlib import Path

from adibas.calibration.registered import for_images_of
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.recordings import open_recording
from adibas.sensors.pace import Pacer
from adibas.sensors.ports import DEFAULT_OPTIONS, READ_TIMEOUT_S, DepthCamera, SensorOptions


class RecordingCamera(DepthCamera):
    """Gives the frames of a recording in order, as they are.

    Parameters
    ----------
    path : Path
        Of any recording that `open_recording` reads.
    options : SensorOptions
        `is_paced` gives the frames at their own pace, else they come as fast as they are read.

    Raises
    ------
    RecordingError
        The recording cannot be read.
    """

    def __init__(self, path: Path, options: SensorOptions = DEFAULT_OPTIONS) -> None:
        self._reader = open_recording(path)
        self._info = _with_depth_camera(self._reader.info)
        self._pacer = Pacer() if options.is_paced else None
        self._next_index = 0

    @property
    def info(self) -> SourceInfo:
        """The header of the recording."""
        return self._info

    @property
    def is_live(self) -> bool:
        """False: a recording waits."""
        return False

    def read(self, timeout_s: float = READ_TIMEOUT_S) -> SensorFrame | None:  # noqa: ARG002
        """Return the next frame, None after the last one; `timeout_s` has no meaning here."""
        if self._next_index >= len(self._reader):
            return None
        frame = self._reader.read(self._next_index)
        self._next_index += 1
        if self._pacer is not None:
            self._pacer.wait_for(frame.timestamp_ns)
        return frame

    def close(self) -> None:
        """Close the recording."""
        self._reader.close()


def _with_depth_camera(info: SourceInfo) -> SourceInfo:
    """Return a header whose calibration holds for depth that the sensor registered itself."""
    if info.calibration is None:
        return info
    return replace(info, calibration=for_images_of(info, info.calibration))
