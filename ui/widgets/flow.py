"""A row of controls that goes on in another row where it is too narrow."""

from PySide6.QtCore import QRect, QSize, Qt
from PySide6.QtWidgets import QLayout, QLayoutItem, QWidget

SPACING_PX = 8


class FlowLayout(QLayout):
    """As wide as its widest control at least; hidden controls take no room.

    Parameters
    ----------
    at_right : bool
        Whether rows end at the right, as the buttons of a form, and do not begin at the left.
    """

    def __init__(self, *, at_right: bool = False) -> None:
        super().__init__()
        self._at_right = at_right
        self._items: list[QLayoutItem] = []
        self.setContentsMargins(0, 0, 0, 0)
        self.setSpacing(SPACING_PX)

    def addItem(self, item: QLayoutItem) -> None:  # noqa: N802  (Qt's name)
        self._items.append(item)

    def count(self) -> int:
        return len(self._items)

    def itemAt(self, index: int) -> QLayoutItem | None:  # noqa: N802
        return self._items[index] if 0 <= index < len(self._items) else None

    def takeAt(self, index: int) -> QLayoutItem | None:  # noqa: N802
        return self._items.pop(index) if 0 <= index < len(self._items) else None

    def expandingDirections(self) -> Qt.Orientation:  # noqa: N802  (Qt's name)
        return Qt.Orientation(0)

    def hasHeightForWidth(self) -> bool:  # noqa: N802  (Qt's name)
        return True

    def heightForWidth(self, width: int) -> int:  # noqa: N802  (Qt's name)
        places = self._places(QRect(0, 0, width, 0))
        return max((place.bottom() + 1 for _item, place in places), default=0)

    def sizeHint(self) -> QSize:  # noqa: N802  (Qt's name)
        seen = [item.sizeHint() for item in self._items if not item.isEmpty()]
        width = sum(size.width() for size in seen) + self.spacing() * max(len(seen) - 1, 0)
        return QSize(width, max((size.height() for size in seen), default=0))

    def minimumSize(self) -> QSize:  # noqa: N802  (Qt's name)
        least = QSize(0, 0)
        for item in self._items:
            if not item.isEmpty():
                least = least.expandedTo(item.minimumSize())
        return least

    def setGeometry(self, place: QRect) -> None:  # noqa: N802  (Qt's name)
        super().setGeometry(place)
        for item, part in self._places(place):
            item.setGeometry(part)

    def _places(self, room: QRect) -> list[tuple[QLayoutItem, QRect]]:
        """Return where every control that is seen stands, row after row, in the row's middle."""
        rows: list[list[tuple[QLayoutItem, QSize]]] = [[]]
        left = room.left()
        for item in self._items:
            if item.isEmpty():
                continue
            size = item.sizeHint()
            if rows[-1] and left + size.width() > room.right() + 1:
                rows.append([])
                left = room.left()
            rows[-1].append((item, QSize(min(size.width(), room.width()), size.height())))
            left += size.width() + self.spacing()
        places: list[tuple[QLayoutItem, QRect]] = []
        top = room.top()
        for row in rows:
            left, height = room.left(), max((size.height() for _item, size in row), default=0)
            if self._at_right:
                taken = sum(size.width() + self.spacing() for _item, size in row) - self.spacing()
                left += max(room.width() - taken, 0)
            for item, size in row:
                above = (height - size.height()) // 2
                places.append((item, QRect(left, top + above, size.width(), size.height())))
                left += size.width() + self.spacing()
            top += height + self.spacing()
        return places


def in_a_flow(*widgets: QWidget, at_right: bool = False) -> FlowLayout:
    """Return a layout of controls in this order."""
    flow = FlowLayout(at_right=at_right)
    for widget in widgets:
        flow.addWidget(widget)
    return flow
