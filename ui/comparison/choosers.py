"""Which sessions are compared, and by which protocol."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QWidget

from adibas.data.sessions import Session
from adibas.texts import translate as _
from ui.comparison.content import Choices
from ui.widgets.dates import moment_text
from ui.widgets.flow import FlowLayout


class Choosers(QWidget):
    """Three lists that fold: before, now, measured by."""

    sessions_chosen = Signal(str, str)
    """The ids of both."""
    protocol_chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._choices = Choices()
        self._earlier, self._later, self._protocol = (QComboBox(self) for _number in range(3))
        self._boxes = (self._earlier, self._later, self._protocol)
        self._labels = tuple(QLabel(self) for _box in self._boxes)
        flow = FlowLayout()
        for label, box in zip(self._labels, self._boxes, strict=True):
            label.setBuddy(box)
            box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
            pair = QWidget(self)
            row = QHBoxLayout(pair)
            row.setContentsMargins(0, 0, 8, 0)
            row.addWidget(label)
            row.addWidget(box)
            flow.addWidget(pair)
        self.setLayout(flow)
        for box in (self._earlier, self._later):
            box.activated.connect(lambda _index: self._send_sessions())
        self._protocol.activated.connect(self._send_protocol)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        texts = (_("&Before"), _("&Now"), _("&Measured by"))
        for label, text in zip(self._labels, texts, strict=True):
            label.setText(text)
        self.show_choices(self._choices)

    def show_choices(self, choices: Choices) -> None:
        """Offer these."""
        self._choices = choices
        titles = dict(choices.protocols)
        for box, offered, chosen in (
            (self._earlier, choices.befores, choices.earlier),
            (self._later, choices.nows, choices.later),
        ):
            box.clear()
            for session in offered:
                box.addItem(_session_text(session, titles), session.session_id)
            box.setCurrentIndex(-1 if chosen is None else box.findData(chosen.session_id))
        self._protocol.clear()
        for name, title in choices.protocols:
            self._protocol.addItem(title, name)
        self._protocol.setCurrentIndex(self._protocol.findData(choices.protocol))

    def _send_sessions(self) -> None:
        chosen = [box.currentData() for box in (self._earlier, self._later)]
        if None not in chosen:
            self.sessions_chosen.emit(*chosen)

    def _send_protocol(self) -> None:
        self.protocol_chosen.emit(self._protocol.currentData())


def _session_text(session: Session, titles: dict[str, str]) -> str:
    """Say when a session was, and by which protocol."""
    named = session.setup.protocol
    parts = (moment_text(session.started_utc), titles.get(named, named))
    return "  ·  ".join(part for part in parts if part)
