"""The tree of a person's bones, how long they are by stature, and what a sensor sees of a joint."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only
from adibas.data.joints import JOINT_NAMES, PARENT_OF, mirror_order
from adibas.files import check_document

ROOT = JOINT_NAMES.index("torso")
PARENTS: tuple[int, ...] = tuple(
    JOINT_NAMES.index(PARENT_OF[name]) if name in PARENT_OF else -1 for name in JOINT_NAMES
)
"""The joint at the other end of the bone that ends at each joint; -1 for the torso."""
ORDER: tuple[int, ...] = tuple(
    JOINT_NAMES.index(name)
    for name in (
        "torso",
        "neck",
        "head",
        *(
            f"{side}_{joint}"
            for side in ("left", "right")
            for joint in ("shoulder", "elbow", "hand", "hip", "knee", "foot")
        ),
    )
)
"""Every joint after its parent."""
MIRRORED: tuple[int, ...] = tuple(mirror_order(JOINT_NAMES))
"""The joint of the other side; the same one in the middle of the body."""
FORMAT, VERSION = "adibas-proportions", 1


@dataclass(frozen=True, slots=True, eq=False)
class Proportions:
    """What is common to people, in the order of `JOINT_NAMES`.

    Attributes
    ----------
    lengths : (15,) array
        Of the bone that ends at the joint, as a share of the stature; 0 for the torso.
    spreads : (15,) array
        Standard deviation of those lengths, relative, over people and poses.
    areas : (15,) array
        Surface that speaks for a joint in plain view, as a share of the stature squared.
    """

    lengths: FloatArray
    spreads: FloatArray
    areas: FloatArray

    def __post_init__(self) -> None:
        for name in ("lengths", "spreads", "areas"):
            check_shape(name, getattr(self, name), (len(JOINT_NAMES),))
            read_only(getattr(self, name))


def bone_lengths_m(joints_m: FloatArray) -> FloatArray:
    """Return (..., 15): length of the bone that ends at each joint; NaN where an end is not seen.

    Parameters
    ----------
    joints_m : (..., 15, 3) array
        Metres.
    """
    parents = np.array(PARENTS)
    lengths_m = np.linalg.norm(joints_m - joints_m[..., parents, :], axis=-1)
    lengths_m[..., ROOT] = np.nan
    return np.asarray(lengths_m)


def learn_proportions(
    joints_m: FloatArray, statures_m: FloatArray, weights_m2: FloatArray
) -> Proportions:
    """Return the proportions of examples.

    Parameters
    ----------
    joints_m : (T, 15, 3) array
        True joints, metres.
    statures_m : (T,) array
    weights_m2 : (T, 15) array
        Surface that spoke for each joint; 0 where it was hidden.
    """
    shares = bone_lengths_m(joints_m) / statures_m[:, None]
    shares[:, ROOT] = 0.0
    # Both sides are one: what is learned knows no better hand.
    both = np.concatenate([shares, shares[:, list(MIRRORED)]])
    areas = weights_m2 / statures_m[:, None] ** 2
    areas = np.concatenate([areas, areas[:, list(MIRRORED)]])
    seen = [column[column > 0] for column in areas.T]
    lengths = both.mean(axis=0)
    spreads = np.divide(both.std(axis=0), lengths, out=np.zeros_like(lengths), where=lengths > 0)
    return Proportions(lengths, spreads, np.array([np.median(one) for one in seen]))


def proportions_to_json(proportions: Proportions) -> dict[str, Any]:
    """Return the document of a file."""
    columns = zip(
        proportions.lengths.tolist(),
        proportions.spreads.tolist(),
        proportions.areas.tolist(),
        strict=True,
    )
    return {
        "format": FORMAT,
        "version": VERSION,
        "joints": {
            name: {"length": length, "spread": spread, "area": area}
            for name, (length, spread, area) in zip(JOINT_NAMES, columns, strict=True)
        },
    }


def proportions_from_json(document: Mapping[str, Any]) -> Proportions:
    """Return the proportions of a document.

    Raises
    ------
    ValueError
        It is no such document.
    """
    check_document(document, FORMAT, VERSION)
    rows = [document["joints"][name] for name in JOINT_NAMES]
    lengths, spreads, areas = (
        np.array([float(row[key]) for row in rows]) for key in ("length", "spread", "area")
    )
    return Proportions(lengths, spreads, areas)
