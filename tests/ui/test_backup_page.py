"""The page of backups: by itself when one is due, by hand, checked, and back into the store."""

from dataclasses import replace
from pathlib import Path
from unittest.mock import create_autospec

import pytest
from PySide6.QtWidgets import QFileDialog, QPlainTextEdit, QPushButton

from adibas.data.patients import Identity
from adibas.sessions import key_state
from adibas.sessions.disk_use import DiskForecast
from adibas.texts import use_language
from tests.ui.conftest import PASSPHRASE
from ui import scheduled_backup
from ui.scheduled_backup import back_up_if_due
from ui.settings import backup_presenter
from ui.settings.backup_presenter import BackupPresenter, BackupView
from ui.settings.screen import build_settings_screen


@pytest.fixture
def view():
    return create_autospec(BackupView, instance=True)


@pytest.fixture
def presenter(view, workspace):
    return BackupPresenter(view, workspace)


def state(view):
    sentences = " ".join(view.show_state.call_args.args[0])
    return sentences, view.show_state.call_args.kwargs["is_urgent"]


def test_the_age_of_the_newest_backup_is_shown_and_warned_about(presenter, view, tmp_path):
    presenter.enter()
    assert state(view)[1]
    assert "no backup" in state(view)[0]
    presenter.change(backup_folder=str(tmp_path / "kept"))
    presenter.back_up(tmp_path / "kept" / "adibas-1.adibas-backup", "")
    sentences, is_urgent = state(view)
    assert "0 days old" in sentences
    assert "GB are free" in sentences
    assert not is_urgent
    assert view.show_plan.call_args.args[0].backup_folder == str(tmp_path / "kept")


@pytest.mark.parametrize(("days", "told"), [(1.2, "is 1 day old."), (1.8, "is 2 days old.")])
def test_a_backup_of_yesterday_is_one_day_old(presenter, view, store, monkeypatch, days, told):
    monkeypatch.setattr(store.backups, "days_since", lambda _folder: days)
    presenter.change(backup_folder="kept")
    assert told in state(view)[0]


def test_a_disk_that_is_nearly_full_is_urgent(presenter, view, store, tmp_path, monkeypatch):
    presenter.change(backup_folder=str(tmp_path / "kept"))
    presenter.back_up(tmp_path / "kept" / "adibas-1.adibas-backup", "")
    monkeypatch.setattr(store, "forecast_disk", lambda: DiskForecast(2 * 10**9, 1e9))
    presenter.enter()
    assert state(view)[1]
    assert "2 months" in state(view)[0]


def test_a_store_of_the_keyring_is_told_what_it_needs(presenter, view, monkeypatch, workspace):
    monkeypatch.setattr(backup_presenter, "key_state", lambda _folder: None)
    monkeypatch.setattr(scheduled_backup, "key_state", lambda _folder: None)
    presenter.change(backup_folder="somewhere")
    assert "need a passphrase" in state(view)[0]
    back_up_if_due(workspace)
    assert not Path("somewhere").exists()
    assert key_state(workspace.store.folder)


def test_a_backup_is_checked_and_brings_back_what_is_missing(
    presenter, view, workspace, told, tmp_path
):
    path = tmp_path / "a.adibas-backup"
    workspace.store.patients.add(Identity("Ana"))
    presenter.back_up(path, "")
    assert told == [("good", "The backup a.adibas-backup is made.")]
    presenter.check(path, PASSPHRASE)
    assert "is whole" in view.show_result.call_args.args[0][0]
    presenter.restore(path, "")
    assert "0 patients" in view.show_result.call_args.args[0][0]
    path.write_bytes(path.read_bytes()[:-2])
    presenter.check(path, "")
    assert "cut off" in str(workspace.jobs.problems[-1])


def test_a_backup_is_made_by_itself_when_one_is_due(workspace, told, tmp_path):
    back_up_if_due(workspace)
    assert told == []
    workspace.preferences.change(backup_folder=str(tmp_path / "kept"))
    back_up_if_due(workspace)
    back_up_if_due(workspace)
    (made,) = (tmp_path / "kept").iterdir()
    assert told == [("good", f"The backup {made.name} is made.")]


def test_what_was_done_when_stop_was_pressed_is_told(
    presenter, view, workspace, told, inline_jobs, tmp_path
):
    inline_jobs.is_stopped_late = True
    path = tmp_path / "a.adibas-backup"
    workspace.store.patients.add(Identity("Ana"))
    presenter.back_up(path, "")
    assert told == [("good", "The backup a.adibas-backup is made.")]
    presenter.restore(path, "")
    assert "0 patients" in view.show_result.call_args.args[0][0]
    told.clear()
    workspace.preferences.change(backup_folder=str(tmp_path / "planned"))
    back_up_if_due(workspace)
    assert [kind for kind, _sentence in told] == ["good"]


def test_missing_files_of_the_store_are_told(presenter, store, told, tmp_path, monkeypatch):
    write = store.backups.write

    def damaged(*words, **more):
        return replace(write(*words, **more), damaged=("pictures/ab",))

    monkeypatch.setattr(store.backups, "write", damaged)
    presenter.back_up(tmp_path / "a.adibas-backup", "")
    assert told[-1][0] == "warning"


@pytest.fixture
def screen(qtbot, workspace):
    screen = build_settings_screen(workspace)
    qtbot.addWidget(screen)
    screen.resize(1000, 800)
    screen.show()
    screen._tabs.setCurrentWidget(screen.protected)
    yield screen
    screen.closed()
    use_language("en")


def press(screen, text, chosen):
    (button,) = [
        b for b in screen.protected.backup.findChildren(QPushButton) if b.text().startswith(text)
    ]
    button.click()
    dialog = screen.protected.backup.findChildren(QFileDialog)[-1]
    dialog.fileSelected.emit(str(chosen))
    dialog.close()


def test_buttons_back_up_check_and_restore(screen, workspace, tmp_path):
    path = tmp_path / "a.adibas-backup"
    press(screen, "Choose the folder", tmp_path / "kept")
    assert workspace.preferences.now.backup_folder == str(tmp_path / "kept")
    press(screen, "Back up now", path)
    assert path.exists()
    (result,) = screen.protected.backup.findChildren(QPlainTextEdit)
    press(screen, "Try a backup out", path)
    assert "is whole" in result.toPlainText()
    press(screen, "Add what is missing", path)
    assert "Added from the backup" in result.toPlainText()
    (none,) = [
        b
        for b in screen.protected.backup.findChildren(QPushButton)
        if "Make no backups" in b.text()
    ]
    none.click()
    assert workspace.preferences.now.backup_folder == ""
