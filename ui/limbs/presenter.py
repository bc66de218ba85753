"""The editor of labelled images: what a tool does, what is kept, what comes next. Without Qt."""

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from adibas.arrays import BoolArray, UInt8Array
from adibas.texts import translate as _
from ui.limbs.ports import Allowed, LimbsView, Tool
from ui.ports import JobControl, Result
from ui.workspace import Workspace

if TYPE_CHECKING:  # they bring the compiler along, and the window does without at its start
    from adibas.limbs.label_edits import LabelHistory
    from adibas.pipeline.limb_labelling import FrameToLabel, LabellingDesk

Place = tuple[float, float]
FOLDER_ENDING = "-limbs"
USUAL_RADIUS_PX = 8
LEAST_CORNERS = 3


class LimbsPresenter:
    """One recording at a time, frame by frame; a frame is kept whenever it is left.

    What reads, searches or writes much runs beside the window, one thing at a time: the desk is
    for one thread.
    """

    def __init__(self, view: LimbsView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self._desk: LabellingDesk | None = None
        self._frame: FrameToLabel | None = None
        self._history: LabelHistory | None = None
        self._ground: UInt8Array | None = None
        self._colors = np.zeros((1, 3), np.uint8)
        self._is_changed = False
        self._is_running = self._is_closed = False
        self._tool: Tool = "brush"
        self._label = 1
        self._radius_px = float(USUAL_RADIUS_PX)
        self._is_beyond = False
        self._path: list[Place] = []
        self._corners: list[Place] = []
        self._show_allowed()

    def open(self, recording: Path) -> None:
        """Open a recording; its labels lie in a folder beside it, and go on where they stood."""
        if self._is_running or not self.leave():
            return

        def work(_control: JobControl) -> "tuple[LabellingDesk, FrameToLabel, UInt8Array]":
            from adibas.pipeline.limb_labelling import LabellingDesk
            from adibas.recordings import open_recording

            folder = recording.with_name(f"{recording.stem}{FOLDER_ENDING}")
            with ExitStack() as undo:
                reader = undo.enter_context(open_recording(recording))
                desk = LabellingDesk(reader, recording.name, folder)
                frame = desk.frame(desk.progress.next_open(-1) or 0)
                labels = _kept(desk, frame)
                undo.pop_all()
            return desk, frame, labels

        def done(found: "tuple[LabellingDesk, FrameToLabel, UInt8Array]") -> None:
            self._show_desk(found[0])
            self._show_frame(found[1], found[2])

        label = _("Opening {file}").format(file=recording.name)
        self._start(label, work, done, lambda found: found[0].close())

    def choose_tool(self, tool: Tool) -> None:
        """Use another tool; a polygon that was begun is given up."""
        self._tool = tool
        self._set_corners([])

    def choose_label(self, label: int) -> None:
        """Paint this label from now on; 0 rubs out."""
        self._label = label

    def set_radius(self, radius_px: int) -> None:
        """Make the brush smaller or larger."""
        self._radius_px = float(radius_px)

    def set_beyond(self, *, is_on: bool) -> None:
        """Paint outside of the person, too, where something was measured."""
        self._is_beyond = is_on

    @property
    def draws_by_dragging(self) -> bool:
        """Whether a drag of the mouse paints, and does not move the picture."""
        return self._tool == "brush"

    def click(self, u: float, v: float) -> None:
        """Use the tool at a pixel."""
        if self._tool == "polygon":
            self._set_corners([*self._corners, (u, v)])
        elif self._tool == "brush":
            self.drag(u, v)
            self.drop()
        elif self._history is not None and self._frame is not None:
            from adibas.limbs.label_edits import filled

            depth_m = self._frame.depth_m
            now = self._history.now
            self._change(filled(now, self._allowed(), depth_m, (u, v), self._label))

    def drag(self, u: float, v: float) -> None:
        """Go on with a stroke of the brush; it is one step when the mouse is let go."""
        if self._history is None or self._is_running:
            return
        self._path.append((u, v))
        self._show_labels(self._stroke(self._history.now))

    def drop(self) -> None:
        """End the stroke."""
        if self._history is None or not self._path:
            return
        stroke = self._stroke(self._history.now)
        self._path = []
        self._change(stroke)

    def enclose(self) -> None:
        """Fill the polygon."""
        if self._history is not None:
            from adibas.limbs.label_edits import enclosed

            corners, self._corners = self._corners, []
            self._change(enclosed(self._history.now, self._allowed(), corners, self._label))
        self._set_corners([])

    def point(self, u: float, v: float) -> None:
        """Tell which limb is there."""
        name = ""
        if self._history is not None and self._desk is not None:
            labels = self._history.now
            row, column = round(v), round(u)
            if 0 <= row < labels.shape[0] and 0 <= column < labels.shape[1] and labels[row, column]:
                name = self._desk.labels.names[int(labels[row, column]) - 1]
        self._view.show_under(name)

    def undo(self) -> None:
        """Take the last step back."""
        self._step(lambda history: history.undone())

    def redo(self) -> None:
        """Do what was undone again."""
        self._step(lambda history: history.redone())

    def propose(self) -> None:
        """Label the frame from the joints that are found in it."""
        desk, frame = self._desk, self._frame
        if desk is not None and frame is not None:
            self._start(_("Looking for limbs"), lambda _c: desk.proposed(frame), self._change)

    def carry(self) -> None:
        """Go to the next frame and give it the labels of this one, moved to where limbs are."""
        desk, frame, history = self._desk, self._frame, self._history
        if desk is None or frame is None or history is None or frame.index + 1 >= len(desk):
            return

        def work(_control: JobControl) -> "tuple[FrameToLabel, UInt8Array, UInt8Array]":
            after = desk.frame(frame.index + 1)
            return after, _kept(desk, after), desk.carried(frame, history.now, after)

        def done(found: "tuple[FrameToLabel, UInt8Array, UInt8Array]") -> None:
            self._show_frame(found[0], found[1])
            if found[2].any():
                self._change(found[2])
            else:
                self._workspace.tell(
                    "warning", _("Nothing was carried over: nobody was found near those limbs.")
                )

        if self.leave():
            self._start(_("Carrying labels over"), work, done)

    def go(self, index: int) -> None:
        """Show another frame."""
        desk = self._desk
        if desk is None or self._frame is None or index == self._frame.index:
            return
        if not 0 <= index < len(desk) or not self.leave():
            return

        def work(_control: JobControl) -> "tuple[FrameToLabel, UInt8Array]":
            frame = desk.frame(index)
            return frame, _kept(desk, frame)

        self._start(_("Reading a frame"), work, lambda found: self._show_frame(*found))

    def go_by(self, n_frames: int) -> None:
        """Show a frame before or after."""
        if self._frame is not None:
            self.go(self._frame.index + n_frames)

    def finish(self) -> None:
        """Note that the frame is done, and show the next one that is not."""
        desk, frame, history = self._desk, self._frame, self._history
        if desk is None or frame is None or history is None or self._is_running:
            return
        if not history.now.any():
            self._workspace.tell("warning", _("No limb is labelled in this frame yet."))
            return
        if not self._workspace.attempt(lambda: desk.keep(frame, history.now, is_done=True)):
            return
        self._is_changed = False
        self._show_progress()
        following = desk.progress.next_open(frame.index)
        if following is None:
            self._workspace.tell(
                "good", _("All frames are done. {folder} can be trained on.").format(
                    folder=desk.folder.name
                )
            )  # fmt: skip
        else:
            self.go(following)

    def leave(self) -> bool:
        """Keep what was changed in the frame; return whether that went well."""
        desk, frame, history = self._desk, self._frame, self._history
        if not self._is_changed or desk is None or frame is None or history is None:
            return True
        if not self._workspace.attempt(lambda: desk.keep(frame, history.now, is_done=False)):
            return False
        self._is_changed = False
        self._show_progress()
        return True

    def close(self) -> None:
        """Keep what was changed, and close the recording."""
        self.leave()
        if self._desk is not None:
            self._desk.close()
        self._desk = self._frame = self._history = None
        self._is_closed = True

    def _start(
        self,
        label: str,
        work: Callable[[JobControl], Result],
        done: Callable[[Result], None],
        too_late: Callable[[Result], None] = lambda _found: None,
    ) -> None:
        """Do one thing beside the window, nothing else meanwhile; `too_late` once it is closed."""
        if self._is_running:
            return
        self._is_running = True
        self._show_allowed()

        def shown(found: Result) -> None:
            (too_late if self._is_closed else done)(found)

        self._workspace.jobs.start(label, work, shown, ended=self._on_ended)

    def _on_ended(self) -> None:
        if self._is_closed:
            return
        self._is_running = False
        self._show_allowed()

    def _show_desk(self, desk: "LabellingDesk") -> None:
        from adibas.pipeline.limb_names import painting_colors

        if self._desk is not None:
            self._desk.close()
        self._desk = desk
        self._colors = painting_colors(desk.labels.names)
        self._view.show_recording(desk.name, str(desk.folder))
        self._view.show_labels(desk.labels.names, self._colors)

    def _show_frame(self, frame: "FrameToLabel", labels: UInt8Array) -> None:
        from adibas.limbs.label_edits import LabelHistory
        from adibas.pipeline.limb_pictures import grey_picture

        self._frame, self._history = frame, LabelHistory(labels)
        self._ground = grey_picture(frame.depth_m)
        self._path = []
        self._is_changed = False
        self._set_corners([])
        self._show_labels(labels)
        self._show_progress()

    def _show_progress(self) -> None:
        if self._desk is not None and self._frame is not None:
            self._view.show_progress(self._frame.index, self._desk.progress)

    def _show_labels(self, labels: UInt8Array) -> None:
        from adibas.pipeline.limb_pictures import tinted

        if self._ground is not None and self._frame is not None:
            picture = tinted(self._ground, labels, self._colors)
            self._view.show_picture(picture, self._frame.mask)

    def _show_allowed(self) -> None:
        history, frame, desk = self._history, self._frame, self._desk
        self._view.show_allowed(
            Allowed(
                is_open=frame is not None,
                is_busy=self._is_running,
                can_undo=history is not None and bool(history.back),
                can_redo=history is not None and bool(history.forth),
                can_enclose=len(self._corners) >= LEAST_CORNERS,
                is_last=frame is None or desk is None or frame.index + 1 >= len(desk),
            )
        )

    def _stroke(self, labels: UInt8Array) -> UInt8Array:
        from adibas.limbs.label_edits import painted

        return painted(labels, self._allowed(), self._path, self._radius_px, self._label)

    def _allowed(self) -> BoolArray:
        """Return where labels may change."""
        if self._frame is None:
            return np.zeros((0, 0), np.bool_)
        mask = self._frame.mask
        return mask | np.isfinite(self._frame.depth_m) if self._is_beyond else mask

    def _set_corners(self, corners: list[Place]) -> None:
        self._corners = corners
        self._view.show_corners(tuple(corners))
        self._show_allowed()

    def _change(self, labels: UInt8Array) -> None:
        self._step(lambda history: history.changed(labels))

    def _step(self, action: "Callable[[LabelHistory], LabelHistory]") -> None:
        if self._history is None or self._path:
            return
        before, self._history = self._history, action(self._history)
        self._is_changed = self._is_changed or self._history is not before
        self._show_labels(self._history.now)
        self._show_allowed()


def _kept(desk: "LabellingDesk", frame: "FrameToLabel") -> UInt8Array:
    kept = desk.kept_labels(frame.index)
    return np.zeros(frame.depth_m.shape, np.uint8) if kept is None else kept
