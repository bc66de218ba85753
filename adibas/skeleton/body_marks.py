"""Where markers of joints are on a body that the depth image shows.

A body is found without its markers: its joints within some centimetres, and of each pixel which
part it shows. Where a marker lies beside a joint, and on which part, was learned from simulated
people, for each view. That names a marker by itself, however many are hidden: a hand on a knee is
on the hand.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only
from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES, mirror_order
from adibas.files import check_document

BodyOdds: TypeAlias = Callable[[FloatArray], FloatArray]
"""Takes (M, 3) points, upright, metres; returns (M, N) log odds of each name against none."""

FORMAT, VERSION = "adibas-body-marks", 1
VIEWS = ("anterior", "posterior", "lateral")
"""The last as the right side is seen; the left one is its mirror image."""
N_PARTS = len(BODY_PART_NAMES) + 1
"""With what is no limb (furniture)."""
OTHER_JOINTS = np.array(mirror_order(JOINT_NAMES))
OTHER_PARTS = np.array([*mirror_order(BODY_PART_NAMES), len(BODY_PART_NAMES)])
ACROSS = np.array([-1.0, 1.0, 1.0])
"""What each joint and part is in the mirror image, and what becomes of a way there."""
FOUND_ELSEWHERE = 0.1
"""How often a joint without markers is taken to be found somewhere else."""
ROOM_M3 = 0.3
"""In which it lies then."""
PART_WEIGHT = 0.5
"""How much parts count: pixels of one body are no independent witnesses."""
OTHER_SIDE = 0.1
"""How often what is found of a side is taken to be of the other: legs are exchanged at times."""
LEAST_SHARE = 1e-3
"""A part that none of the pixels shows is as likely as that."""


@dataclass(frozen=True, slots=True, eq=False)
class ViewMarks:
    """What one view taught; left and right are the patient's.

    Attributes
    ----------
    offsets_m : (15, 3) array
        Mean way from the joint that is found to its marker: x right in the picture, y down, z away
        from the camera.
    covariances_m2 : (15, 3, 3) array
    part_odds : (15, 16) array
        Log of the share of each part, the last of no limb, about markers of the joint by that in
        the whole body.
    """

    offsets_m: FloatArray
    covariances_m2: FloatArray
    part_odds: FloatArray

    def __post_init__(self) -> None:
        n = len(JOINT_NAMES)
        check_shape("offsets_m", self.offsets_m, (n, 3))
        check_shape("covariances_m2", self.covariances_m2, (n, 3, 3))
        check_shape("part_odds", self.part_odds, (n, N_PARTS))
        for array in (self.offsets_m, self.covariances_m2, self.part_odds):
            if not np.isfinite(array).all():
                raise ValueError("marks on bodies are finite numbers")
            read_only(array)
        if np.linalg.eigvalsh(self.covariances_m2).min() <= 0.0:
            raise ValueError("covariances of marks must be positive definite")

    def mirrored(self) -> "ViewMarks":
        """Return what the mirror image would teach."""
        return ViewMarks(
            self.offsets_m[OTHER_JOINTS] * ACROSS,
            self.covariances_m2[OTHER_JOINTS] * np.outer(ACROSS, ACROSS),
            self.part_odds[np.ix_(OTHER_JOINTS, OTHER_PARTS)],
        )


@dataclass(frozen=True, slots=True, eq=False)
class BodyMarks:
    """What was learned.

    Attributes
    ----------
    views : mapping
        `ViewMarks` of each of `VIEWS`.
    provenance : mapping
        From what it was learned; plain JSON values.
    """

    views: Mapping[str, ViewMarks]
    provenance: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if tuple(self.views) != VIEWS:
            raise ValueError(f"marks are learned for {VIEWS}, got {tuple(self.views)}")

    def of_view(self, view: str) -> ViewMarks:
        """Return those of a declared view."""
        if view == "left_lateral":
            return self.views["lateral"].mirrored()
        return self.views["lateral" if view == "right_lateral" else view]


def mark_log_odds(
    marks: ViewMarks, points_m: FloatArray, joints_m: FloatArray, shares: FloatArray
) -> FloatArray:
    """Return (M, 15) log odds of names for points, against a chance spot on the body.

    Parameters
    ----------
    points_m : (M, 3) array
        Upright.
    joints_m : (15, 3) array
        As they were found without markers, in the same axes; one that is NaN tells nothing.
    shares : (M, 16) array
        Of the parts about each point; NaN where nothing of the body is there: that tells nothing.
    """
    odds = _beside_joints(marks, points_m, joints_m) + PART_WEIGHT * _on_parts(marks, shares)
    of_other = odds[:, OTHER_JOINTS]
    sure = np.log([1.0 - OTHER_SIDE, OTHER_SIDE])
    return np.asarray(np.logaddexp(sure[0] + odds, sure[1] + of_other))


def _beside_joints(marks: ViewMarks, points_m: FloatArray, joints_m: FloatArray) -> FloatArray:
    off_m = points_m[:, None] - (joints_m + marks.offsets_m)
    inverse = np.linalg.inv(marks.covariances_m2)
    squared = np.einsum("mni,nij,mnj->mn", off_m, inverse, off_m)
    peaks = 1.0 / np.sqrt(np.linalg.det(2.0 * np.pi * marks.covariances_m2))
    density = peaks * np.exp(-0.5 * squared)
    odds = np.log((1.0 - FOUND_ELSEWHERE) * density * ROOM_M3 + FOUND_ELSEWHERE)
    return np.where(np.isnan(joints_m[:, 0]), 0.0, odds)


def _on_parts(marks: ViewMarks, shares: FloatArray) -> FloatArray:
    is_on_body = ~np.isnan(shares[:, 0])
    odds = np.zeros((len(shares), len(JOINT_NAMES)))
    likely = shares[is_on_body] @ np.exp(marks.part_odds).T
    odds[is_on_body] = np.log(np.maximum(likely, LEAST_SHARE))
    return odds


def marks_to_json(marks: BodyMarks) -> dict[str, Any]:
    """Return it as plain values."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "joints": list(JOINT_NAMES),
        "parts": list(BODY_PART_NAMES),
        "views": {
            view: {name: getattr(one, name).tolist() for name in ViewMarks.__slots__}
            for view, one in marks.views.items()
        },
        "provenance": dict(marks.provenance),
    }


def marks_from_json(document: Mapping[str, Any]) -> BodyMarks:
    """Return what `marks_to_json` wrote.

    Raises
    ------
    KeyError, TypeError, ValueError
        It is no such document.
    """
    check_document(document, FORMAT, VERSION)
    named = tuple(document["joints"]), tuple(document["parts"])
    if named != (JOINT_NAMES, BODY_PART_NAMES):
        raise ValueError("other joints or parts")
    views = {
        view: ViewMarks(
            *(np.array(document["views"][view][name], float) for name in ViewMarks.__slots__)
        )
        for view in VIEWS
    }
    return BodyMarks(views, dict(document["provenance"]))
