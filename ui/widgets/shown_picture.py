"""A picture as it is painted: its pixels become colours when they are first seen."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from PySide6.QtGui import QImage

from adibas.arrays import Float32Array, UInt8Array

SCREEN_BYTES = 4
"""Of a pixel as Qt's painter copies it: blue, green, red, and one that counts for nothing."""


@dataclass(frozen=True, slots=True)
class Coloring:
    """How numbers are shown.

    Attributes
    ----------
    levels_of : callable
        Returns (H, W) levels of (H, W) numbers, each from its number alone.
    palette : tuple of int
        The 256 colours of the levels, as Qt packs them.
    """

    levels_of: Callable[[Float32Array], UInt8Array]
    palette: tuple[int, ...]


class ShownPicture:
    """Pixels, and the images that were made of them; these are kept as long as it is shown.

    Parameters
    ----------
    pixels : (H, W, 3) uint8 or (H, W) float32 array
        RGB, or numbers.
    coloring : Coloring, optional
        Of numbers. They become levels first, which are a quarter of the memory, then smaller, then
        colours: any other order costs half as much again.
    """

    def __init__(self, pixels: UInt8Array | Float32Array, coloring: Coloring | None = None) -> None:
        self._pixels: Any = np.ascontiguousarray(pixels)
        if coloring is not None:
            self._pixels = coloring.levels_of(self._pixels)
        self._coloring = coloring
        self._whole: QImage | None = None
        self._fitted: QImage | None = None
        self._fitted_as: tuple[tuple[int, int], int, float] = (0, 0), 0, 1.0

    @property
    def size(self) -> tuple[int, int]:
        """Width and height."""
        height, width = self._pixels.shape[:2]
        return width, height

    def whole(self) -> QImage:
        """Return the picture with all its pixels."""
        if self._whole is None:
            self._whole = self._as_image(self._pixels)
        return self._whole

    def fitted(self, size: tuple[int, int], rotation_deg: int, ratio: float) -> QImage:
        """Return the picture in (width, height) pixels of the screen, turned clockwise then.

        `ratio` is that of the screen's pixels to Qt's. OpenCV makes it smaller in a third of the
        time that Qt's painter takes, and larger in a twentieth.
        """
        if self._fitted is None or self._fitted_as != (size, rotation_deg, ratio):
            turned = np.ascontiguousarray(np.rot90(self._resized(size), -rotation_deg // 90))
            image = self._as_image(turned)
            if self._coloring is not None:
                image = image.convertToFormat(QImage.Format.Format_RGB32)
            self._fitted = image
            self._fitted.setDevicePixelRatio(ratio)
            self._fitted_as = size, rotation_deg, ratio
        return self._fitted

    def _resized(self, size: tuple[int, int]) -> Any:
        """Return levels as they are, colours as the screen has them: Qt copies 4 bytes a pixel.

        What is larger than the picture shows its pixels, as a picture does that is zoomed.
        """
        if self._coloring is not None:
            return cv2.resize(self._pixels, size, interpolation=cv2.INTER_NEAREST)
        if size[0] >= self.size[0]:
            padded = cv2.cvtColor(self._pixels, cv2.COLOR_RGB2BGRA)
            return cv2.resize(padded, size, interpolation=cv2.INTER_NEAREST)
        cv2.ipp.setUseIPP_NotExact(True)  # of this thread: a third faster, and wrong by one of 255
        try:
            smaller = cv2.resize(self._pixels, size, interpolation=cv2.INTER_LINEAR)
        finally:
            cv2.ipp.setUseIPP_NotExact(False)
        return cv2.cvtColor(smaller, cv2.COLOR_RGB2BGRA)

    def _as_image(self, pixels: Any) -> QImage:
        """Return an image that borrows `pixels`: who holds it holds both."""
        height, width = pixels.shape[:2]
        if self._coloring is None and pixels.shape[2] == SCREEN_BYTES:
            return QImage(pixels.data, width, height, 4 * width, QImage.Format.Format_RGB32)
        if self._coloring is None:
            return QImage(pixels.data, width, height, 3 * width, QImage.Format.Format_RGB888)
        image = QImage(pixels.data, width, height, width, QImage.Format.Format_Indexed8)
        image.setColorTable(self._coloring.palette)
        return image
