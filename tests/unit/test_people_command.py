"""`adibas sessions people`, and what the other commands refuse to whom."""

import json

import pytest

from adibas.cli import main
from adibas.sessions import open_store
from adibas.sessions import people as people_module
from adibas.sessions.roles import Role
from tests.unit.store_samples import CHEAP, NAME, PASSPHRASE, add_capture, add_session, open_sample

ANNA, BORIS, CARLA = "anna has a long one", "boris likes numbers 7", "carla, still another"


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


@pytest.fixture
def session(folder):
    with open_sample(folder) as store:
        session = add_session(store)
        add_capture(store, session)
        return session


@pytest.fixture
def run(folder, capsys, monkeypatch):
    """Run the command as somebody; gives exit code, stdout, stderr."""
    monkeypatch.setattr(people_module, "Argon2Params", lambda: CHEAP)

    def command(passphrase, *arguments, new=None):
        monkeypatch.setenv("ADIBAS_PASSPHRASE", passphrase)
        monkeypatch.delenv("ADIBAS_NEW_PASSPHRASE", raising=False)
        if new is not None:
            monkeypatch.setenv("ADIBAS_NEW_PASSPHRASE", new)
        code = main(["sessions", *arguments, "--store", str(folder)])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return command


@pytest.fixture
def people(run, session):
    """Anna, Boris and Carla, added by the command."""
    told = run(PASSPHRASE, "people", "add", "Anna", new=ANNA)
    assert told[0] == 0, told
    assert "From now on only people open it" in told[1]
    assert run(ANNA, "people", "add", "Boris", "--role", "clinician", new=BORIS)[0] == 0
    assert run(ANNA, "people", "add", "Carla", new=CARLA)[0] == 0
    return session


def test_who_may_not_export_removes_nothing_of_an_earlier_export(run, people, tmp_path):
    (tmp_path / "recording-09.mcap").touch()
    export = ("export", people.session_id, "--out", str(tmp_path), "--overwrite")
    code, _, err = run(CARLA, *export)
    assert (code, "is only for clinicians" in err) == (1, True)
    assert (tmp_path / "recording-09.mcap").exists()


def test_the_first_is_administrator_and_the_next_an_operator_if_nothing_is_said(run, people):
    assert people
    told = json.loads(run(ANNA, "people", "list", "--json")[1])
    assert told["people"] == [
        {"name": "Anna", "role": "administrator"},
        {"name": "Boris", "role": "clinician"},
        {"name": "Carla", "role": "operator"},
    ]
    assert told["you"] == "Anna"
    assert "purge" in told["may"]["administrator"]
    assert "purge" not in told["may"]["clinician"]
    listed = run(ANNA, "people", "list")[1]
    assert "Carla  Operator" in listed
    assert "Clinician may:" in listed


def test_a_store_without_people_says_so(run, session):
    assert session
    assert "has no people" in run(PASSPHRASE, "people", "list")[1]


def test_roles_and_passphrases_change_and_people_go(run, folder, people):
    assert people
    assert run(ANNA, "people", "role", "Carla", "clinician")[0] == 0
    assert run(CARLA, "people", "passphrase", new="carla has a new one")[0] == 0
    assert run(ANNA, "people", "passphrase", "Boris", new="boris forgot his own")[0] == 0
    with open_store(folder, "carla has a new one") as store:
        assert store.role is Role.CLINICIAN
    code, _, err = run(ANNA, "people", "remove", "Boris")
    assert (code, "--yes" in err) == (1, True)
    assert run(ANNA, "people", "remove", "Boris", "--yes")[0] == 0
    assert run("boris forgot his own", "list")[0] == 1


def test_a_new_passphrase_has_to_come_from_somewhere(run, tmp_path, people):
    assert people
    code, _, err = run(ANNA, "people", "add", "Dora")
    assert (code, "--new-passphrase-file" in err) == (1, True)
    file = tmp_path / "dora.txt"
    file.write_text("dora keeps it in a file\n")
    assert run(ANNA, "people", "add", "Dora", "--new-passphrase-file", str(file))[0] == 0
    assert run("dora keeps it in a file", "list")[0] == 0


def test_each_command_obeys_the_role(run, tmp_path, people):
    session_id, pseudonym = people.session_id, people.patient
    refused = {
        CARLA: (
            ("list", "--names"),
            ("export", session_id, "--out", str(tmp_path / "out")),
            ("reliability", "--protocol", "sapo-1"),
        ),
        BORIS: (
            ("purge", pseudonym, "--yes"),
            ("retention",),
            ("retention", "--apply"),
            ("verify", "--entries", "5"),
            ("backup", "--out", str(tmp_path / "all.adibas-backup")),
            ("people", "list"),
            ("people", "add", "Dora"),
            ("to-server", "postgresql://adibas@localhost/adibas"),
        ),
    }
    for command in (*refused[CARLA], *refused[BORIS]):
        code, _, err = run(CARLA, *command)
        assert (code, "only for" in err) == (1, True), (command, err)
    for command in refused[BORIS]:
        code, _, err = run(BORIS, *command)
        assert (code, "only for administrators" in err) == (1, True), (command, err)
    assert list(tmp_path.iterdir()) == [tmp_path / "store"]
    assert run(CARLA, "show", session_id)[0] == 0
    assert NAME in run(BORIS, "list", "--names")[1]
    told = json.loads(run(ANNA, "verify", "--entries", "1000", "--json")[1])
    refusals = [one for one in told["entries"] if one["action"] == "refuse"]
    assert len(refusals) == len(refused[CARLA]) + 2 * len(refused[BORIS])
    assert {one["operator"] for one in refusals} == {"Boris", "Carla"}
