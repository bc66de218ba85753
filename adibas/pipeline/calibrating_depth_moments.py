"""What the still moments of a recording show: the depth of a burst, and where the board stood."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event

import numpy as np

from adibas.arrays import Float32Array, IntArray, UInt8Array
from adibas.calibration.corners import as_gray
from adibas.calibration.extrinsics_pose import BoardPose, find_pose
from adibas.calibration.files import check_fits
from adibas.calibration.finder import TEXTS, BoardSearch, search_board
from adibas.clock import NS_PER_S
from adibas.data.board import Board, BoardCorners
from adibas.data.calibration import DepthBias, RgbdCalibration
from adibas.data.calibration_verdict import SENTENCES, Reason
from adibas.data.frames import depth_in_metres
from adibas.data.surface import BurstDisparity
from adibas.errors import CalibrationError, RecordingError
from adibas.markers.disparity import fuse_depth
from adibas.pipeline.calibrating_depth_types import DepthCalibratingParams, DepthRequest
from adibas.pipeline.still_moments import ChangeMeter, Moment, StillParams, still_moments
from adibas.progress import Progress
from adibas.recordings import open_recording
from adibas.recordings.decoding import decode_color
from adibas.recordings.ports import RecordingReader
from adibas.texts import Message, message

MOVED = message("The board moves. Hold it still for two seconds at each place.")
UNCLEAR = message("It cannot be seen how the board stands. Hold it nearer, and tilt it.")
NO_COLOR = message("The recording has no colour. Record depth and colour together.")


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What a still moment shows.

    Attributes
    ----------
    name : str
        For the reader.
    time_s : float
        From the beginning of the first recording.
    disparity : BurstDisparity
        As measured.
    gray : (H, W) array or None
        Of its middle.
    pose : BoardPose or None
        Of the board.
    hindrance : Message or None
        Why there is no pose, where a board was looked for.
    fields : mapping
        What stands at the places of that sentence.
    """

    name: str
    time_s: float
    disparity: BurstDisparity
    gray: UInt8Array | None
    pose: BoardPose | None
    hindrance: Message | None = None
    fields: Mapping[str, object] = field(default_factory=dict)


def nothing_stands_still() -> CalibrationError:
    """Return the error of a recording without any rest."""
    return CalibrationError(
        "Nothing stands still in the recording. Hold the board still for two seconds at each "
        "place; the sensor must not move."
    )


@dataclass(frozen=True, slots=True, eq=False)
class BoardSight:
    """Where the board stood in a burst, or why that is not known."""

    pose: BoardPose | None = None
    hindrance: Message | None = None
    fields: Mapping[str, object] = field(default_factory=dict)


class Stopped(Exception):  # noqa: N818  (no error: the caller's wish)
    """The caller wants no more."""


class Watch:
    """Reads the frames of recordings, counts them, and ends where the caller wants to."""

    def __init__(
        self,
        paths: Sequence[Path],
        progress: Progress | None,
        stop: Event | None,
        *,
        n_looks: int = 2,
    ) -> None:
        self._progress = progress
        self._stop = stop
        self._done = 0
        self._total = 0
        for path in paths:
            with open_recording(path) as reader:
                self._total += n_looks * len(reader)

    def count(self) -> None:
        """Tell of one frame that is done; every frame may be looked at `n_looks` times."""
        if self._stop is not None and self._stop.is_set():
            raise Stopped
        self._done = min(self._done + 1, self._total)
        if self._progress is not None:
            self._progress(self._done, self._total)


def moments_of(reader: RecordingReader, watch: Watch, params: StillParams) -> tuple[Moment, ...]:
    """Return the still moments of a recording.

    Raises
    ------
    RecordingError
        It has no depth.
    """
    meter = ChangeMeter(reader.info.depth_unit_m, params)
    shares = []
    for frame in reader:
        watch.count()
        shares.append(float("nan") if frame.depth_raw is None else meter.share(frame.depth_raw))
    if not np.isfinite(shares).any():
        raise RecordingError(
            "The recording has no depth. Record depth and colour together, and calibrate again."
        )
    return still_moments(shares, params)


def look_at(
    reader: RecordingReader,
    watch: Watch,
    start: RgbdCalibration,
    request: DepthRequest,
    params: DepthCalibratingParams,
) -> Iterator[Seen]:
    """Give what the still moments of a recording show; times are from its own beginning.

    Raises
    ------
    CalibrationError
        The images have another resolution than the calibration.
    RecordingError
        There is no depth, or the recording cannot be read.
    """
    times_ns = reader.timestamps_ns
    for moment in moments_of(reader, watch, params.still):
        time_s = float(times_ns[moment.middle] - times_ns[0]) / NS_PER_S
        disparity = fuse_depth(_depths(moment, reader, watch, start), DepthBias())
        gray = gray_of(reader, moment.middle)
        sight = BoardSight()
        if request.board is not None:
            sight = _sight(moment, reader, start, request.board, params)
        yield Seen(
            f"{time_s:.1f} s",
            time_s,
            disparity,
            gray,
            sight.pose,
            sight.hindrance,
            sight.fields,
        )


def _depths(
    moment: Moment, reader: RecordingReader, watch: Watch, start: RgbdCalibration
) -> Iterator[Float32Array]:
    unit_m = reader.info.depth_unit_m
    for index in range(moment.first, moment.last):
        watch.count()
        raw = reader.read(index).depth_raw
        if raw is not None:
            check_fits(start, None, raw.shape)
            yield depth_in_metres(raw, unit_m)


def gray_of(reader: RecordingReader, index: int) -> UInt8Array | None:
    """Return the brightness of a frame's colour image; None where it has none."""
    frame = reader.read(index)
    if frame.color is None:
        return None
    return as_gray(decode_color(frame.color, frame.sequence))


def _sight(
    moment: Moment,
    reader: RecordingReader,
    start: RgbdCalibration,
    board: Board,
    params: DepthCalibratingParams,
) -> BoardSight:
    """Return where the board stood, by the mean of its corners all over the burst."""
    found: list[BoardCorners] = []
    for index in spread_over(moment, params.n_corner_frames):
        gray = gray_of(reader, int(index))
        if gray is None:
            return BoardSight(None, NO_COLOR)
        check_fits(start, gray.shape, None)
        search = search_board(gray, board, "", params.finder)
        if search.corners is None or search.corners.is_mirrored:
            return _unseen(search)
        found.append(search.corners)
    corners = mean_corners(found, params.largest_move_px)
    if corners.n_seen == 0:
        return BoardSight(None, MOVED)
    if start.color is None:
        raise ValueError("the colour camera is needed")
    pose = find_pose(corners, board, start.color, params.pose)
    return BoardSight(pose, UNCLEAR if pose is None else None)


def _unseen(search: BoardSearch) -> BoardSight:
    if search.problem is None:
        return BoardSight(None, SENTENCES[Reason.MIRRORED])
    return BoardSight(None, TEXTS[search.problem], search.fields)


def spread_over(moment: Moment, n: int) -> IntArray:
    """Return the numbers of up to `n` frames in the middles of equal parts of a burst."""
    n_frames = moment.last - moment.first
    middles = moment.first + (np.arange(n) + 0.5) * n_frames / n - 0.5
    return np.unique(np.rint(middles).astype(np.int64))


def mean_corners(found: Sequence[BoardCorners], largest_move_px: float) -> BoardCorners:
    """Return the mean of corners of one burst; hidden are those not seen in all, or that moved.

    Parameters
    ----------
    found : sequence of BoardCorners
        One at least.
    largest_move_px : float
        For an image 1280 wide; if most corners moved farther, all are hidden.
    """
    first = found[0]
    pixels = np.stack([corners.pixels for corners in found])
    mean = pixels.mean(axis=0)
    away = np.hypot(*np.moveaxis(pixels - mean, -1, 0)).max(axis=0)
    limit = largest_move_px * first.width / 1280.0
    sigmas = np.sqrt(np.mean([corners.sigma_px**2 for corners in found], axis=0) / len(found))
    is_seen = np.isfinite(away)
    moved = bool(is_seen.any()) and float(np.median(away[is_seen])) > limit
    hidden = ~is_seen | moved
    mean[hidden], sigmas[hidden] = np.nan, np.nan
    return BoardCorners(first.image, first.width, first.height, mean, sigmas, first.is_mirrored)
