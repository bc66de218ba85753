"""Codings and schemes in files, and the second observer. Knows nothing of Qt."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from adibas.behaviour.editing import Draft, History, with_ethogram
from adibas.data.coding import Coding
from adibas.errors import AdibasError, BehaviourError
from adibas.pipeline.coding_drafts import DraftPlace, new_draft
from adibas.pipeline.coding_files import for_file, read_for
from adibas.pipeline.draft_history import note_blind, read_history
from adibas.recordings.ethogram_json import read_ethogram, write_ethogram
from adibas.texts import describe, spoken_language
from adibas.texts import translate as _
from ui.behaviour.coding_presenter import CodingPresenter
from ui.behaviour.ports import Keeper, Source
from ui.behaviour.scheme import SchemeFields, ethogram_of, kept_names
from ui.workspace import Workspace


class FilesView(Protocol):
    """The screen, as this presenter needs it."""

    def show_blind(self, observer: str) -> None:
        """Show that a second observer codes blind; nobody: the first one codes."""


class FilesPresenter:
    """Opens and saves what was coded; puts the first coding away while a second observer codes.

    Parameters
    ----------
    revealed : callable
        Called with the coding of the second observer when he is done.
    note_export : callable
        Called before anything is written.
    """

    def __init__(
        self,
        view: FilesView,
        workspace: Workspace,
        coding: CodingPresenter,
        keeper: Keeper,
        revealed: Callable[[Coding], None],
        note_export: Callable[[], None],
    ) -> None:
        self._view = view
        self._workspace = workspace
        self._coding = coding
        self._keeper = keeper
        self._revealed = revealed
        self._note_export = note_export
        self._source: Source | None = None
        self._first: History[Draft] | None = None

    def use(
        self, source: Source, first: History[Draft], observer: str, second: History[Draft] | None
    ) -> None:
        """Code this recording from now on.

        Parameters
        ----------
        source : Source
        first : History of Draft
            Of the first observer.
        observer : str
            Who coded blind when the recording was left, and goes on; empty for nobody.
        second : History of Draft or None
            What he coded up to now.
        """
        self._source, self._first = source, None
        if observer:
            blind = second or History(_empty(first.now, observer))
            self._open(blind, source.place_for(observer), observer)
            self._first = first
        else:
            self._open(first, source.place_for(""), "")

    def open_coding(self, path: Path) -> None:
        """Take a coding from a file in place of what is coded; it can be undone."""
        draft = self._coding.draft
        if draft is None or self._coding.is_blind:
            return
        name, observed_ms = draft.coding.name, (draft.coding.begin_ms, draft.coding.end_ms)
        scheme = draft.coding.ethogram if draft.coding.ethogram.is_locked else None
        source = self._source

        def taken(found: Coding) -> None:
            if source is self._source and not self._coding.is_blind:
                self._coding.edit(lambda old: _with_coding(old, found))
                self._workspace.tell("good", _("{file} is open.").format(file=path.name))

        self._workspace.jobs.start(
            _("Opening {name}").format(name=path.name),
            lambda _control: read_for(path, name, observed_ms, scheme),
            taken,
        )

    def save_as(self, path: Path) -> None:
        """Write a copy of what is coded, in the format that the ending names."""
        coding = self._coding.coding()
        if coding is None:
            return

        def save() -> None:
            from adibas.reports.codings import write_codings

            self._note_export()
            write_codings(path, [for_file(coding, path)], spoken_language())
            self._workspace.tell("good", _("{file} is written.").format(file=path.name))

        self._workspace.attempt(save)

    def open_scheme(self, path: Path) -> None:
        """Code by the scheme of a file from now on."""
        self._workspace.attempt(lambda: self._coding.use_ethogram(read_ethogram(path)))

    def save_scheme(self, path: Path) -> None:
        """Write the coding scheme."""
        draft = self._coding.draft
        if draft is not None:
            scheme = draft.coding.ethogram
            self._workspace.attempt(lambda: write_ethogram(path, scheme))

    def change_scheme(self, fields: SchemeFields) -> str:
        """Code by the scheme that was typed; return what is wrong with it, nothing if all is well.

        What is coded takes the new names.
        """
        draft = self._coding.draft
        if draft is None:
            return ""
        try:
            scheme = ethogram_of(fields, draft.coding.ethogram)
            changed = with_ethogram(draft, scheme, kept_names(fields))
        except AdibasError as error:
            return describe(error)
        self._coding.edit(lambda _old: changed)
        return ""

    def begin_blind(self, observer: str) -> None:
        """Let a second observer code: he sees nothing of the first one, and the scheme is locked.

        What he coded another day is taken up. Until the second coding is ended he sees nothing of
        the first one, also where the recording is opened anew.
        """
        source, first = self._source, self._coding.history
        if source is None or first is None or self._coding.is_blind:
            return
        initials = observer.strip()

        def begin() -> None:
            if initials in ("", first.now.coding.observer):
                raise BehaviourError("A second observer has initials of his own. Type other ones.")
            self._keeper.flush()
            place = source.place_for(initials)
            kept = read_history(place)
            second = History(_empty(first.now, initials)) if kept is None else kept.history
            note_blind(source.place_for(""), initials)
            self._open(second, place, initials)
            self._first = first

        self._workspace.attempt(begin)

    def end_blind(self) -> None:
        """Show the first observer's coding again, and that of the second one beside it."""
        source, first, second = self._source, self._first, self._coding.coding()
        if source is None or first is None or second is None:
            return

        def end() -> None:
            note_blind(source.place_for(""), "")
            self._open(first, source.place_for(""), "")
            self._first = None
            self._revealed(second)

        self._workspace.attempt(end)

    def _open(self, history: History[Draft], place: DraftPlace, observer: str) -> None:
        self._coding.open(history, place, observer)
        self._view.show_blind(observer)


def _with_coding(draft: Draft, found: Coding) -> Draft:
    """Return the draft with another coding; one without a scheme keeps the one in use."""
    if not found.ethogram.behaviours:
        found = replace(found, ethogram=draft.coding.ethogram)
    return replace(draft, coding=replace(found, name=draft.coding.name), begun=())


def _empty(draft: Draft, observer: str) -> Draft:
    """Return a draft of the same session and scheme, locked, in which nothing is coded."""
    coding = draft.coding
    scheme = replace(coding.ethogram, is_locked=True)
    blank = new_draft(coding.name, (coding.begin_ms, coding.end_ms), scheme, observer)
    return replace(blank, coding=replace(blank.coding, sections=coding.sections))
