"""The tab of protocols, with the page of names for markers behind it."""

from PySide6.QtWidgets import QStackedWidget, QWidget

from ui.settings.names_page import NamesPage
from ui.settings.protocols_page import ProtocolsPage


class MarksTab(QStackedWidget):
    """Shows one of both pages.

    Attributes
    ----------
    protocols, names : QWidget
        The pages.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.protocols, self.names = ProtocolsPage(self), NamesPage(self)
        self.addWidget(self.protocols)
        self.addWidget(self.names)
        self.protocols.names_asked.connect(lambda: self._show(self.names))
        self.names.closed.connect(lambda: self._show(self.protocols))

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.protocols.retranslate()
        self.names.retranslate()

    def entered(self) -> None:
        """Show what is so now."""
        page = self.names if self.currentWidget() is self.names else self.protocols
        page.entered()

    def take_back(self, draft: str) -> None:
        """Show the protocol that was being changed."""
        self.setCurrentWidget(self.protocols)
        self.protocols.take_back(draft)

    def _show(self, page: NamesPage | ProtocolsPage) -> None:
        self.setCurrentWidget(page)
        page.setFocus()
        page.entered()
