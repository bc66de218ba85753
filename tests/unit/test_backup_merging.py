"""A backup in a used store: missing things come back, purged ones do not, nothing is lost."""

import json
import shutil
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import replace
from datetime import timedelta

import pytest

from adibas.cli import main
from adibas.data.corrections import MarkerCorrection
from adibas.data.patients import Consent, Identity
from adibas.errors import PassphraseError, StoreError
from adibas.sessions import open_store
from adibas.sessions.backup_format import BackupReader
from adibas.sessions.merge_words import merge_texts
from adibas.sessions.merging import MergeSummary
from adibas.sessions.restoring import restore_into
from tests.unit.recorded_frames import INFO, assert_same_frame, make_frames
from tests.unit.store_samples import (
    CHEAP,
    IDENTITY,
    NAME,
    PASSPHRASE,
    START,
    add_capture,
    all_bytes,
    marker,
    minutes_clock,
    open_sample,
    raw_connection,
)
from tests.unit.test_sessions_purge import filled

LATER = START + timedelta(days=2)
LATEST = START + timedelta(days=4)


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


@pytest.fixture
def session(folder):
    with open_sample(folder) as store:
        return filled(store)


@pytest.fixture
def backup(folder, session, tmp_path):
    assert session
    return back_up(folder, tmp_path / "a.adibas-backup")


def back_up(folder, path):
    with open_sample(folder) as store:
        store.backups.write(path)
    return path


def restored(folder, backup, **options):
    with open_sample(folder, **options) as store:
        summary = store.backups.restore(backup)
        assert store.verify().is_sound
    return summary


def counts(summary):
    return summary.n_patients, summary.n_sessions, summary.n_captures, summary.n_recordings


def test_a_restore_of_what_is_all_there_changes_nothing(folder, session, backup):
    before = {k: v for k, v in all_bytes(folder).items() if k.endswith(".sealed")}
    summary = restored(folder, backup)
    assert counts(summary) == (0, 0, 0, 0)
    assert (summary.newer_here, summary.both_kept, summary.not_added) == ([], [], [])
    assert {k: v for k, v in all_bytes(folder).items() if k.endswith(".sealed")} == before
    with open_sample(folder) as store:
        assert store.audit.entries(2)[1].action == "merge"
        assert store.patients.get(session.patient).identity == IDENTITY


def test_another_clinics_backup_is_added_whole(session, backup, tmp_path):
    new = tmp_path / "other"
    with open_store(new, "another passphrase", key_params=CHEAP, clock=minutes_clock()) as store:
        mine = filled(store)
        with pytest.raises(PassphraseError):
            store.backups.restore(backup)
        summary = store.backups.restore(backup, PASSPHRASE)
        assert counts(summary) == (1, 1, 1, 1)
        assert store.verify().is_sound
        assert len(store.patients.search("")) == 2
        assert store.captures.of_session(mine.session_id)
        patient = store.patients.get(session.patient)
        assert (patient.identity, len(patient.consents)) == (IDENTITY, 2)
        (capture,) = store.captures.of_session(session.session_id)
        assert capture.history.n_done == 1
        assert store.captures.picture(capture.capture_id).shape == (96, 64, 3)
        (facts,) = store.recordings.of_session(session.session_id)
        with store.recordings.open(facts.recording_id) as reader:
            assert_same_frame(reader.read(1), make_frames(3)[1])
        lines = store.audit.entries(1000, patients=[session.patient])
        assert {line.subject for line in lines if line.action == "merge"} == {
            session.patient,
            session.session_id,
            capture.capture_id,
            facts.recording_id,
        }
        assert counts(store.backups.restore(backup, PASSPHRASE)) == (0, 0, 0, 0)
        assert not (new / "restoring").exists()


@pytest.mark.parametrize(
    ("numbers", "told"),
    [
        ((1, 1, 1, 1), "1 patient, 1 session, 1 capture, 1 recording."),
        ((2, 1, 0, 3), "2 patients, 1 session, 0 captures, 3 recordings."),
    ],
)
def test_one_of_a_kind_is_told_as_one(numbers, told):
    assert merge_texts(MergeSummary(*numbers)) == (f"Added from the backup: {told}",)


def test_what_was_purged_does_not_come_back(folder, session, backup):
    with open_sample(folder) as store:
        store.patients.purge(session.patient)
        summary = store.backups.restore(backup)
        assert counts(summary) == (0, 0, 0, 0)
        assert summary.n_purged == 1
        assert store.patients.search("", with_deleted=True) == ()
        assert "stays gone" in merge_texts(summary)[1]
    assert list(folder.rglob("*.sealed")) == []


def test_a_purged_session_does_not_come_back_to_its_patient(folder, session, backup):
    with open_sample(folder) as store:
        store.sessions.purge(session.session_id)
        assert store.backups.restore(backup).n_purged == 1
        assert store.sessions.of_patient(session.patient, with_deleted=True) == ()
        assert store.verify().is_sound
    assert list(folder.rglob("*.sealed")) == []


def test_who_was_hidden_stays_hidden(folder, session, backup):
    with open_sample(folder) as store:
        store.patients.delete(session.patient)
    restored(folder, backup)
    with open_sample(folder) as store:
        assert store.patients.search("") == ()
        assert len(store.patients.search("", with_deleted=True)) == 1


def test_what_was_changed_since_the_backup_stays_and_is_told(folder, session, backup):
    with open_sample(folder) as store:
        store.patients.change(session.patient, identity=replace(IDENTITY, name="Eva"), notes="new")
        store.sessions.change(session.session_id, notes="new")
        (capture,) = store.captures.of_session(session.session_id)
        store.captures.correct(capture.capture_id, capture.history.undone())
        summary = store.backups.restore(backup)
        ids = [session.patient, session.session_id, capture.capture_id]
        assert summary.newer_here == ids
        patient = store.patients.get(session.patient)
        assert (patient.identity.name, patient.notes) == ("Eva", "new")
        assert store.sessions.get(session.session_id).notes == "new"
        assert store.captures.of_session(session.session_id)[0].history.n_done == 0
        assert "newer here" in merge_texts(summary)[1]


def test_missing_and_damaged_files_are_healed(folder, session, backup):
    files = sorted(folder.rglob("*.sealed"))
    contents = [path.read_bytes() for path in files]
    files[0].unlink()
    files[1].write_bytes(b"damaged")
    files[2].write_bytes(contents[2][:-5])
    summary = restored(folder, backup)
    assert counts(summary) == (0, 0, 0, 0)
    assert [path.read_bytes() for path in files] == contents
    assert session


@pytest.fixture
def two_ways(folder, session, backup, tmp_path):
    """The same store twice: each went on by itself."""
    assert session
    other = tmp_path / "other"
    restore_into(backup, other, PASSPHRASE)
    return folder, other


def go_on(folder, session, name, clock, u):
    """Work in one of two copies of a store."""
    with open_sample(folder, clock=minutes_clock(clock)) as store:
        store.patients.change(session.patient, identity=Identity(name), notes=f"note {name}")
        store.sessions.change(session.session_id, notes=f"visit {name}")
        (capture,) = store.captures.of_session(session.session_id)
        step = MarkerCorrection(marker("m01", 33.0), marker("m01", u))
        store.captures.correct(capture.capture_id, capture.history.after(step))
        add_capture(store, session)
        return capture.capture_id


@pytest.mark.parametrize("is_newer_here", [True, False])
def test_what_went_on_in_two_places_is_kept_from_both(two_ways, session, tmp_path, is_newer_here):
    here, there = two_ways
    clocks = (LATEST, LATER) if is_newer_here else (LATER, LATEST)
    go_on(here, session, "Here", clocks[0], 40.0)
    capture_id = go_on(there, session, "There", clocks[1], 50.0)
    path = back_up(there, tmp_path / "b.adibas-backup")
    with open_sample(here, clock=minutes_clock(LATEST + timedelta(days=1))) as store:
        summary = store.backups.restore(path)
        assert set(summary.both_kept) == {session.patient, session.session_id, capture_id}
        assert counts(summary) == (0, 0, 1, 0)
        winner, other = ("Here", "There") if is_newer_here else ("There", "Here")
        patient = store.patients.get(session.patient)
        assert_both_are_kept(store, session, patient, winner, other)
        first, *more = store.captures.of_session(session.session_id)
        (moved,) = (one for one in first.markers() if one.label == "m01")
        assert (moved.u, len(more)) == (40 if is_newer_here else 50, 2)
        assert store.verify().is_sound
        assert "changed on both sides" in " ".join(merge_texts(summary))
        assert store.backups.restore(path).both_kept == []
        assert store.patients.get(session.patient).notes == patient.notes
    connection = raw_connection(here)
    kept = [row[0] for row in connection.execute("SELECT content FROM corrections")]
    connection.close()
    assert [sum(f'"u":{u}' in text for text in kept) for u in (40.0, 50.0)] == [1, 1]


def assert_both_are_kept(store, session, patient, winner, other):
    assert patient.identity.name == winner
    assert patient.notes.startswith(f"note {winner}")
    assert f"note {other}" in patient.notes
    assert f"\n{other}\n" in patient.notes
    assert store.patients.search(winner)
    notes = store.sessions.get(session.session_id).notes
    assert f"visit {winner}" in notes
    assert f"visit {other}" in notes


@pytest.mark.parametrize("later", ["consent", "hidden", "refused", "notes"])
@pytest.mark.parametrize("is_corrected_here", [True, False])
def test_a_corrected_identity_holds_whatever_else_was_done_later_in_the_other_place(
    two_ways, session, tmp_path, later, is_corrected_here
):
    here, there = two_ways
    corrected, other = (here, there) if is_corrected_here else (there, here)
    right = replace(IDENTITY, name="Corrected")
    with open_sample(corrected, clock=minutes_clock(LATER)) as store:
        store.patients.change(session.patient, identity=right)
    with open_sample(other, clock=minutes_clock(LATEST)) as store:
        match later:
            case "consent":
                consent = Consent(("research",), "Ana", False, LATEST)
                store.patients.give_consent(session.patient, consent)
            case "hidden":
                store.patients.delete(session.patient)
                store.patients.restore(session.patient)
            case "refused":
                store.audit.append("refuse", session.patient, permission="purge")
            case "notes":
                store.patients.change(session.patient, notes="seen at home")
    path = back_up(there, tmp_path / "b.adibas-backup")
    with open_sample(here, clock=minutes_clock(LATEST + timedelta(days=1))) as store:
        store.backups.restore(path)
        patient = store.patients.get(session.patient)
        assert patient.identity == right
        assert patient.notes.startswith("seen at home") == (later == "notes")


@pytest.mark.parametrize("is_measured_here", [True, False])
def test_a_set_up_and_notes_that_were_changed_in_two_places_both_hold(
    two_ways, session, tmp_path, is_measured_here
):
    here, there = two_ways
    measured, noted = (here, there) if is_measured_here else (there, here)
    setup = replace(session.setup, is_repeat=not session.setup.is_repeat)
    with open_sample(measured, clock=minutes_clock(LATER)) as store:
        store.sessions.change(session.session_id, setup=setup)
    with open_sample(noted, clock=minutes_clock(LATEST)) as store:
        store.sessions.change(session.session_id, notes="tired")
    path = back_up(there, tmp_path / "b.adibas-backup")
    with open_sample(here, clock=minutes_clock(LATEST + timedelta(days=1))) as store:
        store.backups.restore(path)
        merged = store.sessions.get(session.session_id)
        assert (merged.setup, merged.notes.splitlines()[0]) == (setup, "tired")


def test_a_name_within_a_word_of_the_notes_is_kept_all_the_same(two_ways, session, tmp_path):
    here, there = two_ways
    for folder, name, clock in ((there, "Eva", LATER), (here, "Ana", LATEST)):
        with open_sample(folder, clock=minutes_clock(clock)) as store:
            store.patients.change(
                session.patient, identity=Identity(name), notes="Evaluation of a banana"
            )
    path = back_up(there, tmp_path / "b.adibas-backup")
    with open_sample(here) as store:
        store.backups.restore(path)
        patient = store.patients.get(session.patient)
        assert patient.identity.name == "Ana"
        assert patient.notes.splitlines()[0] == "Evaluation of a banana"
        assert patient.notes.splitlines()[-1] == "Eva"


def test_a_consent_withdrawn_in_one_place_is_withdrawn(two_ways, session, tmp_path):
    here, there = two_ways
    with open_sample(there, clock=minutes_clock(LATER)) as store:
        store.patients.withdraw_consent(session.patient, 0)
        store.patients.give_consent(session.patient, Consent(("research",), "Ana", False, LATER))
    path = back_up(there, tmp_path / "b.adibas-backup")
    with open_sample(here, clock=minutes_clock(LATEST)) as store:
        store.backups.restore(path)
        consents = store.patients.get(session.patient).consents
        assert [one.withdrawn_utc is None for one in consents] == [False, True, True]
        assert consents[2].given_by == "Ana"
        lines = store.audit.entries(100, patients=[session.patient])
        assert [one.detail for one in lines if one.detail.get("merged")] == [
            {"fields": ["consents"], "merged": True}
        ]
        store.backups.restore(path)
        assert len(store.audit.entries(100, patients=[session.patient])) == len(lines)


def test_somebody_else_of_the_same_pseudonym_is_not_mixed_in(folder, session, backup, tmp_path):
    other = tmp_path / "other"
    with open_sample(other, clock=minutes_clock(LATER)) as store:
        stranger = store.patients.add(Identity("Stranger"))
    connection = raw_connection(other)
    connection.execute("PRAGMA foreign_keys = OFF")
    for table in ("patients", "identities"):
        connection.execute(f"UPDATE {table} SET pseudonym = '{session.patient}'")
    connection.close()
    assert stranger.pseudonym != session.patient
    with open_sample(other) as store:
        summary = store.backups.restore(backup, PASSPHRASE)
        assert summary.not_added == [session.patient]
        assert counts(summary) == (0, 0, 0, 0)
        assert store.patients.get(session.patient).identity.name == "Stranger"
        assert "somebody else" in merge_texts(summary)[-1]
        assert store.verify().is_sound
    assert folder.exists()


def test_a_crash_after_the_change_puts_the_files_in_their_places_later(
    session, backup, tmp_path, monkeypatch
):
    new = tmp_path / "other"
    with open_sample(new) as store:
        monkeypatch.setattr("adibas.sessions.merged_files.finish_merge", lambda _database: None)
        assert counts(store.backups.restore(backup, PASSPHRASE)) == (1, 1, 1, 1)
        assert not store.verify().is_sound
        monkeypatch.undo()
    with open_sample(new) as store:
        assert store.verify().is_sound
        assert store.captures.of_session(session.session_id)
    assert not (new / "restoring").exists()


def test_a_second_restore_loses_no_file_that_the_first_one_left_waiting(
    session, backup, tmp_path, monkeypatch
):
    with open_sample(tmp_path / "third", clock=minutes_clock(LATER)) as store:
        filled(store)
    other = back_up(tmp_path / "third", tmp_path / "c.adibas-backup")
    with open_sample(tmp_path / "other") as store:
        monkeypatch.setattr("adibas.sessions.merged_files.finish_merge", lambda _database: None)
        store.backups.restore(backup, PASSPHRASE)
        monkeypatch.undo()
        store.backups.restore(other, PASSPHRASE)
        assert store.verify().is_sound
        assert store.captures.of_session(session.session_id)


def test_two_restores_of_one_window_go_one_after_the_other(session, backup, tmp_path):
    others = []
    with open_sample(tmp_path / "other") as store, ThreadPoolExecutor(1) as pool:

        def begin_another(_done, _total):
            if not others:
                others.append(pool.submit(store.backups.restore, backup, PASSPHRASE))
                wait(others, timeout=0.3)

        first = store.backups.restore(backup, PASSPHRASE, begin_another)
        assert counts(first) == (1, 1, 1, 1)
        assert counts(others[0].result()) == (0, 0, 0, 0)
        assert store.verify().is_sound
        assert store.captures.of_session(session.session_id)


def test_a_file_that_a_kill_cut_while_it_was_restored_is_not_taken(folder, session, tmp_path):
    with open_sample(folder) as store:
        (facts,) = store.recordings.of_session(session.session_id)
        key, name = store.recordings.key(facts.recording_id), facts.recording_id + "-0a0b"
        store.recordings.codings.write(name, key, b"x" * 3_000_000)
        backup = tmp_path / "a.adibas-backup"
        store.backups.write(backup)
        store.recordings.codings.delete(name)
        path = folder / "restoring"

        def kill(done, _total):
            if list(path.rglob(f"{name}*")) and done > 2_000_000:
                shutil.copytree(path, tmp_path / "as-it-was", dirs_exist_ok=True)
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            store.backups.restore(backup, progress=kill)
    shutil.copytree(tmp_path / "as-it-was", path)
    with open_sample(folder) as store:
        assert not store.recordings.codings.path_of(name).exists()
        store.backups.restore(backup)
        assert store.recordings.codings.read(name, key) == b"x" * 3_000_000


def test_of_two_damaged_files_the_one_that_is_here_stays(folder, session, tmp_path):
    (recording,) = (folder / "recordings").rglob("*.sealed")
    whole = recording.read_bytes()
    recording.write_bytes(b"damaged before")
    backup = back_up(folder, tmp_path / "a.adibas-backup")
    recording.write_bytes(whole[:-1])
    with open_sample(folder) as store:
        store.backups.restore(backup)
    assert recording.read_bytes() == whole[:-1]
    assert session


def test_one_file_comes_back_also_where_there_is_no_room_for_all(folder, backup, monkeypatch):
    (recording,) = (folder / "recordings").rglob("*.sealed")
    whole = recording.read_bytes()
    recording.unlink()
    with BackupReader(backup) as reader:
        n_bytes = reader.header.n_bytes
    for n_short, is_told in ((1, False), (n_bytes - 1000, True)):
        usage = type("Usage", (), {"free": n_bytes - n_short})
        monkeypatch.setattr("shutil.disk_usage", lambda _path, usage=usage: usage)
        with open_sample(folder) as store:
            if is_told:
                with pytest.raises(StoreError, match="disk is full"):
                    store.backups.restore(backup)
            else:
                store.backups.restore(backup)
                assert recording.read_bytes() == whole


def test_a_stop_or_damage_before_the_change_leaves_the_store_as_it_was(session, backup, tmp_path):
    new = tmp_path / "other"

    def stop(_done, _total):
        raise KeyboardInterrupt

    with open_sample(new) as store:
        with pytest.raises(KeyboardInterrupt):
            store.backups.restore(backup, PASSPHRASE, stop)
        backup.write_bytes(backup.read_bytes()[:-3])
        with pytest.raises(StoreError, match="cut off"):
            store.backups.restore(backup, PASSPHRASE)
        assert store.patients.search("") == ()
        assert store.verify().is_sound
    assert not (new / "restoring").exists()
    assert session


def test_a_recording_that_a_crash_cut_is_replaced_by_the_whole_one(folder, session, backup):
    connection = raw_connection(folder)
    connection.execute("UPDATE recordings SET is_closed = 0, n_frames = 0")
    connection.close()
    for path in (folder / "recordings").rglob("*.sealed"):
        path.write_bytes(path.read_bytes()[:10])
    with open_sample(folder) as store:
        assert store.recordings.of_session(session.session_id) == ()
        assert store.backups.restore(backup).n_recordings == 1
        (facts,) = store.recordings.of_session(session.session_id)
        assert facts.n_frames == 3
        assert store.verify().is_sound


def test_a_capture_of_an_unfinished_recording_comes_without_it(folder, session, tmp_path):
    path = tmp_path / "b.adibas-backup"
    with (
        open_sample(folder) as store,
        store.recordings.create(session.session_id, INFO) as writer,
    ):
        writer.write(make_frames(1)[0])
        add_capture(store, session, recording_id=writer.recording_id)
        store.backups.write(path)
    with open_sample(tmp_path / "other") as store:
        assert counts(store.backups.restore(path, PASSPHRASE)) == (1, 1, 2, 1)
        captures = store.captures.of_session(session.session_id)
        assert [bool(one.recording_id) for one in captures] == [True, False]
        assert store.verify().is_sound


def test_a_reader_restores_nothing(folder, backup):
    with open_sample(folder), open_sample(folder) as second:
        with pytest.raises(StoreError, match="another window"):
            second.backups.restore(backup)
        second.backups.write(backup)


def test_the_command_tells_what_came_of_it(folder, session, backup, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("ADIBAS_PASSPHRASE", PASSPHRASE)
    other = tmp_path / "other"
    open_sample(other).close()
    words = ["sessions", "restore", str(backup), "--store", str(other)]
    assert main(words) == 0
    assert "1 patient, 1 session, 1 capture, 1 recording" in capsys.readouterr().out
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["n_patients"] == 0
    assert NAME not in json.dumps(capsys.readouterr().out)
    assert folder.exists()
    assert session


def test_what_was_coded_on_both_sides_stays_as_it_is_here_and_is_told(folder, session, tmp_path):
    def code(content):
        with open_sample(folder) as store:
            (facts,) = store.recordings.of_session(session.session_id)
            key = store.recordings.key(facts.recording_id)
            store.recordings.codings.write(facts.recording_id + "-0a0b", key, content)
            return facts.recording_id

    code(b"coded before")
    backup = back_up(folder, tmp_path / "a.adibas-backup")
    assert restored(folder, backup).other_codings == []
    recording_id = code(b"coded afterwards")
    summary = restored(folder, backup)
    assert summary.other_codings == [recording_id]
    assert recording_id in merge_texts(summary)[-1]
    with open_sample(folder) as store:
        key = store.recordings.key(recording_id)
        assert store.recordings.codings.read(recording_id + "-0a0b", key) == b"coded afterwards"
