"""The person that a simulated body is to be like."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

Sex: TypeAlias = Literal["female", "male"]

YOUNGEST_YEARS = 6.0
OLDEST_YEARS = 90.0


@dataclass(frozen=True, slots=True)
class BodyShape:
    """The person wanted.

    Attributes
    ----------
    sex : "female" or "male"
    age_years : float
        6 to 90.
    stature_m, weight_kg : float
    muscle : float or None
        0 slight, 0.5 average, 1 athletic; None takes the average, less where only that gives the
        weight.
    """

    sex: Sex
    age_years: float
    stature_m: float
    weight_kg: float
    muscle: float | None = None

    def __post_init__(self) -> None:
        if self.sex not in ("female", "male"):
            raise ValueError(f"sex must be female or male, got {self.sex}")
        if not YOUNGEST_YEARS <= self.age_years <= OLDEST_YEARS:
            raise ValueError(f"age_years must be 6 to 90, got {self.age_years}")
        if not (self.stature_m > 0 and self.weight_kg > 0):
            raise ValueError("stature_m and weight_kg must be positive")
        if self.muscle is not None and not 0 <= self.muscle <= 1:
            raise ValueError(f"muscle must be 0 to 1, got {self.muscle}")
