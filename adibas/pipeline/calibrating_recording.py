"""A colour camera from a recording of a board: one picture of each still moment."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from threading import Event

from adibas.data.board import Board
from adibas.errors import CalibrationError
from adibas.pipeline.calibrating import (
    CalibratingParams,
    CameraOutcome,
    NamedImage,
    calibrate_camera,
)
from adibas.pipeline.calibrating_depth_moments import (
    Stopped,
    Watch,
    gray_of,
    moments_of,
    nothing_stands_still,
)
from adibas.pipeline.still_moments import StillParams
from adibas.progress import Progress
from adibas.recordings import open_recording


def calibrate_color_of(
    recordings: Sequence[Path],
    board: Board,
    params: CalibratingParams | None = None,
    *,
    progress: Progress | None = None,
    stop: Event | None = None,
) -> CameraOutcome | None:
    """Calibrate the colour camera of recordings in which a board is held still now and then.

    Parameters
    ----------
    recordings : sequence of Path
        With depth, by which the still moments are found.
    board : Board
        That they show.
    progress : callable or None
        Told (frames done, frames in all).
    stop : Event or None
        Ends the work early.

    Returns
    -------
    outcome : CameraOutcome or None
        None where `stop` was set.

    Raises
    ------
    CalibrationError
        Nothing stands still, or there is no colour.
    RecordingError
        A recording cannot be read, or has no depth.
    """
    watch = Watch(recordings, progress, stop, n_looks=1)
    try:
        images = _pictures(recordings, watch)
        return calibrate_camera(images, board, params, stop=stop)
    except Stopped:
        return None


def serial_of(recordings: Sequence[Path]) -> str:
    """Return the serial number of the sensor; '' where the recordings do not tell it."""
    serials = []
    for path in recordings:
        with open_recording(path) as reader:
            serials.append(reader.info.sensor_serial)
    return next((serial for serial in serials if serial), "")


def _pictures(recordings: Sequence[Path], watch: Watch) -> Iterator[NamedImage]:
    n_still = 0
    is_any = False
    for path in recordings:
        with open_recording(path) as reader:
            times_ns = reader.timestamps_ns
            for moment in moments_of(reader, watch, StillParams()):
                n_still += 1
                gray = gray_of(reader, moment.middle)
                if gray is not None:
                    is_any = True
                    time_s = (times_ns[moment.middle] - times_ns[0]) / 1e9
                    yield NamedImage(f"{path.stem} {time_s:.1f} s", gray)
    if not n_still:
        raise nothing_stands_still()
    if not is_any:
        raise CalibrationError(
            "The recording has no colour. Record depth and colour together, and calibrate again."
        )
