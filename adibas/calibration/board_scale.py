"""Do the squares of a board have the size that was said: their size as the depth sees it.

A board whose squares are smaller than said looks farther away by its image than it is by depth.
Neither is exact: depth has an error of its own, `a + b z + c z^2`, and its `b` and a wrong size
are the same thing seen twice. So the size is known as well as `b` is known beforehand, from the
makers' own tolerances, and not better; a printer that fits a page is farther off.

Source: Rasmussen & Williams, Gaussian processes for machine learning (2006), section 2.7, for a
linear model with an unknown and a known part.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.calibration.shots import BoardShot, moved_plane, plane_of
from adibas.data.board import Board
from adibas.data.sentence import Sentence
from adibas.geometry.rigid import RigidTransform
from adibas.texts import message

SURE = 1.959964
MILLIMETRES = 1000.0

WRONG = message(
    "By depth the squares of the board measure {seen_mm} mm ({low_mm} to {high_mm} mm), not "
    "{said_mm} mm. Measure one with a ruler, give its true size, and calibrate again."
)
RIGHT = message(
    "By depth the squares of the board measure {seen_mm} mm ({low_mm} to {high_mm} mm); "
    "{said_mm} mm were said."
)


@dataclass(frozen=True, slots=True)
class ScaleParams:
    """What is known of depth sensors beforehand.

    Attributes
    ----------
    offset_sd_m, factor_sd, square_sd_per_m : float
        Of `a`, `b - 1` and `c`: 5 mm, 0.01, 0.003; together 8 mm at 0.6 m and 23 mm at 2 m, as
        devices scatter (Boehm 2014: 1-3 cm at 2-3 m).
    noise_per_m : float
        Of one board's mean 1/z, the hand's tremor included: 0.0003; more where the boards scatter
        more.
    least_error : float
        Smaller errors are not worth a word: 0.02, see `adibas.calibration.verdict`.
    """

    offset_sd_m: float = 0.005
    factor_sd: float = 0.01
    square_sd_per_m: float = 0.003
    noise_per_m: float = 0.0003
    least_error: float = 0.02


@dataclass(frozen=True, slots=True)
class BoardScale:
    """The size of a board by depth.

    Attributes
    ----------
    factor : float
        True size over the size that was said.
    interval : (float, float)
        Holds the true factor in 95 % of cases.
    n_boards : int
        How many places of the board tell it.
    is_wrong : bool
        The size that was said is wrong.
    sentence : Sentence
        For the reader.
    """

    factor: float
    interval: tuple[float, float]
    n_boards: int
    is_wrong: bool
    sentence: Sentence


def check_scale(
    shots: Sequence[BoardShot],
    board: Board,
    color_from_depth: RigidTransform,
    params: ScaleParams | None = None,
) -> BoardScale | None:
    """Compare the distances of boards by depth with those by their image.

    Parameters
    ----------
    shots : sequence of BoardShot
        Depth as measured, without correction.
    board : Board
        What was said to be shown.
    color_from_depth : RigidTransform
        Good to some millimetres.

    Returns
    -------
    scale : BoardScale or None
        None without shots.
    """
    params = params or ScaleParams()
    if not shots:
        return None
    by_depth_m, by_image_m = np.array([_distances_m(shot, color_from_depth) for shot in shots]).T
    # factor * by_image = a + b z + c z^2: known beforehand are a, b - 1 and c, but not the factor.
    slopes = np.column_stack([by_image_m, -np.ones_like(by_depth_m), -by_depth_m, -(by_depth_m**2)])
    away_m = by_depth_m - by_image_m
    errors, covariance = _solved(slopes, away_m, by_depth_m, params.noise_per_m, params)
    # What the device errs from place to place of its image is noise here, and often more of it.
    left = (away_m - slopes @ errors) / by_depth_m**2
    noise_per_m = max(params.noise_per_m, float(np.sqrt(left @ left / max(len(left) - 1, 1))))
    errors, covariance = _solved(slopes, away_m, by_depth_m, noise_per_m, params)
    factor, sd = 1.0 + float(errors[0]), float(np.sqrt(covariance[0, 0]))
    low, high = factor - SURE * sd, factor + SURE * sd
    is_wrong = not low <= 1.0 <= high and abs(factor - 1.0) > params.least_error
    side_mm = MILLIMETRES * board.square_m
    fields = {
        "seen_mm": side_mm * factor,
        "low_mm": side_mm * low,
        "high_mm": side_mm * high,
        "said_mm": side_mm,
    }
    sentence = Sentence(WRONG if is_wrong else RIGHT, fields)
    return BoardScale(factor, (low, high), len(shots), is_wrong, sentence)


def _solved(
    slopes: FloatArray,
    away_m: FloatArray,
    by_depth_m: FloatArray,
    noise_per_m: float,
    params: ScaleParams,
) -> tuple[FloatArray, FloatArray]:
    """Return the factor's and the device's errors, and their covariance."""
    sds = (params.offset_sd_m, params.factor_sd, params.square_sd_per_m)
    weights = (noise_per_m * by_depth_m**2) ** -2
    information = slopes.T @ (weights[:, None] * slopes)
    information[1:, 1:] += np.diag(1.0 / np.square(sds))
    covariance = np.asarray(np.linalg.inv(information), float)
    return covariance @ (slopes.T @ (weights * away_m)), covariance


def _distances_m(shot: BoardShot, color_from_depth: RigidTransform) -> FloatArray:
    """Return the distance of a board's middle in the depth camera by depth and by its image."""
    cells = shot.cells
    plane = moved_plane(plane_of(shot.pose).m, color_from_depth)
    rays = np.column_stack([cells.rays, np.ones(len(cells))])
    shares = cells.shares / cells.shares.sum()
    return np.array([1.0 / (shares @ cells.inverse_m), 1.0 / (shares @ (rays @ plane))])
