"""Where the person is."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, check_shape, read_only


@dataclass(frozen=True, slots=True, eq=False)
class BodyMask:
    """Pixels of one person in one image; (H, W) bool, the image named by the variable.

    `is_put_together`: they fall apart in this image, and belong together by the one before.
    """

    pixels: BoolArray
    is_put_together: bool = False

    def __post_init__(self) -> None:
        check_shape("pixels", self.pixels, (None, None))
        if self.pixels.dtype != np.bool_:
            raise ValueError(f"pixels must be bool, got {self.pixels.dtype}")
        read_only(self.pixels)
