"""Which pictures of the board are still lacking, and whether this moment is one of them.

Source: Zhang, A flexible new technique for camera calibration, PAMI 22 (2000), section 5 (tilts of
the board); Strobl & Hirzinger, More accurate pinhole camera calibration with imperfect planar
target, ICCV workshops (2011), for corners up to the border; the measures of a view's novelty
follow ROS' camera_calibration (place, size, tilt).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np

from adibas.arrays import BoolArray, FloatArray
from adibas.calibration.closed_form import pose_from_homography
from adibas.calibration.homography import fit_homography
from adibas.clock import NS_PER_S
from adibas.data.board import Board, BoardCorners
from adibas.geometry.pinhole import Intrinsics
from adibas.texts import Message, message

Lean: TypeAlias = Literal["left", "right", "up", "down"]
LEANS: tuple[Lean, ...] = ("left", "right", "up", "down")
USUAL_FOCAL_SHARE = 0.85
"""Focal length over the image's width of a depth camera's colour camera (61 degrees)."""

PLACES: dict[tuple[int, int], Message] = {
    (-1, -1): message("Hold the board into the top left corner of the picture."),
    (-1, 0): message("Hold the board to the top edge of the picture."),
    (-1, 1): message("Hold the board into the top right corner of the picture."),
    (0, -1): message("Hold the board to the left edge of the picture."),
    (0, 0): message("Hold the board into the middle of the picture."),
    (0, 1): message("Hold the board to the right edge of the picture."),
    (1, -1): message("Hold the board into the bottom left corner of the picture."),
    (1, 0): message("Hold the board to the bottom edge of the picture."),
    (1, 1): message("Hold the board into the bottom right corner of the picture."),
}
LEAN_TEXTS: dict[Lean, Message] = {
    "left": message(
        "Turn the board by a third to half a right angle, so that it faces the picture's left."
    ),
    "right": message(
        "Turn the board by a third to half a right angle, so that it faces the picture's right."
    ),
    "up": message(
        "Lean the board back by a third to half a right angle, so that it faces upwards."
    ),
    "down": message(
        "Lean the board forward by a third to half a right angle, so that it faces down."
    ),
}
NEARER = message("Come nearer: the board shall fill half of the picture's width.")
FARTHER = message("Step back: the board shall fill a quarter of the picture's width.")
DISTANT = message(
    "Step back as far as patients stand, two and a half metres, or as far as the board is still "
    "found: so the depth is calibrated up to there."
)
DEPTH = message(
    "Hold the board still in a few more places, and let the pictures be taken by themselves: the "
    "depth camera needs them."
)
MORE = message("Take a few more pictures, each from another place and with another tilt.")
ENOUGH = message("These pictures suffice. More of them make the result a little better.")


@dataclass(frozen=True, slots=True)
class GuidanceParams:
    """What a set of pictures should have.

    Attributes
    ----------
    least_pictures : int
        12: below, the intervals grow faster than by the square root (Zhang 2000, figure 2).
    cells : (int, int)
        Rows and columns of the map of the image.
    least_lean_rad : float
        15 degrees: a board that faces the camera tells nothing of the focal length.
    near_share, far_share : float
        Of the image's width that the board takes with its outer squares; a little less and a
        little more than what the user is asked for.
    new_place, new_size : float
        A view is new where the board's middle moved by so much of the image's width, or it looks
        larger or smaller by such a factor (a logarithm).
    new_lean_rad : float
        Or where it leans otherwise by so much, 8 degrees.
    still_px_s : float
        Slower than this nothing blurs: a third of a pixel in an exposure of 1/30 s.
    still_s : float
        For so long.
    least_depths : int
        Pictures with depth, for a sensor with a depth camera: 8, see
        `adibas.pipeline.calibrating_depth`.
    distant_m : float
        And the farthest board: 2.45 m, as patients stand.
    least_square_px : float
        Squares that look smaller are not found for sure: 12; farther need no board be.
    """

    least_pictures: int = 12
    cells: tuple[int, int] = (6, 8)
    least_lean_rad: float = math.radians(15.0)
    near_share: float = 0.42
    far_share: float = 0.3
    new_place: float = 0.12
    new_size: float = 0.25
    new_lean_rad: float = math.radians(8.0)
    still_px_s: float = 12.0
    still_s: float = 0.4
    least_depths: int = 8
    distant_m: float = 2.45
    least_square_px: float = 12.0


@dataclass(frozen=True, slots=True, eq=False)
class Stance:
    """How the board stood in one picture.

    Attributes
    ----------
    place : (2,) array
        Middle of the corners that are seen: shares of the image's width, from its middle.
    size : float
        Side of the square of the board's area, as a share of the image's width.
    lean_rad : (2,) array
        By how much the board faces to the image's right and down, radians.
    width_share : float
        What its longer side with the outer squares would take of the image's width.
    distance_m : float
        Of its middle.
    square_px : float
        How large its squares would look, if they faced the camera.
    """

    place: FloatArray
    size: float
    lean_rad: FloatArray
    width_share: float
    distance_m: float
    square_px: float

    def leans(self, least_rad: float) -> tuple[Lean, ...]:
        """Return the sides that it faces by at least so much."""
        right, down = self.lean_rad
        sides: dict[Lean, float] = {"left": -right, "right": right, "up": -down, "down": down}
        return tuple(side for side, lean in sides.items() if lean >= least_rad)


@dataclass(frozen=True, slots=True, eq=False)
class Guidance:
    """What was taken, and what is lacking.

    Attributes
    ----------
    covered : (rows, columns) bool array
        Cells of the image in which corners were found.
    leans : tuple of str
        Sides that the board has faced.
    has_near, has_far : bool
        Whether it was near, and far.
    n_pictures : int
        How many were taken.
    lacking : tuple of Message
        What to do, the most useful first; empty when the pictures suffice.
    n_depths : int or None
        Pictures with depth; None for a sensor without a depth camera.
    has_distant : bool
        Whether one of them was as far away as patients stand.
    """

    covered: BoolArray
    leans: tuple[Lean, ...]
    has_near: bool
    has_far: bool
    n_pictures: int
    lacking: tuple[Message, ...]
    n_depths: int | None = None
    has_distant: bool = False

    @property
    def next_step(self) -> Message:
        """What to do now."""
        return self.lacking[0] if self.lacking else ENOUGH


def stance_of(
    corners: BoardCorners, board: Board, intrinsics: Intrinsics | None = None
) -> Stance | None:
    """Return how the board stands; None where its corners do not tell.

    Parameters
    ----------
    corners : BoardCorners
        As found.
    board : Board
        What was looked for.
    intrinsics : Intrinsics or None
        Known roughly; None for those of a usual camera.
    """
    plane = board.points_m()[:, :2]
    homography = fit_homography(plane, corners.pixels)
    if homography is None:
        return None
    width, height = corners.width, corners.height
    usual_px = USUAL_FOCAL_SHARE * width
    k = intrinsics or Intrinsics(usual_px, usual_px, (width - 1) / 2, (height - 1) / 2)
    pose = pose_from_homography(homography, k.matrix())
    facing = -pose.rotation[:, 2]
    seen = corners.pixels[~np.isnan(corners.sigma_px)]
    middle = np.array([(width - 1) / 2, (height - 1) / 2])
    outline = pose.apply(board.points_m()[[0, board.columns - 1, -board.columns, -1]])
    sides_m = np.array([board.columns - 1, board.rows - 1]) * board.square_m
    scale = k.fx / outline[:, 2].mean() / width
    return Stance(
        place=(seen.mean(axis=0) - middle) / width,
        size=float(np.sqrt(sides_m.prod()) * scale),
        lean_rad=np.arctan2(facing[:2], -facing[2]),
        width_share=float((sides_m.max() + 2 * board.square_m) * scale),
        distance_m=float(outline[:, 2].mean()),
        square_px=float(board.square_m * scale * width),
    )


def is_new(stance: Stance, taken: Sequence[Stance], params: GuidanceParams | None = None) -> bool:
    """Say whether a picture of this stance would show what none before showed."""
    limits = params or GuidanceParams()
    return all(
        np.abs(stance.place - other.place).max() > limits.new_place
        or abs(math.log(stance.size / other.size)) > limits.new_size
        or np.abs(stance.lean_rad - other.lean_rad).max() > limits.new_lean_rad
        for other in taken
    )


def guide(
    pictures: Sequence[BoardCorners],
    stances: Sequence[Stance],
    params: GuidanceParams | None = None,
    *,
    has_depth: Sequence[bool] | None = None,
) -> Guidance:
    """Return what pictures lack that were taken.

    Parameters
    ----------
    pictures : sequence of BoardCorners
        All of one size.
    stances : sequence of Stance
        Of the same pictures.
    has_depth : sequence of bool or None
        Of the same pictures; None for a sensor without a depth camera.
    """
    limits = params or GuidanceParams()
    covered = _covered(pictures, limits.cells)
    leans = {lean for stance in stances for lean in stance.leans(limits.least_lean_rad)}
    shares = [stance.width_share for stance in stances]
    has_near = any(share >= limits.near_share for share in shares)
    has_far = any(share <= limits.far_share for share in shares)
    lacking = [LEAN_TEXTS[lean] for lean in LEANS if lean not in leans]
    lacking += _uncovered(covered)
    lacking += [] if has_near else [NEARER]
    lacking += [] if has_far else [FARTHER]
    n_depths, has_distant = None, False
    if has_depth is not None:
        deep = [stance for stance, has in zip(stances, has_depth, strict=True) if has]
        n_depths, has_distant = len(deep), any(_is_distant(stance, limits) for stance in deep)
        lacking += [] if has_distant else [DISTANT]
    lacking += [] if len(pictures) >= limits.least_pictures else [MORE]
    if n_depths is not None and n_depths < limits.least_depths <= len(pictures):
        lacking.append(DEPTH)
    kept = tuple(lean for lean in LEANS if lean in leans)
    found = (has_near, has_far, len(pictures), tuple(lacking), n_depths, has_distant)
    return Guidance(covered, kept, *found)


def _is_distant(stance: Stance, limits: GuidanceParams) -> bool:
    return stance.distance_m >= limits.distant_m or stance.square_px <= limits.least_square_px


def _covered(pictures: Sequence[BoardCorners], cells: tuple[int, int]) -> BoolArray:
    covered = np.zeros(cells, bool)
    rows, columns = cells
    for picture in pictures:
        seen = picture.pixels[~np.isnan(picture.sigma_px)] + 0.5
        column = np.clip(seen[:, 0] / picture.width * columns, 0, columns - 1).astype(int)
        row = np.clip(seen[:, 1] / picture.height * rows, 0, rows - 1).astype(int)
        covered[row, column] = True
    return covered


def _uncovered(covered: BoolArray) -> list[Message]:
    """Name the ninths of the image of which more than a third has no corner, the emptiest first.

    The outermost cells count as any other: it is there that the lens bends most.
    """
    empty: list[tuple[float, Message]] = []
    for (down, right), text in PLACES.items():
        rows = np.array_split(covered, 3, axis=0)[down + 1]
        share = float(np.array_split(rows, 3, axis=1)[right + 1].mean())
        if share < 2 / 3:
            empty.append((share, text))
    return [text for _, text in sorted(empty, key=lambda one: one[0])]


@dataclass(slots=True)
class StillWatch:
    """Tells when the board has been held still.

    Attributes
    ----------
    params : GuidanceParams
        What still means.
    """

    params: GuidanceParams = field(default_factory=GuidanceParams)
    _before: tuple[int, BoardCorners] | None = None
    _still_since_ns: int | None = None

    def see(self, corners: BoardCorners | None, timestamp_ns: int) -> float:
        """Take the next frame; return how much of the time to stand still is over, 0 to 1."""
        before, self._before = self._before, None
        if corners is None:
            self._still_since_ns = None
            return 0.0
        self._before = (timestamp_ns, corners)
        if before is None or not self._is_still(before, corners, timestamp_ns):
            self._still_since_ns = None
            return 0.0
        if self._still_since_ns is None:
            self._still_since_ns = before[0]
        return min((timestamp_ns - self._still_since_ns) / NS_PER_S / self.params.still_s, 1.0)

    def _is_still(
        self, before: tuple[int, BoardCorners], corners: BoardCorners, timestamp_ns: int
    ) -> bool:
        elapsed_s = (timestamp_ns - before[0]) / NS_PER_S
        moved_px = np.linalg.norm(corners.pixels - before[1].pixels, axis=1)
        moved_px = moved_px[~np.isnan(moved_px)]
        if elapsed_s <= 0 or moved_px.size == 0:
            return False
        return bool(np.median(moved_px) / elapsed_s <= self.params.still_px_s)
