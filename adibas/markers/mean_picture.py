"""The mean of a burst's colour pictures, in which noise is less than in each of them."""

import cv2
import numpy as np

from adibas.arrays import Float32Array, UInt8Array


class MeanPicture:
    """Adds up pictures one after the other; a burst is never in memory as a whole."""

    def __init__(self) -> None:
        self._total: Float32Array | None = None
        self._n_pictures = 0

    def add(self, picture_rgb: UInt8Array) -> None:
        """Add an (H, W, 3) picture.

        Raises
        ------
        ValueError
            It has another size than those before.
        """
        if self._total is None:
            self._total = np.zeros(picture_rgb.shape, np.float32)
        if picture_rgb.shape != self._total.shape:
            raise ValueError("the pictures of a burst have one size")
        cv2.accumulate(picture_rgb, self._total)
        self._n_pictures += 1

    def result(self) -> UInt8Array:
        """Return the (H, W, 3) mean, rounded.

        Raises
        ------
        ValueError
            There was no picture.
        """
        if self._total is None:
            raise ValueError("there is no mean of no pictures")
        return np.rint(self._total / self._n_pictures).astype(np.uint8)
