"""Builds the comparison screen: the one place where its view, presenters and the core meet."""

from PySide6.QtWidgets import QWidget

from ui.comparison.presenter import ComparisonPresenter
from ui.comparison.view import ComparisonScreen
from ui.theme import Theme
from ui.workspace import Workspace


def build_comparison_screen(
    workspace: Workspace, theme: Theme, parent: QWidget | None = None
) -> ComparisonScreen:
    """Return the comparison screen, wired to `workspace`."""
    view = ComparisonScreen(theme, parent)
    view.bind(ComparisonPresenter(view, workspace))
    return view
