"""Buttons that play the video, and where it is."""

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QComboBox, QLabel, QPushButton, QVBoxLayout, QWidget

from adibas.texts import decimal_text
from adibas.texts import translate as _
from ui.behaviour.content import time_text
from ui.behaviour.playing import SPEEDS
from ui.behaviour.presenter import Position
from ui.widgets.flow import in_a_flow

LONG_STEP_S = 1.0
STEPS = {"back": -1, "on": 1}


class Transport(QWidget):
    """Play, step, speed; the frame and its time."""

    played = Signal()
    stepped = Signal(int)
    speed_chosen = Signal(float)
    height_changed = Signal()
    """It needs more rows than before, or fewer."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._is_on = False
        self._position: Position | None = None
        self._play = QPushButton(self)
        self._play.setProperty("main", "true")
        self._steps = {name: QPushButton(self) for name in STEPS}
        self._speed, self._speed_label = QComboBox(self), QLabel(self)
        self._speed_label.setBuddy(self._speed)
        for speed in SPEEDS:
            self._speed.addItem("", speed)
        self._where, self._when = QLabel(self), QLabel(self)
        for button in (self._play, *self._steps.values()):
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        steps = self._steps
        column.addLayout(
            in_a_flow(
                steps["back"],
                self._play,
                steps["on"],
                self._speed_label,
                self._speed,
                self._where,
                self._when,
            )
        )
        self._play.clicked.connect(self.played)
        for name, button in steps.items():
            button.clicked.connect(lambda _on=False, name=name: self.stepped.emit(STEPS[name]))
        self._speed.activated.connect(
            lambda index: self.speed_chosen.emit(self._speed.itemData(index))
        )

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._steps["back"].setText(_("&Back"))
        self._steps["back"].setToolTip(_("One frame back (Left arrow)"))
        self._steps["on"].setText(_("&Forward"))
        self._steps["on"].setToolTip(_("One frame on (Right arrow)"))
        self._speed_label.setText(_("Spee&d"))
        for index, speed in enumerate(SPEEDS):
            text = decimal_text(speed, 2).rstrip("0").rstrip(".,")
            self._speed.setItemText(index, f"{text}\N{MULTIPLICATION SIGN}")
        self.show_playing(is_on=self._is_on, speed=self._speed.currentData())
        self._word_position()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802  (Qt's name)
        super().resizeEvent(event)
        self._keep_rows()

    def event(self, event: QEvent) -> bool:
        """Keep the room of all rows also where words became longer."""
        if event.type() == QEvent.Type.LayoutRequest:
            self._keep_rows()
        return super().event(event)

    def _keep_rows(self) -> None:
        """Be as high as all rows: a splitter asks for the height of one."""
        height = self.heightForWidth(self.width())
        if height != self.minimumHeight():
            self.setMinimumHeight(height)
            self.height_changed.emit()

    def show_playing(self, *, is_on: bool, speed: float) -> None:
        """Show whether the video runs, and how fast."""
        self._is_on = is_on
        self._play.setText(_("&Pause") if is_on else _("&Play"))
        self._play.setToolTip(_("Space"))
        self._speed.setCurrentIndex(SPEEDS.index(speed))

    def show_position(self, position: Position) -> None:
        """Show which frame is seen."""
        self._position = position
        self._word_position()

    def _word_position(self) -> None:
        position = self._position
        if position is not None:
            since, whole = position.time_ms - position.begin_ms, position.end_ms - position.begin_ms
            self._where.setText(
                _("Frame {number} of {n}").format(number=position.index + 1, n=position.n_frames)
            )
            self._when.setText(f"{time_text(since)} / {time_text(whole)}")
