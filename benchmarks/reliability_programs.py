"""Two programs on one store, again and again: one writes and is killed, the other takes over.

``--amount`` is the number of rounds in this run; the next one goes on with other seeds.
"""

import tempfile
from collections.abc import Iterable
from pathlib import Path

from benchmarks.long_run import Run, problem_rows
from benchmarks.store_work import make_store
from benchmarks.table import Row
from benchmarks.two_programs import one_round

WHOLE, QUICK = 100, 2
ROUNDS_OF_A_STORE = 10


def rows(run: Run) -> Iterable[Row]:
    """Open stores twice."""
    done = run.kept("programs", {"n_rounds": 0, "saved": 0, "problems": []})
    to_do = run.n_to_do(WHOLE, done["n_rounds"], QUICK)
    for first in range(0, to_do, ROUNDS_OF_A_STORE):
        n_rounds = min(ROUNDS_OF_A_STORE, to_do - first)
        with tempfile.TemporaryDirectory() as name:
            store = Path(name) / "store"
            acknowledged = make_store(store)
            for number in range(n_rounds):
                run.progress(first + number, to_do)
                told = one_round(store, done["n_rounds"], acknowledged)
                done["n_rounds"] += 1
                done["problems"] += [f"round {told.seed}: {one}" for one in told.problems]
        done["saved"] += told.n_saved
        done.keep()
    yield Row("rounds of two programs on one store", done["n_rounds"], "rounds", WHOLE, "goal")
    yield Row("things saved by both", done["saved"], "things")
    yield from problem_rows("things lost or damaged, or two writers", done["problems"])
