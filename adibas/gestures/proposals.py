"""Where in a stream gestures may be: local minima of the begin-end alignment with examples.

Source: thesis, section 7.1.1; the mean of the best three examples and the wait for the minimum
make it work on streams of people who are not in the training set.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import minimum_filter1d

from adibas.arrays import FloatArray, IntArray
from adibas.gestures.described_track import Frames
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
        Which gesture each example shows, 0 to labels - 1.
    weights : (labels, d) array
        Factors of each number, when it is looked for each gesture; mixtures do not use them.
    params : ProposalParams
    mixtures : sequence of MixtureModel, optional
        What is aligned in place of the examples, one for each owner.
    """

    def __init__(
        self,
        examples: Sequence[FloatArray],
        owners: IntArray,
        weights: FloatArray,
        params: ProposalParams | None = None,
        mixtures: Sequence[MixtureModel] = (),
    ) -> None:
        self._params = params or ProposalParams()
        self._n_labels = len(weights)
        self._parts: list[tuple[StreamAligner | MixtureStream, IntArray]] = []
        if mixtures:
            self._parts.append((MixtureStream(mixtures), owners))
            return
        for row in np.unique(weights, axis=0):
            mine = np.flatnonzero((weights[owners] == row).all(axis=1))
            if mine.size:
                some = [examples[int(index)] for index in mine]
                self._parts.append((StreamAligner(some, row, self._params.steps), owners[mine]))

    def reset(self) -> None:
        """Forget the stream."""
        for aligner, _owners in self._parts:
            aligner.reset()

    def curves(self, frames: FloatArray) -> tuple[FloatArray, IntArray]:
        """Take the next frames of a stream; return cost and start (n, labels) for each end."""
        costs = np.full((len(frames), self._n_labels), np.inf)
        starts = np.zeros(costs.shape, np.int64)
        for aligner, owners in self._parts:
            all_costs, all_starts = aligner.feed(frames)
            for label in np.unique(owners):
                mine = owners == label
                costs[:, label], starts[:, label] = self._decided(
                    all_costs[:, mine], all_starts[:, mine]
                )
        return costs, starts

    def _decided(self, costs: FloatArray, starts: IntArray) -> tuple[FloatArray, IntArray]:
        n_best = min(self._params.n_best, costs.shape[1])
        best = np.argsort(costs, axis=1)[:, :n_best]
        found = np.take_along_axis(costs, best, 1)
        began = np.median(np.take_along_axis(starts, best, 1), axis=1)
        return found.mean(axis=1), began.astype(np.int64)

    def proposals(self, frames: Frames, stream: int = 0) -> Iterator[Segment]:
        """Yield the local minima of every gesture's cost in a whole stream."""
        self.reset()
        curves = [self.curves(frames[at : at + CHUNK]) for at in range(0, len(frames), CHUNK)]
        costs, starts = (np.concatenate(parts) for parts in zip(*curves, strict=True))
        width = 2 * self._params.reach + 1
        is_least = np.isfinite(costs) & (
            costs <= minimum_filter1d(costs, width, axis=0, mode="nearest")
        )
        for end, label in np.argwhere(is_least):
            begin = int(starts[end, label])
            if end - begin + 1 >= SHORTEST:
                yield Segment(stream, int(label), begin, int(end), float(costs[end, label]))


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
