"""A slow turn of the patient on its way from the live sensor into the store."""

from dataclasses import dataclass, replace

from adibas.pipeline.body_views import depth_camera_of
from adibas.pipeline.capturing import (
    BEGAN_ANEW,
    LOST_FRAMES,
    calibration_in_use,
    info_in_use,
    record_burst,
    whole_or_nothing,
)
from adibas.pipeline.live import LiveView
from adibas.progress import Progress
from adibas.recordings import RecordingOptions
from adibas.sessions import SessionStore

TURN_S = 20.0
"""A whole turn in the 10 to 30 seconds in which a body is followed, with time to begin and end."""

AS_STORED = RecordingOptions(color="jpeg")
"""Depth without loss; colour, which is only looked at, in a third of the room and time."""


@dataclass(frozen=True, slots=True)
class TakenTurn:
    """What was recorded.

    Attributes
    ----------
    session_id, recording_id : str
        Of the store.
    n_frames : int
        In the recording.
    notices : tuple of str
        What the reader must know; message ids.
    """

    session_id: str
    recording_id: str
    n_frames: int
    notices: tuple[str, ...]


def take_turn(
    store: SessionStore,
    live: LiveView,
    session_id: str,
    progress: Progress,
    duration_s: float = TURN_S,
) -> TakenTurn:
    """Record a turn into the store, with the calibration in use; what fails leaves nothing there.

    Parameters
    ----------
    store : SessionStore
        Where it is kept.
    live : LiveView
        With a live sensor.
    session_id : str
        Whose patient turns; the caller notes the recording in its set-up.
    progress : callable
        Told (frames, frames in all), ten times a second at least. What it raises cancels the turn
        and is raised again.
    duration_s : float
        At the sensor's rate.

    Raises
    ------
    SensorError
        No sensor is live, or it was lost in the turn.
    CalibrationError
        There is none of the depth camera.
    RecordingError, StoreError
        The store cannot be written, or the disk is full or too slow.
    """
    info, calibration = info_in_use(live), calibration_in_use(live)
    depth_camera_of(calibration)
    n_frames = max(1, round(duration_s * info.frame_rate_hz))
    writer = store.recordings.create(session_id, replace(info, calibration=calibration), AS_STORED)

    def told(done: int, _total: int) -> None:
        progress(done, n_frames)

    with whole_or_nothing(writer):
        burst = record_burst(live, writer, n_frames, told, keeps_frames=False)
        writer.close()
    notices = [LOST_FRAMES] * (writer.n_dropped > 0) + [BEGAN_ANEW] * (burst.n_restarts > 0)
    return TakenTurn(session_id, writer.recording_id, writer.n_frames, tuple(notices))
