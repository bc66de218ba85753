"""Moments of a room far apart, aligned without any guess: how many, and none silently wrong.

With ADIBAS_BENCHMARK_RESULTS=FILE every pair is kept in that file as it is done, and one that
stands there is not done again; a file holds what one state of the program found.
"""

import json
import os
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from adibas.alignment.joint_fit import JointFit
from adibas.alignment.pairing import align_anywhere
from adibas.geometry.rigid import RigidTransform, rotation_vector
from benchmarks.mapping_rooms import room_pair
from benchmarks.table import Row

SEEDS = range(2000, 3000)
MOST_TURN_RAD, MOST_SHIFT_M = np.radians(40.0), 0.5
WRONG_M, WRONG_RAD = 0.02, np.radians(1.0)
"""An alignment that is farther off than that is wrong."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a pair.

    Attributes
    ----------
    seed : int
    refused : str
        Why it was not aligned; empty where it was, "no pair" where furniture left none.
    shift_m, turn_rad : float
        Error of the motion; 0 where it was not aligned.
    """

    seed: int
    refused: str
    shift_m: float = 0.0
    turn_rad: float = 0.0

    @property
    def is_wrong(self) -> bool:
        """Whether it was aligned, and not as it is."""
        return self.shift_m > WRONG_M or self.turn_rad > WRONG_RAD


def far_rows(seeds: range, *, keeps: bool) -> Iterator[Row]:
    """Measure pairs up to 40 degrees and 0.5 m apart."""
    kept = os.environ.get("ADIBAS_BENCHMARK_RESULTS")
    file = Path(kept) if kept and keeps else None
    done = {} if file is None else _read(file)
    for seed in seeds:
        if seed not in done:
            done[seed] = _outcome(seed)
            if file is not None:
                with file.open("a", encoding="utf-8") as lines:
                    lines.write(json.dumps(asdict(done[seed])) + "\n")
    pairs = [done[seed] for seed in seeds if done[seed].refused != "no pair"]
    aligned = [one for one in pairs if not one.refused]
    wrong = [one for one in aligned if one.is_wrong]
    n_right = len(aligned) - len(wrong)
    told = f"noisy rooms up to 40 deg and 0.5 m apart without a guess, {len(pairs)} pairs"
    yield Row(f"{told}: aligned", 100.0 * n_right / len(pairs), "%", 80.0, "goal >=")
    yield Row(
        "same: wrong by more than 2 cm or 1 deg, and not told", len(wrong), "pairs", 0.0, "goal"
    )
    shifts_mm = [1e3 * one.shift_m for one in aligned]
    yield Row("same: shift of the aligned, median error", float(np.median(shifts_mm)), "mm")
    yield Row("same: shift of the aligned, largest error", float(np.max(shifts_mm)), "mm")
    refused = Counter(one.refused for one in pairs if one.refused)
    for why, n in refused.most_common():
        yield Row(f"same: refused, {why}", float(n), "pairs")


def _outcome(seed: int) -> Outcome:
    turn_share, shift_share = np.random.default_rng([seed, 9]).uniform(0.0, 1.0, 2).tolist()
    pair = room_pair(seed, turn_share * MOST_TURN_RAD, shift_share * MOST_SHIFT_M)
    if pair is None:
        return Outcome(seed, "no pair")
    fit = align_anywhere(pair.target, pair.source)
    if not isinstance(fit, JointFit):
        return Outcome(seed, fit.value)
    return Outcome(seed, "", *motion_error(fit.target_from_source, pair.target_from_source))


def motion_error(motion: RigidTransform, truth: RigidTransform) -> tuple[float, float]:
    """Return how far a motion shifts (metres) and turns (radians) amiss."""
    apart = motion @ truth.inverse()
    turn_rad = float(np.linalg.norm(rotation_vector(apart.rotation)))
    return float(np.linalg.norm(apart.translation_m)), turn_rad


def _read(file: Path) -> dict[int, Outcome]:
    if not file.exists():
        return {}
    rows = [json.loads(line) for line in file.read_text("utf-8").splitlines() if line]
    return {row["seed"]: Outcome(**row) for row in rows}
