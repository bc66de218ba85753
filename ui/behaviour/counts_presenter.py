"""What is counted in the coding, and how far two observers agree. Knows nothing of Qt."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from adibas.behaviour.agreement import AgreementParams
from adibas.behaviour.sampling import SAMPLINGS
from adibas.data.coding import MS_PER_S, Coding
from adibas.pipeline.behaviour import divided
from adibas.pipeline.behaviour_agreement import AgreementReport, compare_codings
from adibas.pipeline.coding_files import read_for
from adibas.texts import decimal_text, spoken_language, translate_plural
from adibas.texts import translate as _
from ui.behaviour.coding_presenter import CodingPresenter
from ui.behaviour.finding_presenter import FindingPresenter
from ui.behaviour.measured import (
    MEASURED,
    HeatMap,
    People,
    Raster,
    heat_map,
    measured_table,
    of_person,
    people_of,
    raster,
)
from ui.behaviour.tables import TextTable, agreement_table, counted_table
from ui.ports import JobControl
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.pipeline.behaviour import BehaviourAnalysis

PLOTS = ("raster", "activity")
TABLES = ("totals", "bins", "transitions", "events", *SAMPLINGS, *MEASURED, *PLOTS)
BY_PERSON = ("joints", "paths", "bands", "activity")
"""Of which one person alone can be shown; events tell their subjects."""
EVERYBODY = 0
IN_INTERVALS = ("bins", *SAMPLINGS, "paths", "activity")
USUAL_BIN_S = 60.0


class CountsView(Protocol):
    """The screen, as this presenter needs it."""

    def show_counts(self, table: TextTable) -> None:
        """Show what is counted."""

    def show_plot(self, content: Raster | HeatMap | None) -> None:
        """Show what happened over time; None where nothing is known."""

    def show_people(self, people: People, chosen: int) -> None:
        """Offer one person's activity, or everybody's; no people: nothing to choose."""

    def show_unmeasured(self, *, is_unmeasured: bool) -> None:
        """Say that the program has not looked at the recording yet."""

    def show_agreement(self, table: TextTable, sentence: str) -> None:
        """Show how far two observers agree, and what is to be said of it."""


class CountsPresenter:
    """Counts when the page is seen, and compares when asked.

    Parameters
    ----------
    note_export : callable
        Called before anything is written.
    """

    def __init__(
        self,
        view: CountsView,
        workspace: Workspace,
        coding: CodingPresenter,
        finding: FindingPresenter,
        note_export: Callable[[], None],
    ) -> None:
        self._view = view
        self._workspace = workspace
        self._coding = coding
        self._finding = finding
        self._note_export = note_export
        self._kind = TABLES[0]
        self._person = EVERYBODY
        self._bin_ms = round(USUAL_BIN_S * MS_PER_S)
        self._is_seen = False
        self._other: Coding | None = None
        self._params = AgreementParams()
        self.report: AgreementReport | None = None
        self._is_comparing = False
        self._is_stale = False
        coding.changed.subscribe(self._on_changed)
        finding.found.subscribe(self._count)

    def set_seen(self, *, is_seen: bool) -> None:
        """Count from now on, or no more."""
        self._is_seen = is_seen
        self._count()

    def show(self) -> None:
        """Say everything again, in the language in use."""
        self._count()
        if self.report is not None:
            self._show(self.report)

    def choose_table(self, kind: str) -> None:
        """Show another table."""
        self._kind = kind
        self._count()

    def choose_person(self, person: int) -> None:
        """Show the activity of one person, or of everybody."""
        self._person = person
        self._count()

    def set_bin(self, seconds: float) -> None:
        """Count in bins of this length."""
        self._bin_ms = max(round(seconds * MS_PER_S), 1)
        self._count()

    def write(self, path: Path) -> None:
        """Write what is counted, and what the program measured if it looked at the recording."""
        coding = self._coding.coding()
        if coding is None:
            return
        analysis, bin_ms, language = self._finding.analysis, self._bin_ms, spoken_language()
        self._write(path, lambda: _write(path, coding, analysis, bin_ms, language))

    def compare_file(self, path: Path) -> None:
        """Compare with the coding of another observer."""
        draft = self._coding.draft
        if draft is None or self._coding.is_blind:
            return
        name, observed_ms = draft.coding.name, (draft.coding.begin_ms, draft.coding.end_ms)
        self._workspace.jobs.start(
            _("Opening {name}").format(name=path.name),
            lambda _control: read_for(path, name, observed_ms),
            self.compare,
        )

    def compare(self, other: Coding) -> None:
        """Compare with this coding from now on."""
        if not self._coding.is_blind:
            self._other = other
            self._compare()

    def set_params(self, params: AgreementParams) -> None:
        """Compare in this way from now on."""
        self._params = params
        self._compare()

    def forget(self) -> None:
        """Compare no more: another recording is open, or somebody codes blind."""
        self._other, self.report = None, None
        self._view.show_agreement(TextTable(), "")

    def write_agreement(self, path: Path) -> None:
        """Write all figures and disagreements as a workbook."""
        report, language = self.report, spoken_language()
        if report is None:
            return

        def write() -> None:
            from adibas.reports.agreement_excel import write_agreement_workbook

            write_agreement_workbook(report, path, language)

        self._write(path, write)

    def _write(self, path: Path, write: Callable[[], None]) -> None:
        def work(_control: JobControl) -> None:
            self._note_export()
            write()

        self._workspace.jobs.start(
            _("Writing {file}").format(file=path.name),
            work,
            lambda _none: self._workspace.tell(
                "good", _("{file} is written.").format(file=path.name)
            ),
            stop="tells",
        )

    def _on_changed(self) -> None:
        if self._coding.is_blind and self._other is not None:
            self.forget()
        self._count()
        self._compare()

    def _count(self) -> None:
        coding, analysis = self._coding.coding(), self._finding.analysis
        if not self._is_seen or coding is None:
            return
        kind, bin_ms = self._kind, self._bin_ms
        measured = next((one for one in MEASURED if one == kind), None)
        is_unmeasured = analysis is None and (measured is not None or kind == "activity")
        self._view.show_unmeasured(is_unmeasured=is_unmeasured)
        people = people_of(analysis) if kind in BY_PERSON else ()
        known = any(self._person == number for number, _name in people)
        self._view.show_people(people, self._person if known else EVERYBODY)
        if analysis is not None and known:
            analysis = of_person(analysis, self._person)
        if kind in PLOTS:
            self._view.show_plot(_plot(kind, coding, analysis, bin_ms))
        elif measured is None:
            self._view.show_counts(counted_table(kind, coding, bin_ms))
        elif analysis is None:
            self._view.show_counts(TextTable())
        else:
            parted = divided(analysis, coding.sections, bin_ms)
            self._view.show_counts(measured_table(measured, parted))

    def _compare(self) -> None:
        """Compare beside the window; what changes meanwhile is compared after it."""
        mine, other, params = self._coding.coding(), self._other, self._params
        if mine is None or other is None:
            return
        if self._is_comparing:
            self._is_stale = True
            return
        self._is_comparing, self._is_stale = True, False
        self._workspace.jobs.start(
            _("Comparing"),
            lambda _control: compare_codings([mine, other], params),
            self._on_compared,
            ended=self._on_compare_ended,
        )

    def _on_compare_ended(self) -> None:
        self._is_comparing = False
        if self._is_stale:
            self._compare()

    def _on_compared(self, report: AgreementReport) -> None:
        if self._other is not None:
            self.report = report
            self._show(report)

    def _show(self, report: AgreementReport) -> None:
        (session,) = report.sessions
        result = session.result
        self._coding.compare_with(session.codings[1], result.differences)
        n = sum(not one.is_agreed for one in result.matches)
        seconds = sum(one.end_ms - one.begin_ms for one in result.differences) / MS_PER_S
        sentence = _("{events} not agreed on, and {seconds} s of states seen by one alone.")
        told = sentence.format(
            events=translate_plural("{n} event", "{n} events", n).format(n=n),
            seconds=decimal_text(seconds, 1),
        )
        notices = [notice.text for notice in (*report.notices, *result.notices)]
        self._view.show_agreement(agreement_table(result.figures), " ".join((told, *notices)))


def _plot(
    kind: str, coding: Coding, analysis: "BehaviourAnalysis | None", bin_ms: int
) -> Raster | HeatMap | None:
    if kind == "raster":
        return raster(coding, None if analysis is None else analysis.detected)
    return None if analysis is None else heat_map(analysis, coding, bin_ms)


def _write(
    path: Path,
    coding: Coding,
    analysis: "BehaviourAnalysis | None",
    bin_ms: int,
    language: str,
) -> None:
    """Write the report of the analysis with the coding beside, or of the coding alone."""
    if analysis is not None and path.suffix.lower() == ".xlsx":
        from adibas.reports.behaviour import write_behaviour

        parted = divided(analysis, coding.sections, bin_ms)
        write_behaviour(replace(parted, observed=coding), path, language)
        return
    from adibas.reports.coding_report import write_coding_report

    write_coding_report([coding], bin_ms, path, language)
