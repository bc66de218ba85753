"""Pictures turned by quarters about the line of sight, and the cameras that would take them.

A turned picture holds the same pixels in other places: nothing is interpolated, and each pixel
looks along the ray that it looked along before, in the turned camera's axes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from adibas.arrays import FloatArray
from adibas.geometry.picture_edges import Box
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.planes import Plane

QUARTERS = 4
PRISM = 12
"""So many coefficients of distortion hold those of thin prisms."""

Scalar = TypeVar("Scalar", bound=np.generic)
OfEdge = TypeVar("OfEdge")


@dataclass(frozen=True, slots=True)
class QuarterTurn:
    """By how much a picture is turned clockwise, as who looks at it sees it.

    Attributes
    ----------
    n_quarters : int
        0 to 3.
    """

    n_quarters: int = 0

    def __post_init__(self) -> None:
        if self.n_quarters not in range(QUARTERS):
            raise ValueError(f"n_quarters must be 0 to 3, got {self.n_quarters}")

    @property
    def rotation(self) -> FloatArray:
        """Return the (3, 3) rotation ``turned_from_camera``: x right and y down in each."""
        once = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        return np.asarray(np.linalg.matrix_power(once, self.n_quarters))

    def inverse(self) -> "QuarterTurn":
        """Return the turn that undoes this one."""
        return QuarterTurn(-self.n_quarters % QUARTERS)

    def picture(self, picture: NDArray[Scalar]) -> NDArray[Scalar]:
        """Return a (H, W, ...) picture turned; the same array where nothing is to be turned."""
        if self.n_quarters == 0:
            return picture
        return np.ascontiguousarray(np.rot90(picture, -self.n_quarters))

    def points(self, points_m: FloatArray) -> FloatArray:
        """Return (..., 3) points or directions in the turned camera's axes; NaN stays NaN."""
        return np.asarray(points_m @ self.rotation.T)

    def plane(self, plane: Plane) -> Plane:
        """Return a plane in the turned camera's axes."""
        return Plane(self.points(plane.normal), plane.offset_m)

    def size(self, size: tuple[int, int]) -> tuple[int, int]:
        """Return the (height, width) of the turned picture."""
        height, width = size
        return (width, height) if self.n_quarters % 2 else size

    def intrinsics(self, k: Intrinsics, size: tuple[int, int]) -> Intrinsics:
        """Return the pin-hole part for the turned picture of one of this (height, width)."""
        height, width = size
        for _ in range(self.n_quarters):
            k = Intrinsics(k.fy, k.fx, height - 1.0 - k.cy, k.cx)
            height, width = width, height
        return k

    def distortion(self, coefficients: Sequence[float]) -> tuple[float, ...]:
        """Return the lens of the turned picture; both in OpenCV's order, see `distortion`."""
        turned = list(coefficients)
        for _ in range(self.n_quarters if turned else 0):
            turned[2:4] = turned[3], -turned[2]
            if len(turned) == PRISM:
                turned[8:12] = -turned[10], -turned[11], turned[8], turned[9]
        return tuple(turned)

    def box(self, box: Box, size: tuple[int, int]) -> Box:
        """Return a box of pixels in the turned picture of one of this (height, width)."""
        height, width = size
        for _ in range(self.n_quarters):
            top, bottom, left, right = box
            box = left, right, height - bottom, height - top
            height, width = width, height
        return box

    def edges(
        self, of_edge: tuple[OfEdge, OfEdge, OfEdge, OfEdge]
    ) -> tuple[OfEdge, OfEdge, OfEdge, OfEdge]:
        """Return what holds for (top, bottom, left, right) of a picture for the turned one's."""
        for _ in range(self.n_quarters):
            top, bottom, left, right = of_edge
            of_edge = left, right, bottom, top
        return of_edge
