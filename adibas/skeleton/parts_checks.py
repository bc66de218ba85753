"""Whether core, limbs, anchors and stance of a file fit together: kernels check no index."""

from collections.abc import Mapping

import numpy as np

from adibas.arrays import FloatArray, IntArray, check_shape
from adibas.shapes.parts_types import Anchors, Core, Limbs
from adibas.skeleton.parts import LIMB_NAMES, PartsModel
from adibas.skeleton.stance import Stance

SHAPES: Mapping[type, Mapping[str, str]] = {
    Core: {
        "labels": "C", "mirror": "C", "mean": "C3", "basis": "BD", "basis_mean": "C3",
        "log_weights": "K", "kinds": "K", "means": "KC3", "covariances": "KDD", "factors": "KDD",
    },
    Limbs: {
        "labels": "L2", "roots": "L", "signs": "L", "kinds": "LM", "log_weights": "LM",
        "core_means": "LMB", "core_factors": "LMBB", "means": "LM6", "slopes": "LM6B",
        "factors": "LM66", "outer_factors": "LM33", "bone_means": "LQ2",
        "bone_covariances": "LQ22", "side_covariances": "LQ22", "drawn_means": "LQ2",
        "drawn_covariances": "LQ22", "strange": "L",
    },
    Anchors: {
        "costs": "A", "means": "AC3", "points": "P", "whiteners": "APC33", "constants": "APC",
    },
    Stance: {
        "weights": "S", "means": "SE", "covariances": "SEE", "limbs": "L3", "bone_means": "L2",
        "bone_sds": "L2", "bone_correlations": "L2",
    },
}  # fmt: skip
"""Of each field its lengths, by letters that stand for the same everywhere; see `_lengths`."""

MOST = 1e6
"""No measure of a body is greater; only a weight's logarithm may be far below."""
LONGEST = 20.0
"""Of the logarithm of a bone's length."""
NARROWEST = 1e-9
"""Least deviation of a logarithm, and least variance of any direction against the greatest: less is
lost in rounding."""
ROUNDED = 1e-4
"""How far the product of factors may be off, against the greatest: files have six digits."""


def check_parts(parts: PartsModel) -> None:
    """Raise ValueError unless all arrays of a model fit together."""
    lengths = _lengths(parts)
    _check_fields(parts, lengths)
    core, limbs = parts.core, parts.limbs
    _check_indices("labels", np.concatenate([core.labels, limbs.labels.ravel()]), lengths["N"])
    for name, indices in (("mirror", core.mirror), ("roots", limbs.roots)):
        _check_indices(name, indices, lengths["C"])
    _check_indices("points", parts.anchors.points, lengths["C"])
    for kinds in (core.kinds, *limbs.kinds):
        _check_indices("kinds", kinds, lengths["Q"])
        if len(np.unique(kinds)) < lengths["Q"]:
            raise ValueError("each of the kinds must have a component")
    for factors in (core.factors, limbs.core_factors, limbs.factors, limbs.outer_factors):
        _check_positive("factors", np.diagonal(factors, axis1=-2, axis2=-1))
    _check_factors(core)
    _check_covariances("drawn_covariances", limbs.drawn_covariances)
    for sign in (-1.0, 0.0, 1.0):
        both = limbs.bone_covariances + sign * limbs.side_covariances
        _check_covariances("bone_covariances", both)
    if parts.stance is not None:
        _check_stance(parts.stance, lengths["N"])


def _check_fields(parts: PartsModel, lengths: Mapping[str, int]) -> None:
    given = (parts.core, parts.limbs, parts.anchors, parts.stance)
    for part in (one for one in given if one is not None):
        for name, letters in SHAPES[type(part)].items():
            array = getattr(part, name)
            check_shape(name, array, [lengths[letter] for letter in letters])
            if array.max() > MOST or (name != "log_weights" and array.min() < -MOST):
                raise ValueError(f"{name} must be below {MOST:g}")


def _lengths(parts: PartsModel) -> dict[str, int]:
    """Return what the letters stand for: C points of the core, L limbs, N names, Q kinds, ..."""
    n_core, n_names = len(parts.core.labels), len(parts.names)
    return {
        "2": 2, "3": 3, "6": 6, "N": n_names, "E": 3 * n_names, "Q": len(parts.kinds),
        "C": n_core, "D": 3 * n_core, "B": len(parts.core.basis), "K": len(parts.core.kinds),
        "L": len(LIMB_NAMES), "M": parts.limbs.kinds.shape[-1],
        "A": len(parts.anchors.costs), "P": len(parts.anchors.points),
        "S": 0 if parts.stance is None else len(parts.stance.weights),
    }  # fmt: skip


def _check_factors(core: Core) -> None:
    """Raise unless the factors are those of the covariances: else the search would not end."""
    _check_covariances("covariances", core.covariances)
    found = core.factors @ np.swapaxes(core.factors, 1, 2)
    if not np.allclose(found, core.covariances, rtol=0.0, atol=ROUNDED * np.abs(found).max()):
        raise ValueError("the factors must be those of the covariances")


def _check_stance(stance: Stance, n_names: int) -> None:
    _check_indices("limbs", stance.limbs, n_names)
    _check_positive("weights", stance.weights)
    if not (np.abs(stance.bone_means) < LONGEST).all():
        raise ValueError(f"bone_means must be below {LONGEST:g}")
    if not (stance.bone_sds > NARROWEST).all():
        raise ValueError("bone_sds must be positive")
    if not (np.abs(stance.bone_correlations) < 1.0).all():
        raise ValueError("bone_correlations must be below 1")
    _check_covariances("covariances", stance.covariances)


def _check_covariances(name: str, covariances: FloatArray) -> None:
    """Raise unless they are symmetric, and positive definite by enough that any part of them is."""
    most = NARROWEST * np.abs(covariances).max()
    if not np.allclose(covariances, np.swapaxes(covariances, -1, -2), rtol=0.0, atol=most):
        raise ValueError(f"{name} must be symmetric")
    spreads = np.linalg.eigvalsh(covariances)
    if not (spreads[..., 0] > NARROWEST * spreads[..., -1]).all():
        raise ValueError(f"{name} must be positive definite")


def _check_indices(name: str, indices: IntArray, n: int) -> None:
    if not ((indices >= 0) & (indices < n)).all():
        raise ValueError(f"{name} must be from 0 to {n - 1}")


def _check_positive(name: str, values: FloatArray) -> None:
    if not (values > 0).all():
        raise ValueError(f"{name} must be positive")
