"""The labels of a frame while they are drawn on: tools, and steps back through all frames."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from adibas.arrays import BoolArray, UInt8Array
from ui.limbs.ports import Corners, Tool

if TYPE_CHECKING:  # they bring the compiler along, and the window does without at its start
    from adibas.limbs.label_steps import LabelSteps
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
        self._steps: LabelSteps | None = None
        self._path: Corners = ()
        self._corners: Corners = ()

    def begin(self, frame: "FrameToLabel", labels: UInt8Array) -> None:
        """Draw on another frame; steps in the frames before can still be taken back."""
        from adibas.limbs.label_steps import LabelSteps

        self._frame = frame
        self._steps = (self._steps or LabelSteps()).begun(frame.index, labels)
        self._path = self._corners = ()
        self.is_changed = False

    def end(self) -> None:
        """Draw on nothing any more, and forget all steps."""
        self._frame = self._steps = None

    @property
    def frame(self) -> "FrameToLabel | None":
        """What is drawn on."""
        return self._frame

    @property
    def labels(self) -> UInt8Array | None:
        """The (H, W) labels, without a stroke that goes on; None without a frame."""
        if self._frame is None or self._steps is None:
            return None
        return self._steps.labels(self._frame.index)

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
    def undo_frame(self) -> int | None:
        """The frame of the step that would be taken back; None where there is none."""
        return None if self._steps is None else self._steps.undo_frame

    @property
    def redo_frame(self) -> int | None:
        """The frame of the step that would be done again; None where there is none."""
        return None if self._steps is None else self._steps.redo_frame

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
        elif self._frame is not None and self.labels is not None:
            from adibas.limbs.label_edits import filled

            depth_m, now = self._frame.depth_m, self.labels
            self.replace(filled(now, self._allowed(), depth_m, (u, v), self.label))

    def drag(self, u: float, v: float) -> None:
        """Go on with a stroke of the brush."""
        if self._frame is not None:
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
        labels = self.labels
        if labels is not None:
            from adibas.limbs.label_edits import enclosed

            self.replace(enclosed(labels, self._allowed(), corners, self.label))

    def label_at(self, u: float, v: float) -> int:
        """Return the label at a pixel; 0 for none."""
        labels = self.labels
        row, column = round(v), round(u)
        if labels is None or not (0 <= row < labels.shape[0] and 0 <= column < labels.shape[1]):
            return 0
        return int(labels[row, column])

    def replace(self, labels: UInt8Array) -> None:
        """Take these labels, as one step."""
        if self._frame is not None:
            index = self._frame.index
            self._step(lambda steps: steps.changed(index, labels))

    def undo(self) -> None:
        """Take the last step back, which must be in this frame."""
        self._step(lambda steps: steps.undone())

    def redo(self) -> None:
        """Do what was undone last again, which must be in this frame."""
        self._step(lambda steps: steps.redone())

    def _step(self, action: "Callable[[LabelSteps], LabelSteps]") -> None:
        if self._steps is None or self._path:
            return
        before, self._steps = self._steps, action(self._steps)
        self.is_changed = self.is_changed or self._steps is not before

    def _allowed(self) -> BoolArray:
        """Return where labels may change."""
        if self._frame is None:
            return np.zeros((0, 0), np.bool_)
        mask = self._frame.mask
        return mask | np.isfinite(self._frame.depth_m) if self.is_beyond else mask
