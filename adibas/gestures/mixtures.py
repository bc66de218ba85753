"""Gestures as mixtures: every frame of the model says how much all examples vary there.

Source: Bautista et al., A gesture recognition system for detecting behavioral patterns of ADHD,
IEEE Transactions on Cybernetics 46 (2016): examples are aligned with the one of median length, and
the frames that fall on each of its frames are a mixture of Gaussians.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.timeseries.dtw import warping_path
from adibas.timeseries.gaps import bridged
from adibas.timeseries.mixture_stream import MixtureModel

N_ROUNDS = 12
SHORTEST = 2


@dataclass(frozen=True, slots=True)
class MixtureParams:
    """How mixtures are learned.

    Attributes
    ----------
    n_components : int
        Of each frame: 2. A dozen examples do not tell more apart.
    fewest_each : int
        Examples a component at least; with fewer there is one component: 4.
    least_sd : float
        Of a number, in sizes of the body: 0.03, about the noise of a sensor's joints.
    pooled : float
        The variance over all frames of the gesture counts as so many examples: 5.
    """

    n_components: int = 2
    fewest_each: int = 4
    least_sd: float = 0.03
    pooled: float = 5.0


def mixtures_of(
    examples: Sequence[FloatArray],
    owners: IntArray,
    n_labels: int,
    rng: np.random.Generator,
    params: MixtureParams | None = None,
) -> tuple[MixtureModel, ...]:
    """Return a model for each label that has examples, in the order of labels.

    Parameters
    ----------
    examples : sequence of (m, d) arrays
        NaN where not seen.
    owners : (k,) integer array
        Labels.
    n_labels : int
    rng : Generator
        Of the first guess.
    params : MixtureParams, optional
    """
    params = params or MixtureParams()
    found = []
    for label in range(n_labels):
        mine = [one for one, owner in zip(examples, owners, strict=True) if owner == label]
        if mine:
            found.append(mixture_model(mine, rng, params))
    return tuple(found)


def mixture_model(
    examples: Sequence[FloatArray], rng: np.random.Generator, params: MixtureParams
) -> MixtureModel:
    """Return the mixtures of one gesture."""
    aligned = aligned_examples(examples)  # (k, m, d)
    filled = _filled(aligned)
    pooled = np.maximum(filled.var(axis=0).mean(axis=0), params.least_sd**2)
    n = params.n_components if len(examples) >= params.n_components * params.fewest_each else 1
    return _fitted(filled, pooled, n, rng, params)


def aligned_examples(examples: Sequence[FloatArray]) -> FloatArray:
    """Return (k, m, d): all examples at the frames of the one of median length.

    What several frames of an example fall on is their mean; NaN where none of them was seen.
    """
    order = np.argsort([len(one) for one in examples], kind="stable")
    reference = examples[int(order[len(order) // 2])]
    out = np.full((len(examples), *reference.shape), np.nan)
    for place, one in enumerate(examples):
        _cost, path = warping_path(bridged(reference), bridged(one))
        sums, counts = np.zeros((2, *reference.shape))
        known = np.isfinite(one[path[:, 1]])
        np.add.at(sums, path[:, 0], np.where(known, one[path[:, 1]], 0.0))
        np.add.at(counts, path[:, 0], known)
        seen = counts > 0
        out[place][seen] = sums[seen] / counts[seen]
    return out


def _fitted(
    filled: FloatArray, pooled: FloatArray, n: int, rng: np.random.Generator, params: MixtureParams
) -> MixtureModel:
    """Fit all frames at once by expectation and maximisation, numbers independent."""
    k, m = filled.shape[:2]
    belongs = np.ones((k, m, n))
    if n > 1:
        # The same examples begin together in every frame: styles of a gesture, not of a frame.
        belongs = np.repeat(rng.dirichlet(np.ones(n), (k, 1)), m, axis=1)
    shares, means, variances = _maximised(filled, belongs, pooled, params)
    for _ in range(N_ROUNDS if n > 1 else 0):
        log = np.empty((k, m, n))
        for component in range(n):
            spread = (filled - means[None, :, component]) ** 2 / variances[None, :, component]
            log[:, :, component] = np.log(shares[:, component]) - 0.5 * (
                spread + np.log(variances[None, :, component])
            ).sum(axis=2)
        belongs = np.exp(log - log.max(axis=2, keepdims=True))
        belongs /= belongs.sum(axis=2, keepdims=True)
        shares, means, variances = _maximised(filled, belongs, pooled, params)
    return MixtureModel(shares, means, variances)


def _maximised(
    filled: FloatArray, belongs: FloatArray, pooled: FloatArray, params: MixtureParams
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return shares (m, n), means and variances (m, n, d); variances pulled to the pooled one."""
    weight = belongs.sum(axis=0)
    safe = np.maximum(weight, 1e-9)
    means = np.einsum("kmn,kmd->mnd", belongs, filled) / safe[:, :, None]
    squares = np.einsum("kmn,kmd->mnd", belongs, filled**2) / safe[:, :, None]
    own = np.maximum(squares - means**2, 0.0)
    mixed = (weight[:, :, None] * own + params.pooled * pooled) / (
        weight[:, :, None] + params.pooled
    )
    shares = (weight + 1e-3) / (weight + 1e-3).sum(axis=1, keepdims=True)
    return shares, means, np.maximum(mixed, params.least_sd**2)


def _filled(aligned: FloatArray) -> FloatArray:
    """Return the examples with the mean of the others where one was not seen."""
    known = np.isfinite(aligned)
    counts = known.sum(axis=0)
    mean = np.where(known, aligned, 0.0).sum(axis=0) / np.maximum(counts, 1)
    return np.where(known, aligned, mean[None])
