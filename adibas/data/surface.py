"""The surface that the depth camera saw in a burst."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import Float32Array, IntArray, check_shape, read_only


@dataclass(frozen=True, slots=True, eq=False)
class BurstDisparity:
    """Mean 1/z of every depth pixel over a burst.

    Attributes
    ----------
    mean_per_m : (H, W) float32 array
        Mean of 1/z of the frames that measured the pixel, 1/metres; NaN where too few did, or
        where they disagree (the pixel flickers between two surfaces).
    n_readings : (H, W) int64 array
        Frames that measured the pixel.
    n_frames : int
        Of the burst.
    """

    mean_per_m: Float32Array
    n_readings: IntArray
    n_frames: int

    def __post_init__(self) -> None:
        check_shape("mean_per_m", self.mean_per_m, (None, None))
        check_shape("n_readings", self.n_readings, self.mean_per_m.shape)
        read_only(self.mean_per_m)
        read_only(self.n_readings)

    @property
    def depth_m(self) -> Float32Array:
        """Return the (H, W) depth of which these are the means, metres; NaN where not known."""
        return np.asarray(1.0 / self.mean_per_m, np.float32)
