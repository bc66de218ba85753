"""From the live sensor to a saved capture: record a burst, find its markers, keep both."""

from collections.abc import Iterator
from concurrent.futures import wait
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from datetime import datetime

from adibas.arrays import UInt8Array
from adibas.body.staying import Moment
from adibas.calibration.files import check_fits
from adibas.clock import Clock, utc_now
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import RgbdFrame, SourceInfo
from adibas.data.sessions import Capture
from adibas.data.surface import BurstDisparity
from adibas.errors import AdibasError, CalibrationError, MarkerError, SensorError, StoreError
from adibas.markers.disparity import fuse_depth
from adibas.pipeline.burst_names import name_burst
from adibas.pipeline.burst_recording import Burst
from adibas.pipeline.calibration_age import age_days
from adibas.pipeline.live import LiveView
from adibas.pipeline.namers import namer_of
from adibas.pipeline.posture import (
    MarkerFindings,
    MarkerTarget,
    PostureParams,
    analyse_burst,
    doubts_about,
)
from adibas.pipeline.protocol_measuring import wish_of_session
from adibas.pipeline.provenance import provenance_of
from adibas.pipeline.skeleton_names import with_namer
from adibas.progress import Progress
from adibas.recordings import RecordingWriter
from adibas.recordings.checksum import recording_sha256
from adibas.sessions import NewCapture, SessionStore
from adibas.skeleton.namer import Namer
from adibas.texts import message

POLL_S = 0.1
BACK_BURSTS = 2

NOT_SOUGHT = message("No marker was looked for, because no marker colour was learned.")
NOT_FOUND = message("No marker was found in the burst.")
LOST_FRAMES = message("The sensor lost frames inside the burst.")
TOO_OLD = message(
    "The calibration is older than this clinic allows. Calibrate the sensor, and capture again."
)
BEGAN_ANEW = message("The recording that was played began anew inside the burst.")


@dataclass(frozen=True, slots=True)
class CaptureRequest:
    """What to capture.

    Attributes
    ----------
    session_id : str
        Of the store.
    view : str
        One of `VIEWS`, or empty.
    n_frames : int
        Of the burst: 30 are a second, in which a patient sways by a millimetre or two.
    target : MarkerTarget or None
        None keeps picture and recording, for markers that are set by hand.
    oldest_calibration_days : int or None
        A calibration of more days is told in the capture; None allows any.
    """

    session_id: str
    view: str = ""
    n_frames: int = 30
    target: MarkerTarget | None = None
    oldest_calibration_days: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class CaptureFindings:
    """What a burst shows, ready to be saved.

    Attributes
    ----------
    found : MarkerFindings
        No markers where none were found or looked for; its surface gives the positions of those
        that are set by hand.
    picture_rgb : (H, W, 3) uint8 array
        Of the middle frame.
    notices : tuple of str
        What the reader must know; message ids, where they have no fields.
    """

    found: MarkerFindings
    picture_rgb: UInt8Array
    notices: tuple[str, ...]


def frames_of_view(view: str, burst_frames: int) -> int:
    """Return how many frames a view gets: from behind two bursts' worth, for the back's shape.

    Curves of the spine are small beside the sensor's noise (docs/body-surface.md, *Figures*).
    """
    return BACK_BURSTS * burst_frames if view == "posterior" else burst_frames


def take_capture(
    store: SessionStore,
    live: LiveView,
    request: CaptureRequest,
    progress: Progress,
    clock: Clock = utc_now,
) -> Capture:
    """Record a burst into the store, find its markers, and save the capture.

    The recording is finished only when the markers were looked for. What fails before that, or is
    cancelled, leaves nothing in the store: half a burst is no measure, and the patient is still
    there for another one. Where only the last step fails, the finished recording stays in the
    session.

    Parameters
    ----------
    store : SessionStore
        Where it is kept.
    live : LiveView
        With a live sensor; its settings and calibration are used.
    request : CaptureRequest
        What to capture.
    progress : callable
        Told (steps done, steps in all), ten times a second at least while frames come. What it
        raises cancels the capture and is raised again.

    Raises
    ------
    SensorError
        No sensor is live, or it was lost in the burst.
    CalibrationError
        There is no calibration, or it does not fit.
    RecordingError, StoreError
        The store cannot be written, or the disk is full or too slow.
    """
    info = info_in_use(live)
    calibration = calibration_in_use(live)
    params, begun_utc, before = live.params, clock(), live.person
    writer = store.recordings.create(request.session_id, info)
    with whole_or_nothing(writer):
        burst = record_burst(live, writer, request.n_frames, progress)
        findings = analyse_capture(burst, calibration, request.target, params, progress, before)
        writer.close()
    namer = _namer(store, request)
    found = findings.found
    named = name_burst(namer, found, request.view, calibration, rotation_deg=params.rotation_deg)
    new = NewCapture(
        view=request.view,
        recording_id=writer.recording_id,
        first_frame=0,
        n_frames=len(burst),
        calibration=calibration,
        detected=named.markers,
        rejected=found.rejected,
        provenance=with_namer(
            provenance_of(
                recording_sha256(writer.path), calibration, request.target, params, clock()
            ),
            named.namer,
        ),
        captured_utc=begun_utc,
        notices=(
            *findings.notices,
            *named.doubts,
            *_doubts_about_age(calibration, request, begun_utc),
        ),
    )
    return store.captures.add(request.session_id, new, findings.picture_rgb, found.surface)


def _doubts_about_age(
    calibration: RgbdCalibration, request: CaptureRequest, now_utc: datetime
) -> tuple[str, ...]:
    allowed = request.oldest_calibration_days
    age = age_days(calibration, now_utc)
    return (TOO_OLD,) if allowed is not None and age is not None and age > allowed else ()


def _namer(store: SessionStore, request: CaptureRequest) -> Namer | None:
    """Return who knows the landmarks of the session's protocol; None where nobody does."""
    wish, _notices = wish_of_session(store.sessions.get(request.session_id))
    return None if wish is None else namer_of(wish.protocol, request.view)


def info_in_use(live: LiveView) -> SourceInfo:
    """Return what a live view's sensor says of itself.

    Raises
    ------
    SensorError
        No sensor is live.
    """
    info = live.state.info
    if info is None:
        raise SensorError("No sensor is live. Choose a source and wait for its picture.")
    return info


def calibration_in_use(live: LiveView) -> RgbdCalibration:
    """Return the calibration that a live view measures with.

    Raises
    ------
    CalibrationError
        There is none.
    """
    if live.calibration is None:
        raise CalibrationError(
            "This source brings no calibration, so nothing can be measured. Give one for it, or "
            "choose another source."
        )
    return live.calibration


def analyse_capture(
    burst: Burst,
    calibration: RgbdCalibration,
    target: MarkerTarget | None,
    params: PostureParams,
    progress: Progress,
    before: Moment | None = None,
) -> CaptureFindings:
    """Find the markers of a burst; a burst without any is worth keeping, too.

    `before`: see `analyse_burst`.

    Raises
    ------
    CalibrationError
        The calibration is for another resolution.
    RecordingError
        A frame lacks depth or colour, or its colour image is damaged.
    """
    middle = burst.frame(len(burst) // 2)
    check_fits(calibration, middle.color_rgb.shape[:2], middle.depth_m.shape)
    notices: list[str] = [LOST_FRAMES] * (burst.n_dropped > 0)
    notices += [BEGAN_ANEW] * (burst.n_restarts > 0)
    found = None
    if target is None:
        notices.append(NOT_SOUGHT)
    else:
        try:
            found = analyse_burst(counted(burst, progress), calibration, target, params, before)
        except MarkerError as error:
            notices.append(error.message_id)  # shown in the reader's language later
        else:
            notices += [NOT_FOUND] * (not found.markers)
            notices += doubts_about(found)
    if found is None:
        found = MarkerFindings((), (), _surface(burst, calibration, params))
    return CaptureFindings(found, middle.color_rgb, tuple(notices))


def _surface(burst: Burst, calibration: RgbdCalibration, params: PostureParams) -> BurstDisparity:
    return fuse_depth(
        (frame.depth_m for frame in burst),
        calibration.depth_bias,
        calibration.depth,
        least_share=params.least_pixel_share,
        greatest_sd_per_m=params.greatest_scatter_per_m,
    )


def counted(burst: Burst, progress: Progress) -> Iterator[RgbdFrame]:
    """Give the frames and tell of each: the second half of the work."""
    for done, frame in enumerate(burst, 1):
        progress(len(burst) + done, 2 * len(burst))
        yield frame


def record_burst(
    live: LiveView,
    writer: RecordingWriter,
    n_frames: int,
    progress: Progress,
    *,
    keeps_frames: bool = True,
) -> Burst:
    """Wait for a burst that goes into `writer`; what `progress` raises cancels it."""
    future = live.capture(n_frames, writer, keeps_frames=keeps_frames)
    try:
        while not wait([future], timeout=POLL_S).done:
            progress(min(writer.n_frames, n_frames), 2 * n_frames)
    finally:
        if not future.done():
            live.cancel_capture()
            wait([future])  # the writer is not ours before
    return future.result()


@contextmanager
def whole_or_nothing(writer: RecordingWriter) -> Iterator[None]:
    """Abandon a recording that is not closed in the block, and say that nothing of it is kept."""
    with ExitStack() as undo:
        undo.callback(writer.abandon)
        try:
            yield
        except AdibasError as error:
            told = _with_nothing_kept(error)
            if told is error:
                raise
            raise told from error
        undo.pop_all()


def _with_nothing_kept(error: AdibasError) -> AdibasError:
    """Return `error`, or where the disk failed, one that does not promise that frames are kept."""
    cause: BaseException | None = error
    while cause is not None and not isinstance(cause, OSError):
        cause = cause.__cause__
    if cause is None:
        return error
    return StoreError(
        "The capture is not saved: {reason}. Nothing of it is kept. Free some space on the disk, "
        "or check it, and capture again.",
        reason=cause.strerror or str(cause),
    )
