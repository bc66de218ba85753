"""The depth of a burst as one image of disparity.

Structured-light sensors measure disparity, which is proportional to 1/z: there their noise is
constant and symmetric, and a plane is linear in the pixel. So everything is averaged and fitted in
1/z, in the depth camera's own pixels.
"""

from collections.abc import Iterable

import numpy as np

from adibas.arrays import Float32Array, FloatArray, check_shape
from adibas.data.calibration import CameraCalibration, DepthBias
from adibas.data.surface import BurstDisparity
from adibas.markers.disparity_kernels import accumulate, summarise


class DisparitySum:
    """Adds up the frames of a burst; memory does not grow with its length.

    Parameters
    ----------
    bias : DepthBias
        Applied to each frame.
    camera : CameraCalibration or None
        The depth camera; see `DepthBias.correct`.
    """

    def __init__(self, bias: DepthBias, camera: CameraCalibration | None = None) -> None:
        self._bias = bias
        self._camera = camera
        self._sums: FloatArray | None = None
        self._n_frames = 0

    def add(self, depth_m: Float32Array) -> None:
        """Add one (H, W) depth image, metres, NaN = not measured."""
        check_shape("depth_m", depth_m, (None, None))
        if self._sums is None:
            self._sums = np.zeros((3, *depth_m.shape))
        corrected_m = self._bias.correct(depth_m, self._camera)
        accumulate(np.ascontiguousarray(corrected_m, np.float32), self._sums)
        self._n_frames += 1

    def result(self, least_share: float, greatest_sd_per_m: float) -> BurstDisparity:
        """Return the mean of what was added.

        Parameters
        ----------
        least_share : float
            A pixel needs readings in this share of the frames, and in one at least.
        greatest_sd_per_m : float
            A pixel whose readings scatter more (standard deviation of 1/z) is left out.
        """
        if self._sums is None:
            raise ValueError("a burst has one frame at least")
        least = max(1.0, least_share * self._n_frames)
        mean_per_m = summarise(self._sums, least, greatest_sd_per_m)
        return BurstDisparity(mean_per_m, self._sums[0].astype(np.int64), self._n_frames)


def fuse_depth(
    frames: Iterable[Float32Array],
    bias: DepthBias,
    camera: CameraCalibration | None = None,
    *,
    least_share: float = 0.3,
    greatest_sd_per_m: float = 0.02,
) -> BurstDisparity:
    """Return the mean disparity of the (H, W) depth images of a burst; see `DisparitySum`."""
    total = DisparitySum(bias, camera)
    for depth_m in frames:
        total.add(depth_m)
    return total.result(least_share, greatest_sd_per_m)
