"""How often a joint is where it is said to be: confidences that are shares of right joints.

The confidence of the choice (`adibas.skeleton.following`) orders joints. How many of those with
a confidence are within 10 cm of the truth was counted on simulated people, for people seen whole
and for those whom an edge of the picture cuts off, joint kind by joint kind, close to that edge
and farther from it; a monotone map turns the one into the other. A joint of somebody cut off that
is more often wrong than right is not seen.

Source of the map: Zadrozny & Elkan, Transforming classifier scores into accurate multiclass
probability estimates, KDD 2002 (isotonic regression by pooling adjacent violators).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from adibas.arrays import BoolArray, FloatArray, check_shape, read_only
from adibas.data.joints import JOINT_NAMES
from adibas.files import check_document
from adibas.skeleton.following import ChosenJoints
from adibas.skeleton.picture import Picture

FORMAT, VERSION = "adibas-joint-reliability", 1
NEAR_M = 0.1
LEAST_SHARE = 0.5
N_BINS = 6
PRIOR_JOINTS = 5.0
"""Joints of the whole situation that are thought to be in each bin beside its own."""
WHOLE = "whole"
EDGES = ("top", "bottom", "left", "right")
CLOSE_M = 0.3
"""From the edge that cuts somebody off above or below: of 30 knees that were said to be so close
to it one was right, of 45 others 36."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Shares of right joints over confidence, both rising.

    Attributes
    ----------
    confidences, shares : (K,) arrays
        Straight lines between; flat beyond.
    """

    confidences: FloatArray
    shares: FloatArray

    def __post_init__(self) -> None:
        check_shape("shares", self.shares, self.confidences.shape)
        read_only(self.confidences)
        read_only(self.shares)

    def __call__(self, confidence: float) -> float:
        """Return the share for a confidence."""
        return float(np.interp(confidence, self.confidences, self.shares))


@dataclass(frozen=True, slots=True, eq=False)
class Reliability:
    """A curve for each situation.

    Attributes
    ----------
    curves : mapping
        By the names that `situations` gives.
    provenance : mapping
        On what it was counted; plain JSON values.
    """

    curves: Mapping[str, Curve]
    provenance: Mapping[str, object] = field(default_factory=dict)

    def applied(
        self, joints: ChosenJoints, picture: Picture, least: float = LEAST_SHARE
    ) -> ChosenJoints:
        """Return joints with shares as confidences.

        Of somebody who is cut off, those below `least` are not seen. Of somebody seen whole all
        are given: on real people few of them are wrong (`docs/pose.md`).

        Parameters
        ----------
        joints : ChosenJoints
        picture : Picture
            What it shows of the person, and where it cuts the person off.
        least : float
        """
        shares = np.full(len(JOINT_NAMES), np.nan)
        inside_m = picture.inside_m(joints.joints_m)
        is_front = joints.front_probability > LEAST_SHARE
        for joint in np.flatnonzero(np.isfinite(joints.confidence)):
            names = situations(int(joint), picture.is_cut, inside_m[joint], is_front=is_front)
            confidence = float(joints.confidence[joint])
            shares[joint] = min(self.curves[name](confidence) for name in names)
        is_kept = shares >= (least if any(picture.is_cut) else 0.0)
        return replace(
            joints,
            joints_m=np.where(is_kept[:, None], joints.joints_m, np.nan),
            confidence=np.where(is_kept, shares, np.nan),
        )


def situations(
    joint: int, is_cut: Sequence[bool], inside_m: FloatArray, *, is_front: bool
) -> list[str]:
    """Return the names of the curves that hold for a joint of somebody who is cut off there.

    Above and below, joints close to the edge are told from the others; at a side, limbs of the
    patient's side that lies there.

    Parameters
    ----------
    joint : int
    is_cut : (top, bottom, left, right)
    inside_m : (4,) array
        How far the joint lies inside of each edge.
    is_front : bool
        The person faces the camera.
    """
    side, _, kind = JOINT_NAMES[joint].rpartition("_")
    found = []
    for edge, cut, away_m in zip(EDGES, is_cut, inside_m, strict=True):
        if not cut:
            continue
        if edge in ("top", "bottom"):
            found.append(f"{edge} close {kind}" if away_m < CLOSE_M else f"{edge} {kind}")
        elif not side:
            found.append(f"side {kind}")
        else:
            # Who faces the camera has the right side at the picture's left.
            is_near = (side != edge) == is_front
            found.append(f"side {'near' if is_near else 'far'} {kind}")
    return found or [f"{WHOLE} {kind}"]


def fit_curve(confidences: FloatArray, is_right: BoolArray, expected: float) -> Curve:
    """Return the rising curve through (N,) confidences and what was right of them.

    `expected` is the share that is believed where little was counted.
    """
    order = np.argsort(confidences, kind="stable")
    bins = [one for one in np.array_split(order, N_BINS) if len(one)]
    middles = [float(confidences[one].mean()) for one in bins] or [0.5]
    counts = [float(len(one)) + PRIOR_JOINTS for one in bins] or [PRIOR_JOINTS]
    rights = [float(is_right[one].sum()) + PRIOR_JOINTS * expected for one in bins]
    shares = np.divide(rights or [PRIOR_JOINTS * expected], counts)
    return Curve(np.array(middles), pooled(shares, np.array(counts)))


def pooled(shares: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the (K,) rising values nearest to some, by pooling adjacent violators."""
    blocks: list[tuple[float, float, int]] = []
    for share, weight in zip(shares.tolist(), weights.tolist(), strict=True):
        blocks.append((share, weight, 1))
        while len(blocks) > 1 and blocks[-2][0] >= blocks[-1][0]:
            (a, v, m), (b, w, n) = blocks[-2:]
            blocks[-2:] = [((a * v + b * w) / (v + w), v + w, m + n)]
    return np.repeat([share for share, _, _ in blocks], [n for _, _, n in blocks])


def reliability_to_json(reliability: Reliability) -> dict[str, Any]:
    """Return the document of a file of curves."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "near_m": NEAR_M,
        "curves": {
            name: {
                "confidences": np.round(curve.confidences, 4).tolist(),
                "shares": np.round(curve.shares, 4).tolist(),
            }
            for name, curve in sorted(reliability.curves.items())
        },
        "provenance": dict(reliability.provenance),
    }


def reliability_from_json(document: Mapping[str, Any]) -> Reliability:
    """Return the curves of such a document.

    Raises
    ------
    ValueError
        It is no such document, or curves are missing or fall.
    """
    check_document(document, FORMAT, VERSION)
    curves = {
        name: Curve(np.array(one["confidences"], np.float64), np.array(one["shares"], np.float64))
        for name, one in document["curves"].items()
    }
    if set(curves) != set(all_situations()):
        raise ValueError("the document has other curves")
    if any((np.diff(one.shares) < 0).any() for one in curves.values()):
        raise ValueError("a curve falls")
    return Reliability(curves, dict(document.get("provenance", {})))


def all_situations() -> tuple[str, ...]:
    """Return every name that `situations` gives."""
    cuts = [(False,) * 4, *(tuple(edge == one for one in EDGES) for edge in EDGES)]
    every = {
        name
        for joint in range(len(JOINT_NAMES))
        for cut in cuts
        for away_m in (0.0, 2.0 * CLOSE_M)
        for name in situations(joint, cut, np.full(len(EDGES), away_m), is_front=True)
    }
    return tuple(sorted(every))
