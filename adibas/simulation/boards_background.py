"""What is behind a board: an even wall, or a room full of things with corners of their own."""

import functools
from dataclasses import dataclass

import cv2
import numpy as np

from adibas.arrays import Float32Array

N_THINGS = 60


@dataclass(frozen=True, slots=True)
class Background:
    """What stands behind the board.

    Attributes
    ----------
    level : float
        Linear light of the wall, as a share of full scale.
    is_cluttered : bool
        With shelves, blinds, tiles and other things that have corners and stripes.
    seed : int
        Of the things.
    """

    level: float = 0.3
    is_cluttered: bool = False
    seed: int = 0


def paint_background(
    background: Background, size: tuple[int, int], n_channels: int
) -> Float32Array:
    """Return a new (H, W, C) float32 picture of linear light, 1 = full scale."""
    if not background.is_cluttered:
        return np.full((*size, n_channels), background.level, np.float32)
    return _clutter(background, size, n_channels).copy()


@functools.lru_cache(maxsize=4)
def _clutter(background: Background, size: tuple[int, int], n_channels: int) -> Float32Array:
    height, width = size
    rng = np.random.default_rng([background.seed, 0xC1])
    picture = np.full((height, width, 3), background.level, np.float32)
    for _ in range(N_THINGS):
        middle = rng.uniform((0, 0), (width, height))
        box = np.exp(rng.uniform(np.log(0.01), np.log(0.25), 2)) * width
        shade = tuple(float(x) for x in rng.uniform(0.02, 0.9) * rng.uniform(0.6, 1.0, 3))
        turned = (tuple(middle), tuple(box), float(rng.normal(0.0, 12.0)))
        if rng.random() < 0.3:  # noqa: PLR2004  (assumed)
            cv2.ellipse(picture, turned, shade, -1, cv2.LINE_AA)
            continue
        corners = np.rint(cv2.boxPoints(turned)).astype(np.int32)
        cv2.fillConvexPoly(picture, corners, shade, cv2.LINE_AA)
        if rng.random() < 0.4:  # noqa: PLR2004  (assumed)
            _stripe(picture, corners, shade, rng)
    picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), width / 1280), np.float32)
    return picture if n_channels == picture.shape[2] else picture.mean(axis=2, keepdims=True)


def _stripe(
    picture: Float32Array,
    corners: np.ndarray[tuple[int, ...], np.dtype[np.int32]],
    shade: tuple[float, ...],
    rng: np.random.Generator,
) -> None:
    """Draw blinds or tiles over a thing."""
    lighter = tuple(min(1.0, 0.15 + 1.8 * x) for x in shade)
    a, b, c, d = corners.astype(float)
    n_lines = int(rng.integers(3, 12))
    thickness = max(1, picture.shape[1] // 400)
    is_tiled = rng.random() < 0.5  # noqa: PLR2004  (assumed)
    for share in (np.arange(n_lines) + 0.5) / n_lines:
        sides = [(a + share * (b - a), d + share * (c - d))]
        if is_tiled:
            sides.append((a + share * (d - a), b + share * (c - b)))
        for begin, end in sides:
            first, last = (tuple(int(x) for x in np.rint(point)) for point in (begin, end))
            cv2.line(picture, first, last, lighter, thickness, cv2.LINE_AA)
