"""Protocols as they are written: to read, to change, to save as one's own. Knows no Qt."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from adibas.errors import AdibasError
from adibas.measures.protocol_edits import (
    NewEntry,
    NewMeasure,
    landmarks_of,
    with_landmark,
    with_measure,
)
from adibas.measures.protocol_file import CheckedProtocol, read_protocol
from adibas.measures.protocol_store import (
    UNSAVED,
    delete_own_protocol,
    is_own_protocol,
    new_protocol_text,
    own_folder,
    protocol_files,
    protocol_text,
    save_own_protocol,
)
from adibas.texts import describe, translate_plural
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

    def show_own(self, *, is_own: bool) -> None:
        """Show whether the chosen protocol is this user's own: those alone can be deleted."""

    def show_text(self, text: str) -> None:
        """Show a protocol as it is written."""

    def show_changed(self, text: str) -> None:
        """Show a text that is not saved."""

    def ask_landmark(self, take: Callable[[NewEntry], None]) -> None:
        """Ask for a landmark to be added."""

    def ask_measure(
        self, landmarks: Mapping[str, str], take: Callable[[NewEntry, NewMeasure], None]
    ) -> None:
        """Ask for a measure to be added between these landmarks, names by id."""

    def show_check(self, mistakes: tuple[Mistake, ...], summary: str) -> None:
        """Show what is wrong, or else what the protocol holds."""

    def confirm(self, question: str, consent: str, act: Callable[[], None]) -> None:
        """Ask, and act when the answer is yes."""


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
        names = self._names()
        if self._has_text or not names:
            self._show_names()
        else:
            self.open(names[0])
            self._show_names()

    def take_back(self, chosen: str, text: str) -> None:
        """Show what was typed into a protocol before the window was locked."""
        self._chosen, self._has_text = chosen, True
        self.enter()
        self._view.show_changed(text)
        self.check(text)

    def open(self, name: str) -> None:
        """Show the text of a protocol."""
        self._chosen, self._has_text = name, True
        self._view.show_own(is_own=is_own_protocol(name))

        if not self._workspace.attempt(lambda: self._show_text(protocol_text(name))):
            self._show_text("")  # and not that of the one before under this name

    def begin(self) -> None:
        """Show a small protocol to begin a new one with."""
        self._chosen, self._has_text = "", True
        self._show_names()
        self._show_text(new_protocol_text())

    def check(self, text: str) -> None:
        """Tell every mistake of a text, the newest text first."""
        if self._job is not None and self._job.is_running:
            self._job.cancel()

        def work(_control: JobControl) -> CheckedProtocol:
            return read_protocol(text, UNSAVED)

        self._job = self._workspace.jobs.start(_("Checking the protocol"), work, self._show)

    def ask_landmark(self, text: str) -> None:
        """Ask for a landmark to be added to a text that can be read."""

        def ask() -> None:
            landmarks_of(text)  # a text that cannot be read is told before the form is filled in
            self._view.ask_landmark(lambda entry: self._add(lambda: with_landmark(text, entry)))

        self._workspace.attempt(ask)

    def ask_measure(self, text: str) -> None:
        """Ask for a measure to be added to a text that can be read."""

        def ask() -> None:
            self._view.ask_measure(
                landmarks_of(text),
                lambda entry, measure: self._add(lambda: with_measure(text, entry, measure)),
            )

        self._workspace.attempt(ask)

    def _add(self, changed: Callable[[], str]) -> None:
        def show() -> None:
            text = changed()
            self._view.show_changed(text)
            self.check(text)

        self._workspace.attempt(show)

    def save(self, text: str) -> None:
        """Write the text among this user's own protocols."""
        try:
            path = save_own_protocol(text, self._chosen)
        except AdibasError as error:
            self._workspace.report_problem(error)
            return
        self._chosen, self._has_text = path.stem, True
        self._view.show_text(text)
        self._show_names()
        self._workspace.tell("good", _("Written: {names}").format(names=path.name))

    def ask_delete(self, text: str) -> None:
        """Ask whether the chosen protocol of one's own is to go; one that sessions follow stays.

        Parameters
        ----------
        text : str
            What stands on the page: it stays there, so that saving it brings the protocol back.
        """
        name = self._chosen
        if not is_own_protocol(name):
            return
        n = self._workspace.store.sessions.n_following(name)
        if n:
            told = translate_plural(
                "{n} session follows the protocol {name}, and would lose its measures. It stays.",
                "{n} sessions follow the protocol {name}, and would lose their measures. It stays.",
                n,
            )
            self._workspace.tell("warning", told.format(n=n, name=name))
            return
        question = _(
            "Delete the protocol {name}? Its text stays on the page until you leave it: saved, it "
            "is back."
        )
        self._view.confirm(
            question.format(name=name), _("Delete"), lambda: self._delete(name, text)
        )

    def _delete(self, name: str, text: str) -> None:
        if self._workspace.attempt(lambda: delete_own_protocol(name)):
            self.take_back("", text)
            self._workspace.tell("good", _("{name} was deleted.").format(name=name))

    def _show_text(self, text: str) -> None:
        self._view.show_text(text)
        self.check(text)

    def _names(self) -> tuple[str, ...]:
        return tuple(sorted(protocol_files()))

    def _show_names(self) -> None:
        self._view.show_names(self._names(), self._chosen, str(own_folder()))
        self._view.show_own(is_own=is_own_protocol(self._chosen))

    def _show(self, checked: CheckedProtocol) -> None:
        mistakes = tuple(
            Mistake(int(str(error.fields.get("line", 1))), describe(error))
            for error in checked.errors
        )
        summary = ""
        if checked.protocol is not None:
            summary = _no_mistake(len(checked.protocol.landmarks), len(checked.protocol.measures))
        self._view.show_check(mistakes, summary)


def _no_mistake(n_landmarks: int, n_measures: int) -> str:
    landmarks = translate_plural("{n} landmark", "{n} landmarks", n_landmarks)
    measures = translate_plural("{n} measure", "{n} measures", n_measures)
    return _("No mistake: {landmarks}, {measures}.").format(
        landmarks=landmarks.format(n=n_landmarks), measures=measures.format(n=n_measures)
    )
