"""All screens of the window, in the order of the rail: the one place that knows them all."""

from PySide6.QtWidgets import QWidget

from ui.capture.screen import build_capture_screen
from ui.markers.screen import build_markers_screen
from ui.patients.screen import build_patients_screen
from ui.reports.screen import build_reports_screen
from ui.review.screen import build_review_screen
from ui.settings.screen import build_settings_screen
from ui.theme import Theme
from ui.widgets.screen import Screen
from ui.workspace import Workspace


def build_screens(workspace: Workspace, theme: Theme, parent: QWidget) -> tuple[Screen, ...]:
    """Return every screen, wired to the workspace."""
    return (
        build_patients_screen(workspace, parent),
        build_capture_screen(workspace, parent),
        build_markers_screen(workspace, parent),
        build_review_screen(workspace, theme, parent),
        build_reports_screen(workspace, parent),
        build_settings_screen(workspace, parent),
    )
