"""Poses drawn at random within what joints allow: what models of the body are trained on.

Source of the limits: American Academy of Orthopaedic Surgeons, Joint motion: method of measuring
and recording (1965), rounded to 5 degrees; the shares of each kind are ours.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Literal, TypeAlias

import numpy as np

from adibas.simulation.figures import Figure, TrunkAngles
from adibas.simulation.poses import ArmAngles, LegAngles

Kind: TypeAlias = Literal["standing", "moving", "seated"]
KINDS: tuple[Kind, ...] = ("standing", "moving", "seated")

DrawAngle: TypeAlias = Callable[[float, float], float]
"""Takes the least and the greatest angle in degrees; returns one between them in radians."""


def random_figure(rng: np.random.Generator, kind: Kind) -> Figure:
    """Return a figure of a kind.

    Parameters
    ----------
    rng : Generator
        Its next numbers are used.
    kind : str
        ``standing``: as a patient stands who is measured, each limb a little different;
        ``moving``: anything that somebody on his feet does with arms, trunk and knees;
        ``seated``: on a chair, arms anywhere before the body.
    """
    draw = angle_drawer(rng)
    if kind == "standing":
        return _standing(draw)
    trunk = _trunk(draw, widest=1.0 if kind == "moving" else 0.5)
    arms = [_arm(rng, draw) for _ in range(2)]
    legs = [_leg(draw) if kind == "moving" else _seated_leg(draw) for _ in range(2)]
    if kind == "moving":
        legs = [_balanced(leg, trunk) for leg in legs]
    return Figure(arms[0], arms[1], legs[0], legs[1], trunk)


def angle_drawer(rng: np.random.Generator) -> DrawAngle:
    """Return what draws angles evenly."""

    def draw(low_deg: float, high_deg: float) -> float:
        return math.radians(float(rng.uniform(low_deg, high_deg)))

    return draw


def _standing(draw: DrawAngle) -> Figure:
    def arm() -> ArmAngles:
        return ArmAngles(
            elevation=draw(3, 35),
            plane=draw(-10, 60),
            rotation=draw(-10, 45),
            elbow=draw(2, 30),
            pronation=draw(-20, 60),
        )

    def leg() -> LegAngles:
        return LegAngles(draw(-3, 8), draw(0, 8), draw(0, 12), draw(-5, 20))

    trunk = TrunkAngles(
        pelvis=draw(-5, 8),
        chest=draw(-5, 12),
        head=draw(-15, 25),
        side_bend=draw(-8, 8),
        twist=draw(-8, 8),
        look=draw(-15, 15),
        tilt=draw(-10, 10),
    )
    return Figure(arm(), arm(), leg(), leg(), trunk)


def _trunk(draw: DrawAngle, widest: float) -> TrunkAngles:
    return TrunkAngles(
        pelvis=draw(-10, 50 * widest),
        chest=draw(-15, 80 * widest),
        head=draw(-40, 60),
        side_bend=draw(-30, 30) * widest,
        twist=draw(-40, 40) * widest,
        look=draw(-60, 60),
        tilt=draw(-30, 30),
    )


def _arm(rng: np.random.Generator, draw: DrawAngle) -> ArmAngles:
    """Hanging or raised: a limb drawn evenly over all it can do would hang in few poses."""
    is_hanging = rng.random() < 0.4  # noqa: PLR2004  (a share, ours)
    elevation = draw(3, 40) if is_hanging else draw(30, 165)
    return ArmAngles(
        elevation=elevation,
        plane=draw(-15, 110),
        rotation=draw(-60, 70),
        elbow=draw(0, 140),
        pronation=draw(-80, 80),
        wrist=draw(-60, 60),
        curl=draw(0, 60),
    )


def _leg(draw: DrawAngle) -> LegAngles:
    flexion = draw(-15, 60)
    knee = max(flexion, 0.0) * 0.7 + draw(0, 50)
    return LegAngles(flexion, draw(-3, 25), knee, draw(-10, 30), draw(0, 20))


def _seated_leg(draw: DrawAngle) -> LegAngles:
    flexion = draw(75, 100)
    return LegAngles(flexion, draw(-2, 20), flexion + draw(-25, 15), draw(-10, 25))


def _balanced(leg: LegAngles, trunk: TrunkAngles) -> LegAngles:
    """Shift the hips back where the trunk bends forward, as nobody would stand otherwise."""
    return replace(leg, flexion=leg.flexion - 0.1 * (trunk.pelvis + trunk.chest))
