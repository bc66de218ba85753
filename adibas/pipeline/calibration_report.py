"""What the report of a calibration shows, out of what the calibration gave."""

import math
from dataclasses import replace

import numpy as np

from adibas import __version__
from adibas.calibration.depth_bias import weak_directions
from adibas.calibration.drift import STATED_DISTANCE_M, Drift
from adibas.calibration.extrinsics import ShotFit
from adibas.calibration.finder import TEXTS
from adibas.calibration.vertical import Vertical
from adibas.clock import Clock, utc_now
from adibas.data.board import Board
from adibas.data.calibration import RgbdCalibration
from adibas.data.calibration_report import (
    CalibrationReport,
    DepthReport,
    ReportedDrift,
    ReportedImage,
    ReportedShot,
    ReportedVertical,
)
from adibas.pipeline.calibrating import CameraOutcome, SearchedImage
from adibas.pipeline.calibrating_depth_types import DepthOutcome
from adibas.pipeline.calibrating_infrared import InfraredOutcome
from adibas.pipeline.calibrating_pictures import joined


def report_of_calibration(
    outcome: CameraOutcome,
    calibration: RgbdCalibration | None,
    language: str,
    *,
    depth: DepthReport | None = None,
    previous: RgbdCalibration | None = None,
    clock: Clock = utc_now,
) -> CalibrationReport:
    """Return the report of a calibration.

    Parameters
    ----------
    outcome : CameraOutcome
        Of the colour camera.
    calibration : RgbdCalibration or None
        As it is stored, or would be; its sensor and date stand on the report.
    language : str
        Two letters.
    depth : DepthReport or None
        See `report_of_depth_outcome`.
    previous : RgbdCalibration or None
        The one before of the same sensor.
    clock : callable
        Tells when the report is written.
    """
    is_fitted = outcome.fit is not None and outcome.fit.is_settled
    return CalibrationReport(
        board=outcome.board,
        images=tuple(_image(image) for image in outcome.images),
        verdict=outcome.verdict,
        fit=outcome.fit if is_fitted else None,
        calibration=calibration,
        written_utc=clock(),
        depth=depth,
        previous=previous,
        sensor="" if calibration is None else calibration.sensor_serial,
        language=language,
        version=__version__,
    )


def report_of_depth_outcome(outcome: DepthOutcome) -> DepthReport:
    """Return what a report says of a depth camera that was calibrated by a recording."""
    fit, vertical, drift = outcome.fit, outcome.vertical, outcome.drift
    registration = outcome.registration
    return DepthReport(
        color_from_depth=fit.color_from_depth,
        bias=fit.bias,
        camera=fit.camera,
        parameter_names=fit.parameter_names,
        covariance=np.array(outcome.covariance),
        shots=tuple(sorted(map(_shot, fit.shots), key=lambda shot: shot.time_s)),
        left_open=weak_directions(fit, outcome.covariance),
        registration=None if registration is None else registration.sentence,
        vertical=None if vertical is None else _vertical(vertical),
        drift=None if drift is None else _drift(drift),
    )


def report_of_sensor(
    outcome: DepthOutcome,
    color: CameraOutcome | None,
    board: Board | None,
    language: str,
    *,
    previous: RgbdCalibration | None = None,
    clock: Clock = utc_now,
) -> CalibrationReport:
    """Return the report of a whole sensor, with one verdict.

    Parameters
    ----------
    outcome : DepthOutcome
        Of the depth camera.
    color : CameraOutcome or None
        Of the colour camera; None where it was calibrated before.
    board : Board or None
        That was shown; None: a wall alone.
    language : str
        Two letters.
    previous : RgbdCalibration or None
        The one before of the same sensor.
    """
    depth = report_of_depth_outcome(outcome)
    if color is None:
        return CalibrationReport(
            board=board,
            images=(),
            verdict=outcome.verdict,
            fit=None,
            calibration=outcome.calibration,
            written_utc=clock(),
            depth=depth,
            previous=previous,
            sensor=outcome.calibration.sensor_serial,
            language=language,
            version=__version__,
        )
    return report_of_calibration(
        replace(color, verdict=joined(color.verdict, outcome.verdict)),
        outcome.calibration,
        language,
        depth=depth,
        previous=previous,
        clock=clock,
    )


def report_of_infrared(
    outcome: InfraredOutcome,
    language: str,
    *,
    previous: RgbdCalibration | None = None,
    clock: Clock = utc_now,
) -> CalibrationReport:
    """Return the report of pairs of colour and infrared images: both cameras and their pose.

    Parameters
    ----------
    outcome : InfraredOutcome
        Of the pairs.
    language : str
        Two letters.
    previous : RgbdCalibration or None
        That was given for the colour camera.
    """
    calibration = outcome.calibration
    if calibration.depth is None or calibration.covariance is None:
        raise ValueError("pairs give a depth camera with its covariance")
    depth = DepthReport(
        color_from_depth=calibration.color_from_depth,
        bias=calibration.depth_bias,
        camera=calibration.depth,
        parameter_names=calibration.parameter_names,
        covariance=np.array(calibration.covariance),
    )
    # A camera that was given is not the one that these images alone would give.
    fit = outcome.color.fit if previous is None else None
    whole = report_of_calibration(
        replace(outcome.color, verdict=outcome.verdict, fit=fit),
        calibration,
        language,
        depth=depth,
        previous=previous,
        clock=clock,
    )
    return replace(whole, images=(*whole.images, *map(_image, outcome.infrared.images)))


def _vertical(vertical: Vertical) -> ReportedVertical:
    right, down, ahead = vertical.gravity.tolist()
    return ReportedVertical(
        is_of_floor=vertical.floor is not None,
        lean_rad=math.asin(min(max(ahead, -1.0), 1.0)),
        roll_rad=math.atan2(right, down),
        sd_rad=vertical.sd_rad,
        flatness_m=vertical.flatness_m,
    )


def _drift(drift: Drift) -> ReportedDrift:
    # More of 1/z is nearer.
    square_m2 = -(STATED_DISTANCE_M**2)
    low, high = sorted(square_m2 * rate for rate in drift.interval_per_m_s)
    return ReportedDrift(
        distance_m=STATED_DISTANCE_M,
        rate_m_s=drift.rate_m_s(STATED_DISTANCE_M),
        interval_m_s=(low, high),
        span_s=drift.span_s,
        notice=drift.notice(),
    )


def _image(image: SearchedImage) -> ReportedImage:
    search = image.search
    return ReportedImage(
        name=image.name,
        n_corners=0 if search.corners is None else search.corners.n_seen,
        blur_px=image.blur_px,
        problem=None if search.problem is None else TEXTS[search.problem],
        fields=search.fields,
    )


def _shot(shot: ShotFit) -> ReportedShot:
    # More of 1/z is nearer: depth errs the other way.
    metres = shot.distance_m**2
    return ReportedShot(
        name=shot.name,
        is_wall=bool(np.isnan(shot.sigma_per_m)),
        time_s=shot.time_s,
        distance_m=shot.distance_m,
        error_m=-metres * shot.error_per_m,
        sigma_m=metres * shot.sigma_per_m,
        rms_m=shot.rms_m,
        is_outlier=shot.is_outlier,
    )
