"""What the report of a calibration shows: camera, verdict, and the depth where there is one."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only
from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.data.calibration_verdict import Verdict
from adibas.data.camera_fit import CameraFit
from adibas.data.sentence import Sentence
from adibas.geometry.rigid import RigidTransform
from adibas.texts import Message, translate


@dataclass(frozen=True, slots=True)
class ReportedImage:
    """One image that was given, with or without a board.

    Attributes
    ----------
    name : str
        Of the image.
    n_corners : int
        That it shows.
    blur_px : float
        Of the board; NaN without corners.
    problem : Message or None
        Why it has no corners.
    fields : mapping
        What stands at the places of that sentence.
    """

    name: str
    n_corners: int
    blur_px: float
    problem: Message | None = None
    fields: Mapping[str, object] = field(default_factory=dict)

    @property
    def problem_text(self) -> str:
        """Why it has no corners, in the language in use; empty where it has."""
        return "" if self.problem is None else translate(self.problem).format(**self.fields)


@dataclass(frozen=True, slots=True)
class ReportedShot:
    """One board or wall before the depth camera, after the calibration.

    Attributes
    ----------
    name : str
        Of the shot.
    is_wall : bool
        A wall, of which the colour camera knows nothing.
    time_s : float
        When it was taken.
    distance_m : float
        Along the middle of what was seen.
    error_m, sigma_m : float
        Mean depth minus the colour camera's, and what that may be by the corners' noise; NaN of
        walls.
    rms_m : float
        Of the corrected depth about its own plane.
    is_outlier : bool
        It contradicts the others and took no part.
    """

    name: str
    is_wall: bool
    time_s: float
    distance_m: float
    error_m: float
    sigma_m: float
    rms_m: float
    is_outlier: bool = False


@dataclass(frozen=True, slots=True)
class ReportedVertical:
    """Where down is, and how sure that is.

    Attributes
    ----------
    is_of_floor : bool
        By the floor; else by an accelerometer.
    lean_rad, roll_rad : float
        By which the depth camera looks down, and is turned clockwise about its axis.
    sd_rad : float
        Standard deviation of the direction.
    flatness_m : float
        Root mean square of the floor about its plane; NaN from an accelerometer.
    """

    is_of_floor: bool
    lean_rad: float
    roll_rad: float
    sd_rad: float
    flatness_m: float


@dataclass(frozen=True, slots=True)
class ReportedDrift:
    """How the depth changed while the calibration was made.

    Attributes
    ----------
    distance_m : float
        At which the rates hold.
    rate_m_s : float
        Metres a second; positive: surfaces seem to go away.
    interval_m_s : (float, float)
        Of 95 %.
    span_s : float
        From the first to the last shot.
    notice : Sentence or None
        What to do where it matters.
    """

    distance_m: float
    rate_m_s: float
    interval_m_s: tuple[float, float]
    span_s: float
    notice: Sentence | None


@dataclass(frozen=True, slots=True, eq=False)
class DepthReport:
    """What was found about the depth camera.

    Attributes
    ----------
    color_from_depth : RigidTransform
        Its pose.
    bias : DepthBias
        Its own error.
    camera : CameraCalibration
        Focal lengths and principal point.
    parameter_names : tuple of str
        ``color_from_depth.rx`` (a small turn about the colour camera's axes, radians), ``ry``,
        ``rz``, ``tx``, ``ty``, ``tz`` (metres), ``depth_bias.a``, ``depth.fx`` and so on, as far
        as they were estimated.
    covariance : (n, n) array
        Of these, the colour camera's own error included.
    shots : tuple of ReportedShot
        In the order in which they were taken.
    left_open : tuple of Sentence
        What the shots do not tell.
    registration : Sentence or None
        Whether depth and colour fit on a real edge; None where none was looked at.
    vertical : ReportedVertical or None
        None where it is not known.
    drift : ReportedDrift or None
        None where there are too few shots to tell.
    """

    color_from_depth: RigidTransform
    bias: DepthBias
    camera: CameraCalibration
    parameter_names: tuple[str, ...]
    covariance: FloatArray
    shots: tuple[ReportedShot, ...] = ()
    left_open: tuple[Sentence, ...] = ()
    registration: Sentence | None = None
    vertical: ReportedVertical | None = None
    drift: ReportedDrift | None = None

    def __post_init__(self) -> None:
        n = len(self.parameter_names)
        check_shape("covariance", self.covariance, (n, n))
        read_only(self.covariance)

    def sd(self, name: str) -> float:
        """Return the standard deviation of a parameter; NaN of one that was not estimated."""
        if name not in self.parameter_names:
            return float("nan")
        index = self.parameter_names.index(name)
        return float(np.sqrt(self.covariance[index, index]))


@dataclass(frozen=True, slots=True, eq=False)
class CalibrationReport:
    """A calibration as it is written on paper. Nothing of patients is in it.

    Attributes
    ----------
    board : Board or None
        That was said to be shown; None: a wall alone.
    images : tuple of ReportedImage
        In the order given.
    verdict : Verdict
        What the calibration is worth.
    fit : CameraFit or None
        None where the images gave no camera, or one that means nothing.
    calibration : RgbdCalibration or None
        As it is stored; None without a fit.
    written_utc : datetime
        When the report is written.
    depth : DepthReport or None
        None for a colour camera alone.
    previous : RgbdCalibration or None
        The one before of the same sensor.
    sensor : str
        Its name or number; empty where nobody knows it.
    language : str
        Two letters.
    version : str
        Of the program that writes the report.
    """

    board: Board | None
    images: tuple[ReportedImage, ...]
    verdict: Verdict
    fit: CameraFit | None
    calibration: RgbdCalibration | None
    written_utc: datetime
    depth: DepthReport | None = None
    previous: RgbdCalibration | None = None
    sensor: str = ""
    language: str = "en"
    version: str = ""

    def __post_init__(self) -> None:
        if self.fit is not None and not self.fit.is_settled:
            raise ValueError("the parameters of a search that did not end mean nothing")
        if self.written_utc.tzinfo is None:
            raise ValueError("written_utc needs a time zone")
