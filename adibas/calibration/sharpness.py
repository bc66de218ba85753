"""How blurred a board is in an image, from the edges between its corners.

Across an edge the brightness rises; of an edge blurred by Gauss' law the middle 60 % of the rise
take 1.68 standard deviations.
"""

import numpy as np
from scipy.ndimage import map_coordinates

from adibas.arrays import FloatArray, UInt8Array, check_shape
from adibas.data.board import Board, BoardCorners

RISE_SDS = 1.6832
LOW, HIGH = 0.2, 0.8
N_ACROSS = 61
N_ALONG = 7
REACH = 0.4
"""How far a profile goes to both sides of an edge, in lengths of it."""

LEAST_CONTRAST = 10.0
"""Grey values; fainter edges say nothing."""


def blur_px(gray: UInt8Array, board: Board, corners: BoardCorners) -> float:
    """Return the blur of a board in its image.

    Parameters
    ----------
    gray : (H, W) array
        The image.
    board : Board
        That was found.
    corners : BoardCorners
        Where.

    Returns
    -------
    sigma_px : float
        Standard deviation of the blur, that of the worse of the two directions of edges (a moving
        board is blurred in one direction); NaN where no edge is seen. A sharp camera has 0.5 to 1.
    """
    check_shape("gray", gray, (corners.height, corners.width))
    grid = corners.pixels.reshape(board.rows, board.columns, 2)
    directions = (
        (grid[:, :-1].reshape(-1, 2), grid[:, 1:].reshape(-1, 2)),
        (grid[:-1].reshape(-1, 2), grid[1:].reshape(-1, 2)),
    )
    found = [_median_blur(gray, begins, ends) for begins, ends in directions]
    known = [value for value in found if not np.isnan(value)]
    return max(known) if known else float("nan")


def _median_blur(gray: UInt8Array, begins: FloatArray, ends: FloatArray) -> float:
    is_seen = np.isfinite(begins + ends).all(axis=1)
    begins, ways = begins[is_seen], (ends - begins)[is_seen]
    if len(begins) == 0:
        return float("nan")
    across = np.stack([-ways[:, 1], ways[:, 0]], axis=-1)
    places = np.linspace(-REACH, REACH, N_ACROSS)
    shares = np.linspace(0.3, 0.7, N_ALONG)
    along = begins[:, None] + shares[None, :, None] * ways[:, None]
    sampled = along[:, :, None] + places[None, None, :, None] * across[:, None, None]
    grays = map_coordinates(
        gray.astype(np.float32), [sampled[..., 1], sampled[..., 0]], order=1, mode="nearest"
    )
    profiles = grays.mean(axis=1).astype(float)
    lengths_px = np.hypot(*ways.T)
    widths = np.array([_rise(profile) for profile in profiles]) * lengths_px
    widths = widths[~np.isnan(widths)]
    return float(np.median(widths)) / RISE_SDS if widths.size else float("nan")


def _rise(profile: FloatArray) -> float:
    """Return the way between 20 and 80 % of the rise, in lengths of the edge; NaN if faint."""
    ends = profile[: N_ACROSS // 8].mean(), profile[-(N_ACROSS // 8) :].mean()
    if abs(ends[1] - ends[0]) < LEAST_CONTRAST:
        return float("nan")
    share = np.maximum.accumulate((profile - ends[0]) / (ends[1] - ends[0]))
    places = np.linspace(-REACH, REACH, N_ACROSS)
    low, high = np.interp((LOW, HIGH), share, places)
    return float(high - low)
