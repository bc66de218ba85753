"""The captures of the session as a strip of small pictures."""

from PySide6.QtCore import QEvent, QSize, Qt, Signal
from PySide6.QtGui import QImage, QPixmap, QTransform
from PySide6.QtWidgets import QListView, QListWidget, QListWidgetItem, QWidget

from adibas.arrays import UInt8Array
from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.review.content import CaptureItem
from ui.view_names import VIEW_NAMES
from ui.widgets.swatch import true_icon

SIDE_PX = 104
ID = Qt.ItemDataRole.UserRole


class CaptureStrip(QListWidget):
    """One item a capture; choosing one opens it."""

    chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setViewMode(QListView.ViewMode.IconMode)
        self.setFlow(QListView.Flow.TopToBottom)
        self.setWrapping(False)
        self.setMovement(QListView.Movement.Static)
        self.setIconSize(QSize(SIDE_PX, SIDE_PX))
        self.setSpacing(4)
        self.setWordWrap(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._items: tuple[CaptureItem, ...] = ()
        self._rotation_deg = 0
        self.currentItemChanged.connect(self._on_current)
        self.retranslate()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.setAccessibleName(_("Captures of the session"))
        for row, item in enumerate(self._items):
            self.item(row).setText(_caption(item))
        lines = [line for item in self._items for line in _caption(item).splitlines()]
        widest = max((self.fontMetrics().horizontalAdvance(line) for line in lines), default=0)
        width = max(SIDE_PX, widest) + 16
        self.setFixedWidth(width + 30)
        for row in range(self.count()):
            self._fit(self.item(row), width)

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        """Give the lines the room that they need in letters of another size."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self.retranslate()

    def show_items(
        self, items: tuple[CaptureItem, ...], chosen: str | None, rotation_deg: int
    ) -> None:
        """Show these, and which one is open."""
        was_blocked = self.blockSignals(True)
        if not self._has_same_pictures(items, rotation_deg):
            self.clear()
            for item in items:
                self._add(item, rotation_deg)
        self._items, self._rotation_deg = items, rotation_deg
        for row, item in enumerate(items):
            if item.capture_id == chosen:
                self.setCurrentRow(row)
        self.retranslate()
        self.blockSignals(was_blocked)

    def _fit(self, item: QListWidgetItem, width: int) -> None:
        """Give a picture room for the lines below it."""
        height = item.icon().actualSize(self.iconSize()).height() if not item.icon().isNull() else 0
        n_lines = item.text().count("\n") + 1
        item.setSizeHint(QSize(width, height + n_lines * self.fontMetrics().lineSpacing() + 10))

    def _has_same_pictures(self, items: tuple[CaptureItem, ...], rotation_deg: int) -> bool:
        shown = [(one.capture_id, self._rotation_deg) for one in self._items]
        return shown == [(one.capture_id, rotation_deg) for one in items]

    def _add(self, item: CaptureItem, rotation_deg: int) -> None:
        added = QListWidgetItem(self)
        added.setData(ID, item.capture_id)
        added.setTextAlignment(Qt.AlignmentFlag.AlignHCenter)
        if item.thumbnail_rgb is not None:
            added.setIcon(true_icon(_pixmap(item.thumbnail_rgb, rotation_deg)))

    def _on_current(self, now: QListWidgetItem | None, _before: QListWidgetItem | None) -> None:
        if now is not None:
            self.chosen.emit(now.data(ID))


def _caption(item: CaptureItem) -> str:
    count = translate_plural("{count} marker", "{count} markers", item.n_markers)
    lines = [_(VIEW_NAMES[item.view]), count.format(count=item.n_markers)]
    if item.is_corrected:
        lines.append(_("corrected"))
    return "\n".join(lines)


def _pixmap(picture_rgb: UInt8Array, rotation_deg: int) -> QPixmap:
    height, width = picture_rgb.shape[:2]
    image = QImage(picture_rgb.tobytes(), width, height, 3 * width, QImage.Format.Format_RGB888)
    return QPixmap.fromImage(image.transformed(QTransform().rotate(rotation_deg)))
