"""A question before something that cannot be taken back as easily; Escape and Enter keep all."""

from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMessageBox, QWidget

from adibas.texts import translate as _


def ask(parent: QWidget, question: str, consent: str, act: Callable[[], None]) -> None:
    """Do `act` when the button that says `consent` is chosen."""
    box = QMessageBox(parent)
    box.setIcon(QMessageBox.Icon.Question)
    box.setWindowTitle(consent.replace("&", ""))
    box.setText(question)
    yes = box.addButton(consent, QMessageBox.ButtonRole.DestructiveRole)
    yes.setProperty("danger", "true")
    box.setDefaultButton(box.addButton(_("Cancel"), QMessageBox.ButtonRole.RejectRole))
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    # Qt would look a bound `super().reject` up by its name, and come to the one that asks again.
    yes.clicked.connect(lambda _is_checked: act())
    box.open()
