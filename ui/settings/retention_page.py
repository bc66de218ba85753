"""How long patients are kept, who would go by that, and their removal."""

from functools import partial

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QFormLayout,
    QGroupBox,
    QLabel,
    QPlainTextEdit,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from adibas.sessions.defaults import ADULT_AGE
from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.preferences import MOST_RETENTION_YEARS, Preferences
from ui.settings.preference_page import PreferencePage
from ui.settings.retention_presenter import RetentionPresenter
from ui.widgets.number_fields import WholeNumberField
from ui.widgets.typed_consent import TypedConsent

RESULT_HEIGHT = 120


class RetentionPage(PreferencePage):
    """One group: the rules, the list, and a button that asks for a word before it removes."""

    looked = Signal()
    removed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._n_over = 0
        self._group, self._note = QGroupBox(self), QLabel(self)
        self._years, self._age = WholeNumberField(self), WholeNumberField(self)
        self._years.setRange(1, MOST_RETENTION_YEARS)
        self._age.setRange(ADULT_AGE, MOST_RETENTION_YEARS)
        self._labels = [QLabel(self) for _ in range(2)]
        self._look, self._remove = QPushButton(self), QPushButton(self)
        self._remove.setProperty("danger", "true")
        self._note.setWordWrap(True)
        self._note.setProperty("kind", "quiet")
        self._result = QPlainTextEdit(self)
        self._result.setReadOnly(True)
        self._result.setFixedHeight(RESULT_HEIGHT)
        for part in (self, self._group):
            part.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        self._lay_out()
        self.clear()
        self._years.valueChanged.connect(partial(self.changed.emit, "retention_years"))
        self._age.valueChanged.connect(partial(self.changed.emit, "child_until_age"))
        self._look.clicked.connect(self.looked)
        self._remove.clicked.connect(self._ask)
        self.retranslate()

    def _lay_out(self) -> None:
        form = QFormLayout(self._group)
        form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        form.addRow(self._note)
        for label, field in zip(self._labels, (self._years, self._age), strict=True):
            label.setBuddy(field)
            form.addRow(label, field)
        for part in (self._look, self._result, self._remove):
            form.addRow(part)
        column = QVBoxLayout(self)
        column.setContentsMargins(9, 4, 9, 4)
        column.addWidget(self._group)

    def bind(self, presenter: RetentionPresenter) -> None:
        """Send what is wanted to the presenter, and own it."""
        self._presenter = presenter
        self.changed.connect(lambda name, value: presenter.change(**{name: value}))
        self.looked.connect(presenter.look)
        self.removed.connect(presenter.remove)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._group.setTitle(_("How long patients are kept"))
        self._note.setText(
            _(
                "No legal advice: the law in force at the clinic decides. Nothing is removed "
                "automatically."
            )
        )
        texts = (_("Years after the last session"), _("Children at least up to the age of"))
        for label, text in zip(self._labels, texts, strict=True):
            label.setText(text)
        self._look.setText(_("Whose time is over?"))
        self._remove.setText(_("Remove them for good..."))
        self._result.setAccessibleName(_("Whose time is over"))
        self.clear()  # it was said in the language before

    def show_rules(self, preferences: Preferences) -> None:
        """Show how long patients are kept."""
        self._years.show_value(preferences.retention_years)
        self._age.show_value(preferences.child_until_age)

    def show_read_only(self, *, is_read_only: bool) -> None:
        """Offer no removal where nothing can be changed."""
        self._remove.setEnabled(not is_read_only)

    def show_over(self, lines: tuple[str, ...]) -> None:
        """Show whose time is over, a line each; they can be removed now."""
        self._n_over = len(lines)
        self._result.setPlainText("\n".join(lines))
        self._result.show()
        self._remove.show()

    def show_nobody(self, sentence: str) -> None:
        """Say that there is nobody, or what became of them."""
        self._result.setPlainText(sentence)
        self._result.show()
        self._remove.hide()

    def clear(self) -> None:
        """Show nothing: another list would come now."""
        self._result.clear()
        self._result.hide()
        self._remove.hide()

    def _ask(self) -> None:
        n = self._n_over
        told = translate_plural(
            "{n} patient will be removed with all sessions, pictures and recordings. Nobody can "
            "bring them back; backups still hold them.",
            "{n} patients will be removed with all sessions, pictures and recordings. Nobody can "
            "bring them back; backups still hold them.",
            n,
        )
        dialog = TypedConsent(told.format(n=n), str(n), self)
        dialog.confirmed.connect(self.removed)
        dialog.open()
