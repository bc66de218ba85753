"""How tall a person is and how long each bone, learned while the person is followed."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.skeleton.proportions import ROOT, Proportions, bone_lengths_m


@dataclass(frozen=True, slots=True)
class SizeParams:
    """How a person's size is learned.

    Attributes
    ----------
    mean_m : float
        Stature before anything is seen: 1.55, between children of 6 years and tall adults.
    range_m : (float, float)
        Statures that are believed: 0.95 to 2.1.
    first_spread : float
        Added to the relative spread of every bone while the size is not known: 0.25.
    n_own : int
        Frames of a bone from which on its own length counts as much as the stature's: 20.
    n_kept : int
        Latest frames that count: 300 (10 s).
    """

    mean_m: float = 1.55
    range_m: tuple[float, float] = (0.95, 2.1)
    first_spread: float = 0.25
    n_own: int = 20
    n_kept: int = 300


class PersonSize:
    """Bone lengths of one person.

    Parameters
    ----------
    proportions : Proportions
        Of people in general.
    """

    def __init__(self, proportions: Proportions, params: SizeParams | None = None) -> None:
        self._proportions = proportions
        self._params = params or SizeParams()
        self._lengths_m: list[FloatArray] = []
        self._statures_m: list[float] = []

    @property
    def stature_m(self) -> float:
        """What is believed now."""
        if not self._statures_m:
            return self._params.mean_m
        return float(np.median(self._statures_m))

    @property
    def n_seen(self) -> int:
        """Frames that the stature comes from."""
        return len(self._statures_m)

    def bones_m(self, stature_m: float | None = None) -> tuple[FloatArray, FloatArray]:
        """Return (15,) lengths and (15,) spreads of the bone that ends at each joint, metres.

        `stature_m` is another stature than the one believed.
        """
        params, common = self._params, self._proportions
        stature_m = self.stature_m if stature_m is None else stature_m
        lengths_m = common.lengths * stature_m
        if self._lengths_m:
            own = np.stack(self._lengths_m)
            n_own = np.isfinite(own).sum(axis=0)
            medians_m = np.where(n_own > 0, _medians(own, n_own), lengths_m)
            medians_m = np.clip(medians_m, 0.75 * lengths_m, 1.25 * lengths_m)
            share = n_own / (n_own + params.n_own)
            lengths_m = lengths_m + share * (medians_m - lengths_m)
        vague = params.first_spread / np.sqrt(1.0 + self.n_seen)
        spreads_m = (common.spreads + vague) * lengths_m
        lengths_m[ROOT], spreads_m[ROOT] = 0.0, 1.0
        return lengths_m, spreads_m

    def guess_m(self, places_m: FloatArray) -> float:
        """Return the stature that most bones between the best places (15, 3) speak for.

        The middle of what the bones say and what is believed, weighed by how often it was seen.
        """
        said_m = self._said_m(places_m)
        if not len(said_m):
            return self.stature_m
        n_before = min(self.n_seen, self._params.n_own)
        believed = [self.stature_m] * (1 + 2 * n_before)
        low, high = self._params.range_m
        return float(np.clip(np.median([*said_m, *believed]), low, high))

    def learn(self, joints_m: FloatArray) -> None:
        """Take in the joints (15, 3) of a frame; NaN where not seen."""
        said_m = self._said_m(joints_m)
        if len(said_m) < 4:  # noqa: PLR2004  (bones: fewer say little of the stature)
            return
        low, high = self._params.range_m
        self._statures_m.append(float(np.clip(np.median(said_m), low, high)))
        self._lengths_m.append(bone_lengths_m(joints_m))
        del self._statures_m[: -self._params.n_kept], self._lengths_m[: -self._params.n_kept]

    def _said_m(self, joints_m: FloatArray) -> FloatArray:
        lengths_m = bone_lengths_m(joints_m)
        known = np.isfinite(lengths_m) & (self._proportions.lengths > 0)
        return np.asarray(lengths_m[known] / self._proportions.lengths[known])


def _medians(values: FloatArray, n_known: IntArray) -> FloatArray:
    """Return (C,) medians of the known ones in each column; `numpy.nanmedian` takes longer."""
    rising, columns = np.sort(values, axis=0), np.arange(values.shape[1])  # NaN is last
    below, above = np.maximum(n_known - 1, 0) // 2, n_known // 2
    return np.asarray(0.5 * (rising[below, columns] + rising[above, columns]))
