"""Poses of simulated people by kind: what names of joints are learned from.

Beside the kinds of `adibas.simulation.random_poses`: seated with the arms towards a table, and
active: anything that somebody does who climbs, throws, crouches or jumps. The ranges are ours.
"""

import numpy as np

from adibas.simulation.figures import Figure, TrunkAngles
from adibas.simulation.gestures import gesture_names, perform
from adibas.simulation.poses import ArmAngles, LegAngles, Pose
from adibas.simulation.random_poses import DrawAngle, Kind, angle_drawer, random_figure

LOW_ARM_SHARE, HIGH_ARM_SHARE = 0.35, 0.25
STRAIGHT_LEG_SHARE = 0.5
UPRIGHT = 0.4
"""How far an upright trunk moves of what a bent one does."""


def draw_pose(rng: np.random.Generator, kind: str) -> Pose:
    """Return a pose of a kind: standing, moving, seated, gesture, table or active."""
    if kind == "gesture":
        gesture = perform(str(rng.choice(gesture_names())), int(rng.integers(2**31)))
        return gesture.pose(float(rng.uniform(0.0, gesture.duration_s)))
    if kind in ("table", "active"):
        draw = angle_drawer(rng)
        return (_at_table(draw) if kind == "table" else _active(draw, rng)).pose()
    of_kind: Kind = "standing" if kind == "standing" else "moving"
    return random_figure(rng, "seated" if kind == "seated" else of_kind).pose()


def _at_table(draw: DrawAngle) -> Figure:
    trunk = TrunkAngles(
        pelvis=draw(-15, 25),
        chest=draw(-15, 40),
        head=draw(-20, 60),
        side_bend=draw(-12, 12),
        twist=draw(-20, 20),
        look=draw(-40, 40),
        tilt=draw(-20, 20),
    )
    arms = [
        ArmAngles(
            elevation=draw(15, 75),
            plane=draw(40, 105),
            rotation=draw(-10, 70),
            elbow=draw(40, 130),
            pronation=draw(-40, 80),
            wrist=draw(-30, 30),
            curl=draw(0, 60),
        )
        for _ in range(2)
    ]
    legs = [LegAngles(draw(70, 100), draw(-5, 20), draw(50, 125), draw(-10, 25)) for _ in range(2)]
    return Figure(arms[0], arms[1], legs[0], legs[1], trunk)


def _active(draw: DrawAngle, rng: np.random.Generator) -> Figure:
    share = float(rng.choice([UPRIGHT, 1.0]))
    trunk = TrunkAngles(
        pelvis=share * draw(-15, 60),
        chest=share * draw(-20, 90),
        head=draw(-40, 70),
        side_bend=share * draw(-30, 30),
        twist=share * draw(-45, 45),
        look=draw(-60, 60),
        tilt=draw(-30, 30),
    )
    arms = [_active_arm(draw, float(rng.random())) for _ in range(2)]
    legs = [_active_leg(draw, float(rng.random())) for _ in range(2)]
    return Figure(arms[0], arms[1], legs[0], legs[1], trunk)


def _active_arm(draw: DrawAngle, chance: float) -> ArmAngles:
    if chance < LOW_ARM_SHARE:
        elevation = draw(0, 45)
    elif chance < 1.0 - HIGH_ARM_SHARE:
        elevation = draw(30, 130)
    else:
        elevation = draw(110, 178)
    return ArmAngles(
        elevation=elevation,
        plane=draw(-40, 125),
        rotation=draw(-60, 90),
        elbow=draw(0, 145),
        pronation=draw(-80, 80),
        wrist=draw(-60, 60),
        curl=draw(0, 60),
    )


def _active_leg(draw: DrawAngle, chance: float) -> LegAngles:
    is_straight = chance < STRAIGHT_LEG_SHARE
    flexion = draw(-25, 35) if is_straight else draw(-20, 110)
    knee = 0.6 * max(flexion, 0.0) + draw(0, 60) if is_straight else draw(0, 125)
    return LegAngles(flexion, draw(-8, 35), knee, draw(-15, 35), draw(-10, 40))
