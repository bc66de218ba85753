"""The five gestures of the thesis and idling, as smooth tracks of poses.

Each begins and ends in the standing pose, at 0 and at `duration_s` to the instant. The seed
decides speed, reach, number of repetitions, and the hand.

Source: thesis, section 7.1 (jump, bend, clap, greet, note: the categories; how they are carried
out is ours).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from adibas.arrays import FloatArray
from adibas.simulation.figures import Figure, TrunkAngles
from adibas.simulation.poses import ArmAngles, LegAngles, Pose

GRAVITY_M_PER_S2 = 9.81
REST = Figure()


@dataclass(frozen=True, slots=True)
class Flight:
    """The part of a jump without the floor: a throw, `height_m` at its top."""

    begin_s: float
    height_m: float

    @property
    def duration_s(self) -> float:
        """Return how long a body thrown that high stays up."""
        return 2.0 * math.sqrt(2.0 * self.height_m / GRAVITY_M_PER_S2)

    def lift_m(self, time_s: float) -> float:
        """Return the height over the floor, 0 before and after."""
        since = time_s - self.begin_s
        left = self.duration_s - since
        return max(0.0, 0.5 * GRAVITY_M_PER_S2 * since * left) if since > 0 < left else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Gesture:
    """One performance of a gesture.

    Attributes
    ----------
    name : str
    duration_s : float
        It begins at 0 and ends here, both in the standing pose.
    """

    name: str
    duration_s: float
    _track: CubicHermiteSpline = field(repr=False)
    _flight: Flight | None = None

    def pose(self, time_s: float) -> Pose:
        """Return the pose at `time_s`; before the beginning and after the end it stands."""
        time_s = min(max(time_s, 0.0), self.duration_s)
        lift_m = self._flight.lift_m(time_s) if self._flight else 0.0
        return Figure.from_vector(self._track(time_s)).pose(lift_m)


@dataclass(frozen=True, slots=True, eq=False)
class _Performer:
    """How this time differs from the plan."""

    rng: np.random.Generator
    slowness: float
    reach: float
    right_handed: bool

    def lasting(self, seconds: float) -> float:
        """Return a duration near `seconds`."""
        return seconds * self.slowness * float(self.rng.uniform(0.9, 1.1))

    def angle(self, degrees: float) -> float:
        """Return an angle near `degrees`, radians."""
        return math.radians(degrees * self.reach + float(self.rng.normal(0.0, 2.0)))

    def arm(self, **degrees: float) -> ArmAngles:
        """Return an arm near the angles given in degrees; `curl` is kept as it is."""
        return replace(ArmAngles(), **{name: self.angle(value) for name, value in degrees.items()})

    def with_arms(self, leading: ArmAngles, other: ArmAngles, trunk: TrunkAngles) -> Figure:
        """Return a figure whose better hand leads."""
        left, right = (other, leading) if self.right_handed else (leading, other)
        return Figure(left_arm=left, right_arm=right, trunk=trunk)


_Keys = list[tuple[float, Figure]]


def gesture_names() -> tuple[str, ...]:
    """Return the names that `perform` knows: the thesis' five, then ``idle``."""
    return tuple(_PLANS)


def perform(name: str, seed: int) -> Gesture:
    """Return one performance of a gesture; the same seed gives the same one.

    Raises
    ------
    ValueError
        There is no such gesture.
    """
    if name not in _PLANS:
        raise ValueError(f"gesture must be one of {', '.join(_PLANS)}, got {name}")
    rng = np.random.default_rng(seed)
    performer = _Performer(
        rng,
        slowness=float(rng.uniform(0.8, 1.25)),
        reach=float(rng.uniform(0.9, 1.1)),
        right_handed=bool(rng.random() < 0.8),  # noqa: PLR2004  (some greet with the left)
    )
    keys, flight = _PLANS[name](performer)
    times_s = np.cumsum([0.0, *(lasting for lasting, _ in keys)])
    figures = [REST, *(figure for _, figure in keys)]
    track = _smooth(times_s, np.stack([figure.vector() for figure in figures]))
    return Gesture(name, float(times_s[-1]), track, flight)


def _smooth(times_s: FloatArray, angles: FloatArray) -> CubicHermiteSpline:
    """Return a track without overshoot that starts and stops at rest.

    Source: Fritsch & Carlson, Monotone piecewise cubic interpolation, 1980.
    """
    slopes = PchipInterpolator(times_s, angles).derivative()(times_s)
    slopes[[0, -1]] = 0.0
    return CubicHermiteSpline(times_s, angles, slopes)


def _bend(performer: _Performer) -> tuple[_Keys, Flight | None]:
    """Bend forward with nearly straight knees until the hands hang before the shins; rise."""
    depth = performer.angle(85)
    legs = LegAngles(flexion=math.radians(9), knee=performer.angle(8))
    arm = performer.arm(elevation=6, plane=90, rotation=20, elbow=6, pronation=60)
    low = Figure(
        left_arm=arm,
        right_arm=arm,
        left_leg=legs,
        right_leg=legs,
        trunk=TrunkAngles(pelvis=0.6 * depth, chest=depth, head=0.95 * depth),
    )
    stay = performer.lasting(0.4)
    return [
        (performer.lasting(1.1), low),
        (stay, low),
        (performer.lasting(1.1), REST),
    ], None


def _jump(performer: _Performer) -> tuple[_Keys, Flight | None]:
    """Crouch with the arms back, throw them up and leave the floor, land, rise."""
    height_m = float(performer.rng.uniform(0.12, 0.32))
    crouch = _crouch(performer, deep=1.0, arms_back=True)
    stretched_leg = LegAngles(flexion=0.0, knee=0.03, sole=math.radians(35))
    arm = performer.arm(elevation=125, plane=80, rotation=0, elbow=20, pronation=20)
    stretched = Figure(arm, arm, stretched_leg, stretched_leg, TrunkAngles())
    down, up = performer.lasting(0.5), performer.lasting(0.33)
    flight = Flight(down + up, height_m)
    return [
        (0.5 * down, _sinking(performer)),
        (0.5 * down, crouch),
        (up, stretched),
        (flight.duration_s, stretched),
        (performer.lasting(0.22), _crouch(performer, deep=0.75, arms_back=False)),
        (performer.lasting(0.6), REST),
    ], flight


def _sinking(performer: _Performer) -> Figure:
    """Return the way down, the arms still before the hips and clear of them."""
    hips = performer.angle(25)
    legs = LegAngles(flexion=hips, knee=1.55 * hips)
    arm = performer.arm(elevation=15, plane=60, rotation=5, elbow=15, pronation=10)
    return Figure(arm, arm, legs, legs, TrunkAngles(0.5 * hips, 0.65 * hips, 0.15 * hips))


def _crouch(performer: _Performer, *, deep: float, arms_back: bool) -> Figure:
    hips = deep * performer.angle(55)
    legs = LegAngles(flexion=hips, knee=1.55 * hips)
    # Negative, so that the way leads past the hips and not sideways.
    back = performer.arm(elevation=-35, plane=112, rotation=0, elbow=15, pronation=10)
    fore = performer.arm(elevation=45, plane=70, rotation=10, elbow=30, pronation=30)
    arm = back if arms_back else fore
    return Figure(arm, arm, legs, legs, TrunkAngles(0.5 * hips, 0.65 * hips, 0.15 * hips))


def _clap(performer: _Performer) -> tuple[_Keys, Flight | None]:
    """Bring the hands together before the chest, three to five times."""
    height, elbow = performer.angle(42), performer.angle(92)
    together = ArmAngles(
        elevation=height,
        plane=math.radians(60),
        rotation=math.radians(56),
        elbow=elbow,
        pronation=math.radians(-40),
        wrist=math.radians(-45),
        curl=0.05,
    )
    width = performer.angle(26)
    apart = replace(together, plane=math.radians(52), rotation=math.radians(56) - width, wrist=-0.4)
    n_claps = int(performer.rng.integers(3, 6))
    open_, shut = Figure(apart, apart), Figure(together, together)
    half_s = performer.lasting(0.17)
    keys = [(performer.lasting(0.6), open_)]
    for _ in range(n_claps):
        keys += [(half_s, shut), (half_s, open_)]
    return [*keys, (performer.lasting(0.6), REST)], None


def _greet(performer: _Performer) -> tuple[_Keys, Flight | None]:
    """Raise one hand beside the head and wave it two to four times."""
    raised = replace(
        performer.arm(elevation=68, plane=25, rotation=-85, elbow=100, pronation=75), curl=0.05
    )
    swing = performer.angle(20)
    outward = replace(raised, elbow=raised.elbow - swing)
    inward = replace(raised, elbow=raised.elbow + swing)
    trunk = TrunkAngles(tilt=performer.angle(3))
    n_waves = int(performer.rng.integers(2, 5))
    half_s = performer.lasting(0.24)
    keys = [(performer.lasting(0.7), performer.with_arms(outward, ArmAngles(), trunk))]
    for _ in range(n_waves):
        keys += [
            (half_s, performer.with_arms(inward, ArmAngles(), trunk)),
            (half_s, performer.with_arms(outward, ArmAngles(), trunk)),
        ]
    return [*keys, (performer.lasting(0.7), REST)], None


def _note(performer: _Performer) -> tuple[_Keys, Flight | None]:
    """Write on a pad held in the other hand, the head bowed over it."""
    pad = performer.arm(elevation=18, plane=60, rotation=32, elbow=88, pronation=-70)
    pen = replace(
        performer.arm(elevation=26, plane=45, rotation=38, elbow=92, pronation=35), curl=0.7
    )
    trunk = TrunkAngles(chest=performer.angle(4), head=performer.angle(28))
    keys = [(performer.lasting(0.9), performer.with_arms(pen, pad, trunk))]
    for line in range(int(performer.rng.integers(2, 4))):
        lower = math.radians(4) * line
        for stroke in range(int(performer.rng.integers(3, 6))):
            moved = replace(
                pen,
                rotation=pen.rotation - math.radians(4) * stroke,
                elbow=pen.elbow - lower + math.radians(5) * (stroke % 2),
            )
            keys.append((performer.lasting(0.22), performer.with_arms(moved, pad, trunk)))
    return [*keys, (performer.lasting(0.9), REST)], None


def _idle(performer: _Performer) -> tuple[_Keys, Flight | None]:
    """Stand about: shift the weight, look around, let the arms dangle."""
    keys = []
    for _ in range(int(performer.rng.integers(3, 6))):
        side, look, nod, arm, knee = performer.rng.normal(0.0, 1.0, 5)
        dangling = replace(ArmAngles(), plane=math.radians(15 + 8 * arm))
        leg = replace(LegAngles(), knee=math.radians(2 + 3 * abs(knee)))
        trunk = TrunkAngles(
            head=math.radians(4 * nod),
            side_bend=math.radians(1.5 * side),
            look=math.radians(12 * look),
        )
        keys.append((performer.lasting(1.0), Figure(dangling, dangling, leg, leg, trunk)))
    return [*keys, (performer.lasting(1.0), REST)], None


_PLANS: dict[str, Callable[[_Performer], tuple[_Keys, Flight | None]]] = {
    "jump": _jump,
    "bend": _bend,
    "clap": _clap,
    "greet": _greet,
    "note": _note,
    "idle": _idle,
}
