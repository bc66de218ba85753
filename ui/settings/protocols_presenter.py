"""Protocols as they are written: to read, to change, to save as one's own. Knows no Qt."""

from dataclasses import dataclass
from typing import Protocol

from adibas.errors import AdibasError
from adibas.measures.protocol_file import CheckedProtocol, read_protocol
from adibas.measures.protocol_store import (
    UNSAVED,
    new_protocol_text,
    own_folder,
    protocol_files,
    protocol_text,
    save_own_protocol,
)
from adibas.texts import describe
from adibas.texts import translate as _
from ui.ports import Job, JobControl
from ui.workspace import Workspace


@dataclass(frozen=True, slots=True)
class Mistake:
    """Where in the text, counted from 1, and what is wrong there."""

    line: int
    sentence: str


class ProtocolsView(Protocol):
    """The page, as this presenter needs it."""

    def show_names(self, names: tuple[str, ...], chosen: str, folder: str) -> None:
        """Offer protocols; `folder` is where own ones lie."""

    def show_text(self, text: str) -> None:
        """Show a protocol as it is written."""

    def show_changed(self, text: str) -> None:
        """Show a text that is not saved."""

    def show_check(self, mistakes: tuple[Mistake, ...], summary: str) -> None:
        """Show what is wrong, or else what the protocol holds."""


class ProtocolsPresenter:
    """Opens a protocol, checks every change beside the window, and saves what is right."""

    def __init__(self, view: ProtocolsView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self._job: Job | None = None
        self._chosen = ""
        """Empty: a new one."""
        self._has_text = False

    @property
    def chosen(self) -> str:
        """The protocol that was opened; empty for a new one."""
        return self._chosen

    def enter(self) -> None:
        """Offer the protocols; the first time one is opened."""
        names = tuple(sorted(protocol_files()))
        if self._has_text or not names:
            self._view.show_names(names, self._chosen, str(own_folder()))
            return
        self._view.show_names(names, names[0], str(own_folder()))
        self.open(names[0])

    def take_back(self, chosen: str, text: str) -> None:
        """Show what was typed into a protocol before the window was locked."""
        self._chosen, self._has_text = chosen, True
        self.enter()
        self._view.show_changed(text)
        self.check(text)

    def open(self, name: str) -> None:
        """Show the text of a protocol."""
        self._chosen, self._has_text = name, True

        def show() -> None:
            text = protocol_text(name)
            self._view.show_text(text)
            self.check(text)

        self._workspace.attempt(show)

    def begin(self) -> None:
        """Show a small protocol to begin a new one with."""
        self._chosen, self._has_text = "", True
        names = tuple(sorted(protocol_files()))
        self._view.show_names(names, "", str(own_folder()))
        text = new_protocol_text()
        self._view.show_text(text)
        self.check(text)

    def check(self, text: str) -> None:
        """Tell every mistake of a text, the newest text first."""
        if self._job is not None and self._job.is_running:
            self._job.cancel()

        def work(_control: JobControl) -> CheckedProtocol:
            return read_protocol(text, UNSAVED)

        self._job = self._workspace.jobs.start(_("Checking the protocol"), work, self._show)

    def save(self, text: str) -> None:
        """Write the text among this user's own protocols."""
        try:
            path = save_own_protocol(text, self._chosen)
        except AdibasError as error:
            self._workspace.report_problem(error)
            return
        self._chosen = path.stem
        self._view.show_text(text)
        self.enter()
        self._workspace.tell("good", _("Written: {names}").format(names=path.name))

    def _show(self, checked: CheckedProtocol) -> None:
        mistakes = tuple(
            Mistake(int(str(error.fields.get("line", 1))), describe(error))
            for error in checked.errors
        )
        summary = ""
        if checked.protocol is not None:
            summary = _("No mistake: {n_landmarks} landmarks, {n_measures} measures.").format(
                n_landmarks=len(checked.protocol.landmarks),
                n_measures=len(checked.protocol.measures),
            )
        self._view.show_check(mistakes, summary)
