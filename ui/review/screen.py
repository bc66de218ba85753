"""Builds the review screen: the one place where its view, its presenters and the core meet."""

from PySide6.QtWidgets import QWidget

from ui.review.presenter import ReviewPresenter
from ui.review.view import ReviewScreen
from ui.theme import Theme
from ui.workspace import Workspace


def build_review_screen(
    workspace: Workspace, theme: Theme, parent: QWidget | None = None
) -> ReviewScreen:
    """Return the review screen, wired to `workspace`."""
    view = ReviewScreen(theme, parent)
    view.bind(ReviewPresenter(view, workspace))
    return view
