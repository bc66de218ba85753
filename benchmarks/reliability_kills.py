"""Kills at random moments while recording and saving: nothing that was acknowledged is lost.

``--amount`` is the number of kills in this run; the next one goes on with other seeds.
"""

import tempfile
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from benchmarks.crash_trial import KILLS_PER_STORE, Outcome, kill_often
from benchmarks.long_run import Run, problem_rows
from benchmarks.table import Row

WHOLE, QUICK = 10_000, 20
N_LANES = 2
AT_ONCE = N_LANES * KILLS_PER_STORE
"""Kills after which the counts are kept."""
NOTHING: dict[str, Any] = {
    "n_kills": 0, "problems": [], "frames_lost": 0, "saved": 0, "interrupted": 0, "early": 0,
    "opening_s": 0.0,
}  # fmt: skip


def rows(run: Run) -> Iterable[Row]:
    """Kill."""
    done = run.kept("kills", NOTHING)
    to_do = run.n_to_do(WHOLE, done["n_kills"], QUICK)
    for n_now in range(0, to_do, AT_ONCE):
        run.progress(n_now, to_do)
        done |= _with(done, kill_side_by_side(AT_ONCE, done["n_kills"]))
        done.keep()
    yield from _told(done)


def _with(done: dict[str, Any], outcomes: list[Outcome]) -> dict[str, Any]:
    problems = [
        f"seed {one.seed}, {one.moment_s:.3f} s: {problem}"
        for one in outcomes
        for problem in one.problems
    ]
    last_of_each = [one.n_saved for one in outcomes if (one.seed + 1) % KILLS_PER_STORE == 0]
    return {
        "n_kills": done["n_kills"] + len(outcomes),
        "problems": [*done["problems"], *problems],
        "frames_lost": max(done["frames_lost"], *(one.n_frames_lost for one in outcomes)),
        "saved": done["saved"] + sum(last_of_each),
        "interrupted": done["interrupted"] + sum(one.n_interrupted for one in outcomes),
        "early": done["early"] + sum(one.n_saved == 0 for one in outcomes),
        "opening_s": max(done["opening_s"], *(one.opening_s for one in outcomes)),
    }


def _told(done: dict[str, Any]) -> Iterable[Row]:
    after = f"after {done['n_kills']:,} kills at random moments"
    yield Row("kills", done["n_kills"], "kills", WHOLE, "goal")
    yield from problem_rows(f"things lost or damaged {after}", done["problems"])
    lost = done["frames_lost"]
    yield Row(f"most written frames lost by one kill {after}", lost, "frames", 30, "goal <=")
    yield Row("saved patients, sessions, captures and recordings", done["saved"], "things")
    yield Row("recordings that say that they were interrupted", done["interrupted"], "recordings")
    yield Row("kills before anything was saved in a store", done["early"], "kills")
    yield Row("longest opening after a kill", 1e3 * done["opening_s"], "ms")


def kill_side_by_side(n_kills: int, first_seed: int = 0) -> list[Outcome]:
    """Kill `n_kills` processes with the seeds from `first_seed` on, in two stores at a time."""
    per_lane = n_kills // N_LANES
    starts = [first_seed + lane * per_lane for lane in range(N_LANES)]
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(N_LANES) as pool:

        def kill_in_one(start: int) -> list[Outcome]:
            return list(kill_often(Path(folder) / str(start), range(start, start + per_lane)))

        return [outcome for lane in pool.map(kill_in_one, starts) for outcome in lane]
