"""Learns a gesture: its examples, how well it is known, and by which joints."""

from collections.abc import Mapping

from PySide6.QtCore import QSize
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import translate as _
from ui.behaviour.body_figure import BodyFigure
from ui.behaviour.learning_presenter import LearningPresenter, Marked, marked_text
from ui.behaviour.tables import TextTable
from ui.behaviour.text_table import TextTableView
from ui.theme import Theme
from ui.widgets.flow import in_a_flow
from ui.widgets.scrolled import Scrolled

USUAL_LETTERS, USUAL_LINES = 100, 30
Standard = QDialogButtonBox.StandardButton


class LearnDialog(QDialog):
    """Examples at the left, the figure at the right; what is kept is looked for at once."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._marked, self._name = QComboBox(self), QLineEdit(self)
        self._labels = [QLabel(self) for _field in range(2)]
        self._told, self._result, self._side = (QLabel(self) for _text in range(3))
        for label in (self._told, self._result, self._side):
            label.setWordWrap(True)
        self._examples = TextTableView(self)
        self._figure = BodyFigure(theme, self)
        self._learn, self._own, self._forget = QPushButton(self), QComboBox(self), QPushButton(self)
        self._box = QDialogButtonBox(Standard.Ok | Standard.Cancel, self)
        self._is_learning = self._is_learned = False
        self._lay_out()
        self.retranslate()

    def _lay_out(self) -> None:
        form = QFormLayout()
        form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        for label, part in zip(self._labels, (self._marked, self._name), strict=True):
            label.setBuddy(part)
            form.addRow(label, part)
        left = Scrolled(self)
        left.column.addWidget(self._told)
        left.column.addLayout(form)
        left.column.addWidget(self._examples, 1)
        left.column.addLayout(in_a_flow(self._learn))
        left.column.addWidget(self._result)
        right = QVBoxLayout()
        right.addWidget(self._figure, 1)
        right.addWidget(self._side)
        across = QHBoxLayout()
        across.setSpacing(16)
        across.addWidget(left, 3)
        across.addLayout(right, 2)
        column = QVBoxLayout(self)
        column.addLayout(across, 1)
        column.addLayout(in_a_flow(self._own, self._forget))
        column.addWidget(self._box)
        letters, parent = self.fontMetrics(), self.parentWidget()
        wanted = QSize(USUAL_LETTERS * letters.averageCharWidth(), USUAL_LINES * letters.height())
        self.resize(wanted if parent is None else wanted.boundedTo(parent.window().size()))

    def bind(self, presenter: LearningPresenter) -> None:
        """Send what the user does to `presenter`, and own it."""
        self._presenter = presenter
        self._marked.activated.connect(self._on_marked)
        self._name.textChanged.connect(lambda _text: self._allow())
        self._learn.clicked.connect(lambda: presenter.learn(self._name.text().strip()))
        self._forget.clicked.connect(lambda: presenter.forget(self._own.currentIndex()))
        self._box.accepted.connect(lambda: presenter.keep(self._name.text().strip()))
        self._box.rejected.connect(self.reject)
        self.finished.connect(lambda _code: presenter.close())

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.setWindowTitle(_("Learn a gesture"))
        self._told.setText(
            _(
                "Code every time that somebody does it as a state, from its begin to its end: "
                "what is not marked counts as something else."
            )
        )
        texts = (_("&Examples"), _("&Name of the gesture"))
        for label, text in zip(self._labels, texts, strict=True):
            label.setText(text)
        self._examples.setAccessibleName(_("Examples"))
        self._learn.setText(_("&Learn"))
        self._side.setText(_("Seen from the front: the person's left is at the right."))
        self._own.setAccessibleName(_("Gestures that were learned here"))
        self._forget.setText(_("&Forget this gesture"))
        self._box.button(Standard.Ok).setText(_("&Keep it, and find it here"))
        self._box.button(Standard.Cancel).setText(_("Cancel"))
        self._allow()

    def unsaved(self) -> tuple[str, ...]:
        """Name the gesture that was learned: one that is kept closes the dialog."""
        return (_("The gesture that was learned"),) if self._is_learned else ()

    def show_marked(self, marked: tuple[Marked, ...], chosen: str) -> None:
        self._marked.clear()
        for one in marked:
            self._marked.addItem(marked_text(one), one.behaviour)
        self._marked.setCurrentIndex(self._marked.findData(chosen))
        self._name.setText(chosen)
        if not marked:
            self._result.setText(_("No state is coded in this recording yet."))

    def show_examples(self, table: TextTable) -> None:
        self._examples.show_table(table)
        self._allow()

    def show_learning(self, *, is_on: bool) -> None:
        self._is_learning = is_on
        if is_on:
            self._result.setText(_("Learning..."))
        elif not self._is_learned:
            self._result.setText("")
        self._allow()

    def show_result(self, sentence: str, shares: Mapping[str, float]) -> None:
        self._is_learned = bool(sentence)
        self._result.setText(sentence)
        self._figure.show_shares(shares)
        self._allow()

    def show_own(self, names: tuple[str, ...]) -> None:
        self._own.clear()
        self._own.addItems(list(names))
        for part in (self._own, self._forget):
            part.setVisible(bool(names))

    def finish(self) -> None:
        self.accept()

    def _allow(self) -> None:
        may = self._marked.count() > 0 and bool(self._name.text().strip())
        self._learn.setEnabled(may and not self._is_learning)
        is_done = self._is_learned and not self._is_learning
        self._box.button(Standard.Ok).setEnabled(may and is_done)

    def _on_marked(self, index: int) -> None:
        behaviour = self._marked.itemData(index)
        self._name.setText(behaviour)
        self._presenter.choose(behaviour)
