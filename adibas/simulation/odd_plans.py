"""Scenes that limbs and joints are seldom found in: nobody, half of somebody, things, animals.

A name is ``empty``, ``person``, ``cut_left``, ``cut_right``, ``upper_body``, ``legs``, ``near``,
or one of `adibas.simulation.lone_things.KINDS`: that thing alone. Places are ours.
"""

import math
from dataclasses import dataclass, fields, replace

import numpy as np

from adibas.data.calibration import CameraCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.crowd_plans import (
    Actor,
    Box,
    CrowdPlan,
    Solid,
    figure_between,
    placed,
)
from adibas.simulation.figures import Figure, TrunkAngles
from adibas.simulation.limb_people import random_shape
from adibas.simulation.lone_things import KINDS, draw_thing
from adibas.simulation.poses import Pose
from adibas.simulation.random_poses import random_figure

N_FRAMES = 30
FURTHEST_TURN_RAD = math.radians(40.0)
CALM = 0.3
"""Share of how far trunks bend at random: who bends leaves the part of the room that is named."""
TALL_M = 1.55
"""Who is cut off is at least so tall: the same part of a child would be another."""


@dataclass(frozen=True, slots=True)
class Mover:
    """Somebody who stands and moves from one random pose to the next.

    Attributes
    ----------
    shape : BodyShape
    x_m : float
        To the image's right.
    heading_rad : float
    seed : int
    hold_s : float
        Time from one pose to the next.
    """

    shape: BodyShape
    x_m: float
    heading_rad: float
    seed: int
    hold_s: float = 0.8

    def pose(self, time_s: float) -> Pose:
        """Return the pose at a time."""
        figure = figure_between(self._figure, time_s / self.hold_s)
        return placed(figure.pose(), self.x_m, 0.0, self.heading_rad)

    def _figure(self, number: int) -> Figure:
        figure = random_figure(np.random.default_rng([self.seed, number]), "moving")
        names = (field.name for field in fields(figure.trunk))
        trunk = TrunkAngles(**{name: CALM * getattr(figure.trunk, name) for name in names})
        return replace(figure, trunk=trunk)


def _mover(rng: np.random.Generator, x_m: float, least_m: float) -> tuple[Actor, ...]:
    turn_rad = float(rng.uniform(-FURTHEST_TURN_RAD, FURTHEST_TURN_RAD))
    shape = random_shape(rng)
    while shape.stature_m < least_m:
        shape = random_shape(rng)
    return (Mover(shape, x_m, turn_rad, int(rng.integers(2**31))),)


def _nobody(_rng: np.random.Generator) -> tuple[Actor, ...]:
    return ()


def _nothing(_rng: np.random.Generator) -> tuple[Box, ...]:
    return ()


def _somebody(
    distance_m: float,
    camera_height_m: float,
    tilt_deg: float = 0.0,
    x_m: float = 0.0,
    least_m: float = TALL_M,
) -> CrowdPlan:
    return CrowdPlan(
        lambda rng: _mover(rng, x_m, least_m),
        _nothing,
        N_FRAMES,
        distance_m,
        camera_height_m,
        math.radians(tilt_deg),
    )


def _with_thing(kind: str) -> CrowdPlan:
    def things(rng: np.random.Generator) -> tuple[Solid, ...]:
        return (draw_thing(rng, kind),)

    return CrowdPlan(_nobody, _nothing, N_FRAMES, 2.4, 1.1, math.radians(5.0), things)


ODD_PLANS: dict[str, CrowdPlan] = {
    "person": _somebody(2.7, 1.1, 5.0, least_m=0.0),
    "cut_left": _somebody(2.4, 1.1, 5.0, -1.27),
    "cut_right": _somebody(2.4, 1.1, 5.0, 1.27),
    "upper_body": _somebody(1.3, 1.45),
    "legs": _somebody(1.4, 0.35),
    "near": _somebody(0.75, 1.3),
    "empty": CrowdPlan(_nobody, _nothing, N_FRAMES),
    **{kind: _with_thing(kind) for kind in KINDS},
}


def pinhole(width: int, height: int, across_deg: float) -> CameraCalibration:
    """Return an ideal camera of a size and a horizontal field of view."""
    focal_px = 0.5 * width / math.tan(0.5 * math.radians(across_deg))
    middle = Intrinsics(focal_px, focal_px, 0.5 * (width - 1), 0.5 * (height - 1))
    return CameraCalibration(width, height, middle)
