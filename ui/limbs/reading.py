"""What is read beside the window for the limb editor. Without Qt."""

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from adibas.arrays import UInt8Array

if TYPE_CHECKING:  # they bring the compiler along, and the window does without at its start
    from adibas.pipeline.limb_labelling import FrameToLabel, LabellingDesk
    from adibas.recordings.ports import RecordingReader


class Opened(NamedTuple):
    """A desk, the frame to begin with, and its labels."""

    desk: "LabellingDesk"
    frame: "FrameToLabel"
    labels: UInt8Array


class Carried(NamedTuple):
    """The next frame, its own labels, and those that were carried over."""

    frame: "FrameToLabel"
    labels: UInt8Array
    carried: UInt8Array


def open_desk(
    reader_of: "Callable[[], RecordingReader]", name: str, folder: Path, rotation_deg: int = 0
) -> Opened:
    """Open a recording and its folder at the first frame that is not done.

    `rotation_deg` is how far its picture is turned clockwise to be upright.
    """
    from adibas.pipeline.limb_labelling import DeskSetup, LabellingDesk

    with ExitStack() as undo:
        setup = DeskSetup(rotation_deg=rotation_deg)
        desk = LabellingDesk(undo.enter_context(reader_of()), name, folder, setup)
        frame, labels = read_frame(desk, desk.files.progress.next_open(-1) or 0)
        undo.pop_all()
    return Opened(desk, frame, labels)


def read_frame(desk: "LabellingDesk", index: int) -> "tuple[FrameToLabel, UInt8Array]":
    """Return a frame and the labels that are kept of it; none are all 0."""
    frame = desk.frame(index)
    kept = desk.files.kept(index)
    return frame, np.zeros(frame.depth_m.shape, np.uint8) if kept is None else kept


def carry_over(desk: "LabellingDesk", frame: "FrameToLabel", labels: UInt8Array) -> Carried:
    """Return the next frame and the labels of this one as it has them."""
    after, kept = read_frame(desk, frame.index + 1)
    return Carried(after, kept, desk.carried(frame, labels, after))
