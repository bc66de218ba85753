"""Builds the learner: the one place where its view, its presenter and the core meet."""

from PySide6.QtWidgets import QWidget

from ui.markers.presenter import LearnerPresenter
from ui.markers.view import LearnerScreen
from ui.workspace import Workspace


def build_markers_screen(workspace: Workspace, parent: QWidget | None = None) -> LearnerScreen:
    """Return the learner, wired to `workspace`."""
    view = LearnerScreen(parent)
    view.bind(LearnerPresenter(view, workspace))
    return view
