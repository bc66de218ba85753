"""Builds the calibration screen: the one place where its view, presenter and the core meet."""

from PySide6.QtWidgets import QWidget

from ui.calibration.presenter import CalibrationPresenter
from ui.calibration.view import CalibrationScreen
from ui.workspace import Workspace


def build_calibration_screen(
    workspace: Workspace, parent: QWidget | None = None
) -> CalibrationScreen:
    """Return the calibration screen, wired to `workspace`."""
    view = CalibrationScreen(parent)
    view.bind(CalibrationPresenter(view, workspace))
    return view
