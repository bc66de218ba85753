"""The line under the live picture: sensor, lost frames, disk. It always says all three."""

import math

from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QBoxLayout, QLabel, QWidget

from adibas.pipeline.live import LiveFrame, SensorState
from adibas.texts import describe, message, translate_plural
from adibas.texts import translate as _
from ui.widgets.look import show_kind

FEW_MINUTES = 5
SPACING_PX = 16
SHARES = (3, 2, 2)
"""Of the width: sensor, lost frames, disk."""
Direction = QBoxLayout.Direction
STATES = {
    "closed": message("No sensor is open"),
    "opening": message("Waiting for the sensor"),
    "live": message("Live"),
    "ended": message("The recording is over."),
}


class StatusLine(QWidget):
    """Words, and a warning's colour where something is wrong.

    One beside the other, or one below the other where large letters leave no room.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._sensor, self._dropped, self._disk = (QLabel(self) for _ in range(3))
        for label in (self._sensor, self._dropped, self._disk):
            label.setWordWrap(True)  # an error is told in a sentence
        self._state = SensorState("closed")
        self._rate_hz, self._n_dropped = 0.0, 0
        self._minutes: float | None = None
        self._box = QBoxLayout(Direction.LeftToRight, self)
        self._box.setContentsMargins(0, 0, 0, 0)
        self._box.setSpacing(SPACING_PX)
        for label, share in zip((self._sensor, self._dropped, self._disk), SHARES, strict=True):
            self._box.addWidget(label, share)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._say_sensor()
        self.show_disk(self._minutes)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802  (Qt's name)
        super().resizeEvent(event)
        self._arrange()

    def _arrange(self) -> None:
        """Put what does not fit side by side into lines of its own; an error may wrap."""
        unit_px = (self.width() - 2 * SPACING_PX) / sum(SHARES)
        fits = all(
            label.fontMetrics().horizontalAdvance(label.text()) <= share * unit_px
            for label, share in zip((self._dropped, self._disk), SHARES[1:], strict=True)
        )
        direction = Direction.LeftToRight if fits else Direction.TopToBottom
        if self._box.direction() != direction:
            self._box.setSpacing(SPACING_PX if fits else 0)
            self._box.setDirection(direction)

    def show_state(self, state: SensorState) -> None:
        """Say how the sensor fares; a source that is opened has lost nothing yet."""
        self._state = state
        if state.kind in ("closed", "opening"):
            self._rate_hz, self._n_dropped = 0.0, 0
        self._say_sensor()

    def show_frame(self, frame: LiveFrame) -> None:
        """Say how well frames come; most come as well as the one before."""
        before = round(self._rate_hz), self._n_dropped
        self._rate_hz, self._n_dropped = frame.frame_rate_hz, frame.n_dropped
        if before != (round(self._rate_hz), self._n_dropped):
            self._say_sensor()

    def show_disk(self, minutes: float | None) -> None:
        """Say how many minutes the disk will hold; None where it cannot be told."""
        self._minutes = minutes
        if minutes is None:
            _say(self._disk, _("The disk cannot be asked"), "warning")
            return
        whole = math.floor(minutes)
        told = translate_plural("Disk: {n} minute left", "Disk: {n} minutes left", whole)
        _say(self._disk, told.format(n=whole), "warning" if whole < FEW_MINUTES else "")
        self._arrange()

    def _say_sensor(self) -> None:
        state, n_dropped = self._state, self._n_dropped
        if state.error is not None:
            _say(self._sensor, describe(state.error), "bad")
        elif state.kind == "live" and self._rate_hz > 0:
            rate = _("Live, {rate:.0f} pictures a second").format(rate=self._rate_hz)
            _say(self._sensor, rate, "")
        else:
            told = STATES.get(state.kind, STATES["opening"])
            _say(self._sensor, _(told), "")
        dropped = translate_plural("{n} frame dropped", "{n} frames dropped", n_dropped)
        _say(self._dropped, dropped.format(n=n_dropped), "warning" if n_dropped else "")
        self._arrange()


def _say(label: QLabel, text: str, kind: str) -> None:
    if label.text() != text:
        label.setText(text)
    show_kind(label, kind)
