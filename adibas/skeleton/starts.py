"""From where the search for names starts: the turns of a shape that are tried."""

import math
from itertools import permutations, product

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.skeleton.model import PointModel

PLANE, SPACE = 2, 3
N_HEADINGS = 8
HEADINGS_RAD = {
    "anterior": 0.0,
    "left_lateral": math.pi / 2,
    "posterior": math.pi,
    "right_lateral": -math.pi / 2,
}
"""Turn of a patient about the vertical in the view of that name; 0 faces the camera."""
ABOUT_VIEW_RAD = tuple(math.radians(off) for off in (-45, -15, 15, 45))
N_PLANE_TURNS = 12


def log_radius(points: FloatArray) -> float:
    """Return the logarithm of the root mean square radius of centred (M, D) points."""
    return 0.5 * math.log(max(float((points**2).sum(axis=1).mean()), 1e-12))


def list_turns(model: PointModel, view: str) -> tuple[FloatArray, IntArray]:
    """Return (R, D, D) rotations, prototype from points, and the tree's sectors of each (R,)."""
    n_sectors = model.tree.directions.shape[2]
    if not model.is_upright:
        turns = _plane_turns() if model.n_dimensions == PLANE else _cube_turns()
        return turns, np.zeros(len(turns), np.int64)
    if model.n_dimensions == PLANE:
        return np.eye(PLANE)[None], np.zeros(1, np.int64)
    headings = np.arange(N_HEADINGS) * 2 * math.pi / N_HEADINGS
    if view:
        headings = HEADINGS_RAD[view] + np.array(ABOUT_VIEW_RAD)
    shifts = np.round(headings / (2 * math.pi) * n_sectors).astype(np.int64) % n_sectors
    return np.stack([turn_back(heading) for heading in headings]), shifts


def turn_back(heading_rad: float) -> FloatArray:
    """Return the (3, 3) rotation that takes a patient of that heading to facing the camera."""
    cos, sin = math.cos(heading_rad), math.sin(heading_rad)
    return np.array([[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]])


def heading_of_turn(turn: FloatArray) -> float:
    """Return the heading, radians, of a patient whom a (3, 3) rotation takes to facing us."""
    return math.atan2(turn[2, 0] - turn[0, 2], turn[0, 0] + turn[2, 2])


def heading_cost(turn: FloatArray, view: str, kappa: float) -> float:
    """Return minus the log probability of a heading in a declared view, up to a constant."""
    if not view or len(turn) == PLANE:
        return 0.0
    return kappa * (1.0 - math.cos(heading_of_turn(turn) - HEADINGS_RAD[view]))


def _plane_turns() -> FloatArray:
    angles = np.arange(N_PLANE_TURNS) * 2 * math.pi / N_PLANE_TURNS
    cos, sin = np.cos(angles), np.sin(angles)
    return np.stack([np.stack([cos, -sin], -1), np.stack([sin, cos], -1)], axis=1)


def _cube_turns() -> FloatArray:
    """Return the 24 rotations of a cube."""
    turns = []
    for order in permutations(range(SPACE)):
        for signs in product((-1.0, 1.0), repeat=SPACE):
            turn = np.eye(SPACE)[list(order)] * np.array(signs)[:, None]
            if np.linalg.det(turn) > 0:
                turns.append(turn)
    return np.stack(turns)
