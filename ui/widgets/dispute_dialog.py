"""Asks which of two versions holds, field by field; nothing is overwritten before."""

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QButtonGroup,
    QDialog,
    QGridLayout,
    QGroupBox,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QRadioButton,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import translate as _
from ui.widgets.dates import moment_text
from ui.widgets.scrolled import SHARE_OF_WINDOW, Scrolled, window_room

if TYPE_CHECKING:
    from adibas.sessions.conflicts import Choice
    from ui.disputes import Dispute, DisputeRow

LETTERS_IN_A_LINE = 72
CHOICES: "tuple[Choice, ...]" = ("theirs", "mine", "both")


class DisputeDialog(QDialog):
    """One group of choices a field; it can be saved once each of them is made."""

    def __init__(self, dispute: "Dispute", parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(_("Somebody else changed the same"))
        self._dispute = dispute
        self._is_decided = False
        explanation = QLabel(
            _(
                "While you were changing this, somebody else saved another version. Nothing was "
                "overwritten: choose what holds."
            ),
            self,
        )
        explanation.setWordWrap(True)
        self.groups = [_Fields(row, self) for row in dispute.rows]
        self.save, later = QPushButton(_("&Save"), self), QPushButton(_("&Later"), self)
        self.save.setProperty("main", "true")
        self.save.setEnabled(False)
        later.setDefault(True)
        self.save.clicked.connect(self._on_save)
        later.clicked.connect(self.reject)
        self.finished.connect(self._on_finished)
        for group in self.groups:
            group.choices.idToggled.connect(self._on_chosen)
        self._lay_out(explanation, later)

    def _lay_out(self, explanation: QLabel, later: QPushButton) -> None:
        inside = Scrolled(self)
        for group in self.groups:
            inside.column.addWidget(group)
        inside.column.addStretch(1)
        buttons = QHBoxLayout()
        buttons.addStretch(1)
        buttons.addWidget(later)
        buttons.addWidget(self.save)
        column = QVBoxLayout(self)
        column.setContentsMargins(24, 20, 24, 20)
        column.setSpacing(12)
        column.addWidget(explanation)
        column.addWidget(inside, 1)
        column.addLayout(buttons)
        wished = self.fontMetrics().averageCharWidth() * LETTERS_IN_A_LINE
        width = min(wished, round(SHARE_OF_WINDOW * window_room(self).width()))
        self.setMinimumWidth(width)
        text_px = width - column.contentsMargins().left() - column.contentsMargins().right()
        around_px = explanation.heightForWidth(text_px) + buttons.sizeHint().height()
        self.resize(width, inside.height_in(self, width, around_px + column.spacing()))

    def _on_chosen(self, _number: int, _is_on: bool) -> None:
        self.save.setEnabled(all(group.choices.checkedId() >= 0 for group in self.groups))

    def _on_save(self) -> None:
        self._is_decided = True
        choices = tuple(CHOICES[group.choices.checkedId()] for group in self.groups)
        self.accept()
        self._dispute.decide(choices)

    def _on_finished(self, _result: int) -> None:
        if not self._is_decided:
            self._dispute.put_off()


class _Fields(QGroupBox):
    """One field: who saved what and when, beside what was typed here."""

    def __init__(self, row: "DisputeRow", parent: QWidget) -> None:
        super().__init__(row.field, parent)
        self.choices = QButtonGroup(self)
        when = moment_text(row.changed_utc)
        theirs = _("{operator}, {when}").format(operator=row.operator or _("Somebody"), when=when)
        grid = QGridLayout(self)
        for number, (title, value) in enumerate(((theirs, row.theirs), (_("Yours"), row.mine))):
            button, text = QRadioButton(title, self), QLabel(value, self)
            button.setAccessibleName(f"{row.field}: {title}: {value}")
            text.setWordWrap(True)
            text.setTextFormat(Qt.TextFormat.PlainText)
            text.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            text.setAlignment(Qt.AlignmentFlag.AlignTop)
            self.choices.addButton(button, number)
            grid.addWidget(button, 0, number)
            grid.addWidget(text, 1, number)
            grid.setColumnStretch(number, 1)
        if row.can_keep_both:
            both = QRadioButton(_("Both, one below the other"), self)
            self.choices.addButton(both, CHOICES.index("both"))
            grid.addWidget(both, 2, 0, 1, 2)
