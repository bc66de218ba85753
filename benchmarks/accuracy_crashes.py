"""What kills at random moments take from the session store: nothing, in a thousand of them."""

import tempfile
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from benchmarks.crash_trial import KILLS_PER_STORE, Outcome, kill_often
from benchmarks.table import Row

N_KILLS = 1000
N_QUICK = 20
N_LANES = 2


def rows(*, quick: bool) -> Iterable[Row]:
    """Kill; with `quick` less often."""
    n_kills = N_QUICK if quick else N_KILLS
    outcomes = kill_side_by_side(n_kills)
    problems = [problem for outcome in outcomes for problem in outcome.problems]
    n_early = sum(outcome.n_saved == 0 for outcome in outcomes)
    last_of_each = [o.n_saved for o in outcomes if (o.seed + 1) % KILLS_PER_STORE == 0]
    after = f"after {n_kills:,} kills at random moments"
    yield Row(f"things lost or damaged {after}", len(problems), "things", 0, "goal")
    for outcome in outcomes:
        for problem in outcome.problems:
            yield Row(
                f"seed {outcome.seed}, {outcome.moment_s:.3f} s: {problem}", 1, "things", 0, "goal"
            )
    lost = max(outcome.n_frames_lost for outcome in outcomes)
    yield Row(f"most written frames lost by one kill {after}", lost, "frames", 30, "goal <=")
    yield Row("saved patients, sessions, captures and recordings", sum(last_of_each), "things")
    n_interrupted = sum(outcome.n_interrupted for outcome in outcomes)
    yield Row("recordings that say that they were interrupted", n_interrupted, "recordings")
    yield Row("kills before anything was saved in a store", n_early, "kills")
    slowest_ms = 1e3 * max(outcome.opening_s for outcome in outcomes)
    yield Row("longest opening after a kill", slowest_ms, "ms")


def kill_side_by_side(n_kills: int, first_seed: int = 0) -> list[Outcome]:
    """Kill `n_kills` processes with the seeds from `first_seed` on, in two stores at a time."""
    per_lane = n_kills // N_LANES
    starts = [first_seed + lane * per_lane for lane in range(N_LANES)]
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(N_LANES) as pool:

        def kill_in_one(start: int) -> list[Outcome]:
            return list(kill_often(Path(folder) / str(start), range(start, start + per_lane)))

        return [outcome for lane in pool.map(kill_in_one, starts) for outcome in lane]
