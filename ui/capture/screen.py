"""Builds the capture screen: the one place where its view, its presenter and the core meet."""

from PySide6.QtWidgets import QWidget

from ui.capture.gesture_presenter import GesturePresenter
from ui.capture.gesture_watch import QtGestureWatch
from ui.capture.presenter import CapturePresenter
from ui.capture.view import CaptureScreen
from ui.workspace import Workspace


def build_capture_screen(workspace: Workspace, parent: QWidget | None = None) -> CaptureScreen:
    """Return the capture screen, wired to `workspace`."""
    view = CaptureScreen(parent)
    view.bind(CapturePresenter(view, workspace))
    watch = QtGestureWatch(lambda: workspace.live.view.calibration, view)
    view.bind_gestures(GesturePresenter(view, workspace, watch))
    return view
