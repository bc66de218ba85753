"""The markers of the capture that is reviewed: chosen, moved, named, measured. No Qt."""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Protocol

from adibas.arrays import UInt8Array
from adibas.data.corrections import CorrectionHistory
from adibas.data.markers import Marker, RejectedBlob, is_numbered
from adibas.data.sessions import Capture
from adibas.texts import translate as _
from ui.ports import JobControl
from ui.review.content import MeasureRow, Mode, Points
from ui.review.editor import CaptureEditor
from ui.review.measuring import Asked, Measured, MeasureTable, free_rows
from ui.review.opened import Opened, PassedLandmarks
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.data.protocol_measures import ProtocolMeasures
    from adibas.sessions.conflicts import Decision

SAME_PLACE_PX = 1.0


class PointsView(Protocol):
    """What shows the markers."""

    def show_points(self, points: Points) -> None:
        """Show the markers on the picture and in the list, and what can be done."""

    def show_protocol(self, measures: "ProtocolMeasures | None") -> None:
        """Show the measures of the session's protocol in this view; None where there are none."""

    def show_measures(self, rows: tuple[MeasureRow, ...]) -> None:
        """Show every pair and triplet."""


class PointsPresenter:
    """Turns what the mouse and the keyboard do into corrections.

    Parameters
    ----------
    view : PointsView
        The screen.
    workspace : Workspace
        Its store keeps every correction before it is shown.
    corrected : callable
        Told of the capture after each correction.
    """

    def __init__(
        self, view: PointsView, workspace: Workspace, corrected: Callable[[Capture], None]
    ) -> None:
        self._view = view
        self._workspace = workspace
        self._corrected = corrected
        self._table = MeasureTable(workspace.jobs, self._show_measures)
        self._editor: CaptureEditor | None = None
        self._opened: Opened | None = None
        self._selected: str | None = None
        self._picked: tuple[str, ...] = ()
        self._mode = Mode.CHOOSE
        self._passed = PassedLandmarks()
        self._shows_rejected = False
        self._has_values = False
        self._decisions: tuple[Decision, ...] = ()

    @property
    def picture_rgb(self) -> UInt8Array | None:
        """The picture, once it can be edited."""
        return None if self._opened is None else self._opened.picture_rgb

    @property
    def is_ready(self) -> bool:
        """Whether picture and surface are there."""
        return self._opened is not None

    @property
    def markers(self) -> tuple[Marker, ...]:
        """As seen."""
        return () if self._editor is None else self._editor.markers()

    def open_capture(self, capture: Capture) -> None:
        """Show the markers of a capture; they can be edited once `give_surface` was called."""
        self._editor = CaptureEditor(capture, partial(self._save, capture.capture_id))
        self._opened, self._selected, self._picked = None, None, ()
        self._passed = PassedLandmarks()
        self._show_measures(Measured())
        self._show()

    def give_surface(self, opened: Opened) -> None:
        """Allow editing."""
        self._opened = opened
        if opened.protocol is None and self._mode is Mode.NAME:
            self._mode = Mode.CHOOSE
        self._show()
        if opened.protocol is not None:
            self.measure_all()

    def close_capture(self) -> None:
        """Show no markers."""
        self._editor, self._opened, self._selected, self._picked = None, None, None, ()
        self._table.clear()
        self._show()

    def measure_all(self) -> None:
        """Show every measure of the markers as seen, as soon as possible."""
        editor, opened = self._editor, self._opened
        if editor is None:
            return
        by_hand = editor.history.placed_by_hand()
        protocol, rotation_deg = (
            (None, 0) if opened is None else (opened.protocol, opened.rotation_deg)
        )
        self._table.follow(Asked(editor.capture, editor.markers(), by_hand, protocol, rotation_deg))

    def let_go(self) -> None:
        """Forget a drag that is in progress: nothing of it was saved."""
        if self._editor is not None and self._editor.held is not None:
            self._editor.hold(None)
            self._show()
            self.measure_all()

    def choose_mode(self, mode: Mode) -> None:
        """Let clicks do something else; names are given to the next landmark, chosen again."""
        if mode is Mode.NAME is self._mode:
            self._passed.pass_over(self._next_landmark())
        self._mode, self._picked = mode, ()
        self._show()

    def escape(self) -> None:
        """Step back: from a drag, from a mode, from a choice."""
        if self._editor is not None and self._editor.held is not None:
            self.let_go()
        elif self._picked:
            self.choose_mode(self._mode)
        elif self._mode is not Mode.CHOOSE:
            self.choose_mode(Mode.CHOOSE)
        else:
            self.select(None)

    def show_rejected(self, *, is_shown: bool) -> None:
        """Show what the program refused to take for markers, and why."""
        self._shows_rejected = is_shown
        self._show()

    def select(self, label: str | None) -> None:
        """Choose a marker."""
        if label != self._selected:
            self._selected = label
            self._show()

    def press(self, label: str) -> None:
        """Choose a marker, take it into the measure that is being clicked, or name it."""
        landmark = self._next_landmark()
        if self._mode.measures:
            self._pick(label)
        elif self._mode is Mode.NAME and landmark is not None:
            self.rename(label, landmark)
        else:
            self.select(label)

    def adopt(self, blob: RejectedBlob) -> None:
        """Make a marker of something that was refused."""
        self.add(blob.u, blob.v, is_free=True)

    def click(self, u: float, v: float, *, is_free: bool) -> None:
        """Add a marker where that is wished, under the name that is due; else choose none."""
        if self._mode is Mode.ADD:
            self.add(u, v, is_free=is_free)
        elif self._mode is Mode.NAME:
            self.add(u, v, is_free=is_free, label=self._next_landmark())
        elif self._mode is Mode.CHOOSE:
            self.select(None)

    def add(self, u: float, v: float, *, is_free: bool, label: str | None = None) -> None:
        """Add a marker at the blob nearest to (u, v), or right there; numbered without a label."""
        editor, opened = self._editable()
        if editor is None or opened is None:
            return
        marker = opened.placed(label or editor.free_label(), u, v, is_free=is_free)
        self._selected = marker.label
        self._edit(lambda one: one.add(marker))

    def drag(self, label: str, u: float, v: float) -> None:
        """Show a marker, and what is measured with it, where the mouse is."""
        editor, opened = self._editable()
        if editor is None or opened is None or label not in editor.saved():
            return
        radius_px = editor.saved()[label].radius_px
        editor.hold(opened.surface.measured(label, u, v, radius_px=radius_px))
        self._selected = label
        self._show()
        self.measure_all()

    def drop(self, label: str, u: float, v: float, *, is_free: bool) -> None:
        """Save a dragged marker at the blob nearest to (u, v), or right there."""
        editor, opened = self._editable()
        if editor is None or opened is None or not _holds(editor, label):
            return
        marker = opened.placed(label, u, v, is_free=is_free, before=editor.held)
        editor.hold(None)
        self._edit(lambda one: one.move(marker))

    def nudge(self, du: float, dv: float) -> None:
        """Move the chosen marker by pixels; saved when the key is let go."""
        label = self._selected
        place = next((one for one in self.markers if one.label == label), None)
        if place is None or self._opened is None:
            return
        height, width = self._opened.picture_rgb.shape[:2]
        u = min(max(place.u + du, 0.0), width - 1.0)
        v = min(max(place.v + dv, 0.0), height - 1.0)
        self.drag(place.label, u, v)

    def end_nudge(self) -> None:
        """Save where the chosen marker was nudged to."""
        held = None if self._editor is None else self._editor.held
        if held is not None:
            self.drop(held.label, held.u, held.v, is_free=True)

    def delete(self) -> None:
        """Remove the chosen marker."""
        label = self._selected
        if label is not None:
            self._edit(lambda editor: editor.delete(label))

    def rename(self, label: str, wanted: str) -> None:
        """Give a marker another name."""

        def rename(editor: CaptureEditor) -> None:
            self._selected = label
            self._selected = editor.rename(label, wanted)
            self._warn_of(self._selected, editor.capture.view)

        self._edit(rename)

    def name_others(self) -> None:
        """Let a model name the markers that have only a number, given the names that are there."""
        editor, opened = self._editable()
        if editor is None or opened is None or opened.protocol is None:
            return
        protocol, rotation_deg, burst = opened.protocol, opened.rotation_deg, opened.surface.burst
        capture, markers = editor.capture, editor.markers()

        def work(_control: JobControl) -> Mapping[str, Marker]:
            from adibas.pipeline.naming_others import names_of_others

            return names_of_others(
                protocol, markers, capture.view, capture.calibration, rotation_deg, burst
            )

        def done(found: Mapping[str, Marker]) -> None:
            if self._editor is editor:
                self._take_names(found)

        self._workspace.jobs.start(_("Naming the markers"), work, done)

    def _take_names(self, found: Mapping[str, Marker]) -> None:
        """Save the names that were found, and tell how many there are."""

        def take(editor: CaptureEditor) -> None:
            n_named = editor.take_names(found)
            if not n_named:
                told = _("No other marker can be named for sure. Name one more, and try again.")
                self._workspace.tell("warning", told)
                return
            n_left = sum(is_numbered(one.label) for one in editor.markers())
            told = _("Markers that got a name: {n}. Without one: {left}. Look them over.")
            self._workspace.tell("good", told.format(n=n_named, left=n_left))

        self._edit(take)

    def _warn_of(self, name: str, view: str) -> None:
        """Tell of a name that no measure of the session's protocol can use."""
        protocol = None if self._opened is None else self._opened.protocol
        if protocol is not None and view and not protocol.marks(view, name):
            told = _("{name} is no landmark of this protocol in this view: no measure uses it.")
            self._workspace.tell("warning", told.format(name=name))

    def undo(self) -> None:
        """Take the last correction back."""
        self._edit(CaptureEditor.undo)

    def redo(self) -> None:
        """Do again what was taken back."""
        self._edit(CaptureEditor.redo)

    def keep_measure(self, labels: tuple[str, ...]) -> None:
        """Put a measure among the free ones."""
        self._edit(lambda editor: editor.add_measure(labels))

    def remove_measure(self, labels: tuple[str, ...]) -> None:
        """Take a free measure away."""
        self._edit(lambda editor: editor.remove_measure(labels))

    def _due(self) -> tuple[str, ...] | None:
        """Return the landmarks without a marker, the next one first; None without a protocol."""
        if self._editor is None or self._opened is None or self._opened.protocol is None:
            return None
        view, labels = self._editor.capture.view, self._editor.saved()
        unmarked = self._opened.protocol.unmarked(view, labels)
        return self._passed.order(one.landmark_id for one in unmarked)

    def _next_landmark(self) -> str | None:
        return next(iter(self._due() or ()), None)

    def _pick(self, label: str) -> None:
        """Take a marker into the measure; the same one again takes it out."""
        if label in self._picked:
            self._picked = tuple(one for one in self._picked if one != label)
        else:
            self._picked = (*self._picked, label)
        if len(self._picked) == self._mode.value:
            labels, self._picked = self._picked, ()
            self.keep_measure(labels)
        self._show()

    def _editable(self) -> tuple[CaptureEditor | None, Opened | None]:
        if self._editor is None or self._opened is None or self._workspace.store.is_read_only:
            return None, None
        return self._editor, self._opened

    def _save(
        self, capture_id: str, seen: CorrectionHistory, history: CorrectionHistory
    ) -> Capture:
        capture = self._workspace.store.captures.correct(
            capture_id, history, seen=seen, decisions=self._decisions
        )
        self._corrected(capture)
        if capture.history.n_done != history.n_done:
            told = _("Somebody else corrected this picture meanwhile; that is shown, too.")
            self._workspace.tell("warning", told)
        return capture

    def _edit(self, edit: Callable[[CaptureEditor], None]) -> None:
        """Correct something; a failure is told, and leaves all as it was saved."""
        editor = self._editable()[0]
        if editor is None:
            return

        def save(decisions: "tuple[Decision, ...]") -> None:
            self._decisions = decisions
            edit(editor)

        self._workspace.save_shared(save, self._show_corrected, is_kept=False)

    def _show_corrected(self) -> None:
        """Show what is saved now, or still."""
        if self._selected is not None and all(m.label != self._selected for m in self.markers):
            self._selected = None
        self._show()
        self.measure_all()

    def _show_measures(self, found: Measured) -> None:
        """Show the tables; with the first ones the free measures get their values."""
        self._view.show_measures(found.rows)
        self._view.show_protocol(found.protocol)
        if found.rows and not self._has_values:
            self._show()

    def _free_measures(self, editor: CaptureEditor) -> tuple[MeasureRow, ...]:
        chosen = editor.history.measures()
        self._has_values = self._table.is_warm
        if self._has_values:
            return free_rows(editor.markers(), chosen)
        return tuple(MeasureRow(one.labels) for one in chosen)

    def _show(self) -> None:
        editor = self._editor
        if editor is None:
            self._view.show_points(Points(mode=self._mode))
            return
        can_edit = self._editable()[0] is not None
        markers = editor.markers()
        self._view.show_points(
            Points(
                markers=markers,
                by_hand=editor.history.placed_by_hand(),
                selected=self._selected,
                picked=self._picked,
                measures=self._free_measures(editor),
                rejected=_open_blobs(editor) if self._shows_rejected else (),
                n_rejected=len(_open_blobs(editor)),
                mode=self._mode,
                can_edit=can_edit,
                can_undo=can_edit and editor.history.can_undo,
                can_redo=can_edit and editor.history.can_redo,
                unnamed=self._due(),
            )
        )


def _holds(editor: CaptureEditor, label: str) -> bool:
    return editor.held is not None and editor.held.label == label


def _open_blobs(editor: CaptureEditor) -> tuple[RejectedBlob, ...]:
    """Return the refused blobs that no marker stands at."""
    places = [(marker.u, marker.v) for marker in editor.saved().values()]
    return tuple(
        blob
        for blob in editor.capture.rejected
        if all(math.dist((blob.u, blob.v), place) > SAME_PLACE_PX for place in places)
    )
