"""How far behind and beside a mode of the surface a joint lies, and how that is learned."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from adibas.arrays import FloatArray
from adibas.files import check_document
from adibas.limbs.joint_places import JointPlace, without_side

FORMAT, VERSION = "adibas-joint-offsets", 1
N_ROUNDS = 3
"""Fits, each without what was far off in the one before."""
OUTLIER = 3.0
"""Times the median distance from which on an example is far off."""


@dataclass(frozen=True, slots=True)
class JointOffset:
    """What was learned of one kind of joint.

    Attributes
    ----------
    bare_push_m : float
        Way back along the viewing ray where not all neighbours are seen.
    push_m : float
        The same beside the shares below.
    shares : tuple of float
        Of the way from the mode to the middle of each of `JointPlace.neighbors`.
    """

    bare_push_m: float
    push_m: float = 0.0
    shares: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class JointOffsets:
    """What was learned of all joints, by `JointPlace.kind`, and from what."""

    of_kind: Mapping[str, JointOffset]
    provenance: Mapping[str, object] = field(default_factory=dict)

    def joints_m(
        self, place: JointPlace, modes_m: FloatArray, middles_m: Mapping[str, FloatArray]
    ) -> FloatArray:
        """Return (K, 3) joints behind the (K, 3) modes of the surface, metres.

        Parameters
        ----------
        middles_m : mapping
            Middle of each part that is seen.
        """
        learned = self.of_kind[place.kind]
        lengths_m = np.sqrt(np.einsum("ki,ki->k", modes_m, modes_m))[:, None]
        if not all(name in middles_m for name in place.neighbors):
            return np.asarray(modes_m * (1.0 + learned.bare_push_m / lengths_m))
        joints_m = modes_m * (1.0 + learned.push_m / lengths_m - sum(learned.shares))
        for share, name in zip(learned.shares, place.neighbors, strict=True):
            joints_m += share * middles_m[name]
        return np.asarray(joints_m)


@dataclass(frozen=True, slots=True, eq=False)
class OffsetExample:
    """One joint whose true place is known: (3,) arrays, metres, and the middles of parts."""

    place: JointPlace
    mode_m: FloatArray
    joint_m: FloatArray
    middles_m: Mapping[str, FloatArray]


def learn_offset(examples: Sequence[OffsetExample]) -> JointOffset:
    """Return what fits examples of one kind of joint best, in the least squares."""
    ways = [_ways(example) for example in examples]
    gaps = [example.joint_m - example.mode_m for example in examples]
    bare = _fitted([way[:, :1] for way in ways], gaps)
    whole = [k for k, way in enumerate(ways) if way.shape[1] > 1]
    if not whole:
        return JointOffset(float(bare[0]), float(bare[0]))
    full = _fitted([ways[k] for k in whole], [gaps[k] for k in whole])
    return JointOffset(float(bare[0]), float(full[0]), tuple(full[1:].tolist()))


def _ways(example: OffsetExample) -> FloatArray:
    """Return (3, 1 + n): the ray, and the ways to the neighbours; (3, 1) if one is not seen."""
    mode_m, middles_m = example.mode_m, example.middles_m
    columns = [mode_m / np.linalg.norm(mode_m)]
    if all(name in middles_m for name in example.place.neighbors):
        columns += [middles_m[name] - mode_m for name in example.place.neighbors]
    return np.stack(columns, axis=1)


def _fitted(ways: Sequence[FloatArray], gaps: Sequence[FloatArray]) -> FloatArray:
    matrix, wanted = np.stack(ways), np.stack(gaps)
    kept = np.ones(len(matrix), np.bool_)
    factors: FloatArray = np.zeros(matrix.shape[2])
    for _round in range(N_ROUNDS):
        solution = np.linalg.lstsq(
            matrix[kept].reshape(-1, matrix.shape[2]), wanted[kept].ravel(), rcond=None
        )
        factors = np.asarray(solution[0], float)
        far_m = np.linalg.norm(wanted - matrix @ factors, axis=1)
        kept = far_m <= OUTLIER * np.median(far_m) + 1e-9
    return factors


def offsets_to_json(offsets: JointOffsets) -> dict[str, Any]:
    """Return the document of a file of offsets."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "joints": {
            kind: {
                "bare_push_m": one.bare_push_m,
                "push_m": one.push_m,
                "shares": list(one.shares),
            }
            for kind, one in offsets.of_kind.items()
        },
        "provenance": dict(offsets.provenance),
    }


def offsets_from_json(document: Mapping[str, Any]) -> JointOffsets:
    """Return the offsets of a document.

    Raises
    ------
    ValueError
        It is no such document, or lacks a joint.
    """
    check_document(document, FORMAT, VERSION)
    return JointOffsets(
        {
            without_side(str(kind)): JointOffset(
                float(one["bare_push_m"]),
                float(one["push_m"]),
                tuple(float(share) for share in one["shares"]),
            )
            for kind, one in document["joints"].items()
        },
        dict(document.get("provenance", {})),
    )
