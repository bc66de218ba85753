"""Builds the capture screen: the one place where its view, its presenter and the core meet."""

from PySide6.QtWidgets import QWidget

from ui.capture.people_presenter import PeoplePresenter
from ui.capture.people_watch import QtPeopleWatch
from ui.capture.presenter import CapturePresenter
from ui.capture.view import CaptureScreen
from ui.workspace import Workspace


def build_capture_screen(workspace: Workspace, parent: QWidget | None = None) -> CaptureScreen:
    """Return the capture screen, wired to `workspace`."""
    view = CaptureScreen(parent)
    view.bind(CapturePresenter(view, workspace))
    watch = QtPeopleWatch(lambda: workspace.live.view.calibration, view)
    view.bind_people(PeoplePresenter(view, workspace, watch))
    return view
