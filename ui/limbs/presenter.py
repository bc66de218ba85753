"""The editor of labelled images: what is open, what is kept, what comes next. Without Qt."""

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from adibas.arrays import UInt8Array
from adibas.texts import translate as _
from ui.limbs.drawing import Drawing
from ui.limbs.ports import Allowed, LimbsView, Tool
from ui.ports import JobControl, Result
from ui.workspace import Workspace

if TYPE_CHECKING:  # they bring the compiler along, and the window does without at its start
    from adibas.pipeline.limb_labelling import FrameToLabel, LabellingDesk

FOLDER_ENDING = "-limbs"


class LimbsPresenter:
    """One recording at a time, frame by frame; a frame is kept whenever it is left.

    What reads, searches or writes much runs beside the window, one thing at a time: the desk is
    for one thread.
    """

    def __init__(self, view: LimbsView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self._desk: LabellingDesk | None = None
        self._drawing = Drawing()
        self._ground: UInt8Array | None = None
        self._colors = np.zeros((1, 3), np.uint8)
        self._is_running = self._is_closed = False
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
                frame = desk.frame(desk.files.progress.next_open(-1) or 0)
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
        self._drawing.take(tool)
        self._show_corners()

    def choose_label(self, label: int) -> None:
        """Paint this label from now on; 0 rubs out."""
        self._drawing.label = label

    def set_radius(self, radius_px: int) -> None:
        """Make the brush smaller or larger."""
        self._drawing.radius_px = float(radius_px)

    def set_beyond(self, *, is_on: bool) -> None:
        """Paint outside of the person, too, where something was measured."""
        self._drawing.is_beyond = is_on

    @property
    def draws_by_dragging(self) -> bool:
        """Whether a drag of the mouse paints, and does not move the picture."""
        return self._drawing.tool == "brush"

    def click(self, u: float, v: float) -> None:
        """Use the tool at a pixel."""
        if not self._is_running:
            self._drawing.click(u, v)
            self._show_corners()
            self._show_labels()

    def drag(self, u: float, v: float) -> None:
        """Go on with a stroke of the brush; it is one step when the mouse is let go."""
        if not self._is_running:
            self._drawing.drag(u, v)
            self._show_labels()

    def drop(self) -> None:
        """End the stroke."""
        self._draw(self._drawing.drop)

    def enclose(self) -> None:
        """Fill the polygon."""
        self._draw(self._drawing.enclose)
        self._show_corners()

    def undo(self) -> None:
        """Take the last step back."""
        self._draw(self._drawing.undo)

    def redo(self) -> None:
        """Do what was undone again."""
        self._draw(self._drawing.redo)

    def point(self, u: float, v: float) -> None:
        """Tell which limb is there."""
        names = () if self._desk is None else self._desk.files.labels.names
        self._view.show_under(("", *names)[self._drawing.label_at(u, v)])

    def propose(self) -> None:
        """Label the frame from the joints that are found in it."""
        desk, frame = self._desk, self._drawing.frame
        if desk is not None and frame is not None:
            self._start(_("Looking for limbs"), lambda _c: desk.proposed(frame), self._replace)

    def carry(self) -> None:
        """Go to the next frame and give it the labels of this one, moved to where limbs are."""
        desk, frame, labels = self._desk, self._drawing.frame, self._drawing.labels
        if desk is None or frame is None or labels is None or frame.index + 1 >= len(desk):
            return

        def work(_control: JobControl) -> "tuple[FrameToLabel, UInt8Array, UInt8Array]":
            after = desk.frame(frame.index + 1)
            return after, _kept(desk, after), desk.carried(frame, labels, after)

        def done(found: "tuple[FrameToLabel, UInt8Array, UInt8Array]") -> None:
            self._show_frame(found[0], found[1])
            if found[2].any():
                self._replace(found[2])
            else:
                self._workspace.tell(
                    "warning", _("Nothing was carried over: nobody was found near those limbs.")
                )

        if self.leave():
            self._start(_("Carrying labels over"), work, done)

    def go(self, index: int) -> None:
        """Show another frame."""
        desk, shown = self._desk, self._drawing.frame
        if desk is None or shown is None or index == shown.index:
            return
        if not 0 <= index < len(desk) or not self.leave():
            return

        def work(_control: JobControl) -> "tuple[FrameToLabel, UInt8Array]":
            frame = desk.frame(index)
            return frame, _kept(desk, frame)

        self._start(_("Reading a frame"), work, lambda found: self._show_frame(*found))

    def go_by(self, n_frames: int) -> None:
        """Show a frame before or after."""
        if self._drawing.frame is not None:
            self.go(self._drawing.frame.index + n_frames)

    def finish(self) -> None:
        """Note that the frame is done, and show the next one that is not."""
        desk, frame, labels = self._desk, self._drawing.frame, self._drawing.labels
        if desk is None or frame is None or labels is None or self._is_running:
            return
        if not labels.any():
            self._workspace.tell("warning", _("No limb is labelled in this frame yet."))
            return
        if not self._keep(is_done=True):
            return
        following = desk.files.progress.next_open(frame.index)
        if following is None:
            self._workspace.tell(
                "good", _("All frames are done. {folder} can be trained on.").format(
                    folder=desk.files.folder.name
                )
            )  # fmt: skip
        else:
            self.go(following)

    def leave(self) -> bool:
        """Keep what was changed in the frame; return whether that went well."""
        return not self._drawing.is_changed or self._keep(is_done=False)

    def _keep(self, *, is_done: bool) -> bool:
        """Write the labels; return whether that went well."""
        desk, frame, labels = self._desk, self._drawing.frame, self._drawing.labels
        if desk is None or frame is None or labels is None:
            return True
        keep, depth_raw = desk.files.keep, frame.depth_raw
        if not self._workspace.attempt(
            lambda: keep(frame.index, depth_raw, labels, is_done=is_done)
        ):
            return False
        self._drawing.is_changed = False
        self._show_progress()
        return True

    def close(self) -> None:
        """Keep what was changed, and close the recording."""
        self.leave()
        if self._desk is not None:
            self._desk.close()
        self._desk = None
        self._drawing.end()
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
        self._colors = painting_colors(desk.files.labels.names)
        self._view.show_recording(desk.files.recording, str(desk.files.folder))
        self._view.show_labels(desk.files.labels.names, self._colors)

    def _show_frame(self, frame: "FrameToLabel", labels: UInt8Array) -> None:
        from adibas.pipeline.limb_pictures import grey_picture

        self._drawing.begin(frame, labels)
        self._ground = grey_picture(frame.depth_m)
        self._show_corners()
        self._show_labels()
        self._show_progress()

    def _show_progress(self) -> None:
        frame = self._drawing.frame
        if self._desk is not None and frame is not None:
            self._view.show_progress(frame.index, self._desk.files.progress)

    def _show_labels(self) -> None:
        from adibas.pipeline.limb_pictures import tinted

        frame, labels = self._drawing.frame, self._drawing.shown
        if self._ground is not None and frame is not None and labels is not None:
            self._view.show_picture(tinted(self._ground, labels, self._colors), frame.mask)

    def _show_corners(self) -> None:
        self._view.show_corners(self._drawing.corners)
        self._show_allowed()

    def _show_allowed(self) -> None:
        drawing, frame, desk = self._drawing, self._drawing.frame, self._desk
        self._view.show_allowed(
            Allowed(
                is_open=frame is not None,
                is_busy=self._is_running,
                can_undo=drawing.can_undo,
                can_redo=drawing.can_redo,
                can_enclose=drawing.can_enclose,
                is_last=frame is None or desk is None or frame.index + 1 >= len(desk),
            )
        )

    def _replace(self, labels: UInt8Array) -> None:
        self._draw(lambda: self._drawing.replace(labels))

    def _draw(self, action: Callable[[], None]) -> None:
        action()
        self._show_labels()
        self._show_allowed()


def _kept(desk: "LabellingDesk", frame: "FrameToLabel") -> UInt8Array:
    kept = desk.files.kept(frame.index)
    return np.zeros(frame.depth_m.shape, np.uint8) if kept is None else kept
