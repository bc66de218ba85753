"""Where in a stream gestures may be: local minima of the begin-end alignment with examples.

Source: thesis, section 7.1.1; the mean of the best three examples and the wait for the minimum
make it work on streams of people who are not in the training set.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import minimum_filter1d

from adibas.arrays import FloatArray, IntArray
from adibas.gestures.segments import Segment
from adibas.timeseries.mixture_stream import MixtureModel, MixtureStream
from adibas.timeseries.stream import Steps, StreamAligner

CHUNK = 2048
"""Frames that are aligned at once: hours of stream need no more memory than this."""

SHORTEST = 4
"""Frames of an example or a proposal."""


@dataclass(frozen=True, slots=True)
class ProposalParams:
    """How minima are found.

    Attributes
    ----------
    n_best : int
        So many of the examples that fit best decide; 3: one odd example has no say.
    reach : int
        Frames to both sides in which there is no smaller cost; 4 is 0.27 s at 15 frames/s.
    steps : {'sloped', 'free'}
    """

    n_best: int = 3
    reach: int = 4
    steps: Steps = "sloped"


class ClassAligner:
    """Aligns a stream with the examples of every gesture.

    Parameters
    ----------
    examples : sequence of (m, d) arrays
        Of `SHORTEST` frames or more.
    owners : (k,) integer array
        Which gesture each example shows, 0 to n_labels - 1.
    n_labels : int
    weights : (d,) array, optional
    params : ProposalParams
    mixtures : sequence of MixtureModel, optional
        What is aligned in place of the examples, one for each owner.
    """

    def __init__(
        self,
        examples: Sequence[FloatArray],
        owners: IntArray,
        n_labels: int,
        weights: FloatArray | None = None,
        params: ProposalParams | None = None,
        mixtures: Sequence[MixtureModel] = (),
    ) -> None:
        self._params = params or ProposalParams()
        self._aligner: StreamAligner | MixtureStream = (
            MixtureStream(mixtures)
            if mixtures
            else StreamAligner(examples, weights, self._params.steps)
        )
        self._columns = [np.flatnonzero(owners == label) for label in range(n_labels)]

    def reset(self) -> None:
        """Forget the stream."""
        self._aligner.reset()

    def curves(self, frames: FloatArray) -> tuple[FloatArray, IntArray]:
        """Take the next frames of a stream; return cost and start (n, labels) for each end."""
        costs = np.full((len(frames), len(self._columns)), np.inf)
        starts = np.zeros(costs.shape, np.int64)
        for at in range(0, len(frames), CHUNK):
            part = slice(at, at + CHUNK)
            all_costs, all_starts = self._aligner.feed(frames[part])
            for label, columns in enumerate(self._columns):
                if len(columns):
                    costs[part, label], starts[part, label] = self._decided(
                        all_costs[:, columns], all_starts[:, columns]
                    )
        return costs, starts

    def _decided(self, costs: FloatArray, starts: IntArray) -> tuple[FloatArray, IntArray]:
        n_best = min(self._params.n_best, costs.shape[1])
        best = np.argsort(costs, axis=1)[:, :n_best]
        found = np.take_along_axis(costs, best, 1)
        began = np.median(np.take_along_axis(starts, best, 1), axis=1)
        return found.mean(axis=1), began.astype(np.int64)

    def proposals(self, frames: FloatArray, stream: int = 0) -> list[Segment]:
        """Return the local minima of every gesture's cost in a whole stream."""
        self.reset()
        costs, starts = self.curves(frames)
        width = 2 * self._params.reach + 1
        is_least = np.isfinite(costs) & (
            costs <= minimum_filter1d(costs, width, axis=0, mode="nearest")
        )
        return [
            Segment(stream, int(label), int(starts[end, label]), int(end), float(costs[end, label]))
            for end, label in np.argwhere(is_least)
            if end - starts[end, label] + 1 >= SHORTEST
        ]


def chosen_examples(
    groups: IntArray, labels: IntArray, most: int, rng: np.random.Generator
) -> IntArray:
    """Return which examples stand for their gestures: `most` a label, of many people.

    Parameters
    ----------
    groups, labels : (k,) integer arrays
        Who did it, and what.
    most : int
    rng : Generator
    """
    chosen: list[int] = []
    for label in np.unique(labels):
        mixed = rng.permutation(np.flatnonzero(labels == label))
        turn = {index: int((groups[mixed[:place]] == groups[index]).sum())
                for place, index in enumerate(mixed)}  # fmt: skip
        chosen += sorted(mixed.tolist(), key=lambda index: turn[index])[:most]
    return np.array(sorted(chosen), np.int64)
