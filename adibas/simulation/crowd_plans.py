"""Who does what in the crowded scenes, and what stands about.

The places and times are ours; children's statures are near the median of their age (WHO growth
reference 2007, rounded).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from adibas.arrays import FloatArray, Int32Array
from adibas.simulation.body_shape import BodyShape, Sex
from adibas.simulation.figures import Figure
from adibas.simulation.poses import ArmAngles, LegAngles, Pose
from adibas.simulation.random_poses import random_figure
from adibas.simulation.rotations import about

CHILD_STATURES_M = {6: 1.16, 7: 1.22, 8: 1.28, 9: 1.33, 10: 1.38, 11: 1.44, 12: 1.50}
SEAT_PER_STATURE = 0.25
STEPS_HZ = 0.9
"""Whole strides a second, of two steps."""

Box = tuple[FloatArray, FloatArray]
Solid = tuple[FloatArray, Int32Array]
"""(V, 3) vertices in world axes and (T, 3) triangles."""


class Actor(Protocol):
    """Somebody who moves."""

    @property
    def shape(self) -> BodyShape:
        """Return who it is."""

    def pose(self, time_s: float) -> Pose:
        """Return the pose at a time, in world axes."""


@dataclass(frozen=True, slots=True)
class Sitter:
    """Somebody who sits and changes from one random pose to the next.

    Attributes
    ----------
    shape : BodyShape
    x_m, z_m : float
        Where.
    heading_rad : float
    seed : int
    hold_s : float
        Time from one pose to the next.
    """

    shape: BodyShape
    x_m: float
    z_m: float
    heading_rad: float
    seed: int
    hold_s: float = 0.9

    def pose(self, time_s: float) -> Pose:
        """Return the pose at a time."""
        figure = figure_between(self._figure, time_s / self.hold_s)
        return placed(figure.pose(), self.x_m, self.z_m, self.heading_rad)

    def _figure(self, number: int) -> Figure:
        legs = random_figure(np.random.default_rng([self.seed, 0]), "seated")
        moved = random_figure(np.random.default_rng([self.seed, 1 + number]), "seated")
        trunk = replace(moved.trunk, pelvis=0.3 * moved.trunk.pelvis, chest=0.5 * moved.trunk.chest)
        return replace(moved, left_leg=legs.left_leg, right_leg=legs.right_leg, trunk=trunk)


@dataclass(frozen=True, slots=True)
class Walker:
    """Somebody who walks in a straight line.

    Attributes
    ----------
    shape : BodyShape
    start_m, end_m : (x, z)
        From where to where.
    begin_s, duration_s : float
        Before and after, the walker stands at either end.
    phase : float
        Of the first step, 0 to 1.
    """

    shape: BodyShape
    start_m: tuple[float, float]
    end_m: tuple[float, float]
    begin_s: float
    duration_s: float
    phase: float = 0.0

    def pose(self, time_s: float) -> Pose:
        """Return the pose at a time."""
        share = min(max((time_s - self.begin_s) / self.duration_s, 0.0), 1.0)
        x_m, z_m = (a + share * (b - a) for a, b in zip(self.start_m, self.end_m, strict=True))
        swing = 0.0
        if 0.0 < share < 1.0:
            swing = math.sin(2 * math.pi * (STEPS_HZ * time_s + self.phase))
        to_x, to_z = (b - a for a, b in zip(self.start_m, self.end_m, strict=True))
        # A body with heading 0 walks towards the sensor, that is to smaller z.
        heading_rad = math.atan2(-to_x, -to_z)
        return placed(_stride(swing).pose(), x_m, z_m, heading_rad)


def _stride(swing: float) -> Figure:
    arm, leg = ArmAngles(), LegAngles()

    def swung_arm(forward: float) -> ArmAngles:
        return replace(
            arm, elevation=arm.elevation + 0.4 * abs(forward), plane=math.pi / 2 * np.sign(forward)
        )

    def swung_leg(forward: float) -> LegAngles:
        knee = leg.knee + 0.5 * max(0.0, -forward) + 0.1
        return replace(leg, flexion=leg.flexion + 0.4 * forward, knee=knee)

    return Figure(swung_arm(-swing), swung_arm(swing), swung_leg(swing), swung_leg(-swing))


def figure_between(figure: Callable[[int], Figure], at: float) -> Figure:
    """Return the figure at 2.3, say: on the way, begun and ended slowly, from figure 2 to 3."""
    number, part = divmod(at, 1.0)
    smooth = 0.5 - 0.5 * math.cos(math.pi * part)
    before, after = (figure(int(number) + k).vector() for k in (0, 1))
    return Figure.from_vector(before + smooth * (after - before))


def placed(pose: Pose, x_m: float, z_m: float, heading_rad: float) -> Pose:
    """Return the pose at a place: the offset of a pose is turned with it."""
    down = np.array([0.0, 1.0, 0.0])
    offset = about(down, heading_rad).T @ np.array([x_m, 0.0, z_m])
    return replace(pose, offset_m=offset[[0, 2]].copy(), heading_rad=heading_rad)


def _no_solids(_rng: np.random.Generator) -> tuple[Solid, ...]:
    return ()


@dataclass(frozen=True, slots=True)
class CrowdPlan:
    """One scene.

    Attributes
    ----------
    cast, furniture : functions
        Draw who is there, and boxes (lowest and highest corner, world axes, metres).
    things : function
        Draws what else stands about, of any shape.
    n_frames : int
    distance_m, camera_height_m, tilt_rad : float
        Of the sensor from the origin, over the floor, and its look downwards.
    """

    cast: Callable[[np.random.Generator], tuple[Actor, ...]]
    furniture: Callable[[np.random.Generator], tuple[Box, ...]]
    n_frames: int = 90
    distance_m: float = 2.3
    camera_height_m: float = 1.3
    tilt_rad: float = math.radians(12.0)
    things: Callable[[np.random.Generator], tuple[Solid, ...]] = _no_solids


def _child(rng: np.random.Generator) -> BodyShape:
    age = int(rng.integers(6, 13))
    stature_m = CHILD_STATURES_M[age] * float(rng.normal(1.0, 0.03))
    sex: Sex = "female" if rng.random() < 0.5 else "male"  # noqa: PLR2004
    return BodyShape(sex, age, stature_m, float(rng.uniform(15.0, 18.5)) * stature_m**2)


def _adult(rng: np.random.Generator) -> BodyShape:
    sex: Sex = "female" if rng.random() < 0.5 else "male"  # noqa: PLR2004
    stature_m = float(rng.uniform(1.58, 1.86))
    return BodyShape(sex, 35, stature_m, float(rng.uniform(20.0, 27.0)) * stature_m**2)


def _sitter(rng: np.random.Generator) -> Sitter:
    turn_rad = float(rng.uniform(-0.5, 0.5))
    return Sitter(_child(rng), 0.0, 0.0, turn_rad, int(rng.integers(2**31)))


def _box_at(x_m: float, z_m: float, size_m: tuple[float, float, float], base_m: float) -> Box:
    """Return a box of width, height, depth whose lower side is `base_m` over the floor."""
    width, height, depth = size_m
    low = np.array([x_m - width / 2, -base_m - height, z_m - depth / 2])
    return low, low + np.array([width, height, depth])


def _chair(x_m: float, z_m: float, seat_m: float) -> tuple[Box, ...]:
    legs = tuple(
        _box_at(x_m + dx, z_m + dz, (0.03, seat_m - 0.03, 0.03), 0.0)
        for dx in (-0.16, 0.16)
        for dz in (-0.16, 0.16)
    )
    seat = _box_at(x_m, z_m, (0.36, 0.03, 0.36), seat_m - 0.03)
    back = _box_at(x_m, z_m + 0.19, (0.34, 0.16, 0.02), seat_m + 0.2)
    return (*legs, seat, back)


def _table(z_m: float, height_m: float) -> tuple[Box, ...]:
    top = _box_at(0.0, z_m, (1.1, 0.03, 0.5), height_m - 0.03)
    legs = tuple(
        _box_at(dx, z_m + dz, (0.04, height_m - 0.03, 0.04), 0.0)
        for dx in (-0.5, 0.5)
        for dz in (-0.2, 0.2)
    )
    return (top, *legs)


def _nothing(_rng: np.random.Generator) -> tuple[Box, ...]:
    return ()


def _school_desk(_rng: np.random.Generator) -> tuple[Box, ...]:
    return (*_table(-0.52, 0.58), *_chair(0.0, 0.28, 0.33))


def _cupboards(_rng: np.random.Generator) -> tuple[Box, ...]:
    return (
        _box_at(-0.15, -0.75, (0.5, 0.62, 0.3), 0.0),
        _box_at(0.95, 0.5, (0.5, 1.3, 0.4), 0.0),
        *_chair(-0.9, 0.3, 0.45),
    )


def _one_sitter(rng: np.random.Generator) -> tuple[Actor, ...]:
    return (_sitter(rng),)


def _sitter_and_walker(rng: np.random.Generator) -> tuple[Actor, ...]:
    way = 1.0 if rng.random() < 0.5 else -1.0  # noqa: PLR2004
    z_m = -1.05
    return (
        _sitter(rng),
        Walker(_adult(rng), (-1.5 * way, z_m), (1.5 * way, z_m), 0.3, 2.6, float(rng.random())),
    )


def _mover(rng: np.random.Generator) -> tuple[Actor, ...]:
    shape = _child(rng)
    return (Walker(shape, (-0.9, 0.25), (0.7, 0.1), 0.3, 2.4, float(rng.random())),)


def _two_walkers(rng: np.random.Generator) -> tuple[Actor, ...]:
    first, second = _child(rng), _child(rng)
    return (
        Walker(first, (-1.0, -0.2), (1.0, -0.2), 0.3, 2.4, float(rng.random())),
        Walker(second, (1.0, 0.45), (-1.0, 0.45), 0.3, 2.4, float(rng.random())),
    )


PLANS: dict[str, CrowdPlan] = {
    "seated_child": CrowdPlan(_one_sitter, _school_desk),
    "furniture_before": CrowdPlan(_mover, _cupboards),
    "passer_by": CrowdPlan(_sitter_and_walker, _school_desk, distance_m=2.6),
    "two_children_cross": CrowdPlan(_two_walkers, _nothing, distance_m=2.4),
}
"""The scenes by name."""
