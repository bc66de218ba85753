"""Names for points that have none: the most probable ones, and how sure each is.

What the points could be is searched for by prototypes; what else they could be, with energies
hardly higher, is the doubt.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from adibas.arrays import FloatArray, IntArray, check_shape, read_only
from adibas.data.joints import mirror_order
from adibas.shapes import labelling_exchange_kernels as exchanging
from adibas.skeleton.given_names import agrees, has_names
from adibas.skeleton.model import PointModel
from adibas.skeleton.prepared import PreparedModel
from adibas.skeleton.prototype_search import LEAST_POINTS, Found, LabelParams, PrototypeSearch
from adibas.skeleton.side_odds import side_factor
from adibas.skeleton.starts import heading_of_turn


@dataclass(frozen=True, slots=True, eq=False)
class Labelling:
    """Names of M points.

    Attributes
    ----------
    names : tuple of str or None
        Of each point; None where it has none or the search is not sure.
    guesses : tuple of str or None
        The most probable name of each, however unsure; None: most probably none of the model's.
    confidences : (M,) array
        Of the guesses, 0 to 1.
    heading_rad : float
        Of the patient, 0 facing the camera; NaN where nothing was found, and in the plane.
    masses : (M, N + 1) array
        Probability of each name for each point; the last: of none. All alike where the search
        cannot tell: too few points, or nothing was found.
    """

    names: tuple[str | None, ...]
    guesses: tuple[str | None, ...]
    confidences: FloatArray
    heading_rad: float
    masses: FloatArray

    def __post_init__(self) -> None:
        check_shape("confidences", self.confidences, (len(self.names),))
        check_shape("masses", self.masses, (len(self.names), None))
        read_only(self.confidences)
        read_only(self.masses)


def label_points(
    models: Sequence[PreparedModel],
    points_m: FloatArray,
    view: str = "",
    params: LabelParams | None = None,
    temperature: float = 1.0,
    given: IntArray | None = None,
) -> Labelling:
    """Name points.

    Parameters
    ----------
    models : sequence of PreparedModel
        At least one, all of the same names and of the points' dimensions; the best one names.
    points_m : (M, D) array
        In metres, y down, without NaN.
    view : str
        One of `HEADINGS_RAD` as it was declared; empty: unknown, and the sides are inferred.
    temperature : float
        See `SkeletonModel`.
    given : (M,) int array or None
        Names that points have already, see `given_index`. Where nothing that was found agrees with
        them, nothing is told.
    """
    params = params or LabelParams()
    if not models:
        raise ValueError("points are named by at least one model")
    check_shape("points_m", points_m, (None, models[0].model.n_dimensions))
    nothing = nothing_told(len(points_m), len(models[0].model.names))
    if len(points_m) < LEAST_POINTS:
        return nothing
    points = np.ascontiguousarray(points_m - points_m.mean(axis=0))
    found = [
        one
        for part in models
        for one in PrototypeSearch(part, points, view, params).found(has_mirror=part is models[0])
    ]
    if given is not None and has_names(given):
        kept = (left for one in found for left in _agreeing(one, given))
        found = sorted(kept, key=lambda one: one.candidate.energy)
    return _named(found, models[0].model, len(points), params, temperature) if found else nothing


def nothing_told(n_points: int, n_names: int) -> Labelling:
    """Return the labelling of points that may have any name or none."""
    nobody = (None,) * n_points
    masses = np.full((n_points, n_names + 1), 1.0 / (n_names + 1))
    return Labelling(nobody, nobody, np.zeros(n_points), math.nan, masses)


def _agreeing(one: Found, given: IntArray) -> Iterator[Found]:
    """Give what is left of a candidate and its alternatives; the likeliest is the candidate."""
    every = np.vstack([one.candidate.partners[None], one.others])
    energies = np.append(one.candidate.energy, one.energies)
    # Alternatives that were never made have no energy, and anything at all as names.
    kept = agrees(every, given) & np.isfinite(energies)
    if kept.any():
        every, energies = every[kept], energies[kept]
        best = int(np.argmin(energies))
        candidate = replace(
            one.candidate, partners=every[best].copy(), energy=float(energies[best])
        )
        rest = np.arange(len(energies)) != best
        yield Found(candidate, every[rest], energies[rest])


def _named(
    found: Sequence[Found],
    model: PointModel,
    n_points: int,
    params: LabelParams,
    temperature: float,
) -> Labelling:
    """Return the names of the best candidate, doubted by all others."""
    best = min((one.candidate for one in found), key=lambda one: one.energy)
    masses = np.zeros((n_points, len(model.names) + 1))
    of_other_side = np.zeros_like(masses)
    seen: set[bytes] = set()
    for one in found:
        candidate = one.candidate
        if candidate.partners.tobytes() in seen:
            continue
        seen.add(candidate.partners.tobytes())
        is_other = _is_other_side(candidate.partners, best.partners, model.names)
        side = of_other_side if is_other else masses
        itself = np.array([candidate.energy])
        exchanging.weigh(side, candidate.partners[None], itself, best.energy, temperature)
        exchanging.weigh(side, one.others, one.energies, best.energy, temperature)
    # Each way to name gives every point its weight once.
    weights = float(masses[0].sum()), float(of_other_side[0].sum())
    masses += side_factor(*weights, params.side_divisor) * of_other_side
    masses /= masses.sum(axis=1, keepdims=True)
    index = np.full(n_points, len(model.names))
    index[best.partners[best.partners >= 0]] = np.flatnonzero(best.partners >= 0)
    confidences = masses[np.arange(n_points), index]
    guesses = tuple(None if i == len(model.names) else model.names[i] for i in index)
    names = tuple(
        guess if confidence >= params.sure else None
        for guess, confidence in zip(guesses, confidences, strict=True)
    )
    heading = heading_of_turn(best.turn) if model.n_dimensions == len("xyz") else math.nan
    return Labelling(names, guesses, confidences, heading, masses)


def _is_other_side(partners: IntArray, best: IntArray, names: tuple[str, ...]) -> bool:
    """Say whether at least two names of one are in the other those of the other side."""
    mirror = np.array(mirror_order(names))
    is_turned = (partners == best[mirror]) & (best[mirror] != best) & (partners >= 0)
    return bool(np.count_nonzero(is_turned) >= len("ab") + len("ab"))
