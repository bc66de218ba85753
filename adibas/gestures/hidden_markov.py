"""Gestures as hidden Markov models: the other baseline of the thesis.

One model a gesture that runs through its states from left to right, and one for all that is no
gesture; what is reported is the share of each in the likelihood of a frame.

Source: Rabiner, A tutorial on hidden Markov models, 1989; fitted by hmmlearn.
"""

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from hmmlearn.hmm import GaussianHMM

from adibas.arrays import BoolArray, FloatArray, IntArray

N_STATES, N_DIMENSIONS, N_ROUNDS = 5, 12, 10
LEAST_VARIANCE = 0.05
"""Of numbers that were scaled to variance 1."""

FEWEST_OTHERS = 8
"""Segments from which a model of everything else is learned."""


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """One hidden Markov model with a Gaussian, independent numbers, in each state."""

    stay: FloatArray
    means: FloatArray
    variances: FloatArray

    def scores(self, pieces: FloatArray) -> FloatArray:
        """Return (k,): the log-likelihood a frame of the best way through the states.

        Parameters
        ----------
        pieces : (k, n, d) array
        """
        step = np.log(np.clip(1.0 - self.stay, 1e-9, 1.0))
        remain = np.log(np.clip(self.stay, 1e-9, 1.0))
        spread = (pieces[:, :, None] - self.means) ** 2 / self.variances
        emitted = -0.5 * (spread + np.log(2 * np.pi * self.variances)).sum(axis=3)
        best = np.full(emitted[:, 0].shape, -np.inf)
        best[:, 0] = emitted[:, 0, 0]
        for frame in range(1, pieces.shape[1]):
            moved = np.full_like(best, -np.inf)
            moved[:, 1:] = best[:, :-1] + step[:-1]
            best = np.maximum(best + remain, moved) + emitted[:, frame]
        return np.asarray(best.max(axis=1) / pieces.shape[1])


@dataclass(frozen=True, slots=True, eq=False)
class HiddenMarkov:
    """A chain for each gesture, and one for the rest.

    Attributes
    ----------
    mean : (d,) array
    axes : (d, N_DIMENSIONS) array
        Principal axes, scaled so that each number has variance 1.
    chains : tuple of Chain
        One a label, and a last one for no gesture where such segments were given.
    """

    mean: FloatArray
    axes: FloatArray
    chains: tuple[Chain, ...]
    n_labels: int

    def predict(self, segments: Sequence[FloatArray]) -> FloatArray:
        """Return (k, labels): the share of each gesture, 0 to 1."""
        if not len(segments):
            return np.empty((0, self.n_labels))
        pieces = _filled(np.stack(segments), self.mean) @ self.axes
        scores = np.stack([chain.scores(pieces) for chain in self.chains], axis=1)
        shares = np.exp(scores - scores.max(axis=1, keepdims=True))
        return np.asarray((shares / shares.sum(axis=1, keepdims=True))[:, : self.n_labels])


@dataclass(frozen=True, slots=True, eq=False)
class MarkovTraining:
    """Segments (n, d) of one length with targets (k, labels), 1 where it is that gesture."""

    segments: Sequence[FloatArray]
    targets: FloatArray
    seed: int

    def fitted(self, kept: BoolArray | None = None) -> HiddenMarkov:
        """Return the chains learned from the segments that are `kept` (k,), all if not given."""
        chosen = np.ones(len(self.segments), bool) if kept is None else kept
        pieces = np.stack([one for one, keep in zip(self.segments, chosen, strict=True) if keep])
        targets = self.targets[chosen]
        mean = np.nanmean(pieces, axis=(0, 1))
        mean = np.where(np.isfinite(mean), mean, 0.0)
        flat = _filled(pieces, mean).reshape(-1, len(mean))
        _, sizes, rows = np.linalg.svd(flat, full_matrices=False)
        n = min(N_DIMENSIONS, len(rows))
        axes = rows[:n].T / np.maximum(sizes[:n] / np.sqrt(len(flat)), 1e-9)
        small = (flat @ axes).reshape(len(pieces), -1, n)
        groups = [small[targets[:, label] > 0] for label in range(targets.shape[1])]
        rest = small[~(targets > 0).any(axis=1)]
        if len(rest) >= FEWEST_OTHERS:
            groups.append(rest)
        chains = tuple(_chain(group, self.seed) for group in groups)
        return HiddenMarkov(mean, axes, chains, targets.shape[1])

    def held_out(self, groups: IntArray) -> FloatArray:
        """Return (k, labels): what is predicted for each group by chains learned without it."""
        predicted = np.empty_like(self.targets)
        for group in np.unique(groups):
            kept = np.asarray(groups != group)
            mine = [one for one, keep in zip(self.segments, kept, strict=True) if not keep]
            predicted[~kept] = self.fitted(kept).predict(mine)
        return predicted


def _filled(pieces: FloatArray, mean: FloatArray) -> FloatArray:
    """Return pieces from their mean; what was not seen stands at the mean and says least."""
    return np.asarray(np.where(np.isfinite(pieces), pieces - mean, 0.0))


def _chain(pieces: FloatArray, seed: int) -> Chain:
    """Fit one chain; a gesture without a segment gets one that fits nothing."""
    dimension = pieces.shape[2]
    if not len(pieces):
        nothing = np.full((N_STATES, dimension), 1e3)
        return Chain(np.full(N_STATES, 0.5), nothing, np.ones_like(nothing))
    parts = np.array_split(np.arange(pieces.shape[1]), N_STATES)
    model = GaussianHMM(
        N_STATES, "diag", min_covar=LEAST_VARIANCE, n_iter=N_ROUNDS, random_state=seed,
        init_params="", params="tmc",
    )  # fmt: skip
    model.startprob_ = np.eye(N_STATES)[0]
    stay = 1.0 - N_STATES / pieces.shape[1]
    model.transmat_ = stay * np.eye(N_STATES) + (1 - stay) * np.eye(N_STATES, k=1)
    model.transmat_[-1, -1] = 1.0
    model.means_ = np.stack([pieces[:, part].mean(axis=(0, 1)) for part in parts])
    spread = np.stack([pieces[:, part].var(axis=(0, 1)) for part in parts])
    model.covars_ = np.maximum(spread, LEAST_VARIANCE)
    _quietly(model, pieces)
    variances = np.array([np.diag(part) for part in model.covars_])
    return Chain(
        np.diag(model.transmat_).copy(), model.means_, np.maximum(variances, LEAST_VARIANCE)
    )


def _quietly(model: GaussianHMM, pieces: FloatArray) -> None:
    """Fit without hmmlearn's remarks on how the rounds went."""
    logger = logging.getLogger("hmmlearn")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        lengths = np.full(len(pieces), pieces.shape[1])
        model.fit(pieces.reshape(-1, pieces.shape[2]), lengths)
    finally:
        logger.setLevel(level)
