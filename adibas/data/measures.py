"""Numbers for the clinician, each with the interval that the instrument alone explains."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class DistanceMeasure:
    """Distance of two markers, metres; `interval_m` holds the truth in 95 % of cases."""

    a: str
    b: str
    value_m: float
    interval_m: tuple[float, float]


@dataclass(frozen=True, slots=True)
class AngleMeasure:
    """Angle at `vertex` between the directions to `a` and to `c`, radians in [0, pi].

    `interval_rad` holds the truth in 95 % of cases and stays in [0, pi]; `bias_rad` is how much
    noise pushes the value away from 0 and pi (expected value minus truth).
    """

    a: str
    vertex: str
    c: str
    value_rad: float
    interval_rad: tuple[float, float]
    bias_rad: float
