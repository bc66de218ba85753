"""Generalised Procrustes analysis: shapes laid onto their common mean.

Source: thesis, equation 6.6; Gower, Generalized Procrustes analysis, Psychometrika 40 (1975);
Cootes & Taylor, Statistical models of appearance for computer vision (2004), appendix B, for the
projection into the tangent space of the mean, which keeps the variation linear.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape
from adibas.shapes.similarity import fit_similarity

MAX_ROUNDS = 100
DONE = 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class AlignedShapes:
    """Shapes without their places, turns and sizes.

    Attributes
    ----------
    mean : (N, D) array
        Centred; its size (the root of the sum of squares) is 1 where sizes were taken out, else
        the mean's own. It stands as the first shape stood.
    shapes : (S, N, D) array
        In the mean's frame, in its tangent space where sizes were taken out.
    sizes : (S,) array
        What the sizes were, in the unit of the shapes.
    """

    mean: FloatArray
    shapes: FloatArray
    sizes: FloatArray


def align_shapes(shapes: FloatArray, *, has_scale: bool = True) -> AlignedShapes:
    """Lay shapes onto their common mean.

    Parameters
    ----------
    shapes : (S, N, D) array
        S sets of the same N points, without NaN.
    has_scale : bool
        Whether sizes are taken out, too.

    Raises
    ------
    ValueError
        There is a NaN, or a shape whose points lie in one place or on one line.
    """
    check_shape("shapes", shapes, (None, None, None))
    if len(shapes) == 0 or np.isnan(shapes).any():
        raise ValueError("shapes must be there, and have every point")
    centred = shapes - shapes.mean(axis=1, keepdims=True)
    sizes = np.linalg.norm(centred, axis=(1, 2))
    if not (sizes > 0).all():
        raise ValueError("a shape has all its points in one place")
    moved = centred / sizes[:, None, None] if has_scale else centred
    mean = moved[0]
    for _ in range(MAX_ROUNDS):
        moved = np.stack([_laid(shape, mean, has_scale=has_scale) for shape in moved])
        new = moved.mean(axis=0)
        new = _laid(new, moved[0], has_scale=False)
        if has_scale:
            new = new / np.linalg.norm(new)
        change = float(np.abs(new - mean).max() / np.linalg.norm(new))
        mean = new
        if change < DONE:
            break
    moved = np.stack([_laid(shape, mean, has_scale=has_scale) for shape in moved])
    return AlignedShapes(mean, moved, sizes)


def _laid(shape: FloatArray, mean: FloatArray, *, has_scale: bool) -> FloatArray:
    """Turn a centred shape onto the mean; with scale, into its tangent space."""
    turn = fit_similarity(mean, shape, has_scale=False)
    if turn is None:
        raise ValueError("a shape has all its points on one line")
    turned = shape @ turn.rotation.T
    return np.asarray(turned / (turned * mean).sum()) if has_scale else turned
