"""Joints that the picture does not show: beyond its edge, or where the edge cuts the person off."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray
from adibas.data.calibration import CameraCalibration
from adibas.geometry.distortion import project_distorted
from adibas.geometry.picture_edges import Box

CUT_MARGIN_M = 0.05
"""Before an edge that cuts somebody off: the middle of what is left of a limb is no joint of it."""


@dataclass(frozen=True, slots=True)
class Picture:
    """What a depth picture shows of somebody.

    Attributes
    ----------
    camera : CameraCalibration
        Of the depth images.
    box : (first row, one past the last, first column, one past the last)
        Where there can be depth.
    is_cut : (top, bottom, left, right)
        Whether the person is cut off there.
    """

    camera: CameraCalibration
    box: Box
    is_cut: tuple[bool, bool, bool, bool]

    @property
    def shows_stature(self) -> bool:
        """Return whether neither the head nor a side is cut off: how high somebody reaches."""
        top, _bottom, left, right = self.is_cut
        return not (top or left or right)

    def shows(self, joints_m: FloatArray) -> BoolArray:
        """Say of (N, 3) joints, metres, whether the picture can show them; not of NaN."""
        least_m = np.where(self.is_cut, CUT_MARGIN_M, 0.0)
        return np.asarray((self.inside_m(joints_m) >= least_m).all(axis=1))

    def inside_m(self, joints_m: FloatArray) -> FloatArray:
        """Return how far (N, 3) joints lie inside of each edge: (N, 4), `is_cut`'s order, metres.

        Lengths at the joint's depth; negative beyond the edge, NaN where the joint is.
        """
        camera = self.camera
        u, v = project_distorted(joints_m, camera.intrinsics, camera.distortion).T
        first_row, past_row, first_column, past_column = self.box
        inside_px = np.stack([v - first_row, past_row - v, u - first_column, past_column - u])
        metres_a_px = np.maximum(joints_m[:, 2], CUT_MARGIN_M) / camera.intrinsics.fx
        return np.asarray((inside_px * metres_a_px).T)
