"""`adibas sessions`: what it prints, writes, refuses, and never tells."""

import json
from dataclasses import replace
from datetime import UTC, datetime
from unittest.mock import Mock

import pytest

from adibas.cli import main
from adibas.data.markers import AutomaticName
from adibas.data.patients import Identity
from adibas.errors import ConsentError, FileError
from adibas.recordings import open_recording
from adibas.sessions import default_store_folder
from adibas.sessions.backup_schedule import BackupPlan
from tests.unit.recorded_frames import INFO, assert_same_frame, make_frames
from tests.unit.store_samples import (
    NAME,
    PASSPHRASE,
    MemoryKeyring,
    add_capture,
    add_session,
    all_bytes,
    minutes_clock,
    open_sample,
    use_keyring,
)
from tests.unit.store_samples import marker as sample_marker

LATE = datetime(2027, 1, 1, 9, tzinfo=UTC)


@pytest.fixture
def session(folder):
    """One session of one patient, with two recordings and a corrected capture."""
    with open_sample(folder) as store:
        session = add_session(store)
        for seed in (1, 2):
            with store.recordings.create(session.session_id, INFO) as writer:
                for frame in make_frames(3, seed=seed):
                    writer.write(frame)
        add_capture(store, session, recording_id=writer.recording_id)
        return session


@pytest.fixture
def run(folder, capsys):
    """Run the command on the store; gives exit code, stdout, stderr."""

    def command(action, *arguments):
        code = main(["sessions", action, "--store", str(folder), *arguments])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return command


def as_json(run, *arguments):
    code, out, _ = run(*arguments, "--json")
    assert code == 0
    return json.loads(out)


def test_list_tells_pseudonyms_and_names_only_when_asked(run, session):
    code, out, err = run("list")
    assert (code, err) == (0, "")
    assert session.patient in out
    assert session.session_id in out
    assert NAME not in out
    assert NAME in run("list", "--names")[1]
    assert NAME not in json.dumps(as_json(run, "list"), ensure_ascii=False)
    assert as_json(run, "list", "--names")["patients"][0]["name"] == NAME


def test_list_leaves_hidden_ones_out_unless_asked(run, folder, session):
    with open_sample(folder) as store:
        store.patients.delete(session.patient)
    assert as_json(run, "list") == {"patients": []}
    (patient,) = as_json(run, "list", "--deleted")["patients"]
    assert patient["is_deleted"]
    assert "hidden" in run("list", "--deleted")[1]
    assert "empty" in run("list")[1]


def test_show_tells_captures_and_markers(run, session):
    shown = as_json(run, "show", session.session_id)
    assert shown["patient"] == session.patient
    assert [marker["label"] for marker in shown["captures"][0]["markers"]] == ["m01", "m02", "m03"]
    assert shown["captures"][0]["markers"][2]["position_m"] is None
    assert [recording["n_frames"] for recording in shown["recordings"]] == [3, 3]
    out = run("show", session.session_id)[1]
    assert "anterior" in out
    assert "1900.0 mm" in out
    assert "no position" in out
    assert "named automatically" not in out


def test_show_tells_which_names_the_program_gave_and_how_sure_it_was(run, folder, session):
    by_model = AutomaticName("model of May", 0.936)
    named = replace(sample_marker("neck"), named_by=by_model)
    with open_sample(folder) as store:
        add_capture(store, session, detected=(named,))
    shown = as_json(run, "show", session.session_id)
    (neck,) = shown["captures"][-1]["markers"]
    assert neck["named_by"] == {"model": "model of May", "confidence": 0.936}
    assert "named automatically, 93 %" in run("show", session.session_id)[1]


def test_export_writes_what_any_reader_opens_and_a_line_in_the_log(run, folder, session, tmp_path):
    out = tmp_path / "out"
    written = as_json(run, "export", session.session_id, "--out", str(out))["out"]
    assert sorted(path.name for path in out.iterdir()) == [
        "posture.json",
        "recording-01.mcap",
        "recording-02.mcap",
        "report.pdf",
        "report.xlsx",
    ]
    assert len(written) == 5
    for number, seed in ((1, 1), (2, 2)):
        with open_recording(out / f"recording-{number:02d}.mcap") as reader:
            for got, want in zip(reader, make_frames(3, seed=seed), strict=True):
                assert_same_frame(got, want)
    document = json.loads((out / "posture.json").read_text())
    assert document["patient"] == session.patient
    assert all(NAME.encode() not in path.read_bytes() for path in out.iterdir())
    with open_sample(folder) as store:
        exports = [entry for entry in store.audit.entries() if entry.action == "export"]
    assert len(exports) == 5
    assert all(entry.operator != "op" for entry in exports)


@pytest.mark.parametrize("pictures", ["as-is", "blurred", "depth"])
def test_who_hides_the_face_in_the_report_is_told_that_the_recordings_hold_the_depth_alone(
    run, folder, tmp_path, pictures
):
    with open_sample(folder) as store:
        session = add_session(store)
        with store.recordings.create(session.session_id, INFO) as writer:
            writer.write(make_frames(1)[0])
    out = ("--out", str(tmp_path / "out"), "--pictures", pictures)
    code, said, _ = run("export", session.session_id, *out)
    assert (code, "the depth alone" in said) == (0, pictures != "as-is")


def test_export_replaces_nothing_by_mistake(run, session, tmp_path):
    arguments = ("export", session.session_id, "--out", str(tmp_path / "out"))
    assert run(*arguments)[0] == 0
    code, _, err = run(*arguments)
    assert code == 1
    assert "exists already" in err
    assert run(*arguments, "--overwrite")[0] == 0


def test_export_replaces_no_report_of_another_session(run, folder, session, tmp_path):
    with open_sample(folder) as store:
        other = add_session(store)
        add_capture(store, other)
    out = ("--out", str(tmp_path / "out"))
    assert run("export", session.session_id, *out)[0] == 0
    before = all_bytes(tmp_path / "out")
    code, _, err = run("export", other.session_id, *out)
    assert (code, "posture.json exists already" in err) == (1, True)
    assert all_bytes(tmp_path / "out") == before
    assert run("export", other.session_id, *out, "--overwrite")[0] == 0


def test_an_export_leaves_nothing_of_another_session_in_its_folder(run, folder, session, tmp_path):
    with open_sample(folder) as store:
        other = add_session(store)
        with store.recordings.create(other.session_id, INFO) as writer:
            writer.write(make_frames(1)[0])
    out = tmp_path / "out"
    assert run("export", session.session_id, "--out", str(out))[0] == 0
    (out / "recording-01.mcap").unlink()
    (out / "recording-of-mine.mcap").touch()
    code, _, err = run("export", other.session_id, "--out", str(out))
    assert (code, "exists already" in err) == (1, True)
    assert (out / "recording-02.mcap").exists()
    assert run("export", other.session_id, "--out", str(out), "--overwrite")[0] == 0
    left = sorted(path.name for path in out.iterdir())
    assert left == ["recording-01.mcap", "recording-of-mine.mcap"]


def test_an_export_is_noted_before_it_is_written(run, folder, session, tmp_path, monkeypatch):
    def full(_report, path):
        raise FileError("{file} cannot be written: the disk is full.", file=path.name)

    monkeypatch.setattr("adibas.reports.write_report", full)
    assert run("export", session.session_id, "--out", str(tmp_path / "out"))[0] == 1
    with open_sample(folder) as store:
        exports = [entry for entry in store.audit.entries() if entry.action == "export"]
    assert exports[0].detail["kind"] == "json"


def test_verify_ends_with_1_when_something_is_wrong(run, folder, session):
    assert session.session_id
    code, out, _ = run("verify")
    assert code == 0
    assert "all is well" in out
    path = next((folder / "pictures").rglob("*.sealed"))
    path.write_bytes(path.read_bytes()[:-1])
    code, out, err = run("verify")
    assert code == 1
    assert path.stem in err
    code, out, _ = run("verify", "--json")
    assert code == 1
    assert [finding["kind"] for finding in json.loads(out)["findings"]] == ["changed"]


def test_verify_prints_the_last_lines_of_the_log_when_asked(run, session):
    code, out, _ = run("verify", "--entries", "3")
    assert code == 0
    lines = out.splitlines()
    assert len(lines) == 4
    assert "created" in lines[0]
    assert lines[0].endswith(session.patient)
    assert lines[2].endswith("opened  the patient store")
    assert NAME not in out
    entries = as_json(run, "verify", "--entries", "1000")["entries"]
    sequences = [entry["sequence"] for entry in entries]
    assert sequences == sorted(sequences, reverse=True)
    assert sequences[-1] == 1
    assert {entry["patient"] for entry in entries} == {session.patient, ""}
    assert as_json(run, "verify")["entries"] == []
    with pytest.raises(SystemExit):
        run("verify", "--entries", "0")


def test_purge_wants_a_yes(run, session):
    for subject in (session.session_id, session.patient):
        code, _, err = run("purge", subject)
        assert code == 1
        assert "--yes" in err
    assert as_json(run, "list")["patients"][0]["sessions"] != []
    assert run("purge", session.session_id, "--yes")[0] == 0
    assert as_json(run, "list")["patients"][0]["sessions"] == []
    assert run("purge", session.patient, "--yes")[0] == 0
    assert as_json(run, "list") == {"patients": []}


def test_a_store_that_another_window_holds_is_listed_but_not_purged(run, folder, session):
    with open_sample(folder):
        assert as_json(run, "list")["patients"] != []
        code, _, err = run("purge", session.patient, "--yes")
    assert code == 1
    assert "open in another window" in err


def test_no_store_is_made_by_looking_for_one(run, folder):
    code, _, err = run("list")
    assert code == 1
    assert "no patient store" in err
    assert not folder.exists()


def test_the_passphrase_comes_from_a_file_before_the_environment(
    run, session, tmp_path, monkeypatch
):
    file = tmp_path / "passphrase"
    file.write_text(f"{PASSPHRASE}\r\nanother line\n", encoding="utf-8")
    monkeypatch.setenv("ADIBAS_PASSPHRASE", "a wrong guess")
    assert session.patient in run("list", "--passphrase-file", str(file))[1]
    code, _, err = run("list")
    assert (code, "is wrong" in err) == (1, True)
    monkeypatch.delenv("ADIBAS_PASSPHRASE")
    code, _, err = run("list")
    assert (code, "is locked" in err) == (1, True)
    code, _, err = run("list", "--passphrase-file", str(tmp_path / "nothing"))
    assert (code, "nothing cannot be read" in err) == (1, True)


def test_without_a_passphrase_the_error_says_how_to_give_it(run, session, monkeypatch):
    assert session.session_id
    monkeypatch.delenv("ADIBAS_PASSPHRASE")
    code, _, err = run("list")
    assert (code, "--passphrase-file FILE" in err, "ADIBAS_PASSPHRASE" in err) == (1, True, True)


@pytest.fixture
def typed(monkeypatch):
    """A terminal at which the passphrase is typed; gives the questions."""
    questions = []

    def answer(question):
        questions.append(question)
        return PASSPHRASE

    monkeypatch.delenv("ADIBAS_PASSPHRASE")
    monkeypatch.setattr("sys.stdin", Mock(isatty=lambda: True))
    monkeypatch.setattr("getpass.getpass", answer)
    return questions


def test_a_terminal_is_asked_for_the_passphrase_and_does_not_show_it(run, session, typed):
    code, out, err = run("list")
    assert (code, session.patient in out) == (0, True)
    assert typed == ["Passphrase of the patient store: "]
    assert PASSPHRASE not in out + err


def test_who_types_nothing_is_told_how_else_to_give_the_passphrase(
    run, session, typed, monkeypatch
):
    assert session.session_id

    def end_of_input(_question):
        raise EOFError

    for answer in (lambda _question: "", end_of_input):
        monkeypatch.setattr("getpass.getpass", answer)
        code, _, err = run("list")
        assert (code, "--passphrase-file FILE" in err) == (1, True)
    assert typed == []


def test_a_passphrase_is_typed_once_to_be_changed(folder, session, typed, monkeypatch):
    assert session.session_id
    monkeypatch.setenv("ADIBAS_NEW_PASSPHRASE", "quite another sentence")
    assert main(["sessions", "people", "passphrase", "--store", str(folder)]) == 0
    assert typed == ["Passphrase of the patient store: "]


def test_a_terminal_is_asked_for_the_passphrase_of_a_backup(run, session, typed, tmp_path):
    assert session.session_id
    backup = tmp_path / "all.adibas-backup"
    assert run("backup", "--out", str(backup))[0] == 0
    assert main(["sessions", "restore", str(backup), "--into", str(tmp_path / "new")]) == 0
    assert typed[-1] == "Passphrase of the backup: "


def test_the_passphrase_of_the_environment_is_for_stores_that_need_one(folder, run, monkeypatch):
    from adibas.sessions import open_store

    use_keyring(monkeypatch, MemoryKeyring())
    open_store(folder).close()
    assert run("list")[0] == 0


def test_the_store_of_the_user_is_taken_where_none_is_named(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("adibas.sessions.default_store_folder", lambda: tmp_path / "mine")
    assert default_store_folder() != tmp_path / "mine"
    assert main(["sessions", "list"]) == 1
    assert str(tmp_path / "mine") in capsys.readouterr().err


@pytest.mark.parametrize("action", ["show", "export"])
def test_a_session_that_is_not_there_is_one_sentence(run, session, tmp_path, action):
    assert session.session_id
    out = ["--out", str(tmp_path / "out")] if action == "export" else []
    code, _, err = run(action, "ab12", *out)
    assert code == 1
    assert "no session ab12" in err


def test_a_passphrase_file_may_begin_with_the_mark_of_windows(run, session, tmp_path):
    file = tmp_path / "passphrase.txt"
    file.write_text(f"{PASSPHRASE}\r\n", encoding="utf-8-sig")
    code, out, _ = run("list", "--passphrase-file", str(file))
    assert (code, session.patient in out) == (0, True)


def test_a_passphrase_file_without_line_ends_is_one_sentence(run, session, tmp_path):
    assert session.session_id
    file = tmp_path / "film"
    file.write_bytes(bytes(100_000))
    code, _, err = run("list", "--passphrase-file", str(file))
    assert (code, "first line is too long" in err) == (1, True)


def test_a_passphrase_that_is_no_text_is_wrong_and_damages_nothing(run, session, monkeypatch):
    assert session.session_id
    monkeypatch.setenv("ADIBAS_PASSPHRASE", "\udcff\udcfe long enough")
    code, _, err = run("list")
    assert (code, "passphrase is wrong" in err) == (1, True)


def test_an_id_that_is_no_text_is_one_sentence(run, session):
    assert session.session_id
    code, _, err = run("show", "\udcff")
    assert (code, "half a character" in err, "udcff" in err) == (1, True, False)


def test_what_is_held_of_a_patient_is_listed_and_nothing_is_changed(run, folder, session):
    code, out, _ = run("holdings", session.patient)
    assert code == 0
    assert "What the program cannot reach" in out
    assert session.session_id in out
    assert not set(NAME.split()) & set(out.split())
    told = as_json(run, "holdings", session.patient)
    assert [one["session_id"] for one in told["sessions"]] == [session.session_id]
    assert told["size_bytes"] > 0
    with open_sample(folder) as store:
        assert all(one.is_standing for one in store.patients.get(session.patient).consents)


def test_withdrawing_ends_every_consent_that_stands_and_lists_what_is_held(run, folder, session):
    with open_sample(folder) as store:
        n_standing = len(store.patients.get(session.patient).consents)
    told = as_json(run, "withdraw", session.patient)
    assert told["withdrawn"] == n_standing
    assert all(one["withdrawn_utc"] for one in told["consents"])
    assert len(told["sessions"]) == 1
    with open_sample(folder) as store, pytest.raises(ConsentError):
        store.sessions.start(session.patient, session.setup)
    code, out, _ = run("withdraw", session.patient)
    assert (code, "No consent of this patient stands" in out) == (0, True)


def test_planned_backups_are_told_with_the_folder_that_is_named(run, folder, session, tmp_path):
    plan = BackupPlan(tmp_path / "backups")
    plan.folder.mkdir()
    with open_sample(folder, clock=minutes_clock(LATE)) as store:
        path, _summary = store.backups.write_planned(plan)
    told = as_json(run, "holdings", session.patient, "--backups", str(plan.folder), "--keep", "2")
    assert [one["file"] for one in told["backups"]] == [path.name]
    assert told["backups"][0]["until"] == "2027-01-15"


def test_nobody_of_that_pseudonym_is_one_sentence(run, session):
    assert session.patient
    for action in ("holdings", "withdraw"):
        code, _, err = run(action, "P-NOBODY")
        assert (code, "There is no patient P-NOBODY" in err) == (1, True)


def test_a_name_cannot_steer_the_terminal(run, folder):
    with open_sample(folder) as store:
        store.patients.add(Identity("Ana\n\x1b[2JEva"))
    _, out, _ = run("list", "--names")
    assert "Ana \N{WHITE SQUARE}[2JEva" in out
    assert len(out.splitlines()) == 1


def test_a_user_whose_name_is_no_text_opens_the_store(run, session, monkeypatch):
    monkeypatch.setattr("getpass.getuser", lambda: "dr\udcff")
    assert session.patient in run("list")[1]


def test_export_of_a_cut_recording_tells_what_is_missing(run, folder, session, tmp_path):
    for path in (folder / "recordings").rglob("*.sealed"):
        with path.open("r+b") as file:
            file.truncate(path.stat().st_size * 2 // 3)
    code, out, err = run("export", session.session_id, "--out", str(tmp_path / "out"))
    assert code == 0
    with open_recording(tmp_path / "out" / "recording-01.mcap") as reader:
        assert 0 < len(reader) < 3
        assert f"recording-01.mcap: {len(reader)} frame" in out
    assert err.count("sealed is cut") == 2
