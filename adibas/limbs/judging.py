"""Whether what was segmented is a person at all, and in view: words before a skeleton is made."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, Float32Array
from adibas.data.limbs import LimbParts
from adibas.data.sentence import Sentence
from adibas.texts import message

NOBODY = message("Nobody is seen. Let the person step in front of the camera.")
TOO_NEAR = message(
    "The person is {distance} m from the camera, which is too near. Step back to 1.5 m or more."
)
NO_PERSON = message(
    "What is seen does not look like a person: {percent} % of it is furniture. Move it away."
)
HALF = message(
    "Only a part of the person is in the picture. Step back, or turn the camera, until all is seen."
)
HOLES = message(
    "{percent} % of the person has no depth. Avoid sunlight, and dark or shiny clothes."
)
UNLIKE = message(
    "What is seen is more like furniture or an animal than like a person. Clear the view, or step "
    "forward."
)
FEW_LIMBS = message("Only {n} of {total} limbs are seen: what is seen may be no person.")


@dataclass(frozen=True, slots=True)
class JudgingParams:
    """What is too little; ours, chosen on simulated people and things.

    Attributes
    ----------
    nearest_m : float
        A Kinect measures from 0.5 m; nearer than this its picture cuts a standing person off.
    most_clutter, most_holes : float
        Shares of the mask.
    most_border : float
        Share of the border of the picture that the person covers.
    least_limbs : float
        Share of the labels that must be seen.
    least_limb : float
        Share of the mask from which a limb counts as seen.
    """

    nearest_m: float = 0.8
    most_clutter: float = 0.4
    most_holes: float = 0.35
    most_border: float = 0.02
    least_limbs: float = 0.4
    least_limb: float = 0.004


@dataclass(frozen=True, slots=True)
class Judgement:
    """What was found.

    Attributes
    ----------
    is_person : bool
        False: make no skeleton of it.
    notices : tuple of Sentence
        What to say.
    """

    is_person: bool
    notices: tuple[Sentence, ...]


def judge_mask(
    depth_m: Float32Array, mask: BoolArray | None, params: JudgingParams | None = None
) -> Judgement:
    """Judge the mask of a person before anything is made of it.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        NaN where not measured.
    mask : (H, W) bool array or None
        None or empty: nobody.
    params : JudgingParams or None
    """
    params = params or JudgingParams()
    if mask is None or not mask.any():
        return Judgement(False, (Sentence(NOBODY),))
    inside_m = depth_m[mask]
    measured_m = inside_m[np.isfinite(inside_m)]
    holes = 1.0 - len(measured_m) / len(inside_m)
    if holes > params.most_holes:
        return Judgement(False, (Sentence(HOLES, {"percent": round(100 * holes)}),))
    distance_m = float(np.median(measured_m))
    if distance_m < params.nearest_m:
        return Judgement(False, (Sentence(TOO_NEAR, {"distance": distance_m}),))
    if _border_share(mask) > params.most_border:
        return Judgement(True, (Sentence(HALF),))
    return Judgement(True, ())


def judge_parts(
    parts: LimbParts, mask: BoolArray, params: JudgingParams | None = None
) -> Judgement:
    """Judge the limbs that were found in a mask that is not empty."""
    params = params or JudgingParams()
    n_pixels = max(int(np.count_nonzero(mask)), 1)
    of_limb = np.bincount(parts.chosen[parts.chosen >= 0], minlength=len(parts.labels))
    clutter = 1.0 - of_limb.sum() / n_pixels
    if clutter > params.most_clutter:
        return Judgement(False, (Sentence(NO_PERSON, {"percent": round(100 * clutter)}),))
    n_seen = int(np.count_nonzero(of_limb > params.least_limb * n_pixels))
    if n_seen < params.least_limbs * len(parts.labels):
        fields = {"n": n_seen, "total": len(parts.labels)}
        return Judgement(False, (Sentence(FEW_LIMBS, fields),))
    return Judgement(True, ())


def judge_likeness(score: float, threshold: float) -> Judgement:
    """Judge how much like a person something is, by its limbs; see `adibas.limbs.likeness`."""
    if score < threshold:
        return Judgement(False, (Sentence(UNLIKE),))
    return Judgement(True, ())


def _border_share(mask: BoolArray) -> float:
    """Return the share of the picture's border that a mask covers."""
    border = np.concatenate([mask[0], mask[-1], mask[1:-1, 0], mask[1:-1, -1]])
    return float(border.mean())
