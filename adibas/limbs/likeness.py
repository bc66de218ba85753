"""How much like a person something is, by the limbs that were found in it.

A forest that knows people alone finds limbs in a chair, too: unsure of them, in pieces, and next
to limbs that no body has side by side; sizes and joints tell more (`adibas.limbs.figure`,
`adibas.skeleton.plausibility`). What tells things from people was learned from both, as weights
of such quantities (logistic regression); the measure is ours.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import cv2
import numpy as np

from adibas.arrays import AnyArray, BoolArray, Float32Array, FloatArray, check_shape, read_only
from adibas.data.joints import BODY_PART_NAMES
from adibas.data.limbs import NO_LABEL, LimbParts
from adibas.files import check_document
from adibas.limbs.likeness_kernels import count_borders, find_pieces

FORMAT, VERSION = "adibas-person-likeness", 2
PART_QUANTITIES = (
    "sure",
    "entropy",
    "clutter",
    "unsettled",
    "likelihood",
    "odd_borders",
    "borders",
    "limbs",
    "pieces",
    "whole",
    "area",
)
"""What `describe_parts` gives, in this order."""
LOST_SHARE = 0.01
"""Of simulated people, seen as badly as those that models are trained on, who are not recognised.

Ours: with none lost half of the things would not be, either; real people lie far above.
"""
LEAST_PIXELS, LEAST_SHARE, LEAST_PIECE_SHARE = 4, 0.003, 0.001
_TINY = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Likeness:
    """What was learned.

    Attributes
    ----------
    quantities : tuple of str
        The Q names of what is weighed.
    middles, spreads, weights : (Q,) arrays
        Of each: mean and standard deviation where it was learned, and weight.
    threshold : float
        What is below it is no person.
    provenance : mapping
        From what it was learned; plain JSON values.
    """

    quantities: tuple[str, ...]
    middles: FloatArray
    spreads: FloatArray
    weights: FloatArray
    threshold: float
    provenance: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("middles", "spreads", "weights"):
            check_shape(name, getattr(self, name), (len(self.quantities),))
            read_only(getattr(self, name))

    def score(self, quantities: FloatArray) -> float:
        """Return how much like a person something of (Q,) quantities is; more is more."""
        return float((quantities - self.middles) / self.spreads @ self.weights)


def describe_parts(
    depth_m: Float32Array, mask: BoolArray, focal_px: float, parts: LimbParts
) -> FloatArray:
    """Return the (11,) `PART_QUANTITIES` of limbs that were found.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Metres; NaN where not measured.
    mask : (H, W) bool array
        Whose limbs they are.
    focal_px : float
    parts : LimbParts
        Of the full body; at least one pixel.
    """
    limbs = parts.probabilities
    # A product with ones: sums along rows take several times as long.
    clutter = np.maximum(1.0 - limbs @ np.ones(limbs.shape[1], limbs.dtype), 0.0)
    every = np.column_stack([limbs, clutter])
    step = _step_of(parts.pixels)
    seen = np.ascontiguousarray(parts.pixels[::step, ::step])
    left, top, width, height = cv2.boundingRect(seen.view(np.uint8))
    box = np.s_[top : top + height, left : left + width]
    seen = seen[box]
    thin = np.where(seen, parts.chosen[::step, ::step][box], NO_LABEL)
    chosen = thin[seen].astype(np.int64)
    column = np.where(chosen < 0, limbs.shape[1], chosen)
    likely = every[np.arange(len(every)), column]
    surest = np.ascontiguousarray(limbs.T).max(axis=0)  # along rows it takes seven times as long
    area_m2 = float(np.nansum(depth_m[mask] ** 2)) / focal_px**2
    return np.array(
        [
            surest.mean(),
            -(every * np.log(np.maximum(every, _TINY))).sum(dtype=np.float64) / len(every),
            clutter.mean(),
            (every.argmax(axis=1) != column).mean(),
            np.log(np.maximum(likely, 1e-3)).mean(),
            *_border_shares(thin),
            *_pieces(thin, len(every)),
            np.log(area_m2 + 1e-3),
        ],
        np.float64,
    )


def _step_of(pixels: BoolArray) -> int:
    """Return of how many rows and columns one was looked at."""
    rows, columns = (np.flatnonzero(pixels.any(axis=axis)) for axis in (1, 0))
    return max(1, int(np.gcd(np.gcd.reduce(rows), np.gcd.reduce(columns))))


def _border_shares(labels: AnyArray) -> tuple[float, float]:
    """Return the share of borders between limbs that no body has, and of borders in all pairs."""
    n_pairs, n_borders, n_odd = count_borders(labels, _NEIGHBOURS)
    return n_odd / max(n_borders, 1), n_borders / max(n_pairs, 1)


def _pieces(labels: AnyArray, n_pixels: int) -> tuple[float, float, float]:
    """Return how many limbs are seen, pieces beyond one for each, and the largest one's share."""
    of_piece, sizes = find_pieces(labels)
    n_of = np.bincount(of_piece, sizes, minlength=len(BODY_PART_NAMES))
    largest = np.zeros(len(BODY_PART_NAMES))
    np.maximum.at(largest, of_piece, sizes)
    is_seen = n_of >= max(LEAST_PIXELS, LEAST_SHARE * n_pixels)
    is_large = sizes >= max(LEAST_PIXELS, LEAST_PIECE_SHARE * n_pixels)
    n_limbs, n_pieces = int(is_seen.sum()), int(is_large[is_seen[of_piece]].sum())
    whole = float((largest[is_seen] / n_of[is_seen]).sum())
    return float(n_limbs), float(n_pieces - n_limbs), whole / max(n_limbs, 1)


def _neighbours() -> BoolArray:
    """Return the (15, 15) table of parts that lie side by side on a body."""
    pairs = [
        ("head", "neck"),
        ("head", "torso"),
        ("neck", "torso"),
        ("left_upper_leg", "right_upper_leg"),
    ]
    for side in ("left", "right"):
        chains = (
            ("torso", "upper_arm", "lower_arm", "hand"),
            ("torso", "upper_leg", "lower_leg", "foot"),
        )
        for chain in chains:
            named = [part if part == "torso" else f"{side}_{part}" for part in chain]
            pairs += list(pairwise(named))
    table = np.eye(len(BODY_PART_NAMES), dtype=np.bool_)
    for first, second in pairs:
        a, b = BODY_PART_NAMES.index(first), BODY_PART_NAMES.index(second)
        table[a, b] = table[b, a] = True
    return table


_NEIGHBOURS = _neighbours()


def learn_likeness(
    quantities: tuple[str, ...],
    shown: tuple[FloatArray, FloatArray],
    spared: FloatArray,
    provenance: Mapping[str, object],
) -> Likeness:
    """Return what tells people from things, both as heavy.

    Parameters
    ----------
    quantities : tuple of str
        Q names.
    shown : ((P, Q) array, (T, Q) array)
        People, and things.
    spared : (N, Q) array
        Other people: `LOST_SHARE` of them lie below the threshold.
    provenance : mapping
    """
    people, things = shown
    both = np.concatenate(shown)
    middles, spreads = both.mean(axis=0), both.std(axis=0) + _TINY
    rows = np.column_stack([(both - middles) / spreads, np.ones(len(both))])
    is_person = np.r_[np.ones(len(people)), np.zeros(len(things))]
    heavy = np.r_[np.full(len(people), 0.5 / len(people)), np.full(len(things), 0.5 / len(things))]
    weights = _logistic(rows, is_person, heavy * len(both))[:-1]
    found = Likeness(quantities, middles, spreads, weights, 0.0, provenance)
    threshold = float(np.quantile([found.score(one) for one in spared], LOST_SHARE))
    return replace(found, threshold=threshold)


def _logistic(rows: FloatArray, is_first: FloatArray, heavy: FloatArray) -> FloatArray:
    """Return the weights of a logistic regression, drawn to 0 a little, by Newton's method."""
    ridge = 3.0 * np.eye(rows.shape[1])
    ridge[-1, -1] = _TINY
    weights = np.zeros(rows.shape[1])
    for _round in range(50):
        odds = 1.0 / (1.0 + np.exp(-np.clip(rows @ weights, -30.0, 30.0)))
        slope = rows.T @ (heavy * (is_first - odds)) - ridge @ weights
        bend = (rows * (heavy * odds * (1.0 - odds))[:, None]).T @ rows + ridge
        move = np.linalg.solve(bend, slope)
        weights += move
        if np.abs(move).max() < 1e-9:  # noqa: PLR2004  (nothing moves any more)
            break
    return weights


def likeness_to_json(likeness: Likeness) -> dict[str, Any]:
    """Return the document of a file of what was learned."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "quantities": list(likeness.quantities),
        **{name: getattr(likeness, name).tolist() for name in ("middles", "spreads", "weights")},
        "threshold": likeness.threshold,
        "provenance": dict(likeness.provenance),
    }


def likeness_from_json(document: Mapping[str, Any], quantities: tuple[str, ...]) -> Likeness:
    """Return what such a document says.

    Raises
    ------
    ValueError
        It is no such document, or of other quantities than these.
    """
    check_document(document, FORMAT, VERSION)
    if tuple(document["quantities"]) != quantities:
        raise ValueError("the document is of other quantities")
    middles, spreads, weights = (
        np.array(document[name], np.float64) for name in ("middles", "spreads", "weights")
    )
    provenance = dict(document.get("provenance", {}))
    threshold = float(document["threshold"])
    return Likeness(quantities, middles, spreads, weights, threshold, provenance)
