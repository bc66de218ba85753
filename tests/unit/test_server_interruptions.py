"""A store on a server that several use: restarts, crashes and restores take nothing from others."""

import os
import time

import pytest

from adibas.errors import StoreError
from tests.unit import postgres_server
from tests.unit import test_sessions_server as on_a_server
from tests.unit.recorded_frames import INFO, make_frames
from tests.unit.store_samples import PASSPHRASE, add_capture, add_session, open_sample, picture

pytestmark = pytest.mark.skipif(postgres_server.PROGRAMS is None, reason=postgres_server.MISSING)

server = postgres_server.server
database, folder, opened = on_a_server.database, on_a_server.folder, on_a_server.opened


@pytest.fixture
def backup(tmp_path):
    """Of another store, with three captures."""
    path = tmp_path / "out" / "b.adibas-backup"
    with open_sample(tmp_path / "another") as store:
        for _ in range(3):
            add_capture(store)
        store.backups.write(path)
    return path


def start_anew(server):
    server.kill()
    server.start()


def once(act):
    """Progress that does something in the middle of the work, one time."""
    left = [act]

    def progress(done, total):
        if done * 2 > total and left:
            left.pop()()

    return progress


def unwritten_for_minutes(*paths):
    for path in paths:
        os.utime(path, (time.time() - 3600,) * 2)


def test_a_second_restore_into_one_store_is_told_to_wait_and_harms_nothing(opened, backup):
    with opened("Ana") as ana, opened("Bea") as bea:

        def try_another():
            with pytest.raises(StoreError, match="Another workstation is just restoring"):
                bea.backups.restore(backup, PASSPHRASE)

        assert ana.backups.restore(backup, PASSPHRASE, once(try_another)).n_captures == 3
        assert ana.verify().is_sound
        assert bea.backups.restore(backup, PASSPHRASE).n_captures == 0


def test_who_opens_the_store_during_a_restore_leaves_its_files_alone(opened, backup):
    with opened("Ana") as ana:
        ana.backups.restore(backup, PASSPHRASE, once(lambda: opened("Bea").close()))
        assert ana.verify().is_sound


def test_a_restore_that_lost_its_hold_changes_nothing_and_can_be_repeated(opened, server, backup):
    with opened() as store:
        with pytest.raises(StoreError, match="went away while the backup was being read"):
            store.backups.restore(backup, PASSPHRASE, once(lambda: start_anew(server)))
        assert store.patients.search("") == ()
        assert store.backups.restore(backup, PASSPHRASE).n_captures == 3
        assert store.verify().is_sound


def test_no_picture_is_lost_where_another_restores_after_a_restart(opened, server, backup, folder):
    with opened("Ana") as ana:

        def restore_elsewhere():
            start_anew(server)
            with opened("Bea") as bea:
                assert bea.backups.restore(backup, PASSPHRASE).n_captures == 3

        with pytest.raises(StoreError):
            ana.backups.restore(backup, PASSPHRASE, once(restore_elsewhere))
        assert ana.backups.restore(backup, PASSPHRASE).n_captures == 0
        assert ana.verify().is_sound
    assert not (folder / "restoring").exists()


def test_a_recording_goes_on_over_a_restart_of_the_server_and_nobody_recovers_it(opened, server):
    frames = make_frames(4)
    with opened("Ana") as ana:
        session = add_session(ana)
        writer = ana.recordings.create(session.session_id, INFO)
        for frame in frames[:2]:
            writer.write(frame)
        start_anew(server)
        with opened("Bea") as bea:
            assert bea.recordings.of_session(session.session_id) == ()
        for frame in frames[2:]:
            writer.write(frame)
        writer.close()
        (facts,) = ana.recordings.of_session(session.session_id)
        assert (facts.n_frames, facts.notice) == (4, "")
        assert ana.verify().is_sound


def test_a_recording_that_is_just_beginning_is_not_forgotten_by_others(opened, server, monkeypatch):
    with opened("Ana") as ana:
        session = add_session(ana)
        create = ana.recordings.sealed.create

        def create_after_a_restart(*arguments):
            start_anew(server)
            opened("Bea").close()
            return create(*arguments)

        monkeypatch.setattr(ana.recordings.sealed, "create", create_after_a_restart)
        with ana.recordings.create(session.session_id, INFO) as writer:
            writer.write(make_frames(1)[0])
        assert ana.recordings.facts(writer.recording_id).n_frames == 1
        assert ana.verify().is_sound


def test_a_recording_that_a_crash_cut_is_recovered_when_nobody_wrote_to_it_for_minutes(
    opened, folder
):
    with opened("Ana") as ana:
        session = add_session(ana)
        writer = ana.recordings.create(session.session_id, INFO)
        for frame in make_frames(3):
            writer.write(frame)
        writer._sealed._file.let_go()  # the end of a process closes its files
    with opened("Bea") as bea:
        assert bea.recordings.of_session(session.session_id) == ()
    unwritten_for_minutes(*folder.glob("recordings/*/*.part.sealed"))
    with opened("Bea") as bea:
        (facts,) = bea.recordings.of_session(session.session_id)
        assert facts.n_frames == 3
        assert bea.verify().is_sound


def test_what_was_recovered_elsewhere_stays_when_its_writer_gives_up(opened, server, folder):
    with opened("Ana") as ana:
        session = add_session(ana)
        writer = ana.recordings.create(session.session_id, INFO)
        writer.write(make_frames(1)[0])
        unwritten_for_minutes(*folder.glob("recordings/*/*.part.sealed"))
        start_anew(server)
        opened("Bea").close()
        writer.abandon()
        (facts,) = ana.recordings.of_session(session.session_id)
        assert facts.n_frames == 1
        assert ana.verify().is_sound


def test_a_capture_that_is_being_saved_keeps_its_pictures_over_a_restart(
    opened, server, monkeypatch
):
    with opened("Ana") as ana:
        session = add_session(ana)
        write, written = ana._pictures.write, []

        def write_and_start_anew(*arguments):
            write(*arguments)
            written.append(arguments)
            if len(written) == 1:
                start_anew(server)
                opened("Bea").close()

        monkeypatch.setattr(ana._pictures, "write", write_and_start_anew)
        capture = add_capture(ana, session)
        assert (ana.captures.picture(capture.capture_id) == picture()).all()
        assert ana.verify().is_sound


def test_pictures_that_a_crash_left_pending_go_when_nobody_wrote_to_them_for_minutes(
    opened, folder, monkeypatch
):
    with opened("Ana") as ana:
        monkeypatch.setattr(ana._files, "_give_up", lambda _ids: None)
        with pytest.raises(InterruptedError), ana._files.written([b"a picture"]):
            raise InterruptedError
    (path,) = folder.glob("pictures/*/*.sealed")
    opened("Bea").close()
    assert path.exists()
    unwritten_for_minutes(path)
    with opened("Bea") as bea:
        assert not path.exists()
        assert bea.verify().is_sound
