"""Who has been taken for a person often enough, so that nobody asks again.

A thing at the border of what a person looks like is taken for one in one frame and not in the
next: what is new is judged in some frames, and the most decide.
"""

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import FloatArray

KNOWN_M, KNOWN_S = 0.5, 2.0
"""Whoever is so near to where somebody was not long ago is the same.

People are half hidden while they walk behind things; of their limbs alone they could be anything.
"""
N_VERDICTS, N_ENOUGH = 9, 5
"""Latest verdicts that count, and those for a person after which nobody asks again."""


@dataclass(slots=True)
class _Place:
    middle_m: FloatArray
    seen_s: float
    is_trusted: bool = False
    verdicts: deque[bool] = field(default_factory=lambda: deque(maxlen=N_VERDICTS))


class Trust:
    """Remembers verdicts by place; for one thread at a time."""

    def __init__(self) -> None:
        self._places: list[_Place] = []

    def is_trusted(self, middle_m: FloatArray, time_s: float) -> bool:
        """Say whether whoever is there need not be judged anew."""
        place = self._at(middle_m, time_s)
        return place is not None and place.is_trusted

    def judged(self, middle_m: FloatArray, time_s: float, *, is_person: bool) -> bool:
        """Take in a verdict on whoever is at (3,) metres; return what the latest ones say."""
        place = self._at(middle_m, time_s)
        if place is None:
            place = _Place(middle_m, time_s)
            self._places.append(place)
        place.verdicts.append(is_person)
        n_for = sum(place.verdicts)
        n_against = len(place.verdicts) - n_for
        place.is_trusted = n_for >= N_ENOUGH and n_for > n_against
        return n_for > n_against or (n_for == n_against and is_person)

    def saw(self, middle_m: FloatArray, time_s: float) -> None:
        """Note that somebody is still there, and where."""
        place = self._at(middle_m, time_s)
        if place is not None:
            place.middle_m, place.seen_s = middle_m, time_s

    def _at(self, middle_m: FloatArray, time_s: float) -> _Place | None:
        self._places = [one for one in self._places if time_s - one.seen_s <= KNOWN_S]
        near = [
            (float(np.linalg.norm(one.middle_m - middle_m)), number)
            for number, one in enumerate(self._places)
        ]
        nearest = min(near, default=(KNOWN_M, 0))
        return self._places[nearest[1]] if nearest[0] < KNOWN_M else None
