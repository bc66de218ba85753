"""`adibas sessions recovery-key` and `recover`, what restores take, and the printed page."""

import errno
import io
import json
import sys
import tempfile
from datetime import UTC, datetime

import pytest
from pypdf import PdfReader

from adibas.cli import main, sessions_people, store_options
from adibas.files import cannot_write
from adibas.reports import recovery_sheet as recovery_pages
from adibas.reports.recovery_sheet import recovery_sheet, write_recovery_pdf
from adibas.sessions import open_store
from adibas.sessions import people as people_module
from adibas.sessions.recovery_key import make_recovery_key, read_recovery_key
from adibas.sessions.roles import Role
from adibas.texts import LANGUAGES, speaking
from tests.unit.store_samples import CHEAP, NAME, PASSPHRASE, add_session, open_sample

ANNA, BORIS, NEW = "anna has a long one", "boris likes numbers 7", "a new one is chosen"
MADE = datetime(2026, 11, 25, 12, 0, tzinfo=UTC)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(people_module, "Argon2Params", lambda: CHEAP)
    for name in ("ADIBAS_PASSPHRASE", "ADIBAS_NEW_PASSPHRASE", "ADIBAS_RECOVERY_KEY"):
        monkeypatch.delenv(name, raising=False)
    with open_sample(tmp_path / "store") as store:
        add_session(store)
    return tmp_path / "store"


@pytest.fixture
def run(folder, capsys, monkeypatch):
    """Run an action as somebody; gives exit code, stdout, stderr."""

    def command(passphrase, *arguments):
        monkeypatch.setenv("ADIBAS_PASSPHRASE", passphrase)
        code = main(["sessions", *arguments, "--store", str(folder)])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return command


@pytest.fixture
def file_with(tmp_path):
    """Write a line into a file and return its path."""

    def write(name, line):
        (tmp_path / name).write_text(f"{line}\n", encoding="utf-8")
        return str(tmp_path / name)

    return write


def made(run, passphrase=PASSPHRASE):
    return json.loads(run(passphrase, "recovery-key", "--json")[1])["recovery_key"]


def test_the_key_is_told_once_and_no_second_time(run, folder):
    code, out, err = run(PASSPHRASE, "recovery-key")
    recovery_key = out.splitlines()[0]
    assert (code, err) == (0, "")
    assert read_recovery_key(recovery_key) == recovery_key
    assert "kept nowhere" in out
    assert "opens the store no more" not in out
    code, out, _err = run(PASSPHRASE, "recovery-key")
    assert recovery_key not in out
    assert "opens the store no more" in out
    told = b"".join(path.read_bytes() for path in folder.rglob("*") if path.is_file())
    assert recovery_key.encode() not in told


def test_as_json_the_key_is_on_stdout_alone(run):
    code, out, err = run(PASSPHRASE, "recovery-key", "--json")
    told = json.loads(out)
    assert code == 0
    assert read_recovery_key(told["recovery_key"]) == told["recovery_key"]
    assert (told["replaced"], told["out"]) == (False, None)
    assert told["recovery_key"] not in err
    assert json.loads(run(PASSPHRASE, "recovery-key", "--json")[1])["replaced"] is True


def test_who_is_no_administrator_makes_none(run, folder):
    with open_sample(folder) as store:
        store.people.add("Anna", Role.ADMINISTRATOR, ANNA, CHEAP)
        store.people.add("Boris", Role.CLINICIAN, BORIS, CHEAP)
    before = (folder / "key.json").read_bytes()
    code, out, err = run(BORIS, "recovery-key")
    assert (code, out) == (1, "")
    assert "only for administrators" in err
    assert (folder / "key.json").read_bytes() == before


def test_a_page_that_is_there_is_not_replaced_and_no_key_is_made(run, folder, file_with):
    path, before = file_with("key.pdf", "mine"), (folder / "key.json").read_bytes()
    code, out, err = run(PASSPHRASE, "recovery-key", "--out", path)
    assert (code, out) == (1, "")
    assert "exists already" in err
    assert (folder / "key.json").read_bytes() == before
    assert run(PASSPHRASE, "recovery-key", "--out", path, "--overwrite")[0] == 0


def test_a_page_that_cannot_be_written_leaves_the_key_of_before(run, folder, tmp_path, monkeypatch):
    made(run)
    before = (folder / "key.json").read_bytes()

    def full(path, _sheet):
        raise cannot_write(path, OSError(errno.ENOSPC, "no space"))

    monkeypatch.setattr(recovery_pages, "write_recovery_pdf", full)
    code, out, err = run(PASSPHRASE, "recovery-key", "--out", str(tmp_path / "key.pdf"))
    assert (code, out) == (1, "")
    assert "the disk is full" in err
    assert (folder / "key.json").read_bytes() == before


def test_the_store_opens_by_the_key_and_with_the_new_passphrase(run, folder, file_with):
    arguments = (
        *("--recovery-key-file", file_with("key", made(run).lower())),
        *("--new-passphrase-file", file_with("new", NEW)),
    )
    code, out, err = run("forgotten", "recover", *arguments)
    assert (code, err) == (0, "")
    assert "From now on the new passphrase opens" in out
    with open_store(folder, NEW) as store:
        assert len(store.patients.search("")) == 1
    assert run(PASSPHRASE, "list")[0] == 1


def test_key_and_passphrase_may_be_in_the_environment(run, folder, monkeypatch):
    monkeypatch.setenv("ADIBAS_RECOVERY_KEY", made(run))
    monkeypatch.setenv("ADIBAS_NEW_PASSPHRASE", NEW)
    assert json.loads(run("forgotten", "recover", "--json")[1]) == {"name": None}
    open_store(folder, NEW).close()


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_in_a_terminal_both_are_asked_for_unseen(run, folder, monkeypatch):
    answers, questions = [made(run), NEW, NEW], []

    def answer(question):
        questions.append(question)
        return answers.pop(0)

    monkeypatch.setattr(sys, "stdin", Terminal())
    for module in (store_options, sessions_people):
        monkeypatch.setattr(module.getpass, "getpass", answer)
    assert run("forgotten", "recover")[0] == 0
    assert questions == ["Recovery key: ", "New passphrase: ", "Once more: "]
    open_store(folder, NEW).close()


def test_where_nobody_can_be_asked_it_is_said_how_the_key_is_given(run):
    code, _out, err = run("forgotten", "recover")
    assert code == 1
    assert "--recovery-key-file FILE" in err
    assert "ADIBAS_RECOVERY_KEY" in err


def test_wrong_mistyped_and_missing_keys_are_told_apart(run, folder, file_with):
    def told(recovery_key):
        code, out, err = run(
            "forgotten",
            *("recover", "--recovery-key-file", file_with("key", recovery_key)),
            *("--new-passphrase-file", file_with("new", NEW)),
        )
        assert (code, out) == (1, "")
        return err

    assert "has no recovery key" in told(make_recovery_key())
    right = made(run)
    before = (folder / "key.json").read_bytes()
    assert "belongs to another store" in told(make_recovery_key())
    assert "mistyped" in told(("2" if right[0] != "2" else "3") + right[1:])
    assert (folder / "key.json").read_bytes() == before


def test_of_several_administrators_one_is_named(run, folder, file_with):
    with open_sample(folder) as store:
        store.people.add("Anna", Role.ADMINISTRATOR, ANNA, CHEAP)
        store.people.add("Carla", Role.ADMINISTRATOR, "carla, still another", CHEAP)
    files = (
        *("--recovery-key-file", file_with("key", made(run, ANNA))),
        *("--new-passphrase-file", file_with("new", NEW)),
    )
    code, _out, err = run("forgotten", "recover", *files)
    assert code == 1
    assert "Anna, Carla" in err
    assert json.loads(run("x", "recover", *files, "--name", "carla", "--json")[1]) == {
        "name": "Carla"
    }
    with open_store(folder, NEW) as store:
        assert store.person.name == "Carla"


@pytest.fixture
def backup(run, tmp_path):
    """A backup, and the recovery key that held when it was made."""
    path, recovery_key = tmp_path / "one.adibas-backup", made(run)
    assert run(PASSPHRASE, "backup", "--out", str(path))[0] == 0
    return str(path), recovery_key


def test_a_backup_is_tried_out_and_restored_by_its_recovery_key(
    run, backup, tmp_path, file_with, capsys
):
    path, recovery_key = backup
    made(run)  # another one holds in the store
    key_file = ("--recovery-key-file", file_with("key", recovery_key))
    assert main(["sessions", "verify-backup", path, *key_file, "--temporary", str(tmp_path)]) == 0
    into = tmp_path / "restored"
    assert run("not it", "restore", path, "--into", str(into), *key_file)[0] == 0
    new = ("--new-passphrase-file", file_with("new", NEW))
    assert main(["sessions", "recover", "--store", str(into), *key_file, *new]) == 0
    with open_store(into, NEW) as store:
        assert len(store.patients.search("")) == 1
    capsys.readouterr()


def test_a_mistyped_key_of_a_backup_is_told_as_such(run, backup, tmp_path, file_with):
    path, recovery_key = backup
    mistyped = ("2" if recovery_key[0] != "2" else "3") + recovery_key[1:]
    for typed, told in ((mistyped, "mistyped"), (make_recovery_key(), "nor the recovery key")):
        arguments = ("--into", str(tmp_path / "new"), "--recovery-key-file", file_with("k", typed))
        code, _out, err = run(PASSPHRASE, "restore", path, *arguments)
        assert code == 1
        assert told in err


def test_what_makes_a_store_says_how_it_gets_a_recovery_key(run, folder, tmp_path, backup):
    command = "adibas sessions recovery-key --store"
    with_key = run(PASSPHRASE, "restore", backup[0], "--into", str(tmp_path / "with"))
    assert command not in with_key[1]
    with open_sample(tmp_path / "other") as store:
        store.backups.write(tmp_path / "other.adibas-backup")
    into = tmp_path / "without"
    code, out, _err = run(
        PASSPHRASE, "restore", str(tmp_path / "other.adibas-backup"), "--into", str(into)
    )
    assert code == 0
    assert f"{command} {into}" in out
    assert folder.is_dir()


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_page_has_the_key_in_groups_and_nothing_of_patients(tmp_path, language):
    recovery_key, store_id, path = make_recovery_key(), "0123456789abcdef" * 2, tmp_path / "a.pdf"
    with speaking(language):
        write_recovery_pdf(path, recovery_sheet(recovery_key, store_id, MADE))
    reader = PdfReader(path)
    (page,) = reader.pages
    width, height = (float(side) / 72 * 25.4 for side in page.mediabox.upper_right)
    assert (round(width), round(height)) == (210, 297)
    text = " ".join(page.extract_text().split())
    assert all(group in text for group in recovery_key.split("-"))
    for told in ("ADiBAS 0.1.0", store_id, "2026-11-25", "adibas sessions recover"):
        assert told in text
    sizes = []
    page.extract_text(visitor_text=lambda text, _cm, _tm, _font, size: sizes.append((text, size)))
    key_sizes = [size for text, size in sizes if recovery_key[:4] in text]
    assert min(key_sizes) >= 24


def test_the_page_is_the_only_file_that_has_the_key(run, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    out = tmp_path / "kept" / "key.pdf"
    code, told, _err = run(PASSPHRASE, "recovery-key", "--out", str(out))
    assert code == 0
    recovery_key = told.splitlines()[0]
    assert recovery_key[:4] in PdfReader(out).pages[0].extract_text()
    assert NAME not in PdfReader(out).pages[0].extract_text()
    assert [path.name for path in out.parent.iterdir()] == ["key.pdf"]
    others = [path for path in tmp_path.rglob("*") if path.is_file() and path != out]
    assert not [path for path in others if recovery_key.encode() in path.read_bytes()]
    assert not [path for path in others if path.suffix == ".pdf"]
