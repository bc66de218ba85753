"""All screens of the window, in the order of the rail: the one place that knows them all.

Each is imported when it is first shown: together they bring OpenCV, numba, SciPy and the reports
along, a second and more, and the window is usable before. `preload` brings them in meanwhile.
"""

import threading
from collections.abc import Callable
from importlib import import_module

from PySide6.QtWidgets import QWidget

from ui.collector import take_up
from ui.theme import Theme
from ui.widgets.screen import Screen
from ui.workspace import Workspace

MODULES = (
    "ui.patients.screen",
    "adibas.sessions.store",
    "adibas.sessions.captures",
    "adibas.sessions.stored_recordings",
    "ui.capture.screen",
    "adibas.pipeline.live",
    "ui.markers.screen",
    "ui.review.screen",
    "ui.reports.screen",
    "ui.comparison.screen",
    "pyqtgraph",
    "ui.behaviour.screen",
    "ui.calibration.screen",
    "ui.settings.screen",
)
"""In the order in which a user will probably need them."""


def screen_builders(
    workspace: Workspace, theme: Theme, parent: QWidget
) -> dict[str, Callable[[], Screen]]:
    """Return what builds each screen, by its name."""
    return _session_builders(workspace, theme, parent) | _other_builders(workspace, theme, parent)


def _session_builders(
    workspace: Workspace, theme: Theme, parent: QWidget
) -> dict[str, Callable[[], Screen]]:
    """Return those of the way from patient to reviewed session."""

    def patients() -> Screen:
        from ui.patients.screen import build_patients_screen

        return build_patients_screen(workspace, parent)

    def capture() -> Screen:
        from ui.capture.screen import build_capture_screen

        return build_capture_screen(workspace, parent)

    def markers() -> Screen:
        from ui.markers.screen import build_markers_screen

        return build_markers_screen(workspace, parent)

    def review() -> Screen:
        from ui.review.screen import build_review_screen

        return build_review_screen(workspace, theme, parent)

    return {"patients": patients, "capture": capture, "markers": markers, "review": review}


def _other_builders(
    workspace: Workspace, theme: Theme, parent: QWidget
) -> dict[str, Callable[[], Screen]]:
    """Return those of what is made of sessions, and of the program itself."""

    def reports() -> Screen:
        from ui.reports.screen import build_reports_screen

        return build_reports_screen(workspace, parent)

    def comparison() -> Screen:
        from ui.comparison.screen import build_comparison_screen

        return build_comparison_screen(workspace, theme, parent)

    def behaviour() -> Screen:
        from ui.behaviour.screen import build_behaviour_screen

        return build_behaviour_screen(workspace, theme, parent)

    def calibration() -> Screen:
        from ui.calibration.screen import build_calibration_screen

        return build_calibration_screen(workspace, parent)

    def settings() -> Screen:
        from ui.settings.screen import build_settings_screen

        return build_settings_screen(workspace, parent)

    return {
        "reports": reports,
        "comparison": comparison,
        "behaviour": behaviour,
        "calibration": calibration,
        "settings": settings,
    }


def preload() -> threading.Thread:
    """Import what the other screens need, in a thread, once the window is usable."""

    def load() -> None:
        try:
            for module in MODULES:
                import_module(module)
            import_module("adibas.measures.protocol_store").protocol_titles()
            import_module("adibas.kernels").wake_compiler()
        finally:
            take_up()

    thread = threading.Thread(target=load, name="preload", daemon=True)
    thread.start()
    return thread
