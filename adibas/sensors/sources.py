"""One text names any source of frames, on the command line and in the window."""

from pathlib import Path

from adibas.errors import SensorError
from adibas.sensors.ports import DEFAULT_OPTIONS, DepthCamera, SensorOptions


def open_source(text: str, options: SensorOptions = DEFAULT_OPTIONS) -> DepthCamera:
    """Open a camera, a camera library's file, the simulator, or a recording.

    Parameters
    ----------
    text : str
        ``openni2[:FILE.oni]``, ``realsense[:FILE]``, ``simulator[:SCENE]``, or the path of a
        recording; a camera's library is imported only when it is named.
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

        return OpenNI2Camera(Path(rest) if rest else None, options)
    if kind == "realsense":
        from adibas.sensors.realsense import open_realsense

        return open_realsense(Path(rest) if rest else None, options)
    if kind == "simulator":
        from adibas.sensors.simulator import SimulatorCamera

        return SimulatorCamera(rest or None, options)
    if kind == "kinect1":
        raise SensorError(
            "The Kinect for Xbox 360 (kinect1) is not available in this version. Use an OpenNI2 "
            "sensor, a RealSense, or recordings."
        )
    return _open_recording(text, options)


def _open_recording(text: str, options: SensorOptions) -> DepthCamera:
    path = Path(text)
    if not text or not path.exists():
        raise SensorError(
            "{source} is neither a source nor a recording. Give openni2, openni2:FILE.oni, "
            "realsense, realsense:FILE, simulator, simulator:SCENE, or the path of a recording.",
            source=text or '""',
        )
    from adibas.sensors.replay import RecordingCamera

    return RecordingCamera(path, options)
