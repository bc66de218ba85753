"""A patient's sessions in a list: when, how many captures, and the captures in small."""

from typing import TYPE_CHECKING

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QPoint, QRect, QSize, Qt, Signal
from PySide6.QtGui import QFont, QFontMetrics, QMouseEvent, QPainter, QPalette
from PySide6.QtWidgets import (
    QAbstractItemView,
    QListView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from adibas.texts import translate as _
from ui.patients.history_model import HistoryModel, ShownCapture, session_text
from ui.view_names import VIEW_NAMES

if TYPE_CHECKING:  # patients are listed before anything is known of their sessions
    from adibas.data.sessions import Session

Index = QModelIndex | QPersistentModelIndex
PICTURE_PX = QSize(96, 84)
MARGIN_PX, GAP_PX = 8, 8


class HistoryDelegate(QStyledItemDelegate):
    """Paints a line of words and below it the captures, in as many rows as they need."""

    def __init__(self, view: QListView, model: HistoryModel) -> None:
        super().__init__(view)
        self._view, self._model = view, model

    def sizeHint(  # noqa: N802  (Qt's name)
        self,
        option: QStyleOptionViewItem,  # noqa: ARG002  (Qt's signature)
        index: Index,
    ) -> QSize:
        session = self._model.session(index.row())  # nothing is read for lines that are not seen
        text = session_text(session)
        width = self._view.viewport().width()
        metrics = self._view.fontMetrics()
        cells = self._cells(QRect(0, 0, width, 0), len(session.capture_ids), text, metrics)
        bottom = cells[-1].bottom() if cells else self._words(width, text, metrics).bottom()
        return QSize(width, bottom + MARGIN_PX)

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        shown = self._model.shown(index.row())
        self.initStyleOption(option, index)
        option.text = ""
        style = self._view.style()
        style.drawControl(QStyle.ControlElement.CE_ItemViewItem, option, painter, self._view)
        is_selected = bool(option.state & QStyle.StateFlag.State_Selected)
        role = QPalette.ColorRole.HighlightedText if is_selected else QPalette.ColorRole.Text
        painter.save()
        painter.setPen(self._view.palette().color(role))
        font = QFont(self._view.font())
        font.setStrikeOut(shown.session.is_deleted)
        font.setBold(shown.is_current)
        painter.setFont(font)
        words = self._words(option.rect.width(), shown.text, painter.fontMetrics())
        words.translate(option.rect.topLeft())
        flags = Qt.TextFlag.TextWordWrap | Qt.AlignmentFlag.AlignTop
        painter.drawText(words, flags, shown.text)
        painter.setFont(self._view.font())
        metrics = self._view.fontMetrics()
        cells = self._cells(option.rect, len(shown.captures), shown.text, metrics)
        for capture, cell in zip(shown.captures, cells, strict=True):
            _paint_capture(painter, cell, capture)
        painter.restore()

    def capture_at(self, index: QModelIndex, at: QPoint) -> str | None:
        """Return the capture under a point of the viewport; None beside them."""
        shown = self._model.shown(index.row())
        rect, metrics = self._view.visualRect(index), self._view.fontMetrics()
        cells = self._cells(rect, len(shown.captures), shown.text, metrics)
        hits = (one for one, cell in zip(shown.captures, cells, strict=True) if cell.contains(at))
        return next((one.capture_id for one in hits), None)

    def _words(self, width: int, text: str, metrics: QFontMetrics) -> QRect:
        room = QRect(MARGIN_PX, MARGIN_PX, width - 2 * MARGIN_PX, 10_000)
        height = metrics.boundingRect(room, Qt.TextFlag.TextWordWrap, text).height()
        return QRect(room.left(), room.top(), room.width(), height)

    def _cells(self, rect: QRect, count: int, text: str, metrics: QFontMetrics) -> list[QRect]:
        names = (metrics.horizontalAdvance(_(name)) for name in VIEW_NAMES.values())
        width = max(PICTURE_PX.width(), *names)
        height = PICTURE_PX.height() + metrics.height()
        n_columns = max(1, (rect.width() - 2 * MARGIN_PX + GAP_PX) // (width + GAP_PX))
        top = rect.top() + self._words(rect.width(), text, metrics).bottom() + GAP_PX
        left = rect.left() + MARGIN_PX
        return [
            QRect(
                left + (number % n_columns) * (width + GAP_PX),
                top + (number // n_columns) * (height + GAP_PX),
                width,
                height,
            )
            for number in range(count)
        ]


class HistoryList(QListView):
    """The sessions; Enter or a double click opens one, Delete hides it."""

    opened = Signal(str, object)
    """A session's id, and a capture's or None."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.shown_model = HistoryModel(self)
        self.setModel(self.shown_model)
        self._delegate = HistoryDelegate(self, self.shown_model)
        self.setItemDelegate(self._delegate)
        self.setResizeMode(QListView.ResizeMode.Adjust)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setMinimumHeight(190)
        self.activated.connect(self._on_activated)

    def show_sessions(self, sessions: "tuple[Session, ...]") -> None:
        """Show these; the chosen one stays chosen."""
        chosen = self.chosen_session()
        self.shown_model.show_sessions(sessions)
        row = self.shown_model.row_of(chosen)
        if row is not None:
            self.setCurrentIndex(self.shown_model.index(row))

    def chosen_session(self) -> str | None:
        """Return the session of the chosen line."""
        index = self.currentIndex()
        return self.shown_model.session(index.row()).session_id if index.isValid() else None

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        index = self.indexAt(event.position().toPoint())
        if index.isValid() and event.button() == Qt.MouseButton.LeftButton:
            capture_id = self._delegate.capture_at(index, event.position().toPoint())
            self.opened.emit(self.shown_model.session(index.row()).session_id, capture_id)

    def _on_activated(self, index: QModelIndex) -> None:
        self.opened.emit(self.shown_model.session(index.row()).session_id, None)


def _paint_capture(painter: QPainter, cell: QRect, capture: ShownCapture) -> None:
    room = QRect(cell.topLeft(), QSize(cell.width(), PICTURE_PX.height()))
    pixmap = capture.pixmap
    if pixmap is None or pixmap.isNull():
        painter.drawRect(room.adjusted(0, 0, -1, -1))
        if pixmap is not None:
            painter.drawText(room, Qt.AlignmentFlag.AlignCenter, "?")
    else:
        size = pixmap.size().scaled(room.size(), Qt.AspectRatioMode.KeepAspectRatio)
        place = QRect(QPoint(), size)
        place.moveCenter(room.center())
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.drawPixmap(place, pixmap)
    caption = QRect(cell.left(), room.bottom() + 1, cell.width(), cell.bottom() - room.bottom())
    painter.drawText(caption, Qt.AlignmentFlag.AlignHCenter, capture.caption)
