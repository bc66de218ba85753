"""Backups every few days: when one is due, which are kept, and what counts as one."""

import json
from datetime import timedelta
from pathlib import Path

import pytest

from adibas.cli import main
from adibas.errors import FileError
from adibas.sessions.audit import AuditLog
from adibas.sessions.backup_format import BackupReader
from adibas.sessions.backup_schedule import BackupPlan, backups_in, days_since, is_due
from adibas.sessions.restoring import restore_into
from tests.unit.store_samples import (
    IDENTITY,
    PASSPHRASE,
    START,
    add_capture,
    add_session,
    minutes_clock,
    open_sample,
)

OLD = "adibas-old.adibas-backup"


@pytest.fixture
def folder(tmp_path):
    with open_sample(tmp_path / "store") as store:
        store.patients.add(IDENTITY)
    return tmp_path / "store"


@pytest.fixture
def plan(tmp_path):
    return BackupPlan(tmp_path / "disk" / "backups", every_days=7, keep=2)


def on_day(folder, plan, day):
    with open_sample(folder, clock=minutes_clock(START + timedelta(days=day))) as store:
        made = store.backups.write_planned(plan)
        return made, [one.path.name[7:17] for one in store.backups.kept(plan.folder)]


def test_a_backup_is_made_when_it_is_due_and_the_newest_are_kept(folder, plan):
    assert on_day(folder, plan, 0)[1] == ["2026-11-21"]
    assert on_day(folder, plan, 6) == (None, ["2026-11-21"])
    assert on_day(folder, plan, 8)[1] == ["2026-11-29", "2026-11-21"]
    (path, summary), kept = on_day(folder, plan, 16)
    assert kept == ["2026-12-07", "2026-11-29"]
    assert summary.n_files == 1
    assert path.parent == plan.folder
    assert len(list(plan.folder.iterdir())) == 2


def test_damaged_and_foreign_backups_neither_count_nor_go(folder, plan, tmp_path):
    (path, _), _ = on_day(folder, plan, 0)
    path.write_bytes(b"damaged")
    with open_sample(tmp_path / "other", clock=minutes_clock(START + timedelta(days=1))) as store:
        (foreign, _) = store.backups.write(plan.folder / "adibas-x.adibas-backup"), None
        assert foreign.n_files == 1
    mine = plan.folder / "adibas-by-hand.txt"
    mine.write_text("mine")
    made, kept = on_day(folder, plan, 2)
    assert made is not None
    assert kept == ["2026-11-23"]
    assert len(list(plan.folder.iterdir())) == 4


def test_a_backup_of_the_future_neither_stops_others_nor_drives_them_out(folder, plan):
    plan = BackupPlan(plan.folder, every_days=7, keep=1)
    assert on_day(folder, plan, 3650)[1] == ["2036-11-18"]
    assert on_day(folder, plan, 0)[1] == ["2026-11-21"]
    assert on_day(folder, plan, 6) == (None, ["2026-11-21"])
    assert on_day(folder, plan, 7)[1] == ["2026-11-28"]


def test_a_clock_that_is_put_back_a_little_makes_no_second_backup(folder, plan):
    assert on_day(folder, plan, 10)[0] is not None
    assert on_day(folder, plan, 9.5)[0] is None
    with open_sample(folder, clock=minutes_clock(START + timedelta(days=9.5))) as store:
        assert store.backups.days_since(plan.folder) == 0.0


def test_a_timer_strikes_a_little_early_and_still_makes_one_every_day(folder, plan):
    daily = BackupPlan(plan.folder, every_days=1, keep=9)
    for day in range(3):
        assert on_day(folder, daily, day * (1 - 1e-4))[0] is not None


def test_a_backup_that_was_cut_does_not_count(folder, plan):
    (path, _), _ = on_day(folder, plan, 0)
    path.write_bytes(path.read_bytes()[:-20_000])
    assert on_day(folder, plan, 1)[0] is not None


def test_no_older_backup_goes_while_the_store_lacks_files(folder, plan):
    with open_sample(folder) as store:
        add_capture(store, add_session(store))
    plan = BackupPlan(plan.folder, every_days=1, keep=1)
    on_day(folder, plan, 0)
    (one, *_) = sorted((folder / "pictures").rglob("*.sealed"))
    whole = one.read_bytes()
    one.unlink()
    (_, summary), kept = on_day(folder, plan, 2)
    assert len(summary.damaged) == 1
    assert len(kept) == 2
    one.write_bytes(whole)
    assert len(on_day(folder, plan, 4)[1]) == 1


def test_two_stores_that_are_backed_up_in_one_second_keep_both(folder, plan, tmp_path):
    open_sample(tmp_path / "other").close()
    first, second = (on_day(one, plan, 0)[0][0] for one in (folder, tmp_path / "other"))
    assert first != second
    assert first.exists()


@pytest.fixture
def copy(folder, plan, tmp_path):
    """A copy of the store, as another computer restores it from a backup."""
    (path, _), _ = on_day(folder, plan, 0)
    restore_into(path, tmp_path / "copy", PASSPHRASE)
    return tmp_path / "copy"


def test_a_copy_of_a_store_that_went_on_has_backups_of_its_own_in_the_same_folder(
    folder, copy, plan
):
    plan = BackupPlan(plan.folder, every_days=7, keep=1)
    (of_copy, _), kept = on_day(copy, plan, 10.5)
    assert kept == ["2026-12-01"]
    (mine, _), _ = on_day(folder, plan, 11)  # that of the copy is none of this store
    (again, _), _ = on_day(folder, plan, 20)
    assert set(plan.folder.iterdir()) == {of_copy, again}
    assert not mine.exists()
    (newer, _), _ = on_day(copy, plan, 30)
    assert set(plan.folder.iterdir()) == {newer, again}


def test_backups_from_before_a_copy_was_made_are_of_both(folder, copy, plan):
    assert on_day(folder, plan, 1) == (None, ["2026-11-21"])
    assert on_day(copy, plan, 2) == (None, ["2026-11-21"])


def test_two_copies_whose_timers_strike_in_one_second_write_two_backups(folder, copy, plan):
    on_day(copy, plan, 3)  # nothing is due, but its log goes on
    first, second = (on_day(one, plan, 20)[0][0] for one in (folder, copy))
    assert first != second
    assert first.exists()


def test_a_backup_of_before_that_tells_no_log_counts_as_ever(folder, plan, monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr(AuditLog, "end", lambda _log: None)
        patched.setattr("adibas.sessions.backup_schedule.name_at", lambda *_: OLD)
        on_day(folder, plan, 0)
    with BackupReader(plan.folder / OLD) as backup:
        assert backup.header.log_end is None
    assert on_day(folder, plan, 3)[0] is None


def test_a_backup_that_fails_removes_no_older_one(folder, plan, monkeypatch):
    on_day(folder, BackupPlan(plan.folder, 1, 1), 0)
    monkeypatch.setattr("shutil.disk_usage", lambda _path: type("Usage", (), {"free": 10}))
    with pytest.raises(FileError, match="disk is full"):
        on_day(folder, BackupPlan(plan.folder, 1, 1), 5)
    assert len(list(plan.folder.iterdir())) == 1


def test_an_old_backup_that_cannot_be_removed_is_told(folder, plan, monkeypatch):
    def refuse(_path, missing_ok=False):  # noqa: ARG001
        raise PermissionError(13, "Permission denied")

    on_day(folder, BackupPlan(plan.folder, 1, 1), 0)
    kept = backups_in(plan.folder, "ab" * 16, START)
    assert kept == ()
    with open_sample(folder) as store:
        kept = store.backups.kept(plan.folder)
    monkeypatch.setattr(Path, "unlink", refuse)
    from adibas.sessions.backup_schedule import remove_older

    with pytest.raises(FileError, match="remove the older one yourself"):
        remove_older(kept * 2, 1)


def test_no_backup_is_older_than_any(tmp_path):
    assert backups_in(tmp_path / "nowhere", "ab" * 16, START) == ()
    assert days_since((), START) is None
    assert is_due((), START, 7)


@pytest.mark.parametrize("numbers", [(0, 1), (1, 0)])
def test_a_plan_without_days_or_backups_is_none(tmp_path, numbers):
    with pytest.raises(ValueError, match="no plan"):
        BackupPlan(tmp_path, *numbers)


def test_the_command_does_nothing_when_none_is_due(folder, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("ADIBAS_PASSPHRASE", PASSPHRASE)
    words = ["sessions", "backup", "--store", str(folder), "--if-due", str(tmp_path / "kept")]
    assert main([*words, "--every", "2", "--json"]) == 0
    assert Path(json.loads(capsys.readouterr().out)["out"]).exists()
    assert main(words) == 0
    assert "No backup is due" in capsys.readouterr().out
    assert len(list((tmp_path / "kept").iterdir())) == 1
    with pytest.raises(SystemExit, match="2"):
        main(words[:-2])
