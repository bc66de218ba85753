"""What begins a session, and below it the sessions that there are."""

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QLabel, QPushButton, QVBoxLayout, QWidget

from adibas.sessions.roles import Permission
from adibas.texts import translate as _
from ui.patients.content import History, PurgeQuestion, Thumbnail
from ui.patients.history_list import HistoryList
from ui.patients.purge_dialog import purge_dialog
from ui.widgets.flow import in_a_flow

if TYPE_CHECKING:  # the titles are read after the first patient is chosen
    from adibas.data.protocols import Wording

TWO = 2


class HistoryPanel(QWidget):
    """Three buttons, and a list."""

    start_asked = Signal()
    continue_asked = Signal()
    protocol_chosen = Signal(str)
    """Its name, of sessions that begin from now on; empty for none."""
    start_like_last_asked = Signal()
    compare_asked = Signal(str)
    """The id of the chosen session; empty for none."""
    export_asked = Signal(str)
    opened = Signal(str, object)
    """A session's id, and a capture's or None."""
    delete_asked = Signal(str)
    restore_asked = Signal(str)
    purge_asked = Signal(str)
    purge_confirmed = Signal(str)
    """A session's id."""
    repeat_called = Signal(str, bool)
    """A session's id, and whether it repeats the one before it."""
    pictures_wanted = Signal(tuple)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._history: History | None = None
        self._asked_of = ""
        self.start, self._continue, self._like_last = (QPushButton(self) for _n in range(3))
        self._open, self._delete, self._restore, self._purge = (
            QPushButton(self) for _n in range(4)
        )
        self._compare, self._export = QPushButton(self), QPushButton(self)
        self._repeat = QCheckBox(self)
        self._protocol, self._protocol_label = QComboBox(self), QLabel(self)
        self._protocol_label.setBuddy(self._protocol)
        self._protocols: tuple[tuple[str, Wording], ...] = ()
        self._chosen_protocol = ""
        self._title, self._empty = QLabel(self), QLabel(self)
        self.list = HistoryList(self)
        self.start.setProperty("main", "true")
        self._purge.setProperty("danger", "true")
        self._empty.setProperty("kind", "quiet")
        self._empty.setWordWrap(True)
        self._lay_out()
        self._connect()

    def _lay_out(self) -> None:
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(8)
        column.addWidget(self._protocol_label)
        column.addWidget(self._protocol)
        for button in (self.start, self._continue, self._like_last):
            button.setAutoDefault(True)  # Enter presses it
            column.addWidget(button)
        column.addSpacing(8)
        shown = (self._open, self._compare, self._export)
        actions = (*shown, self._delete, self._restore, self._purge)
        for button in actions:
            button.setAutoDefault(True)
        column.addWidget(self._title)
        column.addWidget(self._empty)
        column.addWidget(self.list, 1)
        column.addLayout(in_a_flow(*actions))
        column.addWidget(self._repeat)
        column.addStretch(0)

    def _connect(self) -> None:
        self.start.clicked.connect(self.start_asked)
        self._protocol.activated.connect(self._on_protocol)
        self._continue.clicked.connect(self.continue_asked)
        self._like_last.clicked.connect(self.start_like_last_asked)
        self._repeat.clicked.connect(
            lambda is_on: self._send(lambda one: self.repeat_called.emit(one, is_on))
        )
        self._compare.clicked.connect(
            lambda: self.compare_asked.emit(self.list.chosen_session() or "")
        )
        self.list.opened.connect(self.opened)
        self.list.shown_model.pictures_wanted.connect(self.pictures_wanted)
        self.list.selectionModel().currentChanged.connect(self._show_actions)
        for button, send in (
            (self._open, lambda one: self.opened.emit(one, None)),
            (self._export, self.export_asked.emit),
            (self._delete, self.delete_asked.emit),
            (self._restore, self.restore_asked.emit),
            (self._purge, self.purge_asked.emit),
        ):
            button.clicked.connect(lambda _checked, send=send: self._send(send))

    def for_roles(self) -> tuple[tuple[QWidget, Permission], ...]:
        """Return the buttons that are not for everybody."""
        return (
            (self._compare, Permission.COMPARE),
            (self._export, Permission.EXPORT),
            (self._delete, Permission.CHANGE_PATIENTS),
            (self._restore, Permission.CHANGE_PATIENTS),
            (self._purge, Permission.PURGE),
        )

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._protocol_label.setText(_("Pro&tocol of a new session"))
        self._protocol.setToolTip(
            _("Which landmarks are marked, and what is measured between them")
        )
        self._word_protocols()
        self.start.setText(_("&Start a session"))
        self.start.setToolTip(_("Start a session with the usual set-up (Ctrl+Enter)"))
        self._continue.setText(_("&Continue the last session"))
        self._like_last.setText(_("Start from the last session's set-&up"))
        self._like_last.setToolTip(_("The same sensor, markers and protocol as the last time"))
        self._title.setText(_("Sessions"))
        self._open.setText(_("O&pen"))
        self._open.setToolTip(_("Review this session (Enter)"))
        self._compare.setText(_("Co&mpare"))
        self._compare.setToolTip(_("See what changed between two sessions of this patient"))
        self._export.setText(_("Export..."))
        self._export.setToolTip(_("Hand this session over to other systems as FHIR or DICOM"))
        self._repeat.setText(_("Counts as a repeat"))
        self._repeat.setToolTip(
            _(
                "Since the session before on this day the markers were placed anew, and nothing "
                "was treated: the two tell how well measures repeat"
            )
        )
        self._delete.setText(_("Delete"))
        self._delete.setToolTip(_("Hide this session; it can be undone (Delete)"))
        self._restore.setText(_("Restore"))
        self._purge.setText(_("Remove for good"))
        self.list.setAccessibleName(_("Sessions of this patient"))
        self._show_empty()
        self.list.shown_model.retranslate()

    def show_history(self, history: History) -> None:
        self._history = history
        self.start.setEnabled(history.can_start)
        self._continue.setEnabled(history.can_continue)
        self._like_last.setEnabled(history.can_continue)
        self.list.show_sessions(history.sessions)
        self._show_empty()
        self.list.setVisible(bool(history.sessions))
        self._show_actions()

    def show_protocols(self, protocols: "tuple[tuple[str, Wording], ...]", chosen: str) -> None:
        self._protocols, self._chosen_protocol = protocols, chosen
        self._word_protocols()

    def show_current(self, session_id: str | None) -> None:
        self.list.shown_model.show_current(session_id)

    def show_thumbnails(self, thumbnails: dict[str, tuple[Thumbnail, ...]]) -> None:
        self.list.shown_model.show_thumbnails(thumbnails)

    def ask_purge(self, question: PurgeQuestion) -> None:
        dialog, session_id = purge_dialog(question, self), self._asked_of
        dialog.confirmed.connect(lambda: self.purge_confirmed.emit(session_id))
        dialog.open()

    def focus_start(self) -> None:
        """Lead to the main action; Enter presses it."""
        self.start.setFocus(Qt.FocusReason.TabFocusReason)

    def press_start(self) -> None:
        """Press the button that starts a session, where it is seen."""
        if self.start.isVisible():
            self.start.click()

    def delete_chosen(self) -> None:
        """Press the button that hides the chosen session, where it is seen."""
        if self._delete.isVisible():
            self._delete.click()

    def _word_protocols(self) -> None:
        self._protocol.clear()
        self._protocol.addItem(_("None: free measures"), "")
        for name, title in self._protocols:
            self._protocol.addItem(title.text, name)
        self._protocol.setCurrentIndex(max(self._protocol.findData(self._chosen_protocol), 0))

    def _on_protocol(self, index: int) -> None:
        self._chosen_protocol = self._protocol.itemData(index)
        self.protocol_chosen.emit(self._chosen_protocol)

    def _send(self, send: object) -> None:
        chosen = self.list.chosen_session()
        if chosen is not None and callable(send):
            self._asked_of = chosen
            send(chosen)

    def _show_empty(self) -> None:
        """Say that there is no session, and how one begins where that can be."""
        history = self._history
        can_start = history is not None and history.can_start
        begin = _("There is no session yet. Begin with “Start a session”.")
        self._empty.setText(begin if can_start else _("There is no session."))
        self._empty.setVisible(history is None or not history.sessions)

    def _n_comparable(self) -> int:
        """Return how many sessions there are with pictures."""
        sessions = () if self._history is None else self._history.sessions
        return sum(bool(one.capture_ids) and not one.is_deleted for one in sessions)

    def _show_actions(self) -> None:
        """Offer what fits the chosen session."""
        row = self.list.currentIndex().row()
        session = self.list.shown_model.session(row) if row >= 0 else None
        can_change = self._history is not None and self._history.can_change
        is_deleted = session is not None and session.is_deleted
        has_list = not self.list.isHidden()
        self._open.setVisible(has_list and not is_deleted)
        self._delete.setVisible(has_list and not is_deleted)
        self._restore.setVisible(has_list and is_deleted)
        self._purge.setVisible(has_list and is_deleted)
        self._compare.setVisible(has_list and not is_deleted and self._n_comparable() >= TWO)
        can_repeat = set() if self._history is None else self._history.can_repeat
        self._repeat.setVisible(session is not None and session.session_id in can_repeat)
        self._repeat.setChecked(session is not None and session.setup.is_repeat)
        self._repeat.setEnabled(can_change)
        self._export.setVisible(has_list and not is_deleted)
        self._export.setEnabled(session is not None and bool(session.capture_ids))
        self._open.setEnabled(session is not None)
        for button in (self._delete, self._restore, self._purge):
            button.setEnabled(session is not None and can_change)
