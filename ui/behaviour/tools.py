"""The row of buttons above the video: what is opened, sought, saved and taken back."""

from collections.abc import Callable

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QComboBox, QInputDialog, QMenu, QPushButton, QVBoxLayout, QWidget

from adibas.pipeline.own_gestures import models_of, own_gestures
from adibas.texts import translate as _
from ui.behaviour.content import Desk
from ui.behaviour.file_dialogs import ask_open, ask_save, coding_filter
from ui.behaviour.sources import ALL, StoredChoice, titled
from ui.widgets.dates import moment_text
from ui.widgets.elided_label import ElidedLabel
from ui.widgets.flow import in_a_flow

BUTTONS = ("open", "find", "file", "scheme", "second", "undo", "redo")
KEYS = {"undo": "Ctrl+Z", "redo": "Ctrl+Shift+Z"}
NATIVE = QKeySequence.SequenceFormat.NativeText
SAVED_AS = (
    ("CSV", "csv"),
    ("Excel", "xlsx"),
    ("BORIS", "boris"),
    ("ELAN", "eaf"),
    ("BORIS", "tsv"),
)


class BehaviourTools(QWidget):
    """Buttons and their menus; nothing is decided here."""

    open_asked = Signal()
    stored_chosen = Signal(str)
    finding_asked = Signal(object)
    """(models): a tuple of `Path`."""
    learning_asked = Signal()
    labelling_asked = Signal()
    """Limbs are to be labelled, for a model of one's own."""
    map_asked = Signal()
    """The recording is to become a surface in 3-D."""
    coding_opened = Signal(object)
    coding_saved = Signal(object)
    scheme_edited = Signal()
    scheme_opened = Signal(object)
    scheme_saved = Signal(object)
    second_began = Signal(str)
    second_ended = Signal()
    section_asked = Signal()
    undone = Signal()
    redone = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._observer = ""
        self._name = ""
        self.title = ElidedLabel(self)
        self.title.setProperty("kind", "title")
        self.stored = QComboBox(self)
        self.buttons = {name: QPushButton(self) for name in BUTTONS}
        self._actions: dict[str, QAction] = {}
        self._menu("find", "shipped", "own", "model", "plain", "learn", "label", "map")
        self._menu("file", "open_coding", "save_coding", "section")
        self._menu("scheme", "edit", "open_scheme", "save_scheme")
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.title)
        column.addLayout(in_a_flow(self.buttons["open"], self.stored, *self._later_buttons()))
        self.buttons["find"].menu().aboutToShow.connect(self._offer_own)
        self._connect()

    def _later_buttons(self) -> list[QPushButton]:
        return [self.buttons[name] for name in BUTTONS[1:]]

    def _menu(self, name: str, *actions: str) -> None:
        menu = QMenu(self.buttons[name])
        for action in actions:
            self._actions[action] = menu.addAction("")
        self.buttons[name].setMenu(menu)

    def _connect(self) -> None:
        clicks: dict[str, Callable[[], None]] = {
            "open": self.open_asked.emit,
            "second": self._on_second,
            "undo": self.undone.emit,
            "redo": self.redone.emit,
        }
        for name, action in clicks.items():
            self.buttons[name].clicked.connect(lambda _on=False, action=action: action())
        chosen: dict[str, Callable[[], None]] = {
            "shipped": lambda: self.finding_asked.emit(models_of("shipped")),
            "plain": lambda: self.finding_asked.emit(()),
            "own": lambda: self.finding_asked.emit(models_of("own")),
            "model": self._ask_model,
            "learn": self.learning_asked.emit,
            "label": self.labelling_asked.emit,
            "map": self.map_asked.emit,
            "open_coding": self._ask_coding,
            "save_coding": self._ask_place,
            "section": self.section_asked.emit,
            "edit": self.scheme_edited.emit,
            "open_scheme": self._ask_scheme,
            "save_scheme": self._ask_scheme_place,
        }
        for name, action in chosen.items():
            self._actions[name].triggered.connect(lambda _on=False, action=action: action())
        self.stored.activated.connect(
            lambda index: self.stored_chosen.emit(self.stored.itemData(index))
        )

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        for name, text in _texts().items():
            self.buttons[name].setText(text)
        for name, text in _action_texts().items():
            self._actions[name].setText(text)
        for name, keys in KEYS.items():
            self.buttons[name].setToolTip(QKeySequence(keys).toString(NATIVE))
        self.stored.setAccessibleName(_("Recordings of the session"))
        self._word_second()

    def show_source(self, title: str, name: str) -> None:
        """Show which recording is open, and what copies are called."""
        self._name = name
        self.title.setText(title)

    def show_stored(self, choices: tuple[StoredChoice, ...]) -> None:
        """Offer the recordings of the session."""
        fill_stored(self.stored, choices)

    def show_desk(self, desk: Desk) -> None:
        """Offer what can be done now."""
        self.buttons["undo"].setEnabled(desk.can_undo)
        self.buttons["redo"].setEnabled(desk.can_redo)
        for name in ("edit", "open_scheme"):
            self._actions[name].setEnabled(not desk.is_locked)

    def show_blind(self, observer: str) -> None:
        """Show that a second observer codes blind; nobody: the first one codes."""
        self._observer = observer
        self.buttons["find"].setEnabled(not observer)
        self._actions["open_coding"].setEnabled(not observer)
        self._word_second()

    def show_finding(self, *, is_on: bool) -> None:
        """Show whether the program looks right now."""
        self.buttons["find"].setEnabled(not is_on and not self._observer)

    def _offer_own(self) -> None:
        self._actions["own"].setEnabled(bool(own_gestures()))

    def _word_second(self) -> None:
        text = _("&Second observer...") if not self._observer else _("End the &second coding")
        self.buttons["second"].setText(text)

    def _on_second(self) -> None:
        if self._observer:
            self.second_ended.emit()
            return
        dialog = QInputDialog(self)
        dialog.setWindowTitle(_("Second observer"))
        dialog.setLabelText(
            _(
                "Initials of the second observer. What is coded until now is hidden, and the "
                "scheme is locked, until the second coding is ended."
            )
        )
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.textValueSelected.connect(self.second_began)
        dialog.open()

    def _ask_model(self) -> None:
        name_filter = _("Models of gestures") + " (*.json)"
        title = _("Model of gestures")
        ask_open(self, title, name_filter, lambda path: self.finding_asked.emit((path,)))

    def _ask_coding(self) -> None:
        ask_open(self, _("Open a coding"), coding_filter(), self.coding_opened.emit)

    def _ask_place(self) -> None:
        filters = tuple(f"{name} (*.{ending})" for name, ending in SAVED_AS)
        ask_save(self, _("Save a copy of the coding"), filters, self._name, self.coding_saved.emit)

    def _ask_scheme(self) -> None:
        name_filter = _("Coding schemes") + " (*.json)"
        ask_open(self, _("Open a coding scheme"), name_filter, self.scheme_opened.emit)

    def _ask_scheme_place(self) -> None:
        filters = (_("Coding schemes") + " (*.json)",)
        title = _("Save the coding scheme")
        ask_save(self, title, filters, "ethogram", self.scheme_saved.emit)


def stored_title(one: StoredChoice) -> str:
    """Return what a stored recording is called, the day as the window writes it."""
    return titled(moment_text(one.created_utc), one.view)


def fill_stored(chooser: QComboBox, choices: tuple[StoredChoice, ...]) -> None:
    """Offer the recordings of the session; the first line is none of them."""
    chooser.clear()
    chooser.addItem(_("Recordings of the session"), "")
    for one in choices:
        text = _("{moment}, {seconds} s").format(
            moment=stored_title(one), seconds=round(one.duration_s)
        )
        chooser.addItem(text, one.recording_id)
    if len(choices) > 1:
        chooser.addItem(_("All of them, one after another"), ALL)
    chooser.setVisible(bool(choices))


def _texts() -> dict[str, str]:
    return {
        "open": _("&Open..."),
        "find": _("Find e&vents"),
        "file": _("Cod&ing"),
        "scheme": _("S&cheme"),
        "undo": _("&Undo"),
        "redo": _("&Redo"),
    }


def _action_texts() -> dict[str, str]:
    return {
        "shipped": _("With the five gestures of the program"),
        "own": _("With the gestures that were learned here"),
        "model": _("With a model of gestures..."),
        "plain": _("Changes of posture and times out of view alone"),
        "learn": _("Learn a gesture from what is coded..."),
        "label": _("Label limbs for a model of your own..."),
        "map": _("Map in 3-D what the camera saw..."),
        "open_coding": _("Open a coding..."),
        "save_coding": _("Save a copy..."),
        "section": _("Mark a section..."),
        "edit": _("Change the coding scheme..."),
        "open_scheme": _("Open a coding scheme..."),
        "save_scheme": _("Save the coding scheme..."),
    }
