"""The picture of the video: zoomed by the wheel; all keys belong to the coding."""

import numpy as np
from PySide6.QtGui import QKeyEvent

from ui.behaviour.ports import Picture
from ui.widgets.depth_picture import PACKED_PALETTE, depth_levels
from ui.widgets.image_view import ImageView
from ui.widgets.shown_picture import Coloring

COLORED = 3
"""Axes of a picture of colours; one of depth has two."""
DEPTH = Coloring(depth_levels, PACKED_PALETTE)


class VideoView(ImageView):
    """Shows frames."""

    def show_frame(self, picture: Picture | None) -> None:
        """Show a frame in colours, or its depth where it has none."""
        if picture is None:
            self.set_picture(None)
        elif picture.ndim == COLORED:
            self.set_picture(picture.astype(np.uint8, copy=False))
        else:
            self.set_numbers(picture.astype(np.float32, copy=False), DEPTH)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802  (Qt's name)
        event.ignore()

    def keyReleaseEvent(self, event: QKeyEvent) -> None:  # noqa: N802  (Qt's name)
        event.ignore()
