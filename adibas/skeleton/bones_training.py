"""Learning how long the bones of limbs are, and how alike both sides'; see `parts_bone_kernels`.

What the components of the limbs alone let expect of the lengths is seen by drawing limbs from
them, one for each core of the training.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from adibas.arrays import AnyArray, FloatArray, IntArray
from adibas.shapes.parts_core_kernels import core_numbers
from adibas.shapes.parts_limb_kernels import place_limb
from adibas.shapes.parts_types import Core, Limbs

N_BONES = 2


def without_bones(n_limbs: int, n_kinds: int) -> dict[str, Any]:
    """Return the fields of `Limbs` of a model that has not learned lengths."""
    units = np.tile(np.eye(N_BONES), (n_limbs, n_kinds, 1, 1))
    return {
        "bone_means": np.zeros((n_limbs, n_kinds, N_BONES)),
        "bone_covariances": units,
        "side_covariances": np.zeros_like(units),
        "drawn_means": np.zeros((n_limbs, n_kinds, N_BONES)),
        "drawn_covariances": units.copy(),
        "strange": np.ones(n_limbs),
    }


def learn_bones(  # noqa: PLR0913, PLR0917
    laid: FloatArray,
    of_kind: AnyArray,
    called: Sequence[str],
    core: Core,
    limbs: Limbs,
    strange: float,
    noise: float,
    rng: np.random.Generator,
) -> Limbs:
    """Return the limbs with what (S, N, 3) shapes and their mirror images say of the lengths.

    Parameters
    ----------
    of_kind : (S,) array of str
    called : sequence of str
        The kinds of posture, in the model's order.
    strange : float
        How often bones are not as learned.
    noise : float
        Standard deviation of a length's logarithm that is added to what was seen.
    """
    numbers = np.array([list(called).index(kind) for kind in of_kind])
    fields = without_bones(len(limbs.roots), len(called))
    fields["strange"][:] = strange
    for left in range(0, len(limbs.roots), 2):
        mine, others = (_lengths(laid, core, limbs, limb) for limb in (left, left + 1))
        drawn = _drawn(laid, numbers, core, limbs, left, rng)
        for q in range(len(called)):
            rows = numbers == q
            both = np.concatenate([mine[rows], others[rows]], axis=1)
            shared = np.cov(both, rowvar=False)
            across = 0.5 * (shared[:N_BONES, N_BONES:] + shared[N_BONES:, :N_BONES])
            own = 0.5 * (shared[:N_BONES, :N_BONES] + shared[N_BONES:, N_BONES:])
            for limb in (left, left + 1):
                fields["bone_means"][limb, q] = mine[rows].mean(axis=0)
                fields["bone_covariances"][limb, q] = own + noise**2 * np.eye(N_BONES)
                fields["side_covariances"][limb, q] = across
                fields["drawn_means"][limb, q] = drawn[rows].mean(axis=0)
                fields["drawn_covariances"][limb, q] = np.cov(drawn[rows], rowvar=False)
    return limbs._replace(**fields)


def _logs(ways: FloatArray) -> FloatArray:
    """Return the (..., 2) logarithms of the lengths of bones, from (..., 2, 3) ways of points."""
    bones = np.stack([ways[..., 0, :], ways[..., 1, :] - ways[..., 0, :]], axis=-2)
    return np.asarray(np.log(np.linalg.norm(bones, axis=-1)))


def _lengths(laid: FloatArray, core: Core, limbs: Limbs, limb: int) -> FloatArray:
    """Return the (S, 2) logarithms of the lengths of a limb's bones, in sizes of the core."""
    cores = laid[:, core.labels]
    off = cores - cores.mean(axis=1, keepdims=True)
    sizes_m = np.sqrt((off**2).sum(axis=2).mean(axis=1))
    ways = laid[:, limbs.labels[limb]] - cores[:, limbs.roots[limb], None]
    return _logs(ways / sizes_m[:, None, None])


def _drawn(
    laid: FloatArray,
    kinds: IntArray,
    core: Core,
    limbs: Limbs,
    left: int,
    rng: np.random.Generator,
) -> FloatArray:
    """Return the same of a limb that is drawn from the components for each shape's core."""
    ways = np.empty((len(laid), 6))
    for way, shape_m, kind in zip(ways, laid, kinds, strict=True):
        plain, _, _ = core_numbers(np.ascontiguousarray(shape_m[core.labels]), core)
        weights, places = place_limb(plain, limbs, left, int(kinds.max()) + 1)
        odds = np.where(limbs.kinds[left] == kind, np.exp(weights), 0.0)
        k = rng.choice(len(odds), p=odds / odds.sum())
        way[:] = places[k] + limbs.factors[left, k] @ rng.normal(size=6)
    return _logs(ways.reshape(-1, 2, 3))
