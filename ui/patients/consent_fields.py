"""What a consent is for, and who gives it."""

from PySide6.QtWidgets import QCheckBox, QComboBox, QLabel, QLineEdit, QVBoxLayout, QWidget

from adibas.data.patients import PURPOSES
from adibas.sessions.audit_words import PURPOSE_NAMES
from adibas.texts import translate as _
from ui.patients.content import ConsentEntry

PATIENT, GUARDIAN = 0, 1


class ConsentFields(QWidget):
    """Purposes, and the patient or a guardian by name."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._purposes = {purpose: QCheckBox(self) for purpose in PURPOSES}
        self._for, self._by, self._name_label = QLabel(self), QLabel(self), QLabel(self)
        self._giver, self.guardian = QComboBox(self), QLineEdit(self)
        self._giver.addItems(["", ""])
        self._by.setBuddy(self._giver)
        self._name_label.setBuddy(self.guardian)
        self._giver.currentIndexChanged.connect(self._show_guardian)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(8)
        column.addWidget(self._for)
        for box in self._purposes.values():
            column.addWidget(box)
        for widget in (self._by, self._giver, self._name_label, self.guardian):
            column.addWidget(widget)
        self.clear()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._for.setText(_("The consent is for:"))
        for purpose, box in self._purposes.items():
            box.setText(_(PURPOSE_NAMES[purpose]))
        self._by.setText(_("G&iven by"))
        self._giver.setItemText(PATIENT, _("The patient"))
        self._giver.setItemText(GUARDIAN, _("A guardian"))
        self._name_label.setText(_("Name of the &guardian"))

    def clear(self) -> None:
        """Begin anew: treatment, by the patient."""
        for purpose, box in self._purposes.items():
            box.setChecked(purpose == "treatment")
        self.guardian.clear()
        self.propose_guardian(is_guardian=False)
        self._show_guardian()

    def show_entry(self, entry: ConsentEntry) -> None:
        """Show what was entered before."""
        for purpose, box in self._purposes.items():
            box.setChecked(purpose in entry.purposes)
        self.propose_guardian(is_guardian=entry.is_guardian)
        self.guardian.setText(entry.guardian)

    def propose_guardian(self, *, is_guardian: bool) -> None:
        """Ask for a guardian, or for the patient."""
        self._giver.setCurrentIndex(GUARDIAN if is_guardian else PATIENT)

    def entry(self) -> ConsentEntry:
        """Return what is entered."""
        purposes = tuple(name for name, box in self._purposes.items() if box.isChecked())
        is_guardian = self._giver.currentIndex() == GUARDIAN
        return ConsentEntry(purposes, is_guardian, self.guardian.text())

    def field(self, name: str) -> QWidget | None:
        """Return the widget of a field of `ConsentEntry`."""
        fields: dict[str, QWidget] = {
            "purposes": self._purposes["treatment"],
            "guardian": self.guardian,
        }
        return fields.get(name)

    def _show_guardian(self) -> None:
        is_guardian = self._giver.currentIndex() == GUARDIAN
        self._name_label.setVisible(is_guardian)
        self.guardian.setVisible(is_guardian)
