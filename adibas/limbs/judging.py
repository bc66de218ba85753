"""Whether what was segmented is a person at all, and in view: words before a skeleton is made."""

from dataclasses import dataclass

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array
from adibas.data.limbs import LimbParts
from adibas.data.sentence import Sentence
from adibas.geometry.picture_edges import cut_px, seen_box
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
BLIND = message(
    "Hardly any depth is measured. Keep 0.8 m away or more, and see that nothing covers the "
    "camera and no sunlight falls on it."
)
TORN = message(
    "Too much of the picture has no depth to find anybody. Avoid sunlight, mirrors and glass, and "
    "step nearer."
)
SOMETHING_NEAR = message(
    "Something is too near to the camera. Step back to 1.5 m or more, and clear the view."
)
SOMETHING_CUT = message(
    "Nobody is seen whole: what stands there is cut off by the edge of the picture. Step back, or "
    "turn the camera, until the whole person is seen."
)
SOMETHING_DARK = message(
    "Nobody is seen, and a large part of the picture has no depth. Whoever stands there is too "
    "near or too far away: keep 1.5 to 4 m from the camera."
)
SOMETHING_LOW = message(
    "Nobody is seen: what stands there is too low or too flat for a person. Clear the view, or "
    "step in front of the camera."
)
SOME_HOLES = message(
    "{percent} % of the picture has no depth: joints are less exact. Avoid sunlight, mirrors, and "
    "dark or shiny surfaces."
)
UNLIKE = message(
    "What is seen is more like furniture or an animal than like a person. Clear the view, or step "
    "forward."
)
FEW_LIMBS = message(
    "Only {n} of {total} limbs are seen: what is seen may be no person. Step forward, and clear "
    "the view."
)
ABSENCES = {
    "blind": BLIND,
    "holes": TORN,
    "near": SOMETHING_NEAR,
    "cut": SOMETHING_CUT,
    "gap": SOMETHING_DARK,
    "thing": SOMETHING_LOW,
    "nobody": NOBODY,
}
"""What is said of each answer of `adibas.body.absence.why_nobody`."""


CLEARLY = 2.0
"""So far below the threshold of the likeness nobody is who is seen whole, and most things are."""

REMARKS = (HALF, SOME_HOLES)
"""What is said of somebody who is measured all the same."""


@dataclass(frozen=True, slots=True)
class JudgingParams:
    """What is too little; ours, chosen on simulated people and things.

    Attributes
    ----------
    nearest_m : float
        A Kinect measures from 0.5 m; nearer than this its picture cuts a standing person off.
    most_clutter, most_holes : float
        Shares of the mask.
    most_picture_holes : float
        Share of the picture in small holes.
    most_border : float
        Share of the border of the picture that the person covers.
    hole_share : float
        Of the picture's width: twice so wide a gap between measured pixels is a hole.
    least_limbs : float
        Share of the labels that must be seen.
    least_limb : float
        Share of the mask from which a limb counts as seen.
    """

    nearest_m: float = 0.8
    most_clutter: float = 0.4
    most_holes: float = 0.3
    most_picture_holes: float = 0.65
    most_border: float = 0.02
    hole_share: float = 0.01
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
    is_clear : bool
        It is no person, and not nearly one.
    """

    is_person: bool
    notices: tuple[Sentence, ...]
    is_clear: bool = False


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
    measured = np.asarray(np.isfinite(depth_m))
    holes = _hole_share(measured, mask, params)
    if holes > params.most_holes:
        return Judgement(False, (Sentence(HOLES, {"percent": round(100 * holes)}),))
    n_near = np.count_nonzero(mask & (depth_m < params.nearest_m))
    if 2 * n_near > np.count_nonzero(mask & measured):
        distance_m = float(np.median(depth_m[mask & measured]))
        return Judgement(False, (Sentence(TOO_NEAR, {"distance": distance_m}),))
    border_px = cut_px(mask, seen_box(measured)).sum()
    if border_px > params.most_border * 2 * sum(mask.shape):
        return Judgement(True, (Sentence(HALF),))
    return Judgement(True, ())


def judge_holes(share: float, params: JudgingParams | None = None) -> Judgement:
    """Judge a picture of which a share is in small holes, too many to pass over."""
    if share > (params or JudgingParams()).most_picture_holes:
        return Judgement(False, (Sentence(TORN),))
    return Judgement(True, (Sentence(SOME_HOLES, {"percent": round(100 * share)}),))


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
        return Judgement(False, (Sentence(UNLIKE),), is_clear=score < threshold - CLEARLY)
    return Judgement(True, ())


def judge_absence(absence: str) -> Judgement:
    """Say why nobody was found, in words; see `adibas.body.absence.why_nobody`."""
    return Judgement(False, (Sentence(ABSENCES[absence]),))


def _hole_share(measured: BoolArray, mask: BoolArray, params: JudgingParams) -> float:
    """Return the share of a mask without depth, or of all around it where that is more.

    Where the depth falls to pieces, a mask is one of the pieces and has few holes of its own.
    """
    left, top, width, height = cv2.boundingRect(mask.astype(np.uint8))
    box = np.s_[top : top + height, left : left + width]
    radius_px = max(1, round(params.hole_share * mask.shape[1]))
    around = np.pad(measured[box].astype(np.uint8), radius_px)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius_px + 1,) * 2)
    closed = cv2.morphologyEx(around, cv2.MORPH_CLOSE, disc)[
        radius_px:-radius_px, radius_px:-radius_px
    ]
    shares = [_share(measured[box], where) for where in (mask[box], closed.view(np.bool_))]
    return 1.0 - min(shares)


def _share(measured: BoolArray, where: BoolArray) -> float:
    n_measured, n_all = int(np.count_nonzero(measured & where)), int(np.count_nonzero(where))
    return n_measured / max(n_all, 1)
