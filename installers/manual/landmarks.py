"""Where the landmarks of a protocol lie in a view, and the numbers of its figure and table."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joints import JOINT_NAMES
from adibas.data.protocols import Landmark, Protocol
from adibas.measures.protocol_store import find_protocol
from adibas.resources import resource_path
from adibas.simulation.body import PosedBody, load_body_model
from adibas.simulation.patient import SHAPES
from adibas.simulation.poses import standing

PROTOCOLS = ("sapo-1", "upper-quadrant", "trunk-symmetry", "joints-15")
MODEL = SHAPES[5]
"""Who stands in the figures."""

RIGHTWARDS = {
    "anterior": np.array([1.0, 0.0, 0.0]),
    "posterior": np.array([-1.0, 0.0, 0.0]),
    "right_lateral": np.array([0.0, 0.0, -1.0]),
    "left_lateral": np.array([0.0, 0.0, 1.0]),
}
"""What the figure's right is on the body: x to the patient's left, y down, z to the back."""

THORACIC = ("t3", "t4", "t5", "t7", "t9", "t10", "t11")
EYE_CORNER_M = 0.02
"""From the middle of the eye outwards; the model has no such landmark."""


@dataclass(frozen=True, slots=True)
class Numbered:
    """A landmark under its number in one view, in metres on the figure: right, and down."""

    number: int
    landmark: Landmark
    right_m: float
    down_m: float


@cache
def standing_model() -> PosedBody:
    """Return the person of the figures."""
    return load_body_model().shaped(MODEL).posed(standing())


def figure_views(protocol: Protocol) -> tuple[str, ...]:
    """Return the views that a protocol's figures show; the 15 joints are the same in all."""
    return protocol.views[:1] if protocol.protocol_id == "joints-15" else protocol.views


def numbered(protocol_id: str, view: str) -> list[Numbered]:
    """Return the landmarks of a view by their numbers: those of the original where it has some."""
    protocol, given = find_protocol(protocol_id), _given_numbers(protocol_id)
    shown = [one for one in protocol.landmarks if view in one.views]
    found = []
    for order, landmark in enumerate(shown, 1):
        place_m = place_of(standing_model(), landmark.landmark_id)
        number = given.get(landmark.landmark_id, {}).get(view, order)
        right_m = float(place_m @ RIGHTWARDS[view])
        found.append(Numbered(number, landmark, right_m, float(place_m[1])))
    return sorted(found, key=lambda one: one.number)


@cache
def _given_numbers(protocol_id: str) -> Mapping[str, Mapping[str, int]]:
    file = json.loads(resource_path("protocols", f"{protocol_id}.json").read_text("utf-8"))
    return {one["id"]: one["number"] for one in file["landmarks"] if "number" in one}


def place_of(body: PosedBody, landmark_id: str) -> FloatArray:
    """Return where a landmark of the shipped protocols lies, metres in body axes."""
    if landmark_id in body.landmarks:
        return body.landmarks[landmark_id]
    if landmark_id in JOINT_NAMES:
        return np.asarray(body.joints_m[JOINT_NAMES.index(landmark_id)])
    if landmark_id == "thoracic_apex":  # the most posterior one, as the protocol defines it
        return max((body.landmarks[name] for name in THORACIC), key=lambda place: float(place[2]))
    side = {"left_canthus": 1.0, "right_canthus": -1.0}[landmark_id]
    return _eye(body, side) + np.array([side * EYE_CORNER_M, 0.0, 0.0])


def _eye(body: PosedBody, side: float) -> FloatArray:
    skeleton = body.body.skeleton
    name = "eye.L" if side > 0 else "eye.R"
    turn = body.bone_turns[skeleton.names.index(name)]
    return np.asarray(turn[:, :3] @ skeleton.head(name) + turn[:, 3])
