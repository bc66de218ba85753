"""The captures of the session as a strip of small pictures."""

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QIcon, QImage, QPixmap, QTransform
from PySide6.QtWidgets import QListView, QListWidget, QListWidgetItem, QWidget

from adibas.arrays import UInt8Array
from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.review.content import CaptureItem
from ui.view_names import VIEW_NAMES

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
        self.setUniformItemSizes(True)
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
        width = max(SIDE_PX, self.fontMetrics().averageCharWidth() * 13) + 12
        self.setGridSize(QSize(width, SIDE_PX + 3 * self.fontMetrics().height() + 16))
        self.setFixedWidth(width + 26)

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
            self.item(row).setText(_caption(item))
            if item.capture_id == chosen:
                self.setCurrentRow(row)
        self.blockSignals(was_blocked)

    def _has_same_pictures(self, items: tuple[CaptureItem, ...], rotation_deg: int) -> bool:
        shown = [(one.capture_id, self._rotation_deg) for one in self._items]
        return shown == [(one.capture_id, rotation_deg) for one in items]

    def _add(self, item: CaptureItem, rotation_deg: int) -> None:
        added = QListWidgetItem(self)
        added.setData(ID, item.capture_id)
        added.setTextAlignment(Qt.AlignmentFlag.AlignHCenter)
        if item.thumbnail_rgb is not None:
            added.setIcon(QIcon(_pixmap(item.thumbnail_rgb, rotation_deg)))

    def _on_current(self, now: QListWidgetItem | None, _before: QListWidgetItem | None) -> None:
        if now is not None:
            self.chosen.emit(now.data(ID))


def _caption(item: CaptureItem) -> str:
    view = _(VIEW_NAMES[item.view])
    pattern = translate_plural("{view}\n{count} marker", "{view}\n{count} markers", item.n_markers)
    if item.is_corrected:
        pattern = translate_plural(
            "{view}\n{count} marker, corrected",
            "{view}\n{count} markers, corrected",
            item.n_markers,
        )
    return pattern.format(view=view, count=item.n_markers)


def _pixmap(picture_rgb: UInt8Array, rotation_deg: int) -> QPixmap:
    height, width = picture_rgb.shape[:2]
    image = QImage(picture_rgb.tobytes(), width, height, 3 * width, QImage.Format.Format_RGB888)
    return QPixmap.fromImage(image.transformed(QTransform().rotate(rotation_deg)))
