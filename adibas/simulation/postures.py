"""The postures in which a patient is measured, and how a standing body sways."""

import math
from dataclasses import dataclass, replace

import numpy as np

from adibas.arrays import FloatArray, read_only
from adibas.simulation.figures import Figure, TrunkAngles
from adibas.simulation.poses import FORWARD, LEFT, ArmAngles, LegAngles, Pose
from adibas.simulation.rotations import about


def _degrees(**angles: float) -> dict[str, float]:
    return {name: math.radians(angle) for name, angle in angles.items()}


POSTURES: dict[str, Figure] = {
    "relaxed": Figure(),
    "arms_abducted": Figure(
        left_arm=ArmAngles(**_degrees(elevation=30, plane=0, rotation=0, elbow=5, pronation=0)),
        right_arm=ArmAngles(**_degrees(elevation=30, plane=0, rotation=0, elbow=5, pronation=0)),
    ),
    "right_arm_forward": Figure(
        right_arm=ArmAngles(**_degrees(elevation=85, plane=75, rotation=0, elbow=5, pronation=60)),
    ),
    "leaning": Figure(
        left_arm=replace(ArmAngles(), **_degrees(elevation=12)),
        right_arm=replace(ArmAngles(), **_degrees(elevation=5, plane=40)),
        left_leg=replace(LegAngles(), **_degrees(spread=5)),
        right_leg=replace(LegAngles(), **_degrees(flexion=6, spread=3, knee=14)),
        trunk=TrunkAngles(**_degrees(pelvis=2, chest=6, head=10, side_bend=5, twist=4, tilt=-4)),
    ),
}
"""The four of the marker benchmark; angles a patient takes up when told to."""

_LOWEST_HZ = 0.05
_HIGHEST_HZ = 1.2
_N_WAVES = 12


@dataclass(frozen=True, slots=True, eq=False)
class Sway:
    """Slow lean about the ankles that no standing person can suppress.

    A sum of sines whose amplitude falls with frequency. The centre of mass is about 1 m over the
    ankles, so 4 and 2 milliradians are 4 and 2 mm there, what force plates find in quiet stance.

    Attributes
    ----------
    frequencies_hz : (N,) array
    amplitudes_rad, phases_rad : (2, N) arrays
        Rows: forward, to the patient's left.
    """

    frequencies_hz: FloatArray
    amplitudes_rad: FloatArray
    phases_rad: FloatArray

    def __post_init__(self) -> None:
        for array in (self.frequencies_hz, self.amplitudes_rad, self.phases_rad):
            read_only(array)

    def applied(self, pose: Pose, time_s: float) -> Pose:
        """Return `pose` as it leans at `time_s`."""
        phases = 2 * math.pi * self.frequencies_hz * time_s + self.phases_rad
        forward, left = (self.amplitudes_rad * np.sin(phases)).sum(1)
        return pose.leaned(about(LEFT, float(forward)) @ about(FORWARD, -float(left)))


def random_sway(
    rng: np.random.Generator, forward_rad: float = 0.004, left_rad: float = 0.002
) -> Sway:
    """Return the sway of one person; the angles are standard deviations, radians."""
    edges = np.geomspace(_LOWEST_HZ, _HIGHEST_HZ, _N_WAVES + 1)
    frequencies_hz = rng.uniform(edges[:-1], edges[1:])
    amplitudes = frequencies_hz**-0.5 * rng.uniform(0.7, 1.3, (2, _N_WAVES))
    amplitudes *= np.sqrt(2.0 / (amplitudes**2).sum(1, keepdims=True))
    amplitudes *= np.array([[forward_rad], [left_rad]])
    return Sway(frequencies_hz, amplitudes, rng.uniform(0, 2 * math.pi, (2, _N_WAVES)))
