"""The controls beside the learner's picture."""

from collections.abc import Callable

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QColor, QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QButtonGroup,
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QRadioButton,
    QSlider,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.markers.ports import Mode, Shown
from ui.widgets.number_fields import WholeNumberField
from ui.widgets.swatch import swatch, true_icon

SWATCH_PX = 28
MOST_SENSITIVITY, MOST_CLUSTERS = 60, 8
LEAST_BRIGHTNESS, MOST_BRIGHTNESS = 10, 220


class LearnerControls(QWidget):
    """Mode, sensitivity, colours, regions."""

    mode_chosen = Signal(str)
    sensitivity_moved = Signal(int)
    clusters_chosen = Signal(int)
    brightness_moved = Signal(int)
    discard_asked = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._color, self._led = QRadioButton(self), QRadioButton(self)
        group = QButtonGroup(self)
        for button, mode in ((self._color, "color"), (self._led, "led")):
            group.addButton(button)
            button.clicked.connect(lambda _checked, mode=mode: self.mode_chosen.emit(mode))
        self._sensitivity = _slider(1, MOST_SENSITIVITY, self)
        self._brightness = _slider(LEAST_BRIGHTNESS, MOST_BRIGHTNESS, self)
        self._clusters = WholeNumberField(self)
        self._clusters.setRange(1, MOST_CLUSTERS)
        self._labels = [QLabel(self) for _ in range(5)]
        self._values = [QLabel(self) for _ in range(2)]
        self._regions = QListWidget(self)
        self._sizes_px: list[int] = []
        self._discard = QPushButton(self)
        self._swatches = QHBoxLayout()
        self._swatch_colors: tuple[tuple[int, int, int], ...] = ()
        for slider, value in zip((self._sensitivity, self._brightness), self._values, strict=True):
            slider.valueChanged.connect(value.setNum)
        self._sensitivity.valueChanged.connect(self.sensitivity_moved)
        self._brightness.valueChanged.connect(self.brightness_moved)
        delete = QShortcut(QKeySequence(QKeySequence.StandardKey.Delete), self._regions)
        delete.setContext(Qt.ShortcutContext.WidgetShortcut)
        delete.activated.connect(self._discard.click)
        self._clusters.valueChanged.connect(self.clusters_chosen)
        self._discard.clicked.connect(lambda: self._send_row(self.discard_asked.emit))
        self._lay_out()

    def _lay_out(self) -> None:
        sensitivity, brightness, clusters, colors, regions = self._labels
        for label, widget in (
            (sensitivity, self._sensitivity),
            (brightness, self._brightness),
            (clusters, self._clusters),
            (regions, self._regions),
        ):
            label.setBuddy(widget)
            label.setWordWrap(True)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self._color)
        layout.addWidget(self._led)
        sliders = (self._sensitivity, self._brightness)
        for label, value, slider in zip(
            (sensitivity, brightness), self._values, sliders, strict=True
        ):
            row = QHBoxLayout()
            row.addWidget(label, 1)
            row.addWidget(value, 0, Qt.AlignmentFlag.AlignTop)
            layout.addLayout(row)
            layout.addWidget(slider)
        layout.addWidget(regions)
        layout.addWidget(self._regions, 1)
        layout.addWidget(self._discard, 0, Qt.AlignmentFlag.AlignLeft)
        layout.addWidget(clusters)
        layout.addWidget(self._clusters)
        layout.addWidget(colors)
        layout.addLayout(self._swatches)
        self._color_parts = (
            *(sensitivity, self._values[0], self._sensitivity),
            *(clusters, self._clusters, colors),
            *(regions, self._regions, self._discard),
        )
        self._led_parts = (brightness, self._values[1], self._brightness)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._color.setText(_("Coloured &stickers"))
        self._led.setText(_("&LEDs in the dark"))
        texts = (
            _("Sensi&tivity: how far a region grows"),
            _("&Brightness of an LED over the scene"),
            _("Number of &colours to learn"),
            _("Learned colours"),
            _("&Regions that you clicked"),
        )
        for label, text in zip(self._labels, texts, strict=True):
            label.setText(text)
        self._discard.setText(_("&Discard the region"))
        for row, n_pixels in enumerate(self._sizes_px):
            self._regions.item(row).setText(_size_text(n_pixels))

    def show_controls(self, shown: Shown) -> None:
        """Show what holds now; nothing of it is a wish of the user."""
        parts = (self._sensitivity, self._brightness, self._clusters)
        for widget in parts:
            widget.blockSignals(True)
        mode: Mode = shown.mode
        (self._led if mode == "led" else self._color).setChecked(True)
        self._sensitivity.setValue(round(shown.sensitivity))
        self._brightness.setValue(round(shown.least_brightness))
        self._clusters.setValue(shown.n_clusters)
        for widget in parts:
            widget.blockSignals(False)
        self._values[0].setNum(self._sensitivity.value())
        self._values[1].setNum(self._brightness.value())
        for part in self._color_parts:
            part.setVisible(mode == "color")
        for part in self._led_parts:
            part.setVisible(mode == "led")
        self._show_regions(shown)
        self._discard.setEnabled(bool(shown.regions))
        self._show_swatches(() if mode == "led" else shown.swatches)

    def _show_regions(self, shown: Shown) -> None:
        row, n_before = self._regions.currentRow(), self._regions.count()
        self._regions.clear()
        self._sizes_px = [n_pixels for _color, n_pixels in shown.regions]
        for color, n_pixels in shown.regions:
            icon = true_icon(swatch(QColor(*color), SWATCH_PX))
            self._regions.addItem(QListWidgetItem(icon, _size_text(n_pixels)))
        last = len(shown.regions) - 1
        is_new = len(shown.regions) > n_before
        self._regions.setCurrentRow(last if is_new else min(row, last))

    def _show_swatches(self, colors: tuple[tuple[int, int, int], ...]) -> None:
        if colors == self._swatch_colors:
            return
        self._swatch_colors = colors
        while self._swatches.count():
            item = self._swatches.takeAt(0)
            widget = item.widget() if item is not None else None
            if widget is not None:
                widget.hide()
                widget.deleteLater()
        for color in colors:
            label = QLabel(self)
            label.setPixmap(swatch(QColor(*color), SWATCH_PX))
            name = QColor(*color).name()
            label.setAccessibleName(name)
            label.setToolTip(name)
            self._swatches.addWidget(label)
        self._swatches.addStretch()

    def _send_row(self, send: Callable[[int], None]) -> None:
        if self._regions.currentRow() >= 0:
            send(self._regions.currentRow())


def _slider(least: int, most: int, parent: QWidget) -> QSlider:
    slider = QSlider(Qt.Orientation.Horizontal, parent)
    slider.setRange(least, most)
    slider.setPageStep(5)
    return slider


def _size_text(n_pixels: int) -> str:
    return translate_plural("{n} pixel", "{n} pixels", n_pixels).format(n=n_pixels)
