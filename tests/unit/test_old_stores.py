"""Stores of every published version open with this program: one backup of each lies in the tests.

A new revision of the tables, or version of sealed recordings, adds the backup of a store that the
program before it made; none is ever made anew.
"""

from pathlib import Path

import pytest

from adibas.sessions.migrating import KNOWN
from adibas.sessions.restoring import restore_into
from adibas.sessions.trial_restore import verify_backup
from tests.unit.recorded_frames import assert_same_frame, make_frames
from tests.unit.store_samples import IDENTITY, PASSPHRASE, open_sample, surface

CORPUS = sorted((Path(__file__).parents[1] / "data" / "stores").glob("*.adibas-backup"))


def test_each_version_of_the_tables_has_a_store_in_the_corpus():
    assert [path.stem for path in CORPUS] == sorted(KNOWN)


@pytest.mark.parametrize("backup", CORPUS, ids=lambda path: path.stem)
def test_an_old_store_is_restored_with_all_that_it_held(backup, tmp_path):
    restore_into(backup, tmp_path / "store", PASSPHRASE)
    with open_sample(tmp_path / "store") as store:
        (row,) = store.patients.search("ximena")
        patient = store.patients.get(row.pseudonym)
        assert (patient.identity, patient.notes) == (IDENTITY, "the left knee")
        assert [one.given_by for one in patient.consents] == ["Rosalia Quetzal"]
        (session,) = store.sessions.of_patient(row.pseudonym)
        (capture,) = store.captures.of_session(session.session_id)
        assert [one.u for one in capture.markers()] == [33.0, 61.0, 90.0]
        assert (store.captures.picture(capture.capture_id) == 77).all()
        kept = store.captures.surface(capture.capture_id)
        assert (kept.n_readings == surface().n_readings).all()
        with store.recordings.open(capture.recording_id) as reader:
            for index, frame in enumerate(make_frames(3)):
                assert_same_frame(reader.read(index), frame)
        codings, key = store.recordings.codings, store.recordings.key(capture.recording_id)
        (coding,) = codings.ids()
        assert codings.read(coding, key) == b"what was coded"
        assert store.verify().is_sound


@pytest.mark.parametrize("backup", CORPUS, ids=lambda path: path.stem)
def test_an_old_store_is_merged_and_checked(backup, tmp_path):
    with open_sample(tmp_path / "used") as store:
        summary = store.backups.restore(backup, PASSPHRASE)
        assert (summary.n_patients, summary.n_captures, summary.n_recordings) == (1, 1, 1)
        assert store.verify().is_sound
    assert verify_backup(backup, PASSPHRASE, room=tmp_path)[1].is_sound
