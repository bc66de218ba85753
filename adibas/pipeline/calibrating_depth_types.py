"""What a calibration of the depth is asked for, and what it gives."""

from dataclasses import dataclass, field
from pathlib import Path

from adibas.arrays import FloatArray
from adibas.calibration.board_scale import BoardScale, ScaleParams
from adibas.calibration.drift import Drift
from adibas.calibration.extrinsics import DepthFit, DepthFitParams
from adibas.calibration.extrinsics_pose import PoseParams
from adibas.calibration.finder import FinderParams
from adibas.calibration.registration_check import RegistrationCheck
from adibas.calibration.shots import ShotParams
from adibas.calibration.vertical import Vertical
from adibas.data.board import Board
from adibas.data.calibration import RgbdCalibration
from adibas.data.calibration_verdict import Verdict
from adibas.data.sentence import Sentence
from adibas.pipeline.still_moments import StillParams


@dataclass(frozen=True, slots=True)
class DepthRequest:
    """What to calibrate, from what.

    Attributes
    ----------
    recording : Path
        Of the board, a wall, or both.
    calibration : RgbdCalibration
        Of the colour camera. A depth camera in it is taken for known if it has a covariance and
        boards were seen in depth; by infrared images its lens is, but not its principal point;
        without a covariance it is the maker's.
    board : Board or None
        None: there is a wall alone.
    has_wall : bool
        Still moments without a board may show a flat wall that fills the depth image.
    more_recordings : tuple of Path
        Of the same sensor, taken right after: a board in one and a wall in another.
    rotation_deg : int
        How far pictures are turned clockwise to be upright: where the floor is looked for, if
        gravity is not known.
    """

    recording: Path
    calibration: RgbdCalibration
    board: Board | None = None
    has_wall: bool = False
    more_recordings: tuple[Path, ...] = ()
    rotation_deg: int = 0

    def __post_init__(self) -> None:
        if self.board is None and not self.has_wall:
            raise ValueError("a calibration of the depth needs a board or a wall")

    @property
    def recordings(self) -> tuple[Path, ...]:
        """All of them."""
        return (self.recording, *self.more_recordings)


@dataclass(frozen=True, slots=True)
class DepthCalibratingParams:
    """Settings of all steps.

    Attributes
    ----------
    n_corner_frames : int
        Pictures of a burst in which corners are looked for: 6. Hands tremble by half a
        millimetre, a few times a second; the mean of the corners must see as much of it as the
        mean of the depth.
    largest_move_px : float
        Of the board's corners within a burst, for an image 1280 wide: 1.5; more, and the depth is
        of several places.
    least_boards, good_boards : int
        Fewer than 4 determine nothing; 8 make a good calibration.
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
    scale: ScaleParams = field(default_factory=ScaleParams)
    n_corner_frames: int = 6
    largest_move_px: float = 1.5
    least_boards: int = 4
    good_boards: int = 8
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
    verdict : Verdict
        What it is worth, and why it is not better.
    scale : BoardScale or None
        Of the board's squares by depth; None without a board.
    """

    calibration: RgbdCalibration
    fit: DepthFit
    covariance: FloatArray
    registration: RegistrationCheck | None
    drift: Drift | None
    vertical: Vertical | None
    n_still: int
    verdict: Verdict
    scale: BoardScale | None = None

    @property
    def notices(self) -> tuple[Sentence, ...]:
        """What the reader should know, the worst first; empty for a good calibration."""
        findings = self.verdict.findings
        return tuple(found.sentence for found in findings if found.sentence is not None)
