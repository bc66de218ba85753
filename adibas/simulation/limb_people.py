"""People of all sizes in poses of all kinds: whom the models of limbs are trained on.

Arms and legs are drawn within what joints allow (see `random_poses`); what people often do is
drawn more often: both arms alike, hands over the head, at the face, together or at the hips, deep
bends, steps, crouching, sitting. The shares are ours.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from adibas.simulation.body_shape import BodyShape, Sex
from adibas.simulation.clothing import Outfit
from adibas.simulation.figures import Figure, TrunkAngles
from adibas.simulation.gestures import gesture_names, perform
from adibas.simulation.looks import CLOTH_SRGB, HAIR_SRGB, SKIN_TONES_SRGB, Look
from adibas.simulation.poses import ArmAngles, LegAngles, Pose
from adibas.simulation.random_poses import DrawAngle, angle_drawer, random_figure

KIND_SHARES: Mapping[str, float] = {
    "standing": 0.12,
    "moving": 0.24,
    "seated": 0.14,
    "gesture": 0.08,
    "overhead": 0.12,
    "at_body": 0.12,
    "stepping": 0.09,
    "bending": 0.06,
    "crouching": 0.03,
}
ALIKE_SHARE = 0.35
"""Of people whose arms do about the same."""
CHILDREN_SHARE = 0.3
GROWN_YEARS = 18.0


def random_shape(rng: np.random.Generator) -> BodyShape:
    """Return anybody from 6 to 85 years, slight to very heavy."""
    sex: Sex = "female" if rng.random() < 0.5 else "male"  # noqa: PLR2004  (half and half)
    is_child = rng.random() < CHILDREN_SHARE
    age = rng.uniform(6.0, GROWN_YEARS) if is_child else rng.uniform(GROWN_YEARS, 85.0)
    grown_m = 1.63 if sex == "female" else 1.77
    stature_m = np.interp(age, [6.0, GROWN_YEARS], [1.16, grown_m]) + rng.normal(scale=0.06)
    mass_index = np.interp(age, [6.0, GROWN_YEARS], [16.0, 24.5]) * np.exp(rng.normal(scale=0.2))
    return BodyShape(sex, float(age), float(stature_m), float(mass_index * stature_m**2))


def random_outfit(rng: np.random.Generator) -> Outfit:
    """Return what anybody may wear, from underwear to a long coat's sleeves."""
    is_bare = rng.random() < 0.15  # noqa: PLR2004  (a share, ours)
    return Outfit(
        hair=bool(rng.random() < 0.95),  # noqa: PLR2004  (a share, ours)
        sleeve=None if is_bare else float(rng.uniform(0.0, 1.95)),
        leg=float(rng.uniform(0.0, 1.97)),
        hem=float(rng.uniform(-0.3, 0.3)),
        waist=float(rng.uniform(0.1, 0.3)),
        shoes=bool(rng.random() < 0.7),  # noqa: PLR2004  (a share, ours)
    )


def random_look(rng: np.random.Generator) -> Look:
    """Return colours of skin, hair and cloth, dark and light."""

    def pick(colors: tuple[tuple[int, int, int], ...]) -> tuple[int, int, int]:
        return colors[int(rng.integers(len(colors)))]

    return Look(
        skin=pick(SKIN_TONES_SRGB),
        hair=pick(HAIR_SRGB),
        top=pick(CLOTH_SRGB),
        bottom=pick(CLOTH_SRGB),
        shoes=pick(CLOTH_SRGB),
    )


def random_kind(rng: np.random.Generator) -> str:
    """Return one of `KIND_SHARES`, as often as it says."""
    return str(rng.choice(list(KIND_SHARES), p=list(KIND_SHARES.values())))


def wide_pose(rng: np.random.Generator, kind: str) -> Pose:
    """Return somebody doing something of `kind`, one of `KIND_SHARES`, before the camera."""
    if kind == "gesture":
        gesture = perform(str(rng.choice(gesture_names())), int(rng.integers(2**31)))
        return gesture.pose(float(rng.uniform(0.0, gesture.duration_s)))
    return _perhaps_alike(_PLANS[kind](rng), rng).pose()


def _perhaps_alike(figure: Figure, rng: np.random.Generator) -> Figure:
    if rng.random() > ALIKE_SHARE:
        return figure
    draw = angle_drawer(rng)
    left = figure.left_arm
    right = replace(
        left,
        elevation=left.elevation + draw(-12, 12),
        plane=left.plane + draw(-12, 12),
        rotation=left.rotation + draw(-12, 12),
        elbow=max(left.elbow + draw(-12, 12), 0.0),
        pronation=left.pronation + draw(-12, 12),
    )
    return replace(figure, right_arm=right)


def _upright(draw: DrawAngle) -> TrunkAngles:
    return TrunkAngles(
        pelvis=draw(-8, 12),
        chest=draw(-12, 20),
        head=draw(-25, 35),
        side_bend=draw(-15, 15),
        twist=draw(-25, 25),
        look=draw(-40, 40),
        tilt=draw(-15, 15),
    )


def _any_arm(rng: np.random.Generator) -> ArmAngles:
    return random_figure(rng, "moving" if rng.random() < 0.6 else "standing").left_arm  # noqa: PLR2004


def _standing_legs(draw: DrawAngle) -> tuple[LegAngles, LegAngles]:
    def leg() -> LegAngles:
        return LegAngles(draw(-6, 15), draw(-1, 15), draw(0, 25), draw(-5, 25))

    return leg(), leg()


def _overhead(rng: np.random.Generator) -> Figure:
    """Return one or both hands above the shoulders."""
    draw = angle_drawer(rng)

    def arm() -> ArmAngles:
        return ArmAngles(
            elevation=draw(100, 178),
            plane=draw(-5, 95),
            rotation=draw(-90, 70),
            elbow=draw(0, 140),
            pronation=draw(-80, 80),
            wrist=draw(-50, 50),
            curl=draw(0, 60),
        )

    other = arm() if rng.random() < 0.6 else _any_arm(rng)  # noqa: PLR2004  (a share, ours)
    arms = (arm(), other) if rng.random() < 0.5 else (other, arm())  # noqa: PLR2004
    return Figure(arms[0], arms[1], *_standing_legs(draw), _upright(draw))


def _at_body(rng: np.random.Generator) -> Figure:
    """Return hands at the body: folded, together, at the hips, the face, the other arm."""
    draw = angle_drawer(rng)

    def arm() -> ArmAngles:
        return ArmAngles(
            elevation=draw(5, 70),
            plane=draw(20, 110),
            rotation=draw(10, 85),
            elbow=draw(50, 145),
            pronation=draw(-80, 80),
            wrist=draw(-50, 50),
            curl=draw(0, 70),
        )

    def on_hip() -> ArmAngles:
        return ArmAngles(
            elevation=draw(30, 60),
            plane=draw(-25, 20),
            rotation=draw(40, 90),
            elbow=draw(70, 120),
            pronation=draw(-40, 40),
        )

    plans = (arm, arm, on_hip, lambda: _any_arm(rng))
    left, right = (plans[int(rng.integers(len(plans)))]() for _ in range(2))
    return Figure(left, right, *_standing_legs(draw), _upright(draw))


def _stepping(rng: np.random.Generator) -> Figure:
    """Return a step, a lunge, a kick, or one leg up."""
    draw = angle_drawer(rng)
    forward = draw(5, 75)
    knee = forward * float(rng.uniform(0.0, 1.4)) + draw(0, 50)
    leading = LegAngles(forward, draw(-3, 30), knee, draw(-10, 30))
    trailing = LegAngles(draw(-35, 10), draw(-3, 25), draw(0, 60), draw(-10, 25), draw(0, 30))
    legs = (leading, trailing) if rng.random() < 0.5 else (trailing, leading)  # noqa: PLR2004
    arms = _any_arm(rng), _any_arm(rng)
    return Figure(arms[0], arms[1], legs[0], legs[1], _upright(draw))


def _bending(rng: np.random.Generator) -> Figure:
    """Return a deep bend, hands anywhere between the knees and the floor or on the body."""
    draw = angle_drawer(rng)
    depth = draw(50, 125)
    trunk = TrunkAngles(
        pelvis=depth * float(rng.uniform(0.4, 0.8)),
        chest=depth,
        head=depth * float(rng.uniform(0.4, 1.2)),
        side_bend=draw(-20, 20),
        twist=draw(-25, 25),
        look=draw(-25, 25),
    )

    def arm() -> ArmAngles:
        return ArmAngles(
            elevation=draw(0, 100),
            plane=draw(40, 110),
            rotation=draw(-20, 60),
            elbow=draw(0, 80),
            pronation=draw(-60, 80),
            wrist=draw(-40, 40),
            curl=draw(0, 70),
        )

    flexion, knee = draw(-15, 40), draw(0, 70)
    legs = [LegAngles(flexion + draw(-8, 8), draw(0, 15), knee + draw(0, 10)) for _ in range(2)]
    return Figure(arm(), arm(), legs[0], legs[1], trunk)


def _crouching(rng: np.random.Generator) -> Figure:
    """Return knees deeply bent."""
    draw = angle_drawer(rng)
    flexion = draw(55, 110)
    legs = [
        LegAngles(
            flexion + draw(-10, 10), draw(0, 35), flexion + draw(10, 40), draw(0, 30), draw(0, 25)
        )
        for _ in range(2)
    ]
    trunk = replace(_upright(draw), pelvis=draw(0, 40), chest=draw(0, 55))
    return Figure(_any_arm(rng), _any_arm(rng), legs[0], legs[1], trunk)


_PLANS: dict[str, Callable[[np.random.Generator], Figure]] = {
    "standing": lambda rng: random_figure(rng, "standing"),
    "moving": lambda rng: random_figure(rng, "moving"),
    "seated": lambda rng: random_figure(rng, "seated"),
    "overhead": _overhead,
    "at_body": _at_body,
    "stepping": _stepping,
    "bending": _bending,
    "crouching": _crouching,
}
