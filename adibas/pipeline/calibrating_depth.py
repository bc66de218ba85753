"""From a recording of a board or a wall to the calibration of the whole sensor.

The scene's still moments are found first. In each, the board's corners are looked for in the
colour images of its beginning, middle and end, and its depth is averaged. Then pose and error of
the depth camera are fitted, the depth pixels on the boards are chosen anew with what was found,
and fitted once more. Edges, time and floor are looked at last.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Event

import numpy as np

from adibas.arrays import Float32Array, FloatArray, UInt8Array
from adibas.body.floor import find_floor
from adibas.calibration.corners import as_gray
from adibas.calibration.depth_bias import camera_covariance, weak_directions, with_depth
from adibas.calibration.drift import Drift, fit_drift
from adibas.calibration.extrinsics import DepthFit, DepthFitParams, DepthStart, fit_depth
from adibas.calibration.extrinsics_pose import BoardPose, PoseParams, find_pose
from adibas.calibration.files import check_fits
from adibas.calibration.finder import FinderParams, search_board
from adibas.calibration.registration_check import (
    RegistrationCheck,
    RegistrationResult,
    check_registration,
)
from adibas.calibration.shots import (
    BoardShot,
    ShotParams,
    WallShot,
    cells_near_plane,
    cells_on_board,
    cells_on_wall,
)
from adibas.calibration.vertical import Vertical, vertical_from_floor
from adibas.clock import Clock, to_text, utc_now
from adibas.data.board import Board, BoardCorners
from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.data.frames import SourceInfo, depth_in_metres
from adibas.data.sentence import Sentence
from adibas.data.surface import BurstDisparity
from adibas.errors import CalibrationError, RecordingError
from adibas.geometry.rigid import IDENTITY, RigidTransform
from adibas.markers.disparity import fuse_depth
from adibas.pipeline.still_moments import ChangeMeter, Moment, StillParams, still_moments
from adibas.recordings import open_recording
from adibas.recordings.decoding import decode_color
from adibas.recordings.ports import RecordingReader
from adibas.texts import message

Progress = Callable[[int, int], None]

NANOSECONDS = 1e-9
MILLIMETRES = 1000.0
N_CHECKED = 3
"""Bursts at which edges are compared, and the floor is looked for."""

FAR_BOARD = message(
    "The farthest board stood at {farthest_m} m. Beyond it the depth is corrected by guess: hold "
    "the board farther away as well."
)
OUTLIERS = message(
    "{n} of {total} boards contradict the others and were left out: the board or the sensor moved, "
    "or something stood before it."
)
FEW_BOARDS = message(
    "Only {n} boards could be used, and {least} are needed for a good calibration. Hold the board "
    "still for two seconds at each place, in view of both cameras."
)


@dataclass(frozen=True, slots=True)
class DepthRequest:
    """What to calibrate, from what.

    Attributes
    ----------
    recording : Path
        Of the board, a wall, or both.
    calibration : RgbdCalibration
        Of the colour camera. A depth camera in it is taken for known if it has a covariance, else
        for the maker's.
    board : Board or None
        None: there is a wall alone.
    has_wall : bool
        Still moments without a board may show a flat wall that fills the depth image.
    """

    recording: Path
    calibration: RgbdCalibration
    board: Board | None = None
    has_wall: bool = False

    def __post_init__(self) -> None:
        if self.board is None and not self.has_wall:
            raise ValueError("a calibration of the depth needs a board or a wall")


@dataclass(frozen=True, slots=True)
class DepthCalibratingParams:
    """Settings of all steps.

    Attributes
    ----------
    largest_move_px : float
        Of the board's corners within a burst, for an image 1280 wide: 1.0; more, and the depth is
        of several places. Hands tremble by half a millimetre.
    least_boards : int
        For a good calibration: 8.
    shift_sd_m : float
        How well the maker's shift between the cameras is known: 4 mm.
    focal_sd, centre_sd_px : float
        And the maker's calibration of the depth camera: see `DepthFitParams`.
    """

    still: StillParams = field(default_factory=StillParams)
    finder: FinderParams = field(default_factory=FinderParams)
    pose: PoseParams = field(default_factory=PoseParams)
    shots: ShotParams = field(default_factory=ShotParams)
    fit: DepthFitParams = field(default_factory=DepthFitParams)
    largest_move_px: float = 1.0
    least_boards: int = 8
    shift_sd_m: float = 0.004
    focal_sd: float = 0.01
    centre_sd_px: float = 6.0


@dataclass(frozen=True, slots=True, eq=False)
class DepthOutcome:
    """What came of a calibration of the depth.

    Attributes
    ----------
    calibration : RgbdCalibration
        Of the whole sensor.
    fit : DepthFit
        Pose and depth bias, with every shot.
    covariance : (n, n) array
        Of the fit's parameters, the colour camera's error included.
    registration : RegistrationCheck or None
        Of depth and colour at real edges; None where no burst has both.
    drift : Drift or None
        Of the depth over the recording.
    vertical : Vertical or None
        From the floor, where one is seen.
    n_still : int
        Still moments in the recording.
    notices : tuple of Sentence
        What the reader should know; empty for a good calibration.
    """

    calibration: RgbdCalibration
    fit: DepthFit
    covariance: FloatArray
    registration: RegistrationCheck | None
    drift: Drift | None
    vertical: Vertical | None
    n_still: int
    notices: tuple[Sentence, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What a still moment shows.

    Attributes
    ----------
    name : str
        For the reader.
    time_s : float
        From the beginning of the recording.
    disparity : BurstDisparity
        As measured.
    gray : (H, W) array or None
        Of its middle.
    pose : BoardPose or None
        Of the board.
    """

    name: str
    time_s: float
    disparity: BurstDisparity
    gray: UInt8Array | None
    pose: BoardPose | None


class _Stopped(Exception):  # noqa: N818  (no error: the caller's wish)
    """The caller wants no more."""


def calibrate_depth(
    request: DepthRequest,
    progress: Progress,
    params: DepthCalibratingParams | None = None,
    *,
    stop: Event | None = None,
    clock: Clock = utc_now,
) -> DepthOutcome | None:
    """Calibrate the depth camera of a recording.

    Parameters
    ----------
    request : DepthRequest
        What, from what.
    progress : callable
        Told (frames done, frames in all); every frame counts twice.
    params : DepthCalibratingParams or None
        How.
    stop : Event or None
        Ends the work early.

    Returns
    -------
    outcome : DepthOutcome or None
        None where `stop` was set.

    Raises
    ------
    CalibrationError
        There is no depth camera to begin with, another resolution, or neither board nor wall.
    RecordingError
        The recording cannot be read, or has no depth.
    """
    params = params or DepthCalibratingParams()
    try:
        with open_recording(request.recording) as reader:
            start = starting_point(request.calibration, reader.info)
            params = replace(params, fit=_fit_params(start, params))
            watch = _Watch(reader, progress, stop)
            moments = _moments(watch, params.still)
            seen = [_look(moment, watch, start, request, params) for moment in moments]
    except _Stopped:
        return None
    return _calibrated(seen, start, request, params, clock)


def starting_point(calibration: RgbdCalibration, info: SourceInfo) -> RgbdCalibration:
    """Return the colour calibration with the depth camera that it or the source knows.

    Raises
    ------
    CalibrationError
        There is no colour camera, or nobody knows the depth camera.
    """
    if calibration.color is None:
        raise CalibrationError(
            "The calibration has no colour camera. Calibrate it first, from images of the board."
        )
    if calibration.depth is not None:
        return calibration
    maker = info.calibration
    if maker is None or maker.depth is None:
        raise CalibrationError(
            "Neither the calibration nor the recording knows the depth camera's focal length. Add "
            "the maker's values for it to the calibration."
        )
    return replace(
        calibration,
        depth=maker.depth,
        color_from_depth=maker.color_from_depth,
        depth_unit_m=info.depth_unit_m,
        sensor_serial=calibration.sensor_serial or info.sensor_serial,
    )


def _fit_params(start: RgbdCalibration, params: DepthCalibratingParams) -> DepthFitParams:
    """Return what is known beforehand of the start."""
    fit = params.fit
    if start.color_from_depth is not IDENTITY and fit.shift_sd_m is None:
        fit = replace(fit, shift_sd_m=params.shift_sd_m)
    if "depth.fx" in start.parameter_names and start.covariance is not None:
        return fit
    return replace(fit, focal_sd=params.focal_sd, centre_sd_px=params.centre_sd_px)


class _Watch:
    """Reads frames, counts them, and ends where the caller wants to."""

    def __init__(self, reader: RecordingReader, progress: Progress, stop: Event | None) -> None:
        self.reader = reader
        self._progress = progress
        self._stop = stop
        self._done = 0

    def count(self, n_frames: int = 1) -> None:
        """Tell of frames that are done."""
        if self._stop is not None and self._stop.is_set():
            raise _Stopped
        total = 2 * len(self.reader)
        self._done = min(self._done + n_frames, total)
        self._progress(self._done, total)


def _moments(watch: _Watch, params: StillParams) -> tuple[Moment, ...]:
    reader = watch.reader
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


def _look(
    moment: Moment,
    watch: _Watch,
    start: RgbdCalibration,
    request: DepthRequest,
    params: DepthCalibratingParams,
) -> Seen:
    reader = watch.reader
    times_ns = reader.timestamps_ns
    disparity = fuse_depth(_depths(moment, watch, start), DepthBias())
    gray, pose = None, None
    if request.board is not None:
        grays = [_gray(reader, index) for index in (moment.middle, moment.first, moment.last - 1)]
        gray = grays[0]
        pose = _pose(grays, start, request.board, params)
    elif request.has_wall:
        gray = _gray(reader, moment.middle)
    name = f"{(times_ns[moment.middle] - times_ns[0]) * NANOSECONDS:.1f} s"
    time_s = float(times_ns[moment.middle] - times_ns[0]) * NANOSECONDS
    return Seen(name, time_s, disparity, gray, pose)


def _depths(moment: Moment, watch: _Watch, start: RgbdCalibration) -> Iterator[Float32Array]:
    unit_m = watch.reader.info.depth_unit_m
    for index in range(moment.first, moment.last):
        watch.count()
        raw = watch.reader.read(index).depth_raw
        if raw is not None:
            check_fits(start, None, raw.shape)
            yield depth_in_metres(raw, unit_m)


def _gray(reader: RecordingReader, index: int) -> UInt8Array | None:
    frame = reader.read(index)
    if frame.color is None:
        return None
    return as_gray(decode_color(frame.color, frame.sequence))


def _pose(
    grays: Sequence[UInt8Array | None],
    start: RgbdCalibration,
    board: Board,
    params: DepthCalibratingParams,
) -> BoardPose | None:
    """Return where the board stood, by the mean of its corners; None where it did not stand."""
    color = start.color
    found: list[BoardCorners] = []
    for gray in grays:
        if gray is None or color is None:
            return None
        check_fits(start, gray.shape, None)
        corners = search_board(gray, board, "", params.finder).corners
        if corners is None or corners.is_mirrored:
            return None
        found.append(corners)
    if color is None:
        return None
    return find_pose(mean_corners(found, params.largest_move_px), board, color, params.pose)


def mean_corners(found: Sequence[BoardCorners], largest_move_px: float) -> BoardCorners:
    """Return the mean of corners of one burst; hidden are those not seen in all, or that moved.

    Parameters
    ----------
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


def _calibrated(
    seen: Sequence[Seen],
    start: RgbdCalibration,
    request: DepthRequest,
    params: DepthCalibratingParams,
    clock: Clock,
) -> DepthOutcome:
    depth = _known(start.depth)
    walls = _walls(seen, depth, request, params)
    boards = _boards(seen, depth, start.color_from_depth, request.board, params)
    if not boards and not walls:
        raise CalibrationError(
            "Neither a board nor a wall stands still in the recording ({n} still moments). Hold "
            "the board still for two seconds at each place, in view of both cameras.",
            n=len(seen),
        )
    first = DepthStart(depth, start.depth_bias)
    given = None if start.color_from_depth is IDENTITY else start.color_from_depth
    fit = fit_depth(first, boards, walls, given, params.fit)
    if boards:
        boards = _boards(seen, fit.camera, fit.color_from_depth, request.board, params) or boards
        fit = fit_depth(first, boards, walls, given, params.fit)
    covariance = fit.covariance
    if start.covariance is not None:
        covariance = camera_covariance(fit, start.parameter_names, start.covariance)
    plain = with_depth(replace(start, created_utc=to_text(clock())), fit)
    vertical = _vertical(seen, plain)
    registration = _registration(seen, plain)
    drift = _drift(fit)
    notices = _notices(fit, covariance, params, has_boards=bool(boards))
    notices += () if drift is None else _given(drift.notice())
    if registration is not None and registration.result is RegistrationResult.SHIFTED:
        notices += (registration.sentence,)
    return DepthOutcome(
        with_depth(plain, fit, vertical) if vertical is not None else plain,
        fit,
        covariance,
        registration,
        drift,
        vertical,
        len(seen),
        notices,
    )


def _given(sentence: Sentence | None) -> tuple[Sentence, ...]:
    return () if sentence is None else (sentence,)


def _known(camera: CameraCalibration | None) -> CameraCalibration:
    if camera is None:
        raise ValueError("the depth camera is needed")
    return camera


def _boards(
    seen: Sequence[Seen],
    depth: CameraCalibration,
    color_from_depth: RigidTransform,
    board: Board | None,
    params: DepthCalibratingParams,
) -> list[BoardShot]:
    shots = []
    for moment in seen:
        if moment.pose is None or board is None:
            continue
        expected = color_from_depth.inverse() @ moment.pose.camera_from_board
        cells = cells_on_board(moment.disparity, depth, board, expected, params.shots)
        if cells is not None:
            shots.append(BoardShot(moment.name, moment.pose, cells, moment.time_s))
    return shots


def _walls(
    seen: Sequence[Seen],
    depth: CameraCalibration,
    request: DepthRequest,
    params: DepthCalibratingParams,
) -> list[WallShot]:
    if not request.has_wall:
        return []
    shots = []
    for moment in seen:
        if moment.pose is None:
            cells = cells_on_wall(moment.disparity, depth, params.shots)
            if cells is not None:
                shots.append(WallShot(moment.name, cells, moment.time_s))
    return shots


def _corrected_m(moment: Seen, calibration: RgbdCalibration) -> Float32Array:
    with np.errstate(divide="ignore"):
        return calibration.corrected_depth((1.0 / moment.disparity.mean_per_m).astype(np.float32))


def _vertical(seen: Sequence[Seen], calibration: RgbdCalibration) -> Vertical | None:
    """Return the vertical of the burst whose floor is known best."""
    depth = _known(calibration.depth)
    best: Vertical | None = None
    for moment in _spread(seen):
        depth_m = _corrected_m(moment, calibration)
        floor = find_floor(depth_m, depth)
        if floor is None:
            continue
        blocks_m = cells_near_plane(depth_m, depth, floor)
        found = vertical_from_floor(blocks_m, floor)
        if found is not None and (best is None or found.sd_rad < best.sd_rad):
            best = found
    return best


def _registration(seen: Sequence[Seen], calibration: RgbdCalibration) -> RegistrationCheck | None:
    """Return the check of the burst whose edges say most."""
    best: RegistrationCheck | None = None
    for moment in _spread([moment for moment in seen if moment.gray is not None]):
        if moment.gray is None:
            continue
        found = check_registration(moment.gray, _corrected_m(moment, calibration), calibration)
        if best is None or _says_more(found, best):
            best = found
    return best


def _says_more(one: RegistrationCheck, other: RegistrationCheck) -> bool:
    if RegistrationResult.UNSURE in (one.result, other.result):
        return other.result is RegistrationResult.UNSURE
    return float(np.hypot(*one.standard_error_px)) < float(np.hypot(*other.standard_error_px))


def _spread(seen: Sequence[Seen]) -> list[Seen]:
    """Return a few moments from all over the recording."""
    chosen = np.unique(np.linspace(0, len(seen) - 1, N_CHECKED).round().astype(int))
    return [seen[index] for index in chosen] if seen else []


def _drift(fit: DepthFit) -> Drift | None:
    shots = [shot for shot in fit.shots if not shot.is_outlier]
    sigmas = np.array([np.hypot(shot.sigma_per_m, fit.sigma_per_m) for shot in shots])
    return fit_drift(
        np.array([shot.time_s for shot in shots]),
        np.array([shot.error_per_m for shot in shots]),
        np.nan_to_num(sigmas),
    )


def _notices(
    fit: DepthFit, covariance: FloatArray, params: DepthCalibratingParams, *, has_boards: bool
) -> tuple[Sentence, ...]:
    """Return what is wrong with the shots, and what they leave open."""
    if not has_boards:
        return ()
    notices: list[Sentence] = []
    boards = [shot for shot in fit.shots if np.isfinite(shot.error_per_m)]
    used = [shot for shot in boards if not shot.is_outlier]
    if len(used) < params.least_boards:
        notices.append(Sentence(FEW_BOARDS, {"n": len(used), "least": params.least_boards}))
    if len(used) < len(boards):
        fields = {"n": len(boards) - len(used), "total": len(boards)}
        notices.append(Sentence(OUTLIERS, fields))
    farthest_m = max(shot.distance_m for shot in used)
    if farthest_m < FAR_M:
        notices.append(Sentence(FAR_BOARD, {"farthest_m": float(farthest_m)}))
    return (*notices, *weak_directions(fit, covariance))


FAR_M = 2.5
"""Patients stand as far away as that."""
