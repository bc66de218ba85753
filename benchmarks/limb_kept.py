"""Counts of right pixels, kept on the disk: a benchmark of hours goes on after a break."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from adibas.arrays import IntArray
from adibas.limbs.evaluation import Confusion
from benchmarks.table import Row

KEPT = Path(__file__).parents[1] / "build" / "benchmarks" / "accuracy_limbs.json"
Confusions = dict[str, IntArray]
Shares = dict[str, float]
"""Percent of right pixels by label, and of their mean."""
MEAN = "mean per label"


class Kept:
    """Confusions that were counted before, by name.

    Parameters
    ----------
    effort : str
        Figures of another effort are others.
    """

    def __init__(self, effort: str) -> None:
        self._prefix = f"{effort}: "

    def get(self, name: str, work: Callable[[], Confusions]) -> Confusions:
        """Return the confusions of `name`, counted now if they were not before."""
        key = self._prefix + name
        before = _read()
        if key in before:
            return {one: np.array(counts) for one, counts in before[key].items()}
        counted = work()
        plain = {one: counts.tolist() for one, counts in counted.items()}
        _write({**_read(), key: plain})  # read again: another benchmark may have added to it
        return counted

    def sum(self, works: Mapping[str, Callable[[], Confusions]]) -> Confusions:
        """Return the sum over several works."""
        total: Confusions = {}
        for name, work in works.items():
            for one, counts in self.get(name, work).items():
                total[one] = total[one] + counts if one in total else counts
        return total


def _read() -> dict[str, dict[str, list[list[int]]]]:
    found: dict[str, dict[str, list[list[int]]]] = {}
    if KEPT.exists():
        found = json.loads(KEPT.read_text("utf-8"))
    return found


def _write(found: dict[str, dict[str, list[list[int]]]]) -> None:
    KEPT.parent.mkdir(parents=True, exist_ok=True)
    unfinished = KEPT.with_suffix(".part")
    unfinished.write_text(json.dumps(found), "utf-8")
    unfinished.replace(KEPT)


def shares_of(labels: tuple[str, ...], counts: IntArray) -> Shares:
    """Return percentages of labels that occur, and their mean."""
    percent = 100 * Confusion(labels, counts).per_class
    shares = {
        label: float(one) for label, one in zip(labels, percent, strict=True) if np.isfinite(one)
    }
    return {**shares, MEAN: float(np.mean(list(shares.values())))}


def gain_row(name: str, before: Shares, cut: Shares) -> Row:
    """Return how much more is right after the cut; it names the labels that it worsens."""
    worse = [label for label in before if label != MEAN and cut[label] < before[label]]
    told = f"; worse for {', '.join(worse)}" if worse else "; no label is worse"
    gain = cut[MEAN] - before[MEAN]
    verdict = "" if gain >= 0 else "; THE CUT IMPROVES NOTHING"
    return Row(f"{name}: gain of the cut{told}{verdict}", gain, "points", 0, "goal >=")
