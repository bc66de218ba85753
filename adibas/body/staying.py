"""People whose outline falls apart from one depth image to the next are still whole.

Who bends towards the camera is seen as a head with an arm, another arm, and legs far behind them:
no rule for one image takes that for a person. Their surfaces lie where the person was a moment
ago, and nearly as far away.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from adibas.arrays import BoolArray, Float32Array, Int32Array
from adibas.body.mask import box_of
from adibas.data.masks import BodyMask

STAYS_WHOLE = 0.8
"""Share of the pixels of a moment ago; of who shows fewer a part may not have been seen."""


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """A depth image of a moment ago, and who was in it.

    Attributes
    ----------
    depth_m : (H, W) float32 array
        NaN where not measured.
    people : sequence of (H, W) bool arrays
    """

    depth_m: Float32Array
    people: Sequence[BoolArray]


@dataclass(frozen=True, slots=True)
class StayingParams:
    """When somebody is put together again; ours, chosen on simulated bends.

    Attributes
    ----------
    least_inside : float
        A surface belongs to who was there if this share of its pixels did: 0.6.
    farthest_m : float
        And if it lies on the average so near to what was seen there: 0.25, more than a body moves
        in a tenth of a second.
    here : float
        Who was found is near the place if this share of the pixels is: 0.3, walking past.
    broken : float
        Somebody fell apart if nobody near has so many pixels, as a share of those before: 0.7.
        Or if two were found where one was.
    whole : float
        And is put together if the surfaces cover this share of the pixels: 0.6.
    hidden : float
        Nobody else is before so much of the pixels: 0.1.
    gap_px : int
        Widest gap between the surfaces; 25: the shadow between an arm and the trunk.
    most : float
        This share of the pixels is not further apart: 0.9.
    """

    least_inside: float = 0.6
    farthest_m: float = 0.25
    here: float = 0.3
    broken: float = 0.7
    whole: float = 0.6
    hidden: float = 0.1
    gap_px: int = 25
    most: float = 0.9


def shows_less(pixels: BoolArray | None, before: Moment) -> bool:
    """Say whether so much less is seen of one person than a moment ago that a part may be missing.

    Parameters
    ----------
    pixels : (H, W) bool array or None
        Of the person now; None where nobody is seen.
    before : Moment
        With that person alone.
    """
    n_now = 0 if pixels is None else np.count_nonzero(pixels)
    (were,) = before.people
    return bool(n_now < STAYS_WHOLE * np.count_nonzero(were))


def put_together(
    found: Sequence[BodyMask],
    labels: Int32Array,
    depth_m: Float32Array,
    before: Moment,
    params: StayingParams | None = None,
) -> tuple[BodyMask, ...]:
    """Return the masks of everybody, those that fell apart put together again.

    Parameters
    ----------
    found : sequence of BodyMask
        Who was found in this image by itself.
    labels : (H, W) int32 array
        Of the image's surfaces; 0 where there is nothing.
    depth_m : (H, W) float32 array
        NaN where not measured.
    before : Moment
    params : StayingParams or None
    """
    params = params or StayingParams()
    people = list(found)
    for pixels in before.people:
        n_before = int(np.count_nonzero(pixels))
        shares = [_inside(one.pixels, pixels) for one in people]
        here = [
            one.pixels for one, share in zip(people, shares, strict=True) if share > params.here
        ]
        others = [
            one for one, share in zip(people, shares, strict=True) if share < params.least_inside
        ]
        largest = max(map(np.count_nonzero, here), default=0)
        if largest >= params.broken * n_before and len(people) - len(others) <= 1:
            continue
        if any(_inside(pixels, one.pixels) > params.hidden for one in others):
            continue  # hidden by somebody, and not fallen apart
        free = labels.copy()
        for one in others:
            free[one.pixels] = 0
        whole = _surfaces_of(pixels, free, depth_m, before.depth_m, params)
        if np.count_nonzero(whole) >= params.whole * n_before and _is_near(whole, params):
            people = [*others, BodyMask(whole, is_put_together=True)]
    return tuple(people)


def _is_near(whole: BoolArray, params: StayingParams) -> bool:
    """Say whether the surfaces lie close together: two people who part do not."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (params.gap_px, params.gap_px))
    here = whole[box_of(whole, params.gap_px)]
    joined = cv2.dilate(here.astype(np.uint8), disc)
    _n_pieces, pieces = cv2.connectedComponents(joined)
    largest = np.bincount(pieces[here]).max()
    return bool(largest >= params.most * np.count_nonzero(here))


def _surfaces_of(
    pixels: BoolArray,
    labels: Int32Array,
    depth_m: Float32Array,
    before_m: Float32Array,
    params: StayingParams,
) -> BoolArray:
    """Return the surfaces that lie where somebody was."""
    n_all = np.bincount(labels.ravel())
    n_labels = len(n_all)
    index = np.flatnonzero(pixels)
    inside = labels.ravel()[index]
    n_inside = np.bincount(inside, minlength=n_labels)
    off_m = np.abs(depth_m.ravel()[index] - before_m.ravel()[index])
    both = np.isfinite(off_m)
    total_m = np.bincount(inside[both], off_m[both], minlength=n_labels)
    n_both = np.bincount(inside[both], minlength=n_labels)
    belongs = (n_inside > params.least_inside * n_all) & (total_m < params.farthest_m * n_both)
    belongs[0] = False
    return np.take(belongs, labels)


def _inside(one: BoolArray, pixels: BoolArray) -> float:
    """Return which share of one mask lies in another."""
    return float(np.count_nonzero(one & pixels)) / max(int(np.count_nonzero(one)), 1)
