"""Learning the prototypes from labelled shapes.

Source: Cootes & Taylor, A mixture model for representing shape variation, Image and Vision
Computing 17 (1999), for several models where one cannot hold all shapes; thesis, equations
6.8-6.11, for each of them. Which shapes go together is found by k-means.
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray, check_shape
from adibas.shapes.procrustes import align_shapes
from adibas.shapes.similarity import fit_similarity
from adibas.skeleton.model import PointModel, Prototype, left_of
from adibas.skeleton.tree import learn_tree

PLANE, SPACE = 2, 3


@dataclass(frozen=True, slots=True)
class TrainingParams:
    """Settings of the training.

    Attributes
    ----------
    n_prototypes : int
        24 at most, and no more than a prototype for each `shapes_per_prototype`.
    shapes_per_prototype : int
        60: fewer do not tell which modes are real.
    kept_variance : float
        Share of the variance that the modes hold: 0.98 (thesis, 6.1.2.2).
    most_modes : int
        16.
    noise_m : float
        Least standard deviation of a point about the model: 15 mm, a palpation and the skin.
    tilt_rad : float
        Shapes whose verticals differ less (root mean square) are upright: 0.5.
    n_rounds : int
        Of k-means: 25.
    seed : int
        Of k-means' start.
    """

    n_prototypes: int = 24
    shapes_per_prototype: int = 60
    kept_variance: float = 0.98
    most_modes: int = 16
    noise_m: float = 0.015
    tilt_rad: float = 0.5
    n_rounds: int = 25
    seed: int = 0


def learn_points(
    names: tuple[str, ...],
    shapes_m: FloatArray,
    kinds: Sequence[str] = (),
    params: TrainingParams | None = None,
) -> PointModel:
    """Learn prototypes from shapes.

    Parameters
    ----------
    names : tuple of str
        Of the points.
    shapes_m : (S, N, D) array
        At least three, D of 2 or 3, y down, in metres.
    kinds : sequence of str
        What each shape is called; may be empty.

    Raises
    ------
    ValueError
        There are fewer shapes, one has a NaN, or they are all the same.
    """
    params = params or TrainingParams()
    check_shape("shapes_m", shapes_m, (None, len(names), None))
    general = align_shapes(shapes_m)
    is_upright = _is_upright(shapes_m, general.shapes, params.tilt_rad)
    centred = shapes_m - shapes_m.mean(axis=1, keepdims=True)
    radii_m = np.sqrt((centred**2).sum(axis=2).mean(axis=1))
    unit = centred / radii_m[:, None, None]
    aligned = _laid_together(unit, is_upright=is_upright)
    n_wanted = min(params.n_prototypes, max(1, len(shapes_m) // params.shapes_per_prototype))
    groups = _grouped(aligned, n_wanted, params)
    prototypes = []
    for group in range(int(groups.max()) + 1):
        is_member = groups == group
        called = [kind for kind, is_in in zip(kinds, is_member, strict=False) if is_in]
        prototypes.append(
            _prototype(names, aligned, is_member, np.log(radii_m), called, is_upright, params)
        )
    tree = learn_tree(_facing(aligned, names) if is_upright else aligned)
    return PointModel(names, tuple(prototypes), tree, is_upright)


def _is_upright(shapes: FloatArray, aligned: FloatArray, tilt_rad: float) -> bool:
    """Say whether the vertical is about the same in the common frame of all shapes."""
    downs = []
    for shape, common in zip(shapes, aligned, strict=True):
        turn = fit_similarity(common, shape)
        if turn is not None:
            downs.append(turn.rotation[:, 1])
    mean = np.mean(downs, axis=0)
    length = float(np.linalg.norm(mean))
    # Of directions that scatter by a small angle about their mean, it has this length.
    return length > math.cos(tilt_rad)


def _laid_together(shapes: FloatArray, *, is_upright: bool, n_rounds: int = 10) -> FloatArray:
    """Turn centred shapes onto their mean: about the vertical where they stand upright."""
    if not is_upright:
        mean = shapes[0]
        for _ in range(n_rounds):
            shapes = np.stack([_turned(shape, mean) for shape in shapes])
            mean = shapes.mean(axis=0)
        return shapes
    if shapes.shape[2] == PLANE:
        return shapes
    mean = shapes[0]
    for _ in range(n_rounds):
        shapes = turned_about_y(shapes, heading_of(shapes, mean))
        mean = shapes.mean(axis=0)
    return shapes


def _turned(shape: FloatArray, mean: FloatArray) -> FloatArray:
    turn = fit_similarity(mean, shape, has_scale=False)
    return shape if turn is None else np.asarray(shape @ turn.rotation.T)


def heading_of(shapes: FloatArray, mean: FloatArray) -> FloatArray:
    """Return the (S,) turns about y, radians, that lay (S, N, 3) shapes onto the (N, 3) mean."""
    x, z = shapes[..., 0], shapes[..., 2]
    across = (z * mean[:, 0] - x * mean[:, 2]).sum(axis=-1)
    along = (x * mean[:, 0] + z * mean[:, 2]).sum(axis=-1)
    return np.asarray(np.arctan2(across, along))


def turned_about_y(shapes: FloatArray, angles_rad: FloatArray) -> FloatArray:
    """Turn (S, N, 3) shapes by (S,) angles: from z towards x."""
    cos, sin = np.cos(angles_rad)[:, None], np.sin(angles_rad)[:, None]
    x, y, z = np.moveaxis(shapes, -1, 0)
    return np.stack([cos * x + sin * z, y, cos * z - sin * x], axis=-1)


def _grouped(shapes: FloatArray, n_groups: int, params: TrainingParams) -> IntArray:
    """Return which group each shape is in: k-means, begun far apart (k-means++)."""
    rng = np.random.default_rng(params.seed)
    rows = shapes.reshape(len(shapes), -1)
    centres = rows[[int(rng.integers(len(rows)))]]
    for _ in range(n_groups - 1):
        nearest = _squared(rows, centres).min(axis=1)
        if not nearest.any():
            break
        chosen = int(rng.choice(len(rows), p=nearest / nearest.sum()))
        centres = np.concatenate([centres, rows[[chosen]]])
    groups = np.zeros(len(rows), int)
    for _ in range(params.n_rounds):
        groups = _squared(rows, centres).argmin(axis=1)
        kept = [k for k in range(len(centres)) if np.count_nonzero(groups == k) > PLANE]
        new = np.stack([rows[groups == k].mean(axis=0) for k in kept])
        if len(new) == len(centres) and np.allclose(new, centres):
            break
        centres = new
    return np.asarray(_squared(rows, centres).argmin(axis=1))


def _squared(rows: FloatArray, centres: FloatArray) -> FloatArray:
    apart = (rows**2).sum(axis=1)[:, None] - 2 * rows @ centres.T + (centres**2).sum(axis=1)
    return np.asarray(np.maximum(apart, 0.0))


def _prototype(  # noqa: PLR0913, PLR0917
    names: tuple[str, ...],
    aligned: FloatArray,
    is_member: BoolArray,
    log_radii: FloatArray,
    called: Sequence[str],
    is_upright: bool,
    params: TrainingParams,
) -> Prototype:
    shapes = aligned[is_member]
    if shapes.shape[2] == SPACE:
        shapes = _laid_together(shapes, is_upright=is_upright)
        shapes = _facing(shapes, names) if is_upright else shapes
    mean = shapes.mean(axis=0)
    size_m = float(np.exp(log_radii[is_member].mean()))
    modes, noise = _modes(shapes - mean, params)
    return Prototype(
        kind=Counter(called).most_common(1)[0][0] if called else "",
        weight=float(is_member.mean()),
        mean=mean,
        modes=modes,
        noise=noise + (params.noise_m / size_m) ** 2,
        log_size=math.log(size_m),
        log_size_sd=max(float(log_radii[is_member].std()), 0.05),
    )


def _facing(shapes: FloatArray, names: tuple[str, ...]) -> FloatArray:
    """Turn (S, N, D) shapes together so that their mean's left is where x grows."""
    left = left_of(shapes.mean(axis=0), names)
    if shapes.shape[2] != SPACE or not np.hypot(left[0], left[2]) > 0:
        return shapes
    return turned_about_y(shapes, np.full(len(shapes), np.arctan2(left[2], left[0])))


def _modes(off: FloatArray, params: TrainingParams) -> tuple[FloatArray, FloatArray]:
    """Return (t, N, D) modes and what a coordinate of each point varies beside them (N,)."""
    n_shapes, n_points, n_dimensions = off.shape
    rows = off.reshape(n_shapes, -1)
    _, spread, directions = np.linalg.svd(rows, full_matrices=False)
    variances = spread**2 / max(n_shapes - 1, 1)
    held = np.cumsum(variances) / max(variances.sum(), 1e-300)
    n_kept = int(np.searchsorted(held, params.kept_variance - 1e-12)) + 1
    n_kept = min(n_kept, params.most_modes, max(n_shapes - 1, 1))
    modes = directions[:n_kept] * np.sqrt(variances[:n_kept, None])
    rest = rows - rows @ directions[:n_kept].T @ directions[:n_kept]
    noise = (rest**2).reshape(off.shape).sum(axis=(0, 2)) / (max(n_shapes - 1, 1) * n_dimensions)
    return modes.reshape(n_kept, n_points, n_dimensions).copy(), noise
