"""The labels of one frame while they are drawn on: tools, and steps that can be taken back."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from adibas.arrays import BoolArray, UInt8Array
from ui.limbs.ports import Corners, Tool

if TYPE_CHECKING:  # they bring the compiler along, and the window does without at its start
    from adibas.limbs.label_edits import LabelHistory
    from adibas.pipeline.limb_labelling import FrameToLabel

USUAL_RADIUS_PX = 8
LEAST_CORNERS = 3


class Drawing:
    """A frame, its labels, and the tool in hand; without a frame nothing can be drawn.

    Attributes
    ----------
    label : int
        What is drawn; 0 rubs out.
    radius_px : float
        Of the brush.
    is_beyond : bool
        Draw outside of the person, too, where something was measured.
    is_changed : bool
        Something was drawn that is not kept.
    """

    def __init__(self) -> None:
        self.label = 1
        self.radius_px = float(USUAL_RADIUS_PX)
        self.is_beyond = False
        self.is_changed = False
        self._tool: Tool = "brush"
        self._frame: FrameToLabel | None = None
        self._history: LabelHistory | None = None
        self._path: Corners = ()
        self._corners: Corners = ()

    def begin(self, frame: "FrameToLabel", labels: UInt8Array) -> None:
        """Draw on another frame."""
        from adibas.limbs.label_edits import LabelHistory

        self._frame, self._history = frame, LabelHistory(labels)
        self._path = self._corners = ()
        self.is_changed = False

    def end(self) -> None:
        """Draw on nothing any more."""
        self._frame = self._history = None

    @property
    def frame(self) -> "FrameToLabel | None":
        """What is drawn on."""
        return self._frame

    @property
    def labels(self) -> UInt8Array | None:
        """The (H, W) labels, without a stroke that goes on; None without a frame."""
        return None if self._history is None else self._history.now

    @property
    def shown(self) -> UInt8Array | None:
        """The (H, W) labels with the stroke that goes on; None without a frame."""
        from adibas.limbs.label_edits import painted

        labels = self.labels
        if labels is None or not self._path:
            return labels
        return painted(labels, self._allowed(), self._path, self.radius_px, self.label)

    @property
    def corners(self) -> Corners:
        """Of the polygon that is being drawn."""
        return self._corners

    @property
    def tool(self) -> Tool:
        """The tool in hand."""
        return self._tool

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to take back."""
        return self._history is not None and bool(self._history.back)

    @property
    def can_redo(self) -> bool:
        """Whether there is a step to do again."""
        return self._history is not None and bool(self._history.forth)

    @property
    def can_enclose(self) -> bool:
        """Whether the polygon has corners enough."""
        return len(self._corners) >= LEAST_CORNERS

    def take(self, tool: Tool) -> None:
        """Use another tool; a polygon that was begun is given up."""
        self._tool = tool
        self._corners = ()

    def click(self, u: float, v: float) -> None:
        """Use the tool at a pixel."""
        if self._tool == "polygon":
            self._corners = (*self._corners, (u, v))
        elif self._tool == "brush":
            self.drag(u, v)
            self.drop()
        elif self._history is not None and self._frame is not None:
            from adibas.limbs.label_edits import filled

            depth_m, now = self._frame.depth_m, self._history.now
            self.replace(filled(now, self._allowed(), depth_m, (u, v), self.label))

    def drag(self, u: float, v: float) -> None:
        """Go on with a stroke of the brush."""
        if self._history is not None:
            self._path = (*self._path, (u, v))

    def drop(self) -> None:
        """End the stroke: it is one step."""
        stroke = self.shown
        self._path = ()
        if stroke is not None:
            self.replace(stroke)

    def enclose(self) -> None:
        """Fill the polygon."""
        corners, self._corners = self._corners, ()
        if self._history is not None:
            from adibas.limbs.label_edits import enclosed

            now = self._history.now
            self.replace(enclosed(now, self._allowed(), corners, self.label))

    def label_at(self, u: float, v: float) -> int:
        """Return the label at a pixel; 0 for none."""
        labels = self.labels
        row, column = round(v), round(u)
        if labels is None or not (0 <= row < labels.shape[0] and 0 <= column < labels.shape[1]):
            return 0
        return int(labels[row, column])

    def replace(self, labels: UInt8Array) -> None:
        """Take these labels, as one step."""
        self._step(lambda history: history.changed(labels))

    def undo(self) -> None:
        """Take the last step back."""
        self._step(lambda history: history.undone())

    def redo(self) -> None:
        """Do what was undone again."""
        self._step(lambda history: history.redone())

    def _step(self, action: "Callable[[LabelHistory], LabelHistory]") -> None:
        if self._history is None or self._path:
            return
        before, self._history = self._history, action(self._history)
        self.is_changed = self.is_changed or self._history is not before

    def _allowed(self) -> BoolArray:
        """Return where labels may change."""
        if self._frame is None:
            return np.zeros((0, 0), np.bool_)
        mask = self._frame.mask
        return mask | np.isfinite(self._frame.depth_m) if self.is_beyond else mask
