"""Which pixels are neighbours: a compact graph of the pixels of a mask alone.

Arcs come in pairs: arc ``k`` of a pixel leads to a neighbour whose arc ``k ^ 1`` leads back.
"""

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from adibas.arrays import BoolArray, FloatArray, Int32Array, read_only
from adibas.graphcut.neighbor_kernels import link

Connectivity: TypeAlias = Literal[4, 8]

NO_NEIGHBOR = -1
_STRAIGHT = ((0, 0, 1), (0, 1, 0))
_DIAGONAL = ((0, 1, 1), (0, 1, -1))
_IN_TIME = ((1, 0, 0),)
_IMAGE = 2
_VIDEO = 3


@dataclass(frozen=True, slots=True, eq=False)
class PixelGraph:
    """The N pixels of a mask and the K arcs of each.

    Attributes
    ----------
    shape : tuple of int
        Of the image (H, W), or of a stack of images (T, H, W).
    pixels : (N,) int32 array
        Flat indices of the pixels in the image or stack, rising.
    neighbors : (N, K) int32 array
        Rows of `pixels`; -1 where the neighbour is outside the mask.
    distances : (K,) array
        Of the neighbour, in pixels; that of the same pixel one image later is 1.
    """

    shape: tuple[int, ...]
    pixels: Int32Array
    neighbors: Int32Array
    distances: FloatArray

    def __post_init__(self) -> None:
        for array in (self.pixels, self.neighbors, self.distances):
            read_only(array)

    @property
    def n_pixels(self) -> int:
        """Return N."""
        return len(self.pixels)


def connect_pixels(mask: BoolArray, connectivity: Connectivity = 8) -> PixelGraph:
    """Connect the pixels of a mask with their 4 or 8 neighbours in it.

    Parameters
    ----------
    mask : (H, W) or (T, H, W) bool array
        In a stack each pixel is connected with itself in the images before and after, too.
    connectivity : 4 or 8
        Neighbours of a pixel within its image.

    Raises
    ------
    ValueError
        The mask is no image or stack of images, or the connectivity is another.
    """
    if mask.ndim not in (_IMAGE, _VIDEO):
        raise ValueError(f"mask must have 2 or 3 dimensions, got {mask.ndim}")
    if connectivity not in (4, 8):
        raise ValueError(f"connectivity must be 4 or 8, got {connectivity}")
    offsets = [
        *_STRAIGHT,
        *(_DIAGONAL if connectivity == 8 else ()),  # noqa: PLR2004
        *(_IN_TIME if mask.ndim == _VIDEO else ()),
    ]
    stack = np.ascontiguousarray(mask if mask.ndim == _VIDEO else mask[None], dtype=np.bool_)
    steps = np.array(offsets, np.int32)
    pixels, neighbors = link(stack, steps)
    distances = np.repeat([math.sqrt(sum(step * step for step in one)) for one in offsets], 2)
    return PixelGraph(mask.shape, pixels, neighbors, distances)
