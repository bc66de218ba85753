"""One text names any source of frames, on the command line and in the window."""

from collections.abc import Sequence
from pathlib import Path

from adibas.errors import FileError, SensorError
from adibas.recordings import is_named_like_recording
from adibas.sensors.ports import DEFAULT_OPTIONS, DepthCamera, SensorDescription, SensorOptions

SENSOR_KINDS = ("openni2", "realsense")
FILE_ENDINGS = (".oni", ".db3", ".bag")
"""Of camera libraries' own recordings."""


def open_source(text: str, options: SensorOptions = DEFAULT_OPTIONS) -> DepthCamera:
    """Open a camera, a camera library's file, the simulator, or a recording.

    Parameters
    ----------
    text : str
        ``openni2[:FILE.oni]``, ``realsense[:FILE]``, ``simulator[:SCENE]``, or the path of a
        recording; a camera's library is imported only when it is named. ``openni2:SENSOR`` and
        ``realsense:SENSOR`` name one of several sensors by its serial number, or by the address
        that its library gives it.
    options : SensorOptions
        What does not concern this source is left aside.

    Raises
    ------
    SensorError
        There is no such source, or it cannot be opened.
    RecordingError
        The recording cannot be read.
    """
    kind, _, rest = text.partition(":")
    if kind == "openni2":
        from adibas.sensors.openni2 import OpenNI2Camera

        return OpenNI2Camera(*_file_and_sensor(rest), options)
    if kind == "realsense":
        from adibas.sensors.realsense import open_realsense

        return open_realsense(*_file_and_sensor(rest), options)
    if kind == "simulator":
        from adibas.sensors.simulator import SimulatorCamera

        return SimulatorCamera(rest or None, options)
    if kind == "kinect1":
        raise SensorError(
            "The Kinect for Xbox 360 (kinect1) is not available in this version. Use an OpenNI2 "
            "sensor, a RealSense, or recordings."
        )
    return _open_recording(text, options)


def is_sensor(text: str) -> bool:
    """Say whether a text that `open_source` takes names a sensor that has to be plugged in."""
    kind, _, rest = text.partition(":")
    return kind in SENSOR_KINDS and _file_and_sensor(rest)[0] is None


def source_of(kind: str, sensor: SensorDescription, others: Sequence[SensorDescription]) -> str:
    """Return the text that opens one of the sensors of a library.

    Parameters
    ----------
    kind : str
        ``openni2`` or ``realsense``.
    others : sequence of SensorDescription
        All that are plugged in. A single one needs no name, and is found in any socket.
    """
    if len(others) == 1:
        return kind
    serials = [one.serial for one in others]
    is_known = bool(sensor.serial) and serials.count(sensor.serial) == 1
    return f"{kind}:{sensor.serial if is_known else sensor.uri}"


def _file_and_sensor(rest: str) -> tuple[Path | None, str | None]:
    """Tell a library's file from the name of a sensor."""
    if not rest:
        return None, None
    is_file = rest.lower().endswith(FILE_ENDINGS) or Path(rest).exists()
    return (Path(rest), None) if is_file else (None, rest)


def _open_recording(text: str, options: SensorOptions) -> DepthCamera:
    path = Path(text)
    if is_named_like_recording(path) and not path.exists():
        raise FileError("{file} is not there. Check the name and the folder.", file=path.name)
    if not text or not path.exists():
        raise SensorError(
            "{source} is neither a source nor a recording. Give openni2, openni2:FILE.oni, "
            "realsense, realsense:FILE, simulator, simulator:SCENE, or the path of a recording.",
            source=text or '""',
        )
    from adibas.sensors.replay import RecordingCamera

    return RecordingCamera(path, options)
