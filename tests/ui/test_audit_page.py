"""The page of the audit log: what it shows, whom it finds, what it writes."""

import csv
from unittest.mock import create_autospec

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QTableWidget, QTabWidget

from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import FileError
from adibas.texts import use_language
from tests.unit.store_samples import add_patient
from ui.settings import audit_presenter
from ui.settings.audit_presenter import AuditPresenter, AuditView
from ui.settings.screen import build_settings_screen

AUDIT_TAB = 2


@pytest.fixture
def ana(store):
    return add_patient(store, Identity("Ana Ruiz", None, "HC-1")).pseudonym


@pytest.fixture
def session(store, ana):
    return store.sessions.start(ana, SessionSetup()).session_id


@pytest.fixture
def bernat(store):
    return store.patients.add(Identity("Bernat Puig")).pseudonym


@pytest.fixture
def view():
    return create_autospec(AuditView, instance=True)


@pytest.fixture
def presenter(view, workspace, session, bernat):  # noqa: ARG001  (they are there)
    return AuditPresenter(view, workspace)


def subjects(view):
    return [entry.subject for entry in view.show_entries.call_args.args[0]]


def test_all_lines_are_shown_newest_first(presenter, view, ana, bernat, session):
    presenter.enter()
    assert subjects(view) == [bernat, session, ana, ana, "store"]
    assert view.show_entries.call_args.kwargs == {"is_cut": False}


@pytest.mark.parametrize("text", ["ruiz", "HC-1", "{ana}", " {ana_small} "])
def test_a_patient_is_found_by_name_number_or_pseudonym(presenter, view, ana, session, text):
    presenter.search(text.format(ana=ana, ana_small=ana.lower()))
    assert subjects(view) == [session, ana, ana]


def test_somebody_who_was_removed_is_found_by_the_pseudonym(presenter, view, store, ana, session):
    store.patients.delete(ana)
    store.patients.purge(ana)
    presenter.search(ana)
    assert subjects(view) == [ana, ana, session, ana, ana]
    presenter.search("ruiz")
    assert subjects(view) == []


def test_older_lines_are_cut_from_the_page_but_not_from_the_file(
    presenter, view, store, workspace, tmp_path, monkeypatch
):
    monkeypatch.setattr(audit_presenter, "MOST_SHOWN", 2)
    told = []
    workspace.noticed.subscribe(lambda kind, _sentence: told.append(kind))
    presenter.enter()
    assert (len(subjects(view)), view.show_entries.call_args.kwargs) == (2, {"is_cut": True})
    presenter.export(tmp_path / "log.csv")
    with (tmp_path / "log.csv").open(encoding="utf-8", newline="") as file:
        assert [int(row["sequence"]) for row in csv.DictReader(file)] == [5, 4, 3, 2, 1]
    assert told == ["good"]
    newest = store.audit.entries(1)[0]
    assert (newest.action, newest.subject) == ("export", "store")
    assert subjects(view)[0] == "store", "the page shows that it was written"


def test_the_lines_on_a_patient_are_found_among_many_with_a_number_like_it(presenter, view, store):
    for number in range(60):
        store.patients.add(Identity(f"Ana {number:02d}", record_number=f"7{number:02d}"))
    zoe = store.patients.add(Identity("Zoe", record_number="7"))
    presenter.search("7")
    assert zoe.pseudonym in subjects(view)


def test_a_log_that_was_written_when_stop_was_pressed_is_told(
    presenter, workspace, inline_jobs, tmp_path
):
    told = []
    workspace.noticed.subscribe(lambda kind, _sentence: told.append(kind))
    inline_jobs.is_stopped_late = True
    presenter.export(tmp_path / "log.csv")
    assert told == ["good"]


def test_only_the_lines_on_one_patient_are_written(presenter, tmp_path, ana):
    presenter.search("ruiz")
    presenter.export(tmp_path / "log.csv")
    with (tmp_path / "log.csv").open(encoding="utf-8", newline="") as file:
        assert {row["patient"] for row in csv.DictReader(file)} == {ana}


def test_a_folder_that_cannot_be_written_is_told(presenter, inline_jobs, store, tmp_path):
    (tmp_path / "file").write_text("no folder")
    presenter.export(tmp_path / "file" / "log.csv")
    assert len(inline_jobs.problems) == 1
    assert store.audit.entries(1)[0].action != "export"


def test_a_log_that_is_only_half_written_is_noted_as_exported(
    presenter, inline_jobs, store, tmp_path, monkeypatch
):
    def full(_entries, path):
        raise FileError("{file} cannot be written: the disk is full.", file=path.name)

    monkeypatch.setattr(audit_presenter, "write_audit_csv", full)
    presenter.export(tmp_path / "log.csv")
    assert len(inline_jobs.problems) == 1
    assert store.audit.entries(1)[0].action == "export"


class LaterJobs:
    """Keeps jobs until the test ends them, in whatever order."""

    def __init__(self):
        self.started = []

    def start(self, _label, work, done, failed=None, ended=None):  # noqa: ARG002
        job = LaterJob(work, done)
        self.started.append(job)
        return job


class LaterJob:
    is_running = True

    def __init__(self, work, done):
        self.work, self.done = work, done
        self.is_cancelled = False

    def cancel(self):
        self.is_cancelled = True


def test_of_two_searches_the_later_one_is_shown(view, workspace, session, bernat):  # noqa: ARG001
    workspace.jobs = LaterJobs()
    presenter = AuditPresenter(view, workspace)
    presenter.search("ruiz")
    presenter.search("puig")
    first, second = workspace.jobs.started
    assert (first.is_cancelled, second.is_cancelled) == (True, False)
    second.done(second.work(None))
    first.done(first.work(None))
    view.show_entries.assert_called_once()
    assert subjects(view) == [bernat]


@pytest.fixture
def screen(workspace, qtbot, session, bernat):  # noqa: ARG001  (they are there)
    screen = build_settings_screen(workspace)
    qtbot.addWidget(screen)
    screen.resize(1140, 740)
    screen.show()
    screen.entered()
    screen.findChild(QTabWidget).setCurrentIndex(AUDIT_TAB)
    yield screen
    screen.closed()
    use_language("en")


def lines(screen):
    (table,) = [one for one in screen.findChildren(QTableWidget) if one.isVisible()]
    columns = range(1, table.columnCount())
    return [
        tuple(table.item(row, column).text() for column in columns)
        for row in range(table.rowCount())
    ]


def test_the_page_says_who_did_what_on_whom(screen, ana, bernat, session):
    assert lines(screen) == [
        ("tester", "created", bernat, ""),
        ("tester", "created", ana, session),
        ("tester", "changed", ana, ""),
        ("tester", "created", ana, ""),
        ("tester", "opened", "", "the patient store"),
    ]
    screen.entered()
    assert len(lines(screen)) == 5
    use_language("es")
    screen.retranslate()
    assert lines(screen)[0][1] == "creado"


def test_typing_finds_and_the_button_writes(screen, ana, tmp_path):
    search = screen.audit.search
    QTest.keyClicks(search, "ruiz")
    assert {line[2] for line in lines(screen)} == {ana}
    QTest.keyClicks(search, "xx")
    assert lines(screen) == []
    search.clear()
    QTest.keyClicks(search, ana)
    QTest.mouseClick(screen.audit.export, Qt.MouseButton.LeftButton)
    (dialog,) = [one for one in QApplication.topLevelWidgets() if isinstance(one, QFileDialog)]
    dialog.fileSelected.emit(str(tmp_path / "mine.csv"))
    dialog.reject()
    assert ana in (tmp_path / "mine.csv").read_text(encoding="utf-8")
