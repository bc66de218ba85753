"""What training leaves: a recogniser of gestures, the same for every method."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias, get_args

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.data.skeleton_track import SkeletonTrack
from adibas.gestures.described_track import DescribedTrack, Frames, described_in_pieces
from adibas.gestures.descriptor import DescriptorParams
from adibas.gestures.hidden_markov import HiddenMarkov
from adibas.gestures.likeness import LARGEST_BATCH, Likeness
from adibas.gestures.proposals import ClassAligner, ProposalParams
from adibas.gestures.segments import Segment, at_one_length
from adibas.gestures.weighting import spread
from adibas.timeseries.mixture_stream import MixtureModel

Method: TypeAlias = Literal["likeness", "hmm", "dtw", "weighted-dtw", "gmm-dtw", "table-7.1"]
METHODS: tuple[Method, ...] = get_args(Method)
Judge: TypeAlias = Likeness | HiddenMarkov
FEW_FRAMES = 64
"""That are aligned before it is seen whether a threshold was crossed; what follows is aligned anew.
"""
MOST_SHARED = 0.3
"""Of the shorter of two reports: more is the same movement reported twice."""


@dataclass(frozen=True, slots=True, eq=False)
class GestureModel:
    """A trained recogniser.

    Attributes
    ----------
    method : str
        ``likeness``: proposals by alignment, judged by `Likeness` (the default); ``hmm``: judged
        by `HiddenMarkov`; ``dtw`` and
        ``weighted-dtw``: the alignment's cost against a threshold; ``gmm-dtw``: the same with
        mixtures in place of examples; ``table-7.1``: the thesis'
        algorithm literally.
    labels : tuple of str
    descriptor : DescriptorParams
        A stream must be described the same way.
    examples : tuple of (m, d) arrays
    owners : (k,) integer array
        Which label each example shows.
    weights : (labels, 14) array
        Of the joints, when each gesture is looked for; the sum of a row is 1.
    thresholds : (labels,) array
        Largest cost of a detection; for ``likeness`` and ``hmm`` largest 1 - likeness.
    gates : (labels,) array
        Largest cost of a proposal that is judged at all.
    judge : Likeness or HiddenMarkov or None
        What rates proposals.
    provenance : dict
        What it was trained on, and how.
    mixtures : tuple of MixtureModel
        Of ``gmm-dtw``, one for each label.
    """

    method: Method
    labels: tuple[str, ...]
    descriptor: DescriptorParams
    examples: tuple[FloatArray, ...]
    owners: IntArray
    weights: FloatArray
    thresholds: FloatArray
    gates: FloatArray
    judge: Judge | None = None
    provenance: dict[str, object] = field(default_factory=dict)
    mixtures: tuple[MixtureModel, ...] = ()

    def aligner(self) -> ClassAligner:
        """Return what aligns a stream with the examples."""
        params = ProposalParams()
        if self.method == "table-7.1":
            params = ProposalParams(n_best=1, steps="free")
        if self.mixtures:
            owners, params = np.unique(self.owners), ProposalParams(n_best=1)
            return ClassAligner((), owners, self.weights, params, self.mixtures)
        factors = spread(self.weights, self.descriptor.n_numbers)
        return ClassAligner(self.examples, self.owners, factors, params)

    def detect(self, track: DescribedTrack[Frames]) -> list[Segment]:
        """Return what is done in a stream: no two at the same time, in the order of time.

        The cost of each is a share of its threshold, 1 at most.
        """
        aligner = self.aligner()
        if self.method == "table-7.1":
            return first_crossings(aligner, track.frames, self.thresholds)
        proposals = [
            proposal
            for proposal in aligner.proposals(track.frames)
            if proposal.cost <= self.gates[proposal.label]
        ]
        rated = self._rated(track.frames, proposals)
        return not_overlapping([one for one in rated if one.cost <= 1.0])

    def classify(self, frames: FloatArray) -> FloatArray:
        """Return the cost (labels,) of a segment being each gesture, as a share of the threshold.

        The best class is the least; above 1 it is none.
        """
        if self.judge is not None:
            found = self.judge.predict([at_one_length(frames)])[0]
            return np.asarray((1.0 - found) / self.thresholds)
        costs, _ = self.aligner().curves(frames)
        return np.asarray(costs.min(axis=0) / self.thresholds)

    def _rated(self, frames: Frames, proposals: Sequence[Segment]) -> list[Segment]:
        if self.judge is None:
            return [
                _with(one, one.label, one.cost / self.thresholds[one.label]) for one in proposals
            ]
        # Several gestures may propose the same frames: they are judged once.
        spans = sorted({(one.begin, one.end) for one in proposals})
        place = {span: number for number, span in enumerate(spans)}
        judged = np.empty((len(spans), len(self.labels)))
        for at in range(0, len(spans), LARGEST_BATCH):
            some = spans[at : at + LARGEST_BATCH]
            pieces = [at_one_length(frames[begin : end + 1]) for begin, end in some]
            judged[at : at + LARGEST_BATCH] = self.judge.predict(pieces)
        judged = (1.0 - judged) / self.thresholds
        costs = judged[[place[one.begin, one.end] for one in proposals]]
        best = costs.argmin(axis=1)
        return [
            _with(one, int(label), float(cost[label]))
            for one, label, cost in zip(proposals, best, costs, strict=True)
        ]


def described_for(
    models: Sequence[GestureModel], track: SkeletonTrack
) -> list[tuple[GestureModel, DescribedTrack[Frames]]]:
    """Return each model with the track as it wants it described; alike ones share one."""
    described = {
        one: described_in_pieces(track, one) for one in {model.descriptor for model in models}
    }
    return [(model, described[model.descriptor]) for model in models]


def _with(segment: Segment, label: int, cost: float) -> Segment:
    return Segment(segment.stream, label, segment.begin, segment.end, float(cost))


def not_overlapping(segments: Sequence[Segment]) -> list[Segment]:
    """Return the cheapest first, each only if it shares little time with those before it."""
    kept: list[Segment] = []
    for one in sorted(segments, key=lambda segment: segment.cost):
        if all(_shared(one, other) <= MOST_SHARED for other in kept):
            kept.append(one)
    return sorted(kept, key=lambda segment: segment.begin)


def _shared(one: Segment, other: Segment) -> float:
    shared = min(one.end, other.end) - max(one.begin, other.begin) + 1
    shorter = min(one.end - one.begin, other.end - other.begin) + 1
    return max(0, shared) / shorter


def first_crossings(aligner: ClassAligner, frames: Frames, thresholds: FloatArray) -> list[Segment]:
    """Return what table 7.1 finds: the first end below a threshold, then all begins anew.

    Source: thesis, table 7.1 and equation 7.5.
    """
    found: list[Segment] = []
    aligner.reset()
    begin = at = 0
    while at < len(frames):
        costs, starts = aligner.curves(frames[at : at + FEW_FRAMES])
        ratios = costs / thresholds
        below = np.flatnonzero((ratios < 1.0).any(axis=1))
        if not below.size:
            at += FEW_FRAMES
            continue
        row = int(below[0])
        label = int(ratios[row].argmin())
        first, end = begin + int(starts[row, label]), at + row
        found.append(Segment(0, label, first, end, float(ratios[row, label])))
        begin = at = end + 1
        aligner.reset()
    return found
