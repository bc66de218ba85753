"""The tabs over the preview: their titles take two lines where one row has no room for them."""

from PySide6.QtCore import QEvent, QSize, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QTabBar, QWidget


class PagesBar(QTabBar):
    """A tab for each view of the report."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._titles: tuple[str, ...] = ()
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setDrawBase(False)
        self.setEnabled(False)

    def show_titles(self, titles: tuple[str, ...]) -> None:
        """Show these tabs; the one that was chosen stays so where it is still there."""
        self.blockSignals(True)
        chosen = max(self.currentIndex(), 0)
        while self.count():
            self.removeTab(0)
        self._titles = titles
        for title in titles:
            self.addTab(title)
        self.blockSignals(False)
        self.setEnabled(bool(titles))  # Tab does not stop where nothing can be chosen
        self.setCurrentIndex(min(chosen, len(titles) - 1))
        self._fit()

    def minimumSizeHint(self) -> QSize:  # noqa: N802  (Qt's name)
        """Ask for the height alone: where even two lines have no room, arrows lead to the rest."""
        return QSize(0, super().minimumSizeHint().height())

    def tabSizeHint(self, index: int) -> QSize:  # noqa: N802  (Qt's name)
        """Ask for the height of all lines: Qt leaves room for one."""
        size = super().tabSizeHint(index)
        n_more = max(self.tabText(one).count("\n") for one in range(self.count()))
        return size + QSize(0, n_more * self.fontMetrics().lineSpacing())

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802  (Qt's name)
        super().resizeEvent(event)
        self._fit()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self._fit()

    def _fit(self) -> None:
        self._write(self._titles)
        widths = (self.tabSizeHint(index).width() for index in range(self.count()))
        if sum(widths) > self.width():
            self._write(tuple(title.replace(" ", "\n") for title in self._titles))

    def _write(self, titles: tuple[str, ...]) -> None:
        for index, title in enumerate(titles):
            if self.tabText(index) != title:
                self.setTabText(index, title)
