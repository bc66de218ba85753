"""The controls beside the live picture: source, display, views, capture."""

from pathlib import Path

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QIcon, QImage, QKeySequence, QPixmap, QShortcut
from PySide6.QtWidgets import (
    QButtonGroup,
    QCheckBox,
    QComboBox,
    QGridLayout,
    QGroupBox,
    QLabel,
    QPushButton,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from adibas.arrays import UInt8Array
from adibas.data.posture import VIEWS
from adibas.data.sessions import SessionSetup
from adibas.sensors.sources import is_sensor
from adibas.texts import translate as _
from ui.capture.people_presenter import CHOICES
from ui.capture.sources import SIZES, SourceChoice, view_title
from ui.view_names import TURN
from ui.widgets.flow import in_a_flow

THUMBNAIL = QSize(45, 36)
CAPTURE_KEYS = "Ctrl+Return"


class SourcePanel(QGroupBox):
    """Which sensor, in which mode, turned how."""

    source_chosen = Signal(str)
    size_chosen = Signal(object)
    look_asked = Signal()
    recording_asked = Signal()
    turn_asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._sources, self._sizes = QComboBox(self), QComboBox(self)
        self._sources.setSizeAdjustPolicy(
            QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        )
        self._sources.setMinimumContentsLength(24)
        self._source_label, self._size_label = QLabel(self), QLabel(self)
        self._source_label.setBuddy(self._sources)
        self._size_label.setBuddy(self._sizes)
        self._look, self._open, self._turn = (QPushButton(self) for _ in range(3))
        self._choices: dict[str, SourceChoice] = {}
        self._offered = SIZES
        self._sources.activated.connect(
            lambda _i: self.source_chosen.emit(self._sources.currentData())
        )
        self._sizes.activated.connect(lambda index: self.size_chosen.emit(self._offered[index]))
        self._look.clicked.connect(self.look_asked)
        self._open.clicked.connect(self.recording_asked)
        self._turn.clicked.connect(self.turn_asked)
        layout = QGridLayout(self)
        layout.addWidget(self._source_label, 0, 0, 1, 2)
        layout.addWidget(self._sources, 1, 0, 1, 2)
        layout.addWidget(self._look, 2, 0)
        layout.addWidget(self._open, 2, 1)
        layout.addWidget(self._size_label, 3, 0)
        layout.addWidget(self._turn, 4, 1)
        layout.addWidget(self._sizes, 4, 0)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.setTitle(_("Sensor"))
        self._source_label.setText(_("S&ource of pictures"))
        self._size_label.setText(_("Colour picture"))
        self._look.setText(_("Loo&k for sensors"))
        self._open.setText(_("&Recording..."))
        self._turn.setText(_("&Turn"))
        self._turn.setToolTip(_("Turn the picture by a quarter, for a sensor on its side"))
        for index in range(self._sources.count()):
            choice = self._choices.get(self._sources.itemData(index))
            if choice is not None:
                self._sources.setItemText(index, _(choice.title))
        self._sources.setToolTip(self._sources.currentText())

    def show_sources(self, choices: tuple[SourceChoice, ...], chosen: str) -> None:
        """Offer sources."""
        self._choices = {choice.source: choice for choice in choices}
        self._sources.clear()
        for choice in choices:
            self._sources.addItem(_(choice.title), choice.source)
        self._show_source(chosen)

    def show_setup(self, setup: SessionSetup) -> None:
        """Show what is in use; a recording has the size that it has."""
        self._show_source(setup.source)
        choice = self._choices.get(setup.source)
        self._offered = SIZES if choice is None else choice.sizes
        self._sizes.clear()
        self._sizes.addItems([f"{width} x {height}" for width, height in self._offered])
        width, height = setup.color_size
        is_offered = (width, height) in self._offered
        index = self._offered.index((width, height)) if is_offered else -1
        self._sizes.setCurrentIndex(index)
        self._sizes.setEnabled(bool(self._offered))

    def _show_source(self, source: str) -> None:
        index = self._sources.findData(source)
        if index < 0:
            name = source if is_sensor(source) else Path(source).name
            self._sources.addItem(name, source)
            index = self._sources.count() - 1
        self._sources.setCurrentIndex(index)
        self._sources.setToolTip(self._sources.currentText())


LAYERS = {"body": True, "markers": True, "plumb": True, "joints": False}
"""What can be drawn over the pictures, and whether it is from the beginning."""


class DisplayPanel(QGroupBox):
    """What is shown of a frame, and looked for in it."""

    changed = Signal()
    joints_wanted = Signal(bool)
    gestures_chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._mode = QComboBox(self)
        self._mode_label = QLabel(self)
        self._mode_label.setBuddy(self._mode)
        for mode in ("color", "both", "blended", "depth"):
            self._mode.addItem("", mode)
        self._mode.activated.connect(lambda _i: self.changed.emit())
        self._boxes = {name: QCheckBox(self) for name in LAYERS}
        layout = QVBoxLayout(self)
        layout.addWidget(self._mode_label)
        layout.addWidget(self._mode)
        for name, box in self._boxes.items():
            box.setChecked(LAYERS[name])
            box.toggled.connect(lambda _on: self.changed.emit())
            layout.addWidget(box)
        self._boxes["joints"].toggled.connect(self.joints_wanted)
        self._gestures = QComboBox(self)
        for choice in CHOICES:
            self._gestures.addItem("", choice)
        self._gestures.activated.connect(self._on_gestures)
        layout.addWidget(self._gestures)

    @property
    def mode(self) -> str:
        """One of color, both, blended, depth."""
        return str(self._mode.currentData())

    def choose_mode(self, mode: str) -> None:
        """Show another one of them."""
        self._mode.setCurrentIndex(self._mode.findData(mode))
        self.changed.emit()

    def shows(self, name: str) -> bool:
        """Say whether one of the `LAYERS` is drawn."""
        return self._boxes[name].isChecked()

    @property
    def follows_people(self) -> bool:
        """Whether anything is looked for without markers."""
        return self.shows("joints") or self._gestures.currentData() != "none"

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.setTitle(_("Picture"))
        self._mode_label.setText(_("Sho&w"))
        texts = (_("Colour"), _("Colour and depth"), _("Depth over colour"), _("Depth"))
        for index, text in enumerate(texts):
            self._mode.setItemText(index, text)
        self._boxes["body"].setText(_("Outline of the &body"))
        self._boxes["markers"].setText(_("&Markers that are found"))
        self._boxes["plumb"].setText(_("&Plumb line and horizon"))
        self._boxes["joints"].setText(_("&Joints without markers"))
        self._gestures.setAccessibleName(_("Gestures that are looked for"))
        kinds = (_("No gestures"), _("Gestures of the program"), _("Gestures learned here"))
        for index, text in enumerate(kinds):
            self._gestures.setItemText(index, text)

    def _on_gestures(self, index: int) -> None:
        self.gestures_chosen.emit(self._gestures.itemData(index))
        self.changed.emit()


class ViewsPanel(QGroupBox):
    """The four views and the turn: which is next, and which are taken."""

    chosen = Signal(str)
    review_asked = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._buttons: dict[str, QToolButton] = {}
        self._looks: dict[str, QToolButton] = {}
        group = QButtonGroup(self)
        layout = QGridLayout(self)
        layout.setColumnStretch(0, 1)
        layout.setSpacing(4)
        for index, view in enumerate((*VIEWS, TURN)):
            button, look = QToolButton(self), QToolButton(self)
            button.setCheckable(True)
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            button.setIconSize(THUMBNAIL)
            button.setShortcut(QKeySequence(f"F{index + 5}"))
            for one in (button, look):
                one.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
                one.setSizePolicy(QSizePolicy.Policy.Minimum, QSizePolicy.Policy.Preferred)
                layout.addWidget(one, index, int(one is look))
            button.clicked.connect(lambda _on, view=view: self.chosen.emit(view))
            look.clicked.connect(lambda _on, view=view: self.review_asked.emit(view))
            group.addButton(button)
            self._buttons[view], self._looks[view] = button, look
        self._taken: frozenset[str] = frozenset()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.setTitle(_("Views"))
        for view, button in self._buttons.items():
            mark = "✓ " if view in self._taken else ""
            shortcut = button.shortcut()
            button.setText(mark + view_title(view))
            button.setShortcut(shortcut)
            button.setToolTip(f"{view_title(view)} ({shortcut.toString()})")
            taken = _("taken") if view in self._taken else _("not taken yet")
            button.setAccessibleName(f"{view_title(view)}, {taken}")
            self._looks[view].setText(_("Look at it"))
            self._looks[view].setAccessibleName(
                _("Look at the view: {view}").format(view=view_title(view))
            )

    def show_views(self, view: str, taken: dict[str, UInt8Array | None]) -> None:
        """Mark the next view, and show pictures of those that were taken."""
        self._taken = frozenset(taken)
        for name, button in self._buttons.items():
            button.setChecked(name == view)
            button.setIcon(_icon(taken.get(name)))
            self._looks[name].setEnabled(name in taken)
        self.retranslate()


class ShutterPanel(QWidget):
    """The button that takes the view, and what lacks before it can."""

    capture_asked = Signal()
    learn_asked = Signal()
    wand_asked = Signal()
    consent_asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._readiness = QLabel(self)
        self._readiness.setWordWrap(True)
        self._readiness.setProperty("kind", "warning")
        self._learn, self._capture, self._wand, self._consent = (
            QPushButton(self) for _number in range(4)
        )
        self._capture.setProperty("main", "true")
        keys = QKeySequence(CAPTURE_KEYS)  # beside its underlined letter
        QShortcut(keys, self).activated.connect(self._capture.click)
        self._capture.setToolTip(keys.toString(QKeySequence.SequenceFormat.NativeText))
        self._capture.clicked.connect(self.capture_asked)
        self._learn.clicked.connect(self.learn_asked)
        self._wand.clicked.connect(self.wand_asked)
        self._consent.clicked.connect(self.consent_asked)
        self._consent.hide()
        self._can_stop = self._is_ready = False
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self._readiness)
        layout.addWidget(self._consent)
        layout.addLayout(in_a_flow(self._learn, self._wand))
        layout.addWidget(self._capture)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._learn.setText(_("&Learn the marker colour"))
        self._consent.setText(_("Record the co&nsent..."))
        self._wand.setText(_("Wan&d..."))
        self._wand.setToolTip(_("Check with a wand of known length that the sensor measures well"))
        self._capture.setText(_("Stop") if self._can_stop else _("&Capture this view"))

    def show_readiness(self, sentence: str, *, is_ready: bool) -> None:
        """Say what lacks."""
        self._readiness.setText(sentence)
        self._readiness.setVisible(bool(sentence))
        self._is_ready = is_ready
        self._enable()

    def offer_consent(self, *, is_lacking: bool) -> None:
        """Lead to where a consent is recorded."""
        self._consent.setVisible(is_lacking)

    def show_stop(self, *, can_stop: bool) -> None:
        """Let the button stop what it began."""
        self._can_stop = can_stop
        self.retranslate()
        self._enable()

    def _enable(self) -> None:
        is_usable = self._is_ready or self._can_stop
        if not is_usable and self._capture.hasFocus():
            self.setFocus()  # Qt would give it to the next button, for the next Space to press
        self._capture.setEnabled(is_usable)
        if is_usable and self.hasFocus():
            self._capture.setFocus()
        for button in (self._learn, self._wand):
            button.setEnabled(not self._can_stop)


def _icon(picture_rgb: UInt8Array | None) -> QIcon:
    """Return a thumbnail, an empty one where nothing was taken."""
    pixmap = QPixmap(THUMBNAIL)
    pixmap.fill(Qt.GlobalColor.gray)
    if picture_rgb is not None:
        height, width = picture_rgb.shape[:2]
        image = QImage(picture_rgb.tobytes(), width, height, 3 * width, QImage.Format.Format_RGB888)
        pixmap = QPixmap.fromImage(image).scaled(THUMBNAIL, Qt.AspectRatioMode.KeepAspectRatio)
    return QIcon(pixmap)
