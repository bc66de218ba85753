"""Two programs that open one store at the same moment: one writes, the other reads."""

import json
import multiprocessing
import time
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from adibas.data.patients import Identity
from adibas.errors import StoreError
from adibas.sessions import SessionStore, open_store
from benchmarks.crash_trial import Acknowledged, Outcome, look
from benchmarks.crash_victim import CHEAP, PASSPHRASE, Victim

SECONDS_TO_ANSWER = 120.0
LONGEST_WORK_S = 0.5
FRAMES = 30


@dataclass(slots=True)
class Round:
    """What one pair of programs did.

    Attributes
    ----------
    seed : int
    n_saved : int
        Things that either said was saved.
    problems : list of str
        Everything that must not be.
    """

    seed: int
    n_saved: int = 0
    problems: list[str] = field(default_factory=list)


def program(folder: str, seed: int, pipe: Connection) -> None:
    """Open the store and do what is asked until the pipe ends."""
    store = open_store(Path(folder), PASSPHRASE, operator=f"op {seed}", key_params=CHEAP)
    pipe.send_bytes(json.dumps(["opened", "reader" if store.is_read_only else "writer"]).encode())
    victim = Victim(store, pipe, np.random.default_rng(seed), FRAMES)
    while True:
        asked = pipe.recv_bytes()
        if asked == b"work":
            victim.work_for_ever()
        elif asked == b"read":
            pipe.send_bytes(json.dumps(["read", _read(store)]).encode())
        elif asked == b"again":
            store.close()
            store = open_store(Path(folder), PASSPHRASE, operator=f"op {seed}", key_params=CHEAP)
            role = "reader" if store.is_read_only else "writer"
            pipe.send_bytes(json.dumps(["opened", role]).encode())
            victim = Victim(store, pipe, np.random.default_rng(seed), FRAMES)
        else:
            victim.work_once(victim.add_patient())
            pipe.send_bytes(b'["done", ""]')


def _read(store: SessionStore) -> str:
    """Look at everything, and try to change something; return what is wrong."""
    for patient in store.patients.search(""):
        for session in store.sessions.of_patient(patient.pseudonym):
            store.captures.of_session(session.session_id)
    try:
        store.patients.add(Identity("Nobody"))
    except StoreError:
        return ""
    return "the reader could write"


def one_round(folder: Path, seed: int, acknowledged: Acknowledged) -> Round:
    """Let two programs open the store, kill the writer, and let the other one take over."""
    told = Round(seed)
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["benchmarks.two_programs"])
    pipes, processes = [], []
    for number in range(2):
        ours, theirs = context.Pipe()
        process = context.Process(
            target=program, args=(str(folder), 2 * seed + number, theirs), daemon=True
        )
        process.start()
        theirs.close()
        pipes.append(ours)
        processes.append(process)
    try:
        _together(pipes, processes, told, acknowledged)
    except (EOFError, OSError, TimeoutError) as error:
        told.problems.append(f"a program ended: {error!r}")
    for process in processes:
        process.kill()
        process.join()
    outcome = Outcome(seed, 0.0)
    look(folder, outcome, acknowledged, Acknowledged())
    told.n_saved = outcome.n_saved
    told.problems += outcome.problems
    return told


def _together(
    pipes: list[Connection],
    processes: "list[multiprocessing.context.ForkServerProcess]",
    told: Round,
    acknowledged: Acknowledged,
) -> None:
    roles = [_answer(pipe, acknowledged) for pipe in pipes]
    if sorted(roles) != ["reader", "writer"]:
        told.problems.append(f"of two programs there are {roles}")
        return
    writer = roles.index("writer")
    reading = pipes[1 - writer]
    pipes[writer].send_bytes(b"work")
    until_s = time.monotonic() + LONGEST_WORK_S * float(np.random.default_rng(told.seed).random())
    while time.monotonic() < until_s:
        reading.send_bytes(b"read")
        if wrong := _answer(reading, acknowledged):
            told.problems.append(wrong)
    processes[writer].kill()
    processes[writer].join()
    _drain(pipes[writer], acknowledged)
    reading.send_bytes(b"again")
    if _answer(reading, acknowledged) != "writer":
        told.problems.append("nobody can write after the writer was killed")
        return
    reading.send_bytes(b"once")
    _answer(reading, acknowledged)


def _answer(pipe: Connection, acknowledged: Acknowledged) -> str:
    """Return what a program answers; note what it says that it saved meanwhile."""
    until_s = time.monotonic() + SECONDS_TO_ANSWER
    while pipe.poll(max(0.0, until_s - time.monotonic())):
        said = json.loads(pipe.recv_bytes())
        if said[0] in ("opened", "read", "done"):
            return str(said[1])
        acknowledged.take(said)
    raise TimeoutError("no answer")


def _drain(pipe: Connection, acknowledged: Acknowledged) -> None:
    try:
        while pipe.poll(SECONDS_TO_ANSWER):
            acknowledged.take(json.loads(pipe.recv_bytes()))
    except (EOFError, OSError):
        return
