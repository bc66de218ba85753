"""Builds the report screen: the one place where its view, its presenter and the core meet."""

from PySide6.QtWidgets import QWidget

from ui.export.dialog import open_export
from ui.reports.presenter import ReportsPresenter
from ui.reports.view import ReportsScreen
from ui.workspace import Workspace


def build_reports_screen(workspace: Workspace, parent: QWidget | None = None) -> ReportsScreen:
    """Return the report screen, wired to `workspace`."""
    view = ReportsScreen(parent)
    view.bind(ReportsPresenter(view, workspace))
    view.export_asked.connect(lambda session_id: open_export(workspace, view, session_id))
    return view
