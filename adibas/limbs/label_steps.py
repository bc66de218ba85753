"""Corrections of many frames in one order: the last step is taken back first, wherever it was."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from adibas.arrays import UInt8Array
from adibas.limbs.label_edits import LabelHistory

MOST_STEPS = 200


@dataclass(frozen=True, slots=True, eq=False)
class LabelSteps:
    """What can be undone and done again, over all frames that were drawn on.

    Attributes
    ----------
    of_frame : mapping
        The history of each frame that has a step, and of the one in hand.
    back, forth : tuple of int
        Frames of the steps that can be undone, the last step last; of those that can be done
        again, the next one last.
    most_steps : int
        Older ones are forgotten, in whatever frame they were.
    """

    of_frame: Mapping[int, LabelHistory] = field(default_factory=lambda: MappingProxyType({}))
    back: tuple[int, ...] = ()
    forth: tuple[int, ...] = ()
    most_steps: int = MOST_STEPS

    @property
    def undo_frame(self) -> int | None:
        """Return the frame of the step that would be taken back next."""
        return self.back[-1] if self.back else None

    @property
    def redo_frame(self) -> int | None:
        """Return the frame of the step that would be done again next."""
        return self.forth[-1] if self.forth else None

    def labels(self, frame: int) -> UInt8Array:
        """Return the (H, W) labels of a frame that was begun."""
        return self.of_frame[frame].now

    def begun(self, frame: int, labels: UInt8Array) -> "LabelSteps":
        """Return the steps with a frame in hand that has these labels.

        Steps of a frame that somebody else has changed meanwhile are forgotten; and the labels of
        frames that nobody can undo a step in.
        """
        known = self.of_frame.get(frame)
        is_same = known is not None and np.array_equal(known.now, labels)
        back, forth = self.back, self.forth
        if not is_same:
            back, forth = (tuple(one for one in all_ if one != frame) for all_ in (back, forth))
        kept = {one: self.of_frame[one] for one in {*back, *forth} if one != frame}
        # Its own limit is never reached: steps are forgotten here, in their order.
        fresh = LabelHistory(labels, most_steps=self.most_steps + 1)
        history = known if is_same and known is not None else fresh
        return replace(self, of_frame={**kept, frame: history}, back=back, forth=forth)

    def changed(self, frame: int, labels: UInt8Array) -> "LabelSteps":
        """Return the steps with one more; what was undone cannot be done again after it."""
        before = self.of_frame[frame]
        after = before.changed(labels)
        if after is before:
            return self
        histories = {one: replace(history, forth=()) for one, history in self.of_frame.items()} | {
            frame: after
        }
        grown = replace(self, of_frame=histories, back=(*self.back, frame), forth=())
        return _shortened(grown) if len(grown.back) > self.most_steps else grown

    def undone(self) -> "LabelSteps":
        """Return the steps without the last one; the same where there is none."""
        if not self.back:
            return self
        frame = self.back[-1]
        histories = {**self.of_frame, frame: self.of_frame[frame].undone()}
        return replace(self, of_frame=histories, back=self.back[:-1], forth=(*self.forth, frame))

    def redone(self) -> "LabelSteps":
        """Return the steps with the one that was undone last; the same where there is none."""
        if not self.forth:
            return self
        frame = self.forth[-1]
        histories = {**self.of_frame, frame: self.of_frame[frame].redone()}
        return replace(self, of_frame=histories, back=(*self.back, frame), forth=self.forth[:-1])


def _shortened(steps: LabelSteps) -> LabelSteps:
    """Return the steps without the oldest one."""
    frame = steps.back[0]
    history = steps.of_frame[frame]
    shorter = replace(history, back=history.back[1:])
    return replace(steps, of_frame={**steps.of_frame, frame: shorter}, back=steps.back[1:])
