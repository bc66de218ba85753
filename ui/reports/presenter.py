"""What the report screen shows and writes. Knows nothing of Qt."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

from adibas.arrays import UInt8Array
from adibas.data.report import PictureChoice, SessionReport
from adibas.data.sessions import Session
from adibas.errors import AdibasError
from adibas.pipeline.session_comparison import is_earlier
from adibas.pipeline.stored_report import ReportWish, StoredReports, stored_report
from adibas.reports.batch import write_session_reports
from adibas.reports.facts import (
    Pairs,
    capture_facts,
    capture_names,
    comparison_facts,
    general_facts,
    session_facts,
)
from adibas.reports.pictures import draw_markers, picture_of
from adibas.sessions import SessionStore
from adibas.texts import describe, speaking, translate_plural
from adibas.texts import translate as _
from ui.ports import Job, JobControl
from ui.preferences import Preferences
from ui.workspace import Workspace

MOST_SESSIONS = 200
PREVIEW_HEIGHT_PX = 900


@dataclass(frozen=True, slots=True)
class SessionLine:
    """One session to choose: its id, the patient's name, when, and how many views it has."""

    session_id: str
    who: str
    session: Session
    is_chosen: bool


@dataclass(frozen=True, slots=True, eq=False)
class PreviewPage:
    """One view as the report will show it."""

    title: str
    picture_rgb: UInt8Array
    facts: Pairs


class ReportsView(Protocol):
    """The screen, as this presenter needs it."""

    def show_sessions(self, lines: tuple[SessionLine, ...], *, n_newest: int | None) -> None:
        """Offer sessions; those chosen are reported.

        Parameters
        ----------
        n_newest : int or None
            There are older ones than so many that were looked through; None: it is all of them.
        """

    def show_earlier(self, sessions: tuple[Session, ...], chosen: str) -> None:
        """Offer what the report can be compared with; none chosen: with nothing."""

    def show_wish(self, wish: ReportWish) -> None:
        """Show language, pictures and notes in use."""

    def show_preview(self, head: Pairs, pages: tuple[PreviewPage, ...]) -> None:
        """Show what the report of the first chosen session will say."""

    def show_no_preview(self, sentence: str) -> None:
        """Say why there is no preview."""

    def show_written(self, folder: Path | None) -> None:
        """Offer to open the folder of what was written; None = nothing yet."""

    def ask_export(self, session_id: str) -> None:
        """Ask how a session is handed over to other systems."""


class ReportsPresenter:
    """Keeps the choice of sessions, previews the first, and writes them all."""

    def __init__(self, view: ReportsView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self._wish = ReportWish(workspace.preferences.now.language)
        self._chosen: tuple[str, ...] = ()
        self._preview_job: Job | None = None
        self._is_seen = False
        self._seen_session: str | None = None
        self._is_language_chosen = False
        self._folder = ""
        self._ends = [
            workspace.session_changed.subscribe(self._on_session),
            workspace.preferences.changed.subscribe(self._on_preferences),
        ]
        view.show_wish(self._wish)
        view.show_written(None)

    def close(self) -> None:
        """Listen no more."""
        for end in self._ends:
            end()

    def enter(self) -> None:
        """Offer the sessions there are now; another one that is looked at is chosen alone."""
        self._is_seen = True
        session = self._workspace.session
        if session is not None and session.session_id != self._seen_session:
            self._chosen = (session.session_id,)
            self._seen_session = session.session_id
        self._offer_earlier()
        self._preview()
        self._show_sessions()

    def leave(self) -> None:
        """Note that nobody looks."""
        self._is_seen = False

    @property
    def folder(self) -> str:
        """Where reports were written last since the store was opened; empty before the first.

        It is written down nowhere: many folders are called after a patient.
        """
        return self._folder

    def choose_sessions(self, session_ids: tuple[str, ...]) -> None:
        """Report these."""
        if session_ids != self._chosen:
            self._chosen = session_ids
            self._offer_earlier()
            self._preview()

    def choose_earlier(self, session_id: str) -> None:
        """Tell what changed since this session; empty: nothing of that."""
        self._change(replace(self._wish, compared_with=session_id))

    def choose_language(self, language: str) -> None:
        """Write in this language, whatever the window speaks."""
        self._is_language_chosen = True
        self._change(replace(self._wish, language=language))

    def choose_pictures(self, pictures: PictureChoice) -> None:
        """Show so much of the patient; notes, in which people are named, follow."""
        with_notes = pictures is PictureChoice.AS_IS
        self._change(replace(self._wish, pictures=pictures, with_notes=with_notes))

    def choose_notes(self, *, with_notes: bool) -> None:
        """Tell the notes on the session, or not."""
        self._change(replace(self._wish, with_notes=with_notes))

    def write(self, folder: Path, kinds: tuple[str, ...]) -> None:
        """Write the chosen reports in every kind into a folder; nothing there is replaced."""
        if not self._chosen or not kinds:
            self._workspace.tell("warning", _("Choose a session, and a kind of file."))
            return
        store, chosen, wish = self._workspace.store, self._chosen, self._wish
        self._folder = str(folder)

        def work(control: JobControl) -> tuple[Path, ...]:
            store.note_export("report", *chosen)  # first: half a report has left the store, too
            reports = StoredReports(store, chosen, wish)
            return write_session_reports(reports, folder, kinds, control.progress)

        self._workspace.jobs.start(
            _("Writing reports"),
            work,
            lambda written: self._on_written(folder, written),
            stop="tells",
        )

    def export(self) -> None:
        """Hand the chosen session over to other systems; they take one at a time."""
        if len(self._chosen) == 1:
            self._view.ask_export(self._chosen[0])
        else:
            self._workspace.tell("warning", _("Choose one session: they are exported one by one."))

    def _on_written(self, folder: Path, written: tuple[Path, ...]) -> None:
        names = ", ".join(path.name for path in written)
        told = translate_plural(
            "Written: {names}", "{n} files are written: {names}", len(written)
        ).format(n=len(written), names=names)
        self._view.show_written(folder)
        self._workspace.tell("good", told)

    def _offer_earlier(self) -> None:
        """Offer the earlier sessions of the patient, where one session alone is reported."""
        found: list[Session] = []
        if len(self._chosen) == 1:
            self._workspace.attempt(
                lambda: found.extend(earlier_sessions(self._workspace.store, self._chosen[0]))
            )
        if self._wish.compared_with not in {one.session_id for one in found}:
            self._wish = replace(self._wish, compared_with="")
        self._view.show_earlier(tuple(found), self._wish.compared_with)

    def _on_session(self) -> None:
        if self._is_seen:
            self.enter()

    def _change(self, wish: ReportWish) -> None:
        self._wish = wish
        self._view.show_wish(wish)
        self._preview()

    def _on_preferences(self, now: Preferences) -> None:
        """Follow the window's language until another one was chosen."""
        if now.language != self._wish.language and not self._is_language_chosen:
            self._wish = replace(self._wish, language=now.language)
            self._view.show_wish(self._wish)
            if self._is_seen:
                self._preview()

    def _show_sessions(self) -> None:
        """List what can be reported; among many patients the names take a while."""
        store, current = self._workspace.store, self._workspace.session

        def work(_control: JobControl) -> tuple[tuple[tuple[Session, str], ...], int | None]:
            return _sessions_and_names(store, current)

        def done(listed: tuple[tuple[tuple[Session, str], ...], int | None]) -> None:
            found, n_newest = listed
            self._choose_of({one.session_id for one, _who in found})
            self._view.show_sessions(
                tuple(
                    SessionLine(one.session_id, who, one, one.session_id in self._chosen)
                    for one, who in found
                ),
                n_newest=n_newest,
            )
            if not found:
                self._view.show_no_preview(
                    _("No session has a capture yet. Take one on the capture screen.")
                )

        self._workspace.jobs.start(_("Listing the sessions"), work, done)

    def _choose_of(self, offered: set[str]) -> None:
        """Report no more what is gone or hidden; once it is looked at again, it is chosen again.

        The session that is looked at may be chosen before it has captures.
        """
        if (session := self._workspace.session) is not None:
            offered = offered | {session.session_id}
        if self._seen_session not in offered:
            self._seen_session = None
        self.choose_sessions(tuple(one for one in self._chosen if one in offered))

    def _preview(self) -> None:
        """Make the preview of the first chosen session, in place of one still in work."""
        if self._preview_job is not None and self._preview_job.is_running:
            self._preview_job.cancel()
        if not self._chosen:
            self._view.show_no_preview(_("Choose a session at the left."))
            return
        store, session_id, wish = self._workspace.store, self._chosen[0], self._wish

        def work(_control: JobControl) -> tuple[Pairs, tuple[PreviewPage, ...]]:
            return preview(stored_report(store, session_id, wish))

        def failed(error: AdibasError) -> None:
            self._view.show_no_preview(describe(error))

        self._preview_job = self._workspace.jobs.start(
            _("Making the preview"), work, lambda made: self._view.show_preview(*made), failed
        )


def earlier_sessions(store: SessionStore, session_id: str) -> tuple[Session, ...]:
    """Return what a session can be compared with, newest first."""
    session = store.sessions.get(session_id)
    return tuple(
        one
        for one in store.sessions.of_patient(session.patient)
        if one.capture_ids and is_earlier(one, session)
    )


def _sessions_and_names(
    store: SessionStore, current: Session | None
) -> tuple[tuple[tuple[Session, str], ...], int | None]:
    """Return the sessions that have captures, newest first, each with its patient's name.

    With them comes of how many they are where there are older ones.
    """
    newest = store.sessions.recent(MOST_SESSIONS + 1)
    sessions = list(newest[:MOST_SESSIONS])
    if current is not None and all(one.session_id != current.session_id for one in sessions):
        sessions.insert(0, current)
    names = store.patients.names()
    found = tuple((one, names.get(one.patient, one.patient)) for one in sessions if one.capture_ids)
    return found, MOST_SESSIONS if len(newest) > MOST_SESSIONS else None


def preview(report: SessionReport) -> tuple[Pairs, tuple[PreviewPage, ...]]:
    """Return what a report will say first, and its pictures, in the report's language."""
    with speaking(report.language):
        head = [*session_facts(report), *comparison_facts(report), *general_facts(report)]
        titles = capture_names(report)
        pages = tuple(
            PreviewPage(
                title=title[:1].upper() + title[1:],
                picture_rgb=draw_markers(
                    picture_of(capture.analysis, report.pictures, report.rotation_deg),
                    PREVIEW_HEIGHT_PX,
                ),
                facts=capture_facts(report, capture),
            )
            for title, capture in zip(titles, report.captures, strict=True)
        )
    return head, pages
