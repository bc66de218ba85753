"""Furniture and things around simulated people, some of which end up in the mask of the person."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, Int32Array
from adibas.data.joints import JOINT_NAMES
from adibas.simulation.body import PosedBody
from adibas.simulation.poses import DOWN
from adibas.simulation.room import chair_mesh
from adibas.simulation.rotations import about

CLUTTER_SHARE = 0.4
"""Of images with things; of people who sit, `SEAT_SHARE` sit on a chair."""
SEAT_SHARE = 0.75
IN_MASK_SHARE = 0.6
_FACES = np.array(
    [
        *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)),
        *((2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
    ],
    np.int32,
)


@dataclass(frozen=True, slots=True, eq=False)
class Thing:
    """A thing in world axes.

    Attributes
    ----------
    vertices_m : (V, 3) array
    triangles : (T, 3) int32 array
        Seen from both sides.
    infrared : float
        Reflectance.
    is_in_mask : bool
        Whether whoever cut out the person took it for a part.
    """

    vertices_m: FloatArray
    triangles: Int32Array
    infrared: float
    is_in_mask: bool


def random_things(rng: np.random.Generator, posed: PosedBody, kind: str) -> tuple[Thing, ...]:
    """Return what stands about a person; `kind` is that of the pose."""
    meshes = []
    if kind == "seated" and rng.random() < SEAT_SHARE:
        meshes.append(_seat(rng, posed))
    if rng.random() < CLUTTER_SHARE:
        plans = tuple(_PLANS)
        chosen = rng.integers(len(plans), size=int(rng.integers(1, 3)))
        meshes.extend(plans[number](rng, posed) for number in chosen)
    is_in_mask = bool(rng.random() < IN_MASK_SHARE)
    return tuple(
        Thing(vertices, triangles, float(rng.uniform(0.1, 0.7)), is_in_mask)
        for vertices, triangles in meshes
    )


_Solid = tuple[FloatArray, Int32Array]


def _box(low: FloatArray, high: FloatArray) -> _Solid:
    corners = np.array(
        [[(low, high)[(k >> a) & 1][a] for a in range(3)] for k in range(8)], dtype=float
    )
    return corners, _FACES


def _placed(solid: _Solid, turn_rad: float, at_m: FloatArray) -> _Solid:
    return solid[0] @ about(DOWN, turn_rad).T + at_m, solid[1]


def _joined(solids: list[_Solid]) -> _Solid:
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in solids)])
    triangles = [faces + start for (_, faces), start in zip(solids, starts, strict=False)]
    return (
        np.concatenate([vertices for vertices, _ in solids]),
        np.concatenate(triangles).astype(np.int32),
    )


def _joint(posed: PosedBody, name: str) -> FloatArray:
    position_m: FloatArray = posed.joints_m[JOINT_NAMES.index(name)]
    return position_m


def _hips(posed: PosedBody) -> FloatArray:
    return 0.5 * (_joint(posed, "left_hip") + _joint(posed, "right_hip"))


def _seat(rng: np.random.Generator, posed: PosedBody) -> _Solid:
    """Return a chair or a stool under somebody who sits: its seat just below the thighs."""
    hips = _hips(posed)
    vertices, triangles = chair_mesh(0.0, 0.0)
    if rng.random() < 0.3:  # noqa: PLR2004  (a share, ours)
        half = rng.uniform(0.15, 0.25)
        vertices, triangles = _box(np.array([-half, -0.43, -half]), np.array([half, 0.0, half]))
    top_m = -hips[1] - rng.uniform(0.08, 0.13)
    scale = np.array([rng.uniform(0.85, 1.2), max(top_m, 0.1) / 0.47, rng.uniform(0.85, 1.2)])
    at = np.array([hips[0], 0.0, hips[2]])
    return _placed((vertices * scale, triangles), posed.pose.heading_rad, at)


def _table(rng: np.random.Generator, posed: PosedBody) -> _Solid:
    """Return a table before the person."""
    top_m = rng.uniform(0.5, 0.85)
    wide, deep = rng.uniform(0.4, 0.8), rng.uniform(0.2, 0.4)
    solids = [_box(np.array([-wide, -top_m, -deep]), np.array([wide, -top_m + 0.03, deep]))]
    for x in (-wide, wide - 0.05):
        for z in (-deep, deep - 0.05):
            low, high = np.array([x, -top_m + 0.03, z]), np.array([x + 0.05, 0.0, z + 0.05])
            solids.append(_box(low, high))
    heading = posed.pose.heading_rad + rng.normal(scale=0.2)
    ahead = about(DOWN, heading) @ np.array([0.0, 0.0, -(deep + rng.uniform(0.15, 0.5))])
    hips = _hips(posed)
    return _placed(_joined(solids), heading, np.array([hips[0], 0.0, hips[2]]) + ahead)


def _chair(rng: np.random.Generator, posed: PosedBody) -> _Solid:
    """Return an empty chair beside or behind the person."""
    angle, reach = rng.uniform(-math.pi, math.pi), rng.uniform(0.35, 0.6)
    hips = _hips(posed)
    at = np.array([hips[0] + reach * math.sin(angle), 0.0, hips[2] + reach * math.cos(angle)])
    return _placed(chair_mesh(0.0, 0.0), rng.uniform(-math.pi, math.pi), at)


def _held(rng: np.random.Generator, posed: PosedBody) -> _Solid:
    """Return a thing in a hand: a ball, a bag, a stick."""
    side = "left" if rng.random() < 0.5 else "right"  # noqa: PLR2004  (half and half)
    half = rng.uniform((0.015, 0.03, 0.015), (0.15, 0.35, 0.15))
    return _placed(_box(-half, half), rng.uniform(-math.pi, math.pi), _joint(posed, f"{side}_hand"))


def _box_beside(rng: np.random.Generator, posed: PosedBody) -> _Solid:
    """Return a cupboard, a bed's end, a plant's pot: any box that touches the person."""
    half = rng.uniform((0.08, 0.1, 0.08), (0.45, 0.7, 0.3))
    angle = rng.uniform(-math.pi, math.pi)
    hips = _hips(posed)
    reach = 0.15 + half[0] + rng.uniform(0.0, 0.25)
    at = np.array(
        [hips[0] + reach * math.sin(angle), -half[1], hips[2] + abs(reach * math.cos(angle))]
    )
    return _placed(_box(-half, half), rng.uniform(-math.pi, math.pi), at)


def _floor(rng: np.random.Generator, posed: PosedBody) -> _Solid:
    """Return the floor about the feet, as masks often have it."""
    half = rng.uniform((0.15, 0.001, 0.1), (0.5, 0.002, 0.35))
    feet = 0.5 * (_joint(posed, "left_foot") + _joint(posed, "right_foot"))
    return _placed(_box(-half, half), rng.uniform(-0.5, 0.5), np.array([feet[0], 0.0, feet[2]]))


def _wall(rng: np.random.Generator, posed: PosedBody) -> _Solid:
    """Return a piece of the wall behind, or of a curtain beside."""
    half = rng.uniform((0.1, 0.2, 0.01), (0.4, 0.7, 0.03))
    hips = _hips(posed)
    at = hips + np.array([rng.normal(scale=0.3), rng.uniform(-0.7, 0.4), rng.uniform(0.12, 0.35)])
    return _placed(_box(-half, half), rng.normal(scale=0.3), at)


_PLANS: tuple[Callable[[np.random.Generator, PosedBody], _Solid], ...] = (
    _table,
    _chair,
    _chair,
    _held,
    _box_beside,
    _box_beside,
    _floor,
    _wall,
)
