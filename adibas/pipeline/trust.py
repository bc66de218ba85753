"""Who has been taken for a person often enough, so that hardly anybody asks again.

A thing at the border of what a person looks like is taken for one in one frame and not in the
next: what is new is judged in some frames, and the most decide. Whoever is trusted then is judged
now and then: a thing may stand where a person was a moment ago.
"""

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import FloatArray
from adibas.limbs.judging import Judgement

KNOWN_M, KNOWN_S = 0.5, 2.0
"""Whoever is so near to where somebody was not long ago is the same.

People are half hidden while they walk behind things; of their limbs alone they could be anything.
"""
N_VERDICTS, N_ENOUGH = 9, 5
"""Latest verdicts that count, and those for a person after which hardly anybody asks again."""
CALM_S, DOUBT_S = 4.0, 0.3
"""Times between two questions about who is trusted, and about who was clearly refused last.

A verdict takes a fifth of a frame's time: so it is asked for in less than one of a hundred frames.
Clear refusals are so far apart that a person who is badly seen for a moment is not lost.
"""


@dataclass(slots=True, eq=False)
class Acquaintance:
    """Somebody, or something, that was seen: where it was last, and what was said of it.

    Attributes
    ----------
    middle_m : (3,) array
    seen_s : float
    is_trusted : bool
        It was taken for a person often enough.
    """

    middle_m: FloatArray
    seen_s: float
    is_trusted: bool = False
    _judged_s: float = -np.inf
    _n_refusals: int = 0
    _verdicts: deque[bool] = field(default_factory=lambda: deque(maxlen=N_VERDICTS))

    def is_to_be_judged(self, time_s: float, *, is_whole: bool) -> bool:
        """Say whether to ask what it is; of who is trusted only where all of it is seen."""
        if not self.is_trusted:
            return True
        pause_s = DOUBT_S if self._n_refusals else CALM_S
        return is_whole and time_s - self._judged_s >= pause_s

    def judged(self, found: Judgement, time_s: float) -> bool:
        """Take in a verdict; return whether it is a person, by the latest ones."""
        self._judged_s = time_s
        if self.is_trusted:
            self._doubted(found)
            return self.is_trusted
        self._verdicts.append(found.is_person)
        n_for = sum(self._verdicts)
        n_against = len(self._verdicts) - n_for
        self.is_trusted = n_for >= N_ENOUGH and n_for > n_against
        return n_for > n_against or (n_for == n_against and found.is_person)

    def _doubted(self, found: Judgement) -> None:
        """Withdraw trust after as many clear refusals as verdicts count, none for a person between.

        Who is half hidden is refused, too, but seldom clearly.
        """
        if found.is_person:
            self._n_refusals = 0
        elif found.is_clear:
            self._n_refusals += 1
        if self._n_refusals == N_VERDICTS:
            self.is_trusted, self._n_refusals = False, 0
            self._verdicts.extend([False] * N_VERDICTS)


class Trust:
    """Remembers who was seen where; for one thread at a time."""

    def __init__(self) -> None:
        self._known: list[Acquaintance] = []

    def meet(self, middles_m: FloatArray, time_s: float) -> list[Acquaintance]:
        """Return who each one is that is seen in a frame, known before or new.

        The nearest are the same, one to one: a thing beside a person is not that person.

        Parameters
        ----------
        middles_m : (N, 3) array
            Of all that is seen, metres.
        time_s : float
        """
        known = [one for one in self._known if time_s - one.seen_s <= KNOWN_S]
        ways_m = sorted(
            (float(np.linalg.norm(one.middle_m - middle_m)), row, column)
            for row, middle_m in enumerate(middles_m)
            for column, one in enumerate(known)
        )
        met: dict[int, Acquaintance] = {}
        free = set(range(len(known)))
        for way_m, row, column in ways_m:
            if way_m < KNOWN_M and row not in met and column in free:
                met[row] = known[column]
                free.remove(column)
        for row, middle_m in enumerate(middles_m):
            one = met.setdefault(row, Acquaintance(middle_m, time_s))
            one.middle_m, one.seen_s = middle_m, time_s
        everybody = [met[row] for row in range(len(middles_m))]
        self._known = [*(known[column] for column in sorted(free)), *everybody]
        return everybody
