"""The depth camera's part of a calibration, from the pictures that the wizard takes.

Each picture of a board that was held still brings the mean depth of that moment and the mean of
the corners all over it: the same that `adibas.pipeline.calibrating_depth` reads from a recording.
"""

from collections.abc import Sequence

import cv2
import numpy as np

from adibas.arrays import FloatArray, UInt8Array
from adibas.calibration.board_scale import ScaleParams
from adibas.calibration.corners import as_gray
from adibas.calibration.extrinsics_pose import BoardPose, find_pose
from adibas.calibration.verdict import ScaleCheck
from adibas.clock import NS_PER_S, Clock, utc_now
from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.calibration_verdict import Finding, Grade, Reason, Verdict
from adibas.data.frames import SourceInfo
from adibas.data.sentence import Sentence
from adibas.data.surface import BurstDisparity
from adibas.errors import CalibrationError
from adibas.geometry.distortion import project_distorted
from adibas.pipeline.calibrating_depth import DepthOutcome, calibrate_seen
from adibas.pipeline.calibrating_depth_moments import Seen
from adibas.pipeline.calibration_pictures import KeptPicture, read_disparity
from adibas.texts import Message, message

LONGEST_S = 3600.0
"""Pictures that lie farther apart are of several days, or the sensor's clock began anew."""

LEAST_MEASURED = 0.5
"""Share of a board's corners at which there must be depth."""

NO_DEPTH = message(
    "The depth camera is not calibrated, because no picture has depth. Let the pictures be taken "
    "by the program while the board is held still before the sensor."
)


def has_depth_camera(info: SourceInfo) -> bool:
    """Say whether a sensor has a depth camera that somebody has calibrated roughly."""
    return info.calibration is not None and info.calibration.depth is not None


def calibrate_depth_of(
    pictures: Sequence[KeptPicture],
    board: Board,
    color: RgbdCalibration,
    info: SourceInfo,
    clock: Clock = utc_now,
    rotation_deg: int = 0,
) -> DepthOutcome | Verdict:
    """Calibrate the depth camera from pictures of a board.

    Parameters
    ----------
    pictures : sequence of KeptPicture
        Those without depth are left out.
    board : Board
        That they show.
    color : RgbdCalibration
        Of the colour camera alone, by the same pictures.
    info : SourceInfo
        Of the sensor, which knows its depth camera roughly.
    rotation_deg : int
        How far pictures are turned clockwise to be upright.

    Returns
    -------
    outcome : DepthOutcome or Verdict
        A verdict alone where nothing came of it.

    Raises
    ------
    FileError
        The depth of a picture is damaged.
    """
    seen = _seen(pictures, board, color)
    if not seen:
        return _failed(Sentence(NO_DEPTH))
    try:
        return calibrate_seen(seen, color, info, board, rotation_deg=rotation_deg, clock=clock)
    except CalibrationError as error:
        return _failed(Sentence(Message(error.message_id), error.fields))


def check_scales(
    pictures: Sequence[KeptPicture], board: Board, color: CameraCalibration, info: SourceInfo
) -> tuple[ScaleCheck, ...]:
    """Compare each board's distance by depth with that by its image, however much they differ.

    Parameters
    ----------
    color : CameraCalibration
        By the same pictures.

    Raises
    ------
    FileError
        The depth of a picture is damaged.
    """
    maker = info.calibration
    if maker is None or maker.depth is None:
        return ()
    checks = []
    for picture in pictures:
        disparity, pose = read_disparity(picture), _pose(picture, board, color)
        if disparity is not None and pose is not None:
            checks += _scale(disparity, pose, board, maker)
    return tuple(checks)


def joined(verdict: Verdict, other: Verdict) -> Verdict:
    """Return one verdict of two, the worst first."""
    grades = list(Grade)
    findings = (*verdict.findings, *other.findings)
    return Verdict(tuple(sorted(findings, key=lambda one: -grades.index(one.grade))))


def _failed(sentence: Sentence) -> Verdict:
    return Verdict((Finding(Reason.DEPTH, Grade.USABLE, sentence=sentence),))


def _seen(
    pictures: Sequence[KeptPicture], board: Board, color: RgbdCalibration
) -> tuple[Seen, ...]:
    if color.color is None:
        raise ValueError("the colour camera is needed")
    seen = []
    for picture, time_s in zip(pictures, _times_s(pictures), strict=True):
        disparity = read_disparity(picture)
        if disparity is not None:
            pose = _pose(picture, board, color.color)
            seen.append(Seen(picture.searched.name, time_s, disparity, _gray(picture), pose))
    return tuple(seen)


def _times_s(pictures: Sequence[KeptPicture]) -> list[float]:
    """Return when they were taken; 0 for all where that is not known."""
    times_s = np.array([picture.taken_ns for picture in pictures], float) / NS_PER_S
    times_s -= times_s[:1]
    is_one_clock = bool((np.diff(times_s) > 0).all() and (times_s <= LONGEST_S).all())
    return list((times_s if is_one_clock else np.zeros(len(pictures))).tolist())


def _pose(picture: KeptPicture, board: Board, color: CameraCalibration) -> BoardPose | None:
    return find_pose(picture.still_corners or picture.corners, board, color)


def _gray(picture: KeptPicture) -> UInt8Array | None:
    """Return the brightness of a picture; None where its file is gone meanwhile."""
    color_bgr = cv2.imread(str(picture.color_file), cv2.IMREAD_COLOR)
    if color_bgr is None:
        return None
    return as_gray(cv2.cvtColor(color_bgr, cv2.COLOR_BGR2RGB).astype(np.uint8, copy=False))


def _scale(
    disparity: BurstDisparity, pose: BoardPose, board: Board, maker: RgbdCalibration
) -> list[ScaleCheck]:
    """Look at the depth in each corner of a board; none where too little is measured."""
    if maker.depth is None:
        raise ValueError("the depth camera is needed")
    points_m = maker.color_from_depth.inverse().apply(
        pose.camera_from_board.apply(board.points_m())
    )
    measured = _at(disparity, points_m, maker.depth)
    factors = (1.0 / points_m[:, 2]) / measured
    factors = factors[np.isfinite(factors)]
    if len(factors) < LEAST_MEASURED * len(points_m):
        return []
    by_image_m = float(np.median(points_m[:, 2]))
    by_depth_m = float(np.median(factors)) * by_image_m
    tolerance = ScaleParams()
    sd_m = np.linalg.norm(
        (
            tolerance.offset_sd_m,
            tolerance.factor_sd * by_depth_m,
            tolerance.square_sd_per_m * by_depth_m**2,
        )
    )
    return [ScaleCheck(by_depth_m, by_image_m, float(sd_m))]


def _at(disparity: BurstDisparity, points_m: FloatArray, depth: CameraCalibration) -> FloatArray:
    """Return the 1/z that was measured where the points are seen; NaN outside the image."""
    pixels = project_distorted(points_m, depth.intrinsics, depth.distortion)
    inside = (
        np.isfinite(pixels).all(axis=1)
        & (points_m[:, 2] > 0)
        & (
            np.abs(pixels - 0.5 * np.array([depth.width - 1, depth.height - 1]))
            < 0.5 * np.array([depth.width, depth.height])
        ).all(axis=1)
    )
    found = np.full(len(points_m), np.nan)
    u, v = np.rint(pixels[inside]).astype(int).T
    found[inside] = disparity.mean_per_m[v, u]
    return found
