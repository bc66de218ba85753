"""The pictures of the board: what they lack, and each of them small. No decisions."""

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QIcon, QImage, QKeySequence, QPixmap, QShortcut
from PySide6.QtWidgets import (
    QCheckBox,
    QGridLayout,
    QGroupBox,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from adibas.arrays import UInt8Array
from adibas.pipeline.calibration_pictures import KeptPicture
from adibas.texts import decimal_text
from adibas.texts import translate as _
from ui.calibration.ports import Shown
from ui.calibration.wording import progress_of
from ui.widgets.look import show_kind

THUMBNAIL = QSize(80, 64)
LIST_HEIGHT_PX = 190


class PicturesPanel(QGroupBox):
    """A list of ticks, a list of pictures, and what can be done with them."""

    automatic_changed = Signal(bool)
    remove_asked = Signal(int)
    chosen = Signal(int)
    images_asked = Signal()
    anew_asked = Signal()
    sensor_asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._ticks = [QLabel(self) for _ in range(10)]
        self._automatic = QCheckBox(self)
        self._list = QListWidget(self)
        self._list.setViewMode(QListWidget.ViewMode.IconMode)
        self._list.setMovement(QListWidget.Movement.Static)
        self._list.setResizeMode(QListWidget.ResizeMode.Adjust)
        self._list.setIconSize(THUMBNAIL)
        self._list.setMinimumHeight(LIST_HEIGHT_PX)
        self._empty = QLabel(self)
        self._empty.setWordWrap(True)
        self._empty.setProperty("kind", "quiet")
        self._remove, self._images, self._anew, self._sensor = (QPushButton(self) for _ in range(4))
        self._pictures: tuple[KeptPicture, ...] = ()
        self._icons: dict[int, QIcon] = {}
        self._lay_out()
        self._connect()

    def _lay_out(self) -> None:
        layout = QVBoxLayout(self)
        ticks = QGridLayout()
        for number, tick in enumerate(self._ticks):
            tick.setWordWrap(True)
            ticks.addWidget(tick, number // 2, number % 2)
        layout.addLayout(ticks)
        layout.addWidget(self._automatic)
        layout.addWidget(self._empty)
        layout.addWidget(self._list)
        buttons = QGridLayout()
        for number, button in enumerate((self._remove, self._anew)):
            buttons.addWidget(button, 0, number)
        buttons.addWidget(self._images, 1, 0, 1, 2)
        buttons.addWidget(self._sensor, 2, 0, 1, 2)
        layout.addLayout(buttons)

    def _connect(self) -> None:
        delete = QShortcut(QKeySequence(Qt.Key.Key_Delete), self._list, self._on_remove)
        delete.setContext(Qt.ShortcutContext.WidgetShortcut)
        self._automatic.clicked.connect(self.automatic_changed)
        self._remove.clicked.connect(self._on_remove)
        self._images.clicked.connect(self.images_asked)
        self._anew.clicked.connect(self.anew_asked)
        self._sensor.clicked.connect(self.sensor_asked)
        self._list.currentItemChanged.connect(lambda _now, _before: self._on_chosen())

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.setTitle(_("Pictures of the board"))
        self._automatic.setText(_("Take them auto&matically"))
        self._automatic.setToolTip(_("Take a picture when the board is still and the view is new"))
        self._list.setAccessibleName(_("Pictures of the board"))
        self._empty.setText(_("None yet. Hold the board before the sensor."))
        self._remove.setText(_("&Remove"))
        self._remove.setToolTip(_("Remove the chosen picture (Delete)"))
        self._anew.setText(_("Start ane&w..."))
        self._images.setText(_("Use sa&ved pictures..."))
        self._sensor.setText(_("Back to the se&nsor"))

    def show_pictures(self, shown: Shown) -> None:
        """Show the pictures, and what they lack."""
        ticks = () if shown.guidance is None else progress_of(shown.guidance)
        for number, label in enumerate(self._ticks):
            label.setVisible(number < len(ticks))
            if number < len(ticks):
                text, is_there = ticks[number]
                label.setText(("✓ " if is_there else "○ ") + text)
                show_kind(label, "good" if is_there else "quiet")
        self._automatic.setChecked(shown.is_automatic)
        self._automatic.setVisible(not shown.is_offline)
        self._sensor.setVisible(shown.is_offline)
        self._show_list(shown.pictures)
        for button in (self._remove, self._anew):
            button.setEnabled(bool(shown.pictures) and not shown.is_busy)
        self._images.setEnabled(not shown.is_busy)

    def _show_list(self, pictures: tuple[KeptPicture, ...]) -> None:
        self._empty.setVisible(not pictures)
        self._list.setVisible(bool(pictures))
        if [one.number for one in pictures] == [one.number for one in self._pictures]:
            return
        row, has_grown = self._list.currentRow(), len(pictures) > len(self._pictures)
        self._pictures = pictures
        self._list.blockSignals(True)
        self._list.clear()
        for one in pictures:
            item = QListWidgetItem(_icon(one.preview_rgb), one.searched.name)
            item.setData(Qt.ItemDataRole.UserRole, one.number)
            blur = decimal_text(one.searched.blur_px, 1)
            item.setToolTip(
                _("Picture {name}: blur {blur} px").format(name=one.searched.name, blur=blur)
            )
            self._list.addItem(item)
        self._list.setCurrentRow(len(pictures) - 1 if has_grown else min(row, len(pictures) - 1))
        self._list.blockSignals(False)
        self._list.scrollToItem(self._list.currentItem())

    def _on_remove(self) -> None:
        item = self._list.currentItem()
        if item is not None:
            self.remove_asked.emit(item.data(Qt.ItemDataRole.UserRole))

    def _on_chosen(self) -> None:
        item = self._list.currentItem()
        if item is not None:
            self.chosen.emit(item.data(Qt.ItemDataRole.UserRole))


def _icon(picture_rgb: UInt8Array) -> QIcon:
    height, width = picture_rgb.shape[:2]
    image = QImage(picture_rgb.tobytes(), width, height, 3 * width, QImage.Format.Format_RGB888)
    return QIcon(QPixmap.fromImage(image))
