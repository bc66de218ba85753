"""What pictures of a board give for one sensor: fitted, judged, held against the time before."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from adibas.calibration.comparison import Comparison, compare
from adibas.calibration.kept import KeptCalibration, KeptCalibrations, sensor_key, sizes_of
from adibas.clock import Clock
from adibas.data.board import Board
from adibas.data.calibration import RgbdCalibration
from adibas.data.calibration_report import DepthReport
from adibas.data.calibration_verdict import Grade, Reason, Verdict
from adibas.data.frames import SourceInfo
from adibas.geometry.pinhole import Intrinsics
from adibas.pipeline.calibrating import CameraOutcome, color_calibration, fit_searched, judged
from adibas.pipeline.calibrating_depth import DepthOutcome
from adibas.pipeline.calibrating_pictures import (
    calibrate_depth_of,
    check_scales,
    has_depth_camera,
    joined,
)
from adibas.pipeline.calibration_pictures import KeptPicture
from adibas.pipeline.calibration_report import report_of_depth_outcome
from adibas.pipeline.live_frames import LiveFrame


@dataclass(frozen=True, slots=True, eq=False)
class CalibratedSensor:
    """What is calibrated.

    Attributes
    ----------
    key : str
        As `sensor_key` tells it; '' for pictures of a sensor that nobody knows.
    color_size : (width, height)
        Of its colour image.
    info : SourceInfo
        As it was opened.
    rotation_deg : int
        How far its picture is turned clockwise to be upright: where the floor is looked for.
    """

    key: str
    color_size: tuple[int, int]
    info: SourceInfo
    rotation_deg: int = 0

    @property
    def intrinsics(self) -> Intrinsics | None:
        """Of the colour camera, as far as they are known before; None where they are not."""
        calibration = self.info.calibration
        color = None if calibration is None else calibration.color
        if color is None or (color.width, color.height) != self.color_size:
            return None
        return color.intrinsics


def sensor_of(frame: LiveFrame, info: SourceInfo) -> CalibratedSensor | None:
    """Return the sensor that a live frame comes of; None where it has no colour."""
    if frame.color_rgb is None:
        return None
    height, width = frame.color_rgb.shape[:2]
    return CalibratedSensor(sensor_key(info), (width, height), info, frame.rotation_deg)


@dataclass(frozen=True, slots=True, eq=False)
class SensorOutcome:
    """What the pictures gave.

    Attributes
    ----------
    camera : CameraOutcome
        Of the colour camera, with the verdict on both cameras.
    calibration : RgbdCalibration or None
        As it would be kept; None where nothing could be fitted.
    previous : KeptCalibration or None
        The newest one before of the same sensor.
    comparison : Comparison or None
        With that.
    depth : DepthOutcome or None
        Of the depth camera; None where there is none, or no picture tells of it.
    """

    camera: CameraOutcome
    calibration: RgbdCalibration | None
    previous: KeptCalibration | None
    comparison: Comparison | None
    depth: DepthOutcome | None = None

    @property
    def is_good_enough(self) -> bool:
        """Say whether it may be used."""
        return self.calibration is not None and self.camera.verdict.grade is not Grade.REPEAT

    def depth_report(self) -> DepthReport | None:
        """Return what is told of the depth camera; None where nothing was found of it."""
        return None if self.depth is None else report_of_depth_outcome(self.depth)


def calibrate_sensor(
    pictures: Sequence[KeptPicture],
    board: Board,
    sensor: CalibratedSensor,
    kept: KeptCalibrations,
    clock: Clock,
) -> SensorOutcome:
    """Fit, judge, and compare with the newest calibration of the sensor among `kept`.

    Raises
    ------
    CalibrationError
        There is no picture, or a calibration of this sensor is damaged.
    """
    info = sensor.info
    camera = _camera(pictures, board, info)
    fit = camera.fit
    if fit is None or not fit.is_settled:
        return SensorOutcome(camera, None, None, None)
    color = color_calibration(fit, sensor.key, clock, camera.method)
    depth: DepthOutcome | Verdict | None = None
    if has_depth_camera(info) and not _is_of_wrong_scale(camera):
        depth = calibrate_depth_of(pictures, board, color, info, clock, sensor.rotation_deg)
        verdict = depth if isinstance(depth, Verdict) else depth.verdict
        camera = replace(camera, verdict=joined(camera.verdict, verdict))
    depth = None if isinstance(depth, Verdict) else depth
    calibration = _joined(color, depth, info)
    previous = kept.newest(sensor.key, sizes_of(calibration))
    comparison = None if previous is None else compare(previous.calibration, calibration)
    return SensorOutcome(camera, calibration, previous, comparison, depth)


def _camera(pictures: Sequence[KeptPicture], board: Board, info: SourceInfo) -> CameraOutcome:
    """Fit and judge the colour camera, and judge again with what the depth says of scale."""
    searched = tuple(one.searched for one in pictures)
    camera = fit_searched(searched, board)
    if camera.fit is None or not camera.fit.is_settled:
        return camera
    checks = check_scales(pictures, board, camera.fit.camera, info)
    return judged(camera, checks) if checks else camera


def _joined(
    color: RgbdCalibration, depth: DepthOutcome | None, info: SourceInfo
) -> RgbdCalibration:
    """Return what is known of the sensor, with its cameras as they are now."""
    before = info.calibration
    if before is None:
        return replace(color, depth_unit_m=info.depth_unit_m)
    known = color if depth is None else depth.calibration
    joined = replace(
        before,
        color=color.color,
        rms_px=color.rms_px,
        parameter_names=known.parameter_names,
        covariance=known.covariance,
        sensor_serial=color.sensor_serial,
        created_utc=color.created_utc,
        valid_region=color.valid_region,
        corner_method=color.corner_method,
        gravity=known.gravity,  # not that of before: the sensor stands elsewhere
        floor=known.floor,
        gravity_sd_rad=known.gravity_sd_rad,
        floor_flatness_m=known.floor_flatness_m,
    )
    if depth is None:
        return joined
    return replace(
        joined,
        depth=known.depth,
        color_from_depth=known.color_from_depth,
        depth_bias=known.depth_bias,
    )


def _is_of_wrong_scale(camera: CameraOutcome) -> bool:
    return any(finding.reason is Reason.SCALE for finding in camera.verdict.findings)
