"""Two programs edit the same session of one store on a real server, at the same time."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from adibas.sessions import open_store
from adibas.sessions.moving import move_to_server
from tests.unit import postgres_server
from tests.unit.store_samples import PASSPHRASE, add_capture, open_sample

pytestmark = pytest.mark.skipif(postgres_server.PROGRAMS is None, reason=postgres_server.MISSING)
ROOT = Path(__file__).parents[2]


server = postgres_server.server


@pytest.fixture
def capture(server, tmp_path, request):
    name = f"clinic_{abs(hash(request.node.name)) % 10**6}"
    with open_sample(tmp_path / "store") as store:
        capture = add_capture(store)
    address = server.make_database(name)
    move_to_server(tmp_path / "store", PASSPHRASE, address, server.password)
    return capture


@pytest.fixture
def work(server, tmp_path, capture):
    """Run a task on two workstations at once, after both have seen the same; gives the answers."""
    secrets = {"ADIBAS_SERVER_PASSWORD": server.password, "ADIBAS_PASSPHRASE": PASSPHRASE}

    def both(**tasks):
        ids = (capture.session_id, capture.capture_id)
        program = str(Path(__file__).with_name("workstation.py"))
        processes = [
            subprocess.Popen(
                [sys.executable, program, str(tmp_path / "store"), operator, *ids],
                env={**os.environ, "PYTHONPATH": str(ROOT), **secrets},
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
            for operator in tasks
        ]
        assert [process.stdout.readline() for process in processes] == ["seen\n"] * 2
        for process, task in zip(processes, tasks.values(), strict=True):
            process.stdin.write(json.dumps(task) + "\n")
            process.stdin.flush()
        answers = [process.communicate(timeout=120)[0] for process in processes]
        assert [process.returncode for process in processes] == [0, 0]
        return dict(zip(tasks, map(json.loads, answers), strict=True))

    return both


@pytest.fixture
def look(server, tmp_path):
    def opened():
        return open_store(tmp_path / "store", PASSPHRASE, server_password=server.password)

    return opened


def test_the_second_to_save_is_shown_the_conflict_and_both_versions_are_kept(work, look, capture):
    common = {"times": 1, "field": "rotation_deg", "label": "m01"}
    answers = work(
        Ana={**common, "notes": "left", "values": [90, 90], "u": 31.0},
        Bea={**common, "notes": "right", "values": [180, 180], "u": 41.0},
    )
    told = {operator: found for operator, found in answers.items() if found}
    mine = {"Ana": ("left", "90", 31.0), "Bea": ("right", "180", 41.0)}
    fields = ("notes", "setup.rotation_deg", "m01")
    seen = {field: who for who, found in told.items() for field, *_ in found}
    assert sorted(seen) == sorted(fields)  # each field once, to one of the two
    for second, found in told.items():
        (first,) = {"Ana", "Bea"} - {second}
        for field, operator, theirs, own in found:
            number = fields.index(field)
            assert (operator, theirs, own) == (first, mine[first][number], mine[second][number])
    with look() as store:
        session = store.sessions.get(capture.session_id)
        assert session.notes == mine[seen["notes"]][0]
        marker = store.captures.get(capture.capture_id).markers()[0]
        assert marker.u == mine[seen["m01"]][2]
        with store._database.reading() as transaction:
            n_corrections = transaction.exec_driver_sql("SELECT count(*) FROM corrections").scalar()
        assert n_corrections == 2
        over = [one.detail.get("over") for one in store.audit.entries(50)]
        assert ["notes", "setup.rotation_deg"] in over
        assert store.verify().is_sound


def test_of_many_edits_of_different_things_at_once_none_is_lost(work, look, capture):
    n_times = 25
    answers = work(
        Ana={
            "times": n_times,
            "field": "rotation_deg",
            "values": [90, 180],
            "label": "m01",
            "u": 100,
        },
        Bea={"times": n_times, "field": "protocol", "values": ["a", "b"], "label": "m02", "u": 200},
    )
    assert answers == {"Ana": [], "Bea": []}
    with look() as store:
        session = store.sessions.get(capture.session_id)
        assert (session.setup.rotation_deg, session.setup.protocol) == (90, "a")
        found = {one.label: one.u for one in store.captures.get(capture.capture_id).markers()}
        assert (found["m01"], found["m02"]) == (99 + n_times, 199 + n_times)
        lines = [one for one in store.audit.entries(500) if one.action == "change"]
        for operator in ("Ana", "Bea"):
            kinds = [bool(one.detail.get("fields")) for one in lines if one.operator == operator]
            assert (kinds.count(True), kinds.count(False)) == (n_times, n_times)
        assert store.verify().is_sound
