"""Whether a live frame is the next picture of a calibration, and if not, what hinders."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import UInt8Array
from adibas.calibration.finder import TEXTS, BoardSearch, as_gray
from adibas.calibration.guidance import GuidanceParams, Stance, StillWatch, is_new, stance_of
from adibas.calibration.sharpness import blur_px
from adibas.calibration.verdict import VerdictParams
from adibas.data.board import Board, BoardCorners
from adibas.data.calibration import DepthBias
from adibas.data.calibration_verdict import SENTENCES, Reason
from adibas.data.surface import BurstDisparity
from adibas.geometry.pinhole import Intrinsics
from adibas.markers.disparity import DisparitySum
from adibas.pipeline.calibrating import SearchedImage
from adibas.pipeline.calibrating_depth_moments import mean_corners
from adibas.pipeline.calibrating_depth_types import DepthCalibratingParams
from adibas.pipeline.calibration_pictures import NewPicture
from adibas.pipeline.hints import NO_COLOR
from adibas.pipeline.live_frames import LiveFrame
from adibas.texts import Message, message
from adibas.texts import translate as _

COVERED = message("A part of the board is hidden. Hold it so that all of it is seen.")
KNOWN = message("Taken. Now hold the board elsewhere, or tilt it another way.")
MOVING = message("Hold the board still for a moment.")
BLURRED = message("The board is blurred. Hold it still, give more light, and clean the lens.")
UNCLEAR = message("It cannot be seen how the board stands. Hold it nearer.")
PASSING = frozenset({KNOWN, MOVING})
"""They hinder for a moment and are no fault: nothing to warn of."""


@dataclass(frozen=True, slots=True)
class WatchParams:
    """When a picture is taken.

    Attributes
    ----------
    guidance : GuidanceParams
        What is still, and what is new.
    verdict : VerdictParams
        What is whole, and what is blurred; so no picture is taken that would be complained of.
    least_share, greatest_sd_per_m : float
        Of the depth's mean: a pixel needs readings in half of the frames, and flickers by less
        than 0.02 (8 cm at 2 m) while the board stands still.
    depth : DepthCalibratingParams
        What the depth's calibration takes for still.
    """

    guidance: GuidanceParams = field(default_factory=GuidanceParams)
    verdict: VerdictParams = field(default_factory=VerdictParams)
    least_share: float = 0.5
    greatest_sd_per_m: float = 0.02
    depth: DepthCalibratingParams = field(default_factory=DepthCalibratingParams)


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """One live frame.

    Attributes
    ----------
    corners : BoardCorners or None
        Where a board is seen.
    stance : Stance or None
        How it stands.
    still_share : float
        How much of the time to stand still is over, 0 to 1.
    hindrance : Message or None
        Why this is no new picture; None: it is one.
    fields : mapping
        What stands at the places of that sentence.
    """

    corners: BoardCorners | None = None
    stance: Stance | None = None
    still_share: float = 0.0
    hindrance: Message | None = None
    fields: Mapping[str, object] = field(default_factory=dict)

    @property
    def is_ready(self) -> bool:
        """Say whether this is a new picture."""
        return self.corners is not None and self.hindrance is None

    @property
    def text(self) -> str:
        """What hinders, in the language in use; empty where nothing does."""
        return "" if self.hindrance is None else _(self.hindrance).format(**self.fields)


def load_kernels() -> None:
    """Load or compile what adds up depth, in the calling thread.

    The window's thread sees the frames; at the first of them it would wait for the compiler.
    """
    depth = DisparitySum(DepthBias())
    depth.add(np.ones((1, 1), np.float32))
    depth.result(1.0, 1.0)


class MomentWatch:
    """Sees live frames one after the other.

    Parameters
    ----------
    board : Board
        That is held.
    intrinsics : Intrinsics or None
        Of the camera, known roughly.
    params : WatchParams or None
        When a picture is taken.
    """

    def __init__(
        self, board: Board, intrinsics: Intrinsics | None = None, params: WatchParams | None = None
    ) -> None:
        self.board = board
        self._intrinsics = intrinsics
        self._params = params or WatchParams()
        self._still = StillWatch(self._params.guidance)
        self._depth: DisparitySum | None = None
        self._found: list[BoardCorners] = []
        self._blur: tuple[UInt8Array, float] | None = None

    def stance_of(self, corners: BoardCorners) -> Stance | None:
        """Return how the board stands in a picture, by the same camera as in all others."""
        return stance_of(corners, self.board, self._intrinsics)

    def see(self, frame: LiveFrame, taken: Sequence[Stance]) -> Moment:
        """Take the next frame.

        Parameters
        ----------
        frame : LiveFrame
            In which this board was looked for.
        taken : sequence of Stance
            Of the pictures that there are.
        """
        search = frame.board
        corners = None if search is None else search.corners
        if corners is not None and len(corners.pixels) != self.board.n_corners:
            search, corners = None, None  # of the board before, which was chosen a moment ago
        still_share = self._still.see(corners, frame.timestamp_ns)
        self._add_depth(frame, corners if still_share > 0.0 else None)
        if search is None or corners is None:
            return _without_board(frame, search)
        stance = self.stance_of(corners)
        hindrance = self._hindrance(frame, corners, stance, still_share, taken)
        return Moment(corners, stance, still_share, hindrance)

    def picture(self, frame: LiveFrame) -> NewPicture | None:
        """Return a frame as a picture, whatever hinders; None where no board is seen in it.

        It brings depth and corners on average since board and camera stand still, if they do.
        """
        search, color_rgb = frame.board, frame.color_rgb
        if search is None or search.corners is None or color_rgb is None:
            return None
        if len(search.corners.pixels) != self.board.n_corners or search.corners.is_mirrored:
            return None
        if self.stance_of(search.corners) is None:
            return None
        blur = self._blur_px(color_rgb, search.corners)
        searched = SearchedImage("", color_rgb.shape[:2], search, blur)
        disparity, corners = self._mean_depth(), self._mean_corners()
        return NewPicture(color_rgb, searched, frame.timestamp_ns, disparity, corners)

    def _hindrance(
        self,
        frame: LiveFrame,
        corners: BoardCorners,
        stance: Stance | None,
        still_share: float,
        taken: Sequence[Stance],
    ) -> Message | None:
        """Return what hinders, the first thing first that must be done."""
        verdict = self._params.verdict
        if corners.is_mirrored:
            return SENTENCES[Reason.MIRRORED]
        if corners.n_seen < verdict.cut_share * self.board.n_corners:
            return COVERED
        if stance is None:
            return UNCLEAR
        if not is_new(stance, taken, self._params.guidance):
            return KNOWN
        if still_share < 1.0:
            return MOVING
        return BLURRED if self._is_blurred(frame, corners) else None

    def _is_blurred(self, frame: LiveFrame, corners: BoardCorners) -> bool:
        if frame.color_rgb is None:
            return True
        limit_px = self._params.verdict.blur_px * max(corners.width / 1280.0, 0.5)
        return not self._blur_px(frame.color_rgb, corners) <= limit_px

    def _blur_px(self, color_rgb: UInt8Array, corners: BoardCorners) -> float:
        """Return the blur of a picture; a frame that is taken was looked at a moment ago."""
        if self._blur is None or self._blur[0] is not color_rgb:
            self._blur = color_rgb, blur_px(as_gray(color_rgb), self.board, corners)
        return self._blur[1]

    def _add_depth(self, frame: LiveFrame, corners: BoardCorners | None) -> None:
        """Add what stands still; without corners it does not."""
        if corners is None or frame.depth_m is None:
            self._depth = None
            self._found = []
            return
        if self._depth is None:
            self._depth = DisparitySum(DepthBias())
        self._depth.add(frame.depth_m)
        self._found.append(corners)

    def _mean_depth(self) -> BurstDisparity | None:
        if self._depth is None:
            return None
        return self._depth.result(self._params.least_share, self._params.greatest_sd_per_m)

    def _mean_corners(self) -> BoardCorners | None:
        if not self._found:
            return None
        found = mean_corners(self._found, self._params.depth.largest_move_px)
        return found if found.n_seen else None


def _without_board(frame: LiveFrame, search: BoardSearch | None) -> Moment:
    if search is None or search.problem is None:
        return Moment(hindrance=NO_COLOR if frame.color_rgb is None else MOVING)
    return Moment(hindrance=TEXTS[search.problem], fields=search.fields)
