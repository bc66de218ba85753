"""From a recording of a board or a wall to the calibration of the whole sensor.

The scene's still moments are found first. In each, the board's corners are looked for in colour
images all over it, and its depth is averaged. Then pose and error of the depth camera are fitted,
the depth pixels on the boards are chosen anew with what was found, and fitted once more. Scale,
edges, time and floor are looked at last.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from threading import Event

from adibas.arrays import FloatArray
from adibas.calibration.board_scale import check_scale
from adibas.calibration.depth_bias import BIAS, camera_covariance, color_covariance, with_depth
from adibas.calibration.extrinsics import DepthFit, DepthFitParams, DepthStart, fit_depth
from adibas.calibration.shots import BoardShot, WallShot, cells_on_board, cells_on_wall
from adibas.clock import Clock, to_text, utc_now
from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import SourceInfo
from adibas.data.sentence import Sentence
from adibas.errors import CalibrationError
from adibas.geometry.rigid import IDENTITY, RigidTransform
from adibas.pipeline.calibrating_depth_checks import (
    drift_of,
    registration_of,
    verdict_of,
    vertical_of,
)
from adibas.pipeline.calibrating_depth_moments import (
    Seen,
    Stopped,
    Watch,
    look_at,
    nothing_stands_still,
)
from adibas.pipeline.calibrating_depth_types import (
    DepthCalibratingParams,
    DepthOutcome,
    DepthRequest,
)
from adibas.progress import Progress
from adibas.recordings import open_recording

__all__ = [
    "DepthCalibratingParams",
    "DepthOutcome",
    "DepthRequest",
    "calibrate_depth",
    "calibrate_seen",
    "starting_point",
]


def calibrate_depth(
    request: DepthRequest,
    progress: Progress | None = None,
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
    progress : callable or None
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
    start = request.calibration
    seen: list[Seen] = []
    try:
        watch = Watch(request.recordings, progress, stop)
        for path in request.recordings:
            with open_recording(path) as reader:
                start = starting_point(start, reader.info)
                later_s = seen[-1].time_s if seen else 0.0
                seen += [
                    replace(moment, time_s=moment.time_s + later_s)
                    for moment in look_at(reader, watch, start, request, params)
                ]
    except Stopped:
        return None
    params = replace(params, fit=_fit_params(request.calibration, start, params))
    return _calibrated(seen, start, request, params, clock)


def calibrate_seen(
    seen: Sequence[Seen],
    color: RgbdCalibration,
    info: SourceInfo,
    board: Board,
    *,
    rotation_deg: int = 0,
    clock: Clock = utc_now,
) -> DepthOutcome:
    """Calibrate the depth camera from still moments that are at hand already.

    Parameters
    ----------
    seen : sequence of Seen
        Of one sensor.
    color : RgbdCalibration
        Of the colour camera alone.
    info : SourceInfo
        Of the sensor, which knows its depth camera roughly.
    board : Board
        That is seen.
    rotation_deg : int
        How far pictures are turned clockwise to be upright.

    Raises
    ------
    CalibrationError
        As `calibrate_depth`.
    """
    params = DepthCalibratingParams()
    start = starting_point(color, info)
    params = replace(params, fit=_fit_params(color, start, params))
    request = DepthRequest(Path(), color, board, rotation_deg=rotation_deg)
    return _calibrated(seen, start, request, params, clock)


def starting_point(calibration: RgbdCalibration, info: SourceInfo) -> RgbdCalibration:
    """Return the colour calibration with the depth camera that it or the source knows.

    Raises
    ------
    CalibrationError
        There is no colour camera, nobody knows the depth camera, or the sensor is another one.
    """
    if calibration.color is None:
        raise CalibrationError(
            "The calibration has no colour camera. Calibrate it first, from images of the board."
        )
    if info.is_depth_registered:
        raise CalibrationError(
            "The sensor moved the depth into the colour image while it recorded, and that cannot "
            "be undone. Record again with the sensor's own registration switched off."
        )
    serials = {calibration.sensor_serial, info.sensor_serial} - {""}
    if len(serials) > 1:
        raise CalibrationError(
            "The calibration is of sensor {calibrated}, but the recording of sensor {recorded}. "
            "Give the calibration of this sensor.",
            calibrated=calibration.sensor_serial,
            recorded=info.sensor_serial,
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


def _fit_params(
    given: RgbdCalibration, start: RgbdCalibration, params: DepthCalibratingParams
) -> DepthFitParams:
    """Return what is known beforehand of the start."""
    fit = params.fit
    if start.color_from_depth is not IDENTITY and fit.shift_sd_m is None:
        fit = replace(fit, shift_sd_m=params.shift_sd_m)
    if given.depth is None or given.covariance is None:
        return replace(fit, focal_sd=params.focal_sd, centre_sd_px=params.centre_sd_px)
    if BIAS[0] in given.parameter_names:
        return fit
    # No board was seen in depth: the camera is that of infrared images, whose lens it shares, but
    # not the principal point.
    return replace(fit, centre_sd_px=params.centre_sd_px)


def _calibrated(
    seen: Sequence[Seen],
    start: RgbdCalibration,
    request: DepthRequest,
    params: DepthCalibratingParams,
    clock: Clock,
) -> DepthOutcome:
    fit, boards = _fitted(seen, start, request, params)
    covariance = fit.covariance
    if start.covariance is not None:
        covariance = camera_covariance(fit, start.parameter_names, start.covariance)
    plain = with_depth(replace(start, created_utc=to_text(clock())), fit)
    vertical = vertical_of(seen, plain, request.rotation_deg)
    registration, drift = registration_of(seen, plain), drift_of(fit)
    outliers = {shot.name for shot in fit.shots if shot.is_outlier}
    used = [shot for shot in boards if shot.name not in outliers]
    scale = None
    if request.board is not None:
        scale = check_scale(used, request.board, fit.color_from_depth, params.scale)
    verdict = verdict_of(fit, covariance, (scale, registration, drift), params)
    return DepthOutcome(
        plain if vertical is None else with_depth(plain, fit, vertical),
        fit,
        covariance,
        registration,
        drift,
        vertical,
        len(seen),
        verdict,
        scale,
    )


def _fitted(
    seen: Sequence[Seen],
    start: RgbdCalibration,
    request: DepthRequest,
    params: DepthCalibratingParams,
) -> tuple[DepthFit, list[BoardShot]]:
    depth = start.depth
    if depth is None:
        raise ValueError("the depth camera is needed")
    walls = _walls(seen, depth, params) if request.has_wall else []
    boards = _boards(seen, depth, start.color_from_depth, request.board, params)
    if not boards and not walls:
        raise _nothing(seen)
    first = DepthStart(depth, start.depth_bias, _color_covariance(start))
    given = None if start.color_from_depth is IDENTITY else start.color_from_depth
    fit = fit_depth(first, boards, walls, given, params.fit)
    if boards:
        boards = _boards(seen, fit.camera, fit.color_from_depth, request.board, params) or boards
        fit = fit_depth(first, boards, walls, given, params.fit)
    return fit, boards


def _color_covariance(start: RgbdCalibration) -> FloatArray | None:
    if start.covariance is None:
        return None
    return color_covariance(start.parameter_names, start.covariance)


def _nothing(seen: Sequence[Seen]) -> CalibrationError:
    """Return the error that says why there is nothing to calibrate from."""
    if not seen:
        return nothing_stands_still()
    reasons = Counter(
        Sentence(moment.hindrance, moment.fields).text
        for moment in seen
        if moment.hindrance is not None
    )
    if not reasons:
        return CalibrationError(
            "None of the {n} still moments shows a wall or a board in the depth image. Let the "
            "wall fill the image, and hold the board in view of both cameras.",
            n=len(seen),
        )
    [(reason, n_times)] = reasons.most_common(1)
    return CalibrationError(
        "The board is seen in none of the {n} still moments. In {n_times} of them: {reason}",
        n=len(seen),
        n_times=n_times,
        reason=reason,
    )


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
    seen: Sequence[Seen], depth: CameraCalibration, params: DepthCalibratingParams
) -> list[WallShot]:
    shots = []
    for moment in seen:
        if moment.pose is None:
            cells = cells_on_wall(moment.disparity, depth, params.shots)
            if cells is not None:
                shots.append(WallShot(moment.name, cells, moment.time_s))
    return shots
