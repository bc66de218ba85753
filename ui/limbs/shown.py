"""What the page shows of the desk and of the frame in hand. Without Qt."""

from typing import TYPE_CHECKING

import numpy as np

from adibas.arrays import UInt8Array
from ui.limbs.drawing import Drawing
from ui.limbs.ports import Allowed, LimbsView

if TYPE_CHECKING:  # they bring the compiler along, and the window does without at its start
    from adibas.pipeline.limb_labelling import FrameToLabel, LabellingDesk


class ShownFrame:
    """Keeps the page as the drawing is; it decides nothing but what can be done now."""

    def __init__(self, view: LimbsView, drawing: Drawing) -> None:
        self._view, self._drawing = view, drawing
        self._desk: LabellingDesk | None = None
        self._ground: UInt8Array | None = None
        self._colors = np.zeros((1, 3), np.uint8)

    def show_desk(self, desk: "LabellingDesk", title: str) -> None:
        """Show another recording."""
        from adibas.pipeline.limb_names import painting_colors

        self._desk = desk
        self._colors = painting_colors(desk.files.labels.names)
        self._view.show_recording(title, str(desk.files.folder))
        self._view.show_labels(desk.files.labels.names, self._colors)

    def show_frame(self, frame: "FrameToLabel") -> None:
        """Show another frame, which the drawing has begun with."""
        from adibas.pipeline.limb_pictures import grey_picture

        self._ground = grey_picture(frame.depth_m)
        self.show_labels()
        self.show_progress()

    def show_progress(self) -> None:
        """Show which frame it is, and how many are done."""
        frame = self._drawing.frame
        if self._desk is not None and frame is not None:
            self._view.show_progress(frame.index, self._desk.files.progress)

    def show_labels(self) -> None:
        """Show the labels of the frame."""
        from adibas.pipeline.limb_pictures import tinted

        frame, labels = self._drawing.frame, self._drawing.shown
        if self._ground is not None and frame is not None and labels is not None:
            self._view.show_picture(tinted(self._ground, labels, self._colors), frame.mask)

    def show_corners(self, *, is_busy: bool) -> None:
        """Show the polygon that is being drawn."""
        self._view.show_corners(self._drawing.corners)
        self.show_allowed(is_busy=is_busy)

    def show_allowed(self, *, is_busy: bool) -> None:
        """Offer what can be done now."""
        drawing, frame, desk = self._drawing, self._drawing.frame, self._desk
        self._view.show_allowed(
            Allowed(
                is_open=frame is not None,
                is_busy=is_busy,
                can_undo=drawing.undo_frame is not None,
                can_redo=drawing.redo_frame is not None,
                can_enclose=drawing.can_enclose,
                is_last=frame is None or desk is None or frame.index + 1 >= len(desk),
            )
        )
