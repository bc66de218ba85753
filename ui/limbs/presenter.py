"""The editor of labelled images: what is open, what is kept, what comes next. Without Qt."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.arrays import UInt8Array
from adibas.texts import translate as _
from ui.limbs.drawing import Drawing
from ui.limbs.one_job import OneJob
from ui.limbs.ports import LimbsView, StoredRecording, Tool
from ui.limbs.reading import Carried, Opened, carry_over, open_desk, read_frame
from ui.limbs.shown import ShownFrame
from ui.workspace import Workspace

if TYPE_CHECKING:  # they bring the compiler along, and the window does without at its start
    from adibas.pipeline.limb_labelling import FrameToLabel, LabellingDesk
    from adibas.recordings.ports import RecordingReader

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
        self._shown = ShownFrame(view, self._drawing)
        self._asked: StoredRecording | None = None
        self._job = OneJob(workspace.jobs, self._show_allowed)
        self._show_allowed()

    def open(self, recording: Path) -> None:
        """Open a recording; its labels lie in a folder beside it, and go on where they stood."""

        def reader() -> "RecordingReader":
            from adibas.recordings import open_recording

            return open_recording(recording)

        folder = recording.with_name(f"{recording.stem}{FOLDER_ENDING}")
        self._open(reader, (recording.name, recording.name), folder)

    def open_stored(self, recording: StoredRecording) -> None:
        """Open a recording of the store, after a question where its labels may lie."""
        if not self._job.is_running and self.leave():
            self._asked = recording
            self._view.ask_folder(recording.title)

    def choose_folder(self, folder: Path) -> None:
        """Go on with that question: what is labelled lies there, and is not sealed."""
        recording, self._asked = self._asked, None
        if recording is None or not self._workspace.attempt(recording.note_export):
            return
        names = recording.name, recording.title
        self._open(recording.open, names, folder, recording.rotation_deg)
        self._workspace.tell(
            "warning",
            _("Depth images that are labelled lie in {folder}, outside of the store: they are not "
              "sealed there. Keep them as safe as the store.").format(folder=folder.name),
        )  # fmt: skip

    def _open(
        self,
        reader_of: "Callable[[], RecordingReader]",
        names: tuple[str, str],
        folder: Path,
        rotation_deg: int = 0,
    ) -> None:
        """Open a recording: what the folder calls it, and what the reader does."""
        if self._job.is_running or not self.leave():
            return
        name, title = names

        def done(found: Opened) -> None:
            self._take(found.desk, title)
            self._show_frame(found.frame, found.labels)

        self._job.start(
            _("Opening {file}").format(file=title),
            lambda _control: open_desk(reader_of, name, folder, rotation_deg),
            done,
            lambda found: found.desk.close(),
        )

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
        if not self._job.is_running:
            self._drawing.click(u, v)
            self._show_corners()
            self._shown.show_labels()

    def drag(self, u: float, v: float) -> None:
        """Go on with a stroke of the brush; it is one step when the mouse is let go."""
        if not self._job.is_running:
            self._drawing.drag(u, v)
            self._shown.show_labels()

    def drop(self) -> None:
        """End the stroke."""
        self._draw(self._drawing.drop)

    def enclose(self) -> None:
        """Fill the polygon."""
        self._draw(self._drawing.enclose)
        self._show_corners()

    def undo(self) -> None:
        """Take the last step back, in whatever frame it was; that frame is shown."""
        self._in_frame(self._drawing.undo_frame, self._drawing.undo)

    def redo(self) -> None:
        """Do what was undone again, in whatever frame it was."""
        self._in_frame(self._drawing.redo_frame, self._drawing.redo)

    def _in_frame(self, index: int | None, action: Callable[[], None]) -> None:
        shown = self._drawing.frame
        if shown is None or index is None or self._job.is_running:
            return
        if index == shown.index:
            self._draw(action)
        else:
            self._go(index, lambda: self._draw(action))

    def point(self, u: float, v: float) -> None:
        """Tell which limb is there."""
        names = () if self._desk is None else self._desk.files.labels.names
        self._view.show_under(("", *names)[self._drawing.label_at(u, v)])

    def propose(self) -> None:
        """Label the frame from the joints that are found in it."""
        desk, frame = self._desk, self._drawing.frame
        if desk is not None and frame is not None:
            self._job.start(_("Looking for limbs"), lambda _c: desk.proposed(frame), self._replace)

    def carry(self) -> None:
        """Go to the next frame and give it the labels of this one, moved to where limbs are."""
        desk, frame, labels = self._desk, self._drawing.frame, self._drawing.labels
        if desk is None or frame is None or labels is None or frame.index + 1 >= len(desk):
            return

        def done(found: Carried) -> None:
            self._show_frame(found.frame, found.labels)
            if found.carried.any():
                self._replace(found.carried)
            else:
                self._workspace.tell(
                    "warning", _("Nothing was carried over: nobody was found near those limbs.")
                )

        if self.leave():
            self._job.start(
                _("Carrying labels over"), lambda _c: carry_over(desk, frame, labels), done
            )

    def go(self, index: int) -> None:
        """Show another frame."""
        self._go(index, lambda: None)

    def _go(self, index: int, then: Callable[[], None]) -> None:
        desk, shown = self._desk, self._drawing.frame
        if desk is None or shown is None or index == shown.index:
            return
        if not 0 <= index < len(desk) or not self.leave():
            return

        def done(found: "tuple[FrameToLabel, UInt8Array]") -> None:
            self._show_frame(*found)
            then()

        self._job.start(_("Reading a frame"), lambda _control: read_frame(desk, index), done)

    def go_by(self, n_frames: int) -> None:
        """Show a frame before or after."""
        if self._drawing.frame is not None:
            self.go(self._drawing.frame.index + n_frames)

    def finish(self) -> None:
        """Note that the frame is done, and show the next one that is not."""
        desk, frame, labels = self._desk, self._drawing.frame, self._drawing.labels
        if desk is None or frame is None or labels is None or self._job.is_running:
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
        self._shown.show_progress()
        return True

    def close(self) -> None:
        """Keep what was changed, and close the recording."""
        self.leave()
        if self._desk is not None:
            self._desk.close()
        self._desk = None
        self._drawing.end()
        self._job.close()

    def _take(self, desk: "LabellingDesk", title: str) -> None:
        """Work at another desk from now on."""
        if self._desk is not None:
            self._desk.close()
        self._desk = desk
        self._drawing.end()
        self._shown.show_desk(desk, title)

    def _show_frame(self, frame: "FrameToLabel", labels: UInt8Array) -> None:
        self._drawing.begin(frame, labels)
        self._shown.show_frame(frame)
        self._show_corners()

    def _show_corners(self) -> None:
        self._shown.show_corners(is_busy=self._job.is_running)

    def _show_allowed(self) -> None:
        self._shown.show_allowed(is_busy=self._job.is_running)

    def _replace(self, labels: UInt8Array) -> None:
        self._draw(lambda: self._drawing.replace(labels))

    def _draw(self, action: Callable[[], None]) -> None:
        action()
        self._shown.show_labels()
        self._show_allowed()
