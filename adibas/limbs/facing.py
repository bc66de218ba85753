"""Front or back, by the shape of the body: toes, face, seat, bent arms and legs.

A forest that was trained on people from the front takes a back for a front and exchanges the
sides; its labels cannot tell. The shape can. What tells how much was learned from simulated people
seen from both sides, as weights of quantities of the shape (logistic regression).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only
from adibas.files import check_document
from adibas.limbs.facing_quantities import QUANTITIES, describe_shape
from adibas.limbs.proposals import PartPoints

FORMAT, VERSION = "adibas-facing", 1
FARTHEST = 3.0
"""Standard deviations from the mean that count: what lies farther is mostly a wrong part."""


@dataclass(frozen=True, slots=True, eq=False)
class Facing:
    """What was learned.

    Attributes
    ----------
    middles, spreads, weights : (Q,) arrays
        Of each of `QUANTITIES`: mean and standard deviation where it was learned, and weight.
    bias : float
    provenance : mapping
        From what it was learned; plain JSON values.
    """

    middles: FloatArray
    spreads: FloatArray
    weights: FloatArray
    bias: float
    provenance: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("middles", "spreads", "weights"):
            check_shape(name, getattr(self, name), (len(QUANTITIES),))
            read_only(getattr(self, name))

    def log_odds(self, quantities: FloatArray) -> FloatArray:
        """Return log odds of front against back of (..., Q) quantities; NaN tells nothing."""
        scaled = np.clip((quantities - self.middles) / self.spreads, -FARTHEST, FARTHEST)
        return np.asarray(np.nan_to_num(scaled) @ self.weights + self.bias)


@dataclass(frozen=True, slots=True)
class FacingParams:
    """How much one frame counts.

    Attributes
    ----------
    share : float
        Of the log odds, since frames of one recording show the same person in the same clothes and
        are no new witnesses: 0.15, a seventh.
    most : float
        Log odds that one frame tells at most: 0.5.
    """

    share: float = 0.15
    most: float = 0.5


def front_evidence(points: PartPoints, facing: Facing, params: FacingParams | None = None) -> float:
    """Return log odds of front against back in one frame; about 0 where nothing tells."""
    params = params or FacingParams()
    odds = params.share * float(facing.log_odds(describe_shape(points)))
    return float(np.clip(odds, -params.most, params.most))


def facing_to_json(facing: Facing) -> dict[str, Any]:
    """Return it as plain values."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "quantities": list(QUANTITIES),
        "middles": facing.middles.tolist(),
        "spreads": facing.spreads.tolist(),
        "weights": facing.weights.tolist(),
        "bias": facing.bias,
        "provenance": dict(facing.provenance),
    }


def facing_from_json(document: Mapping[str, Any]) -> Facing:
    """Return what `facing_to_json` wrote.

    Raises
    ------
    KeyError, TypeError, ValueError
        It is no such document.
    """
    check_document(document, FORMAT, VERSION)
    if tuple(document["quantities"]) != QUANTITIES:
        raise ValueError("other quantities")
    middles, spreads, weights = (
        np.array(document[name], float) for name in ("middles", "spreads", "weights")
    )
    return Facing(middles, spreads, weights, float(document["bias"]), dict(document["provenance"]))
