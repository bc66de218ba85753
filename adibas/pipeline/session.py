"""From a recording on the disk to a posture analysis, one burst at a time."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from adibas.arrays import UInt8Array
from adibas.calibration.files import check_fits, read_calibration
from adibas.calibration.registered import for_images_of, would_move_again
from adibas.clock import Clock, utc_now
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import RgbdFrame
from adibas.data.markers import Marker
from adibas.data.posture import PostureAnalysis
from adibas.errors import CalibrationError, MarkerError, RecordingError
from adibas.measures.geometry_tables import all_angles, all_distances
from adibas.pipeline.burst_names import name_burst
from adibas.pipeline.calibration_age import check_age
from adibas.pipeline.labels import read_labels, with_labels
from adibas.pipeline.learning import read_target
from adibas.pipeline.namers import namer_of
from adibas.pipeline.posture import (
    MarkerFindings,
    MarkerTarget,
    PostureParams,
    analyse_burst,
    doubts_about,
)
from adibas.pipeline.protocol_measuring import ProtocolWish, check_view, with_measures
from adibas.pipeline.provenance import provenance_of
from adibas.pipeline.seen_before import seen_before
from adibas.pipeline.skeleton_names import with_namer
from adibas.progress import Progress
from adibas.recordings import open_recording
from adibas.recordings.checksum import recording_sha256
from adibas.recordings.decoding import to_rgbd
from adibas.recordings.ports import RecordingReader
from adibas.recordings.reading import no_whole_frame
from adibas.skeleton.namer import Namer
from adibas.texts import Message

MARKERS_FOR_A_DISTANCE = 2


@dataclass(frozen=True, slots=True)
class PostureRequest:
    """What to analyse.

    Attributes
    ----------
    recording : Path
        MCAP, .oni or TUM folder.
    markers : str
        A file of learned colours, or ``led``.
    calibration : Path or None
        A file that takes the place of the recording's own calibration.
    frames : tuple
        First frame and the frame after the last; None = to the end.
    view, patient : str
        One of `VIEWS` or empty; a pseudonym or empty.
    protocol : ProtocolWish or None
        What to measure besides distances and angles.
    labels : Path or None
        A file that names the markers.
    oldest_calibration_days : int or None
        An older calibration is refused; None: of any age.
    """

    recording: Path
    markers: str
    calibration: Path | None = None
    frames: tuple[int, int | None] = (0, None)
    view: str = ""
    patient: str = ""
    params: PostureParams = field(default_factory=PostureParams)
    protocol: ProtocolWish | None = None
    labels: Path | None = None
    oldest_calibration_days: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class FoundMarkers:
    """The markers of one burst, few or none as they may be.

    Attributes
    ----------
    target : MarkerTarget
        What was looked for.
    findings : MarkerFindings
        As the pictures give them, without names.
    markers : tuple of Marker
        With the names that labels and the protocol's model give them.
    namer : Namer or None
        What gave names beside the labels.
    calibration : RgbdCalibration
    picture_rgb : (H, W, 3) array
        The middle picture of the burst.
    frames : (int, int)
        Of the burst, the end not included.
    notices : tuple of str
        What was lost of the recording.
    doubts : tuple of Message
        What the reader should know of the markers.
    """

    target: MarkerTarget
    findings: MarkerFindings
    markers: tuple[Marker, ...]
    namer: Namer | None
    calibration: RgbdCalibration
    picture_rgb: UInt8Array
    frames: tuple[int, int]
    notices: tuple[str, ...]
    doubts: tuple[Message, ...]


def find_in_recording(
    request: PostureRequest,
    progress: Progress,
    clock: Clock = utc_now,
    *,
    may_lack: bool = False,
) -> FoundMarkers:
    """Find the markers of one burst and name them.

    Parameters
    ----------
    may_lack : bool
        Whether a burst with fewer than two markers is no error.

    Raises
    ------
    RecordingError, CalibrationError, MarkerError, ProtocolError
        As `analyse_recording`.
    """
    target = read_target(request.markers)
    labels = () if request.labels is None else read_labels(request.labels)
    if request.protocol is not None:
        check_view(request.protocol, request.view)
    with open_recording(request.recording) as recording:
        frames = _burst_range(recording, request.frames, request.recording.name)
        calibration = calibration_of(recording, request.calibration)
        check_age(calibration, request.oldest_calibration_days, clock())
        _check_size(recording, frames[0], calibration)
        before = seen_before(recording, frames[0], calibration, request.params)
        burst = _Burst(recording, *frames, progress)
        findings = analyse_burst(burst, calibration, target, request.params, before)
        notices = tuple(notice for notice in (recording.notice,) if notice)
    if not may_lack:
        check_findings(findings)
    wish = request.protocol
    named = name_burst(
        None if wish is None else namer_of(wish.protocol, request.view),
        replace(findings, markers=with_labels(findings.markers, labels)),
        request.view,
        calibration,
        frozenset(line.label for line in labels),
        request.params.rotation_deg,
    )
    return FoundMarkers(
        target,
        findings,
        named.markers,
        named.namer,
        calibration,
        burst.picture_rgb(),
        frames,
        notices,
        (*named.doubts, *doubts_about(findings)),
    )


def analyse_recording(
    request: PostureRequest, progress: Progress, clock: Clock = utc_now
) -> PostureAnalysis:
    """Find the markers of one burst and measure every pair and triplet.

    Raises
    ------
    RecordingError
        The recording is missing, broken, or has no such frames.
    CalibrationError
        There is no calibration, or it is too old, or for another resolution.
    MarkerError
        Fewer than two markers have a position, or the colour model fits everything; or the labels
        name markers that are not there.
    ProtocolError
        The protocol measures nothing in that view.
    """
    found = find_in_recording(request, progress, clock)
    findings, calibration, markers = found.findings, found.calibration, found.markers
    begin, end = found.frames
    analysis = PostureAnalysis(
        patient=request.patient,
        view=request.view,
        n_frames=end - begin,
        first_frame=begin,
        markers=markers,
        rejected=findings.rejected,
        distances=all_distances(markers),
        angles=all_angles(markers),
        picture_rgb=found.picture_rgb,
        calibration=calibration,
        provenance=with_namer(
            provenance_of(
                recording_sha256(request.recording),
                calibration,
                found.target,
                request.params,
                clock(),
            ),
            found.namer,
        ),
        notices=(*found.notices, *found.doubts),
        surface_per_m=findings.surface.mean_per_m,
    )
    if request.protocol is None:
        return analysis
    return with_measures(analysis, request.protocol, (), request.params.rotation_deg)


class _Burst:
    """The frames of the burst, read one by one; keeps the middle picture for the report."""

    def __init__(
        self,
        recording: RecordingReader,
        begin: int,
        end: int,
        progress: Progress,
    ) -> None:
        self._recording = recording
        self._range = range(begin, end)
        self._progress = progress
        self._picture_rgb: UInt8Array | None = None

    def __iter__(self) -> Iterator[RgbdFrame]:
        middle = self._range[len(self._range) // 2]
        for done, index in enumerate(self._range, 1):
            frame = to_rgbd(self._recording.read(index), self._recording.info)
            if index == middle:
                self._picture_rgb = frame.color_rgb
            yield frame
            self._progress(done, len(self._range))

    def picture_rgb(self) -> UInt8Array:
        """Return the middle colour image of the burst that was read."""
        if self._picture_rgb is None:
            raise ValueError("the burst was not read to its middle")
        return self._picture_rgb


def check_findings(findings: MarkerFindings) -> None:
    """Raise MarkerError unless there is something to measure."""
    if not findings.markers:
        raise MarkerError(
            "No marker was found. Check that the markers have the learned colour and are in view, "
            "or learn the colour again in this light."
        )
    n_measured = sum(marker.position_m is not None for marker in findings.markers)
    if len(findings.markers) < MARKERS_FOR_A_DISTANCE:
        raise MarkerError(
            "Only one marker was found, and a distance needs two. Check that the markers have the "
            "learned colour and are in view."
        )
    if n_measured < MARKERS_FOR_A_DISTANCE:
        raise MarkerError(
            "Of {n_found} markers the depth camera gives a position to {n_measured}, and a "
            "distance needs two. Stand between 0.8 and 4 m from the sensor, inside its picture.",
            n_found=len(findings.markers),
            n_measured=n_measured,
        )


def _check_size(recording: RecordingReader, index: int, calibration: RgbdCalibration) -> None:
    frame = to_rgbd(recording.read(index), recording.info)
    check_fits(calibration, frame.color_rgb.shape[:2], frame.depth_m.shape)


def wanted_frames(recording: RecordingReader, frames: tuple[int, int | None], name: str) -> range:
    """Return the indices of the frames from the first one on, up to the second one (None: all).

    Raises
    ------
    RecordingError
        The recording, which its user knows as `name`, has none of them.
    """
    wanted = range(*slice(*frames).indices(len(recording)))
    if not wanted:
        raise _no_such_frames(recording, frames, name)
    return wanted


def _burst_range(
    recording: RecordingReader, frames: tuple[int, int | None], name: str
) -> tuple[int, int]:
    begin, asked_end = frames
    end = len(recording) if asked_end is None else asked_end
    if not begin < end <= len(recording):
        raise _no_such_frames(recording, frames, name)
    return begin, end


def _no_such_frames(
    recording: RecordingReader, frames: tuple[int, int | None], name: str
) -> RecordingError:
    if len(recording) == 0:
        return no_whole_frame(name)
    begin, end = frames
    return RecordingError(
        "{file} has {n_frames} frames, so frames {frames} cannot be read. Choose a range inside "
        "0:{n_frames}.",
        file=name,
        n_frames=len(recording),
        frames=f"{begin}:{'' if end is None else end}",
    )


def calibration_of(recording: RecordingReader, path: Path | None) -> RgbdCalibration:
    """Return the calibration of a file, or the recording's own.

    Raises
    ------
    CalibrationError
        There is none, or it would register depth that the sensor registered itself.
    """
    calibration = recording.info.calibration if path is None else read_calibration(path)
    if calibration is None and recording.notice:
        raise CalibrationError(
            "{notice} Its calibration is lost. Give one with --calibration FILE.",
            notice=recording.notice,
        )
    if calibration is None:
        raise CalibrationError(
            "The recording brings no calibration. Give one with --calibration FILE."
        )
    if path is not None and would_move_again(recording.info, calibration):
        raise CalibrationError(
            "The sensor moved the depth of this recording into the colour image itself, and {file} "
            "would move it a second time. Leave this calibration out, give one of the colour "
            "camera alone, or record again with the sensor's own registration switched off.",
            file=path.name,
        )
    return for_images_of(recording.info, calibration)
