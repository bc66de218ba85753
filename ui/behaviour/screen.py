"""Builds the behaviour screen: the one place where its view, presenters and the core meet."""

from pathlib import Path

from PySide6.QtWidgets import QWidget

from adibas.errors import AdibasError
from adibas.texts import translate as _
from ui.behaviour.frame_feed import QtFrameFeed
from ui.behaviour.keeping import DraftKeeper
from ui.behaviour.presenter import BehaviourPresenter
from ui.behaviour.tools import stored_title
from ui.behaviour.view import BehaviourScreen
from ui.frame_bridge import CallBridge
from ui.limbs.dialog import open_limb_editor
from ui.limbs.ports import StoredRecording
from ui.mapping.content import RecordingToMap
from ui.mapping.dialog import MapDialog, open_map
from ui.theme import Theme
from ui.workspace import Workspace


def build_behaviour_screen(
    workspace: Workspace, theme: Theme, parent: QWidget | None = None
) -> BehaviourScreen:
    """Return the behaviour screen, wired to `workspace`."""
    view = BehaviourScreen(theme, parent)

    def report(error: object) -> None:
        if isinstance(error, AdibasError):
            workspace.report_problem(error)

    keeper = DraftKeeper(CallBridge(report, view).publish)
    feed = QtFrameFeed(view)
    presenter = BehaviourPresenter(view, workspace, feed, keeper, title_of=stored_title)
    view.bind(presenter)
    view.offer_labelling(lambda: open_limb_editor(workspace, view, _to_label(workspace, presenter)))
    view.offer_map(lambda: _map(workspace, view, presenter))
    return view


def _map(
    workspace: Workspace, view: BehaviourScreen, presenter: BehaviourPresenter
) -> MapDialog | None:
    """Show the map dialog for what is looked at; where that is nothing, say so."""
    source = presenter.source
    if source is None:
        workspace.tell("warning", _("Open a recording of a moving camera first."))
        return None
    return open_map(
        workspace,
        view,
        RecordingToMap(source.title, source.name, source.path, source.access, presenter.note_map),
    )


def _to_label(workspace: Workspace, presenter: BehaviourPresenter) -> Path | StoredRecording | None:
    """Return what is looked at, as the limb editor opens it; None for several recordings."""
    source = presenter.source
    if source is None or source.parts:
        return None
    if not source.session_id:
        return presenter.recording

    def note_export() -> None:
        workspace.store.note_export("limb labels", source.session_id)

    return StoredRecording(
        *(source.title, source.name, lambda: source.access.open(source.path), note_export),
        source.rotation_deg,
    )
