"""A known length, measured before a session: does the calibration still hold.

Source: the wand check of marker systems, as ASTM E3064 (2016) describes it; intervals from
`adibas.geometry.uncertainty`.
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from adibas.arrays import FloatArray, check_shape
from adibas.data.sentence import Sentence
from adibas.geometry.uncertainty import uncertain_distances
from adibas.texts import message

MILLIMETRES = 1000.0


class WandResult(Enum):
    """What came of the check."""

    PASSED = "passed"
    FAILED = "failed"
    UNSURE = "unsure"


TEXTS = {
    WandResult.PASSED: message(
        "The wand of {length_mm} mm measures {measured_mm} mm ({low_mm} to {high_mm} mm): the "
        "sensor measures as it was calibrated."
    ),
    WandResult.FAILED: message(
        "The wand of {length_mm} mm measures {measured_mm} mm ({low_mm} to {high_mm} mm), more "
        "than {tolerance_mm} mm away from the truth. Check that both markers are fixed to its "
        "ends and well seen, and let the sensor warm up; if it stays so, calibrate again."
    ),
    WandResult.UNSURE: message(
        "The wand of {length_mm} mm measures {measured_mm} mm, but only within {low_mm} to "
        "{high_mm} mm. Hold it nearer and across the line of sight, and measure again."
    ),
}


@dataclass(frozen=True, slots=True)
class WandParams:
    """When a wand passes.

    Attributes
    ----------
    tolerance_m : float
        How far from the truth is still good: 5 mm, less than palpation scatters (3-6 mm).
    """

    tolerance_m: float = 0.005

    def __post_init__(self) -> None:
        if not self.tolerance_m > 0:
            raise ValueError(f"tolerance_m must be positive, got {self.tolerance_m}")


@dataclass(frozen=True, slots=True)
class WandCheck:
    """A measured wand.

    Attributes
    ----------
    length_m, measured_m : float
        As it is, and as measured.
    interval_m : (float, float)
        Holds what was measured in 95 % of cases, by the instrument's own account.
    tolerance_m : float
        How far from the truth was still good.
    """

    length_m: float
    measured_m: float
    interval_m: tuple[float, float]
    tolerance_m: float

    @property
    def result(self) -> WandResult:
        """Passed: the truth lies within interval and tolerance.

        Unsure: the interval is wider than the tolerance to either side, so that passing would say
        nothing.
        """
        low_m, high_m = self.interval_m
        if not low_m - self.tolerance_m <= self.length_m <= high_m + self.tolerance_m:
            return WandResult.FAILED
        is_wide = 0.5 * (high_m - low_m) > self.tolerance_m
        return WandResult.UNSURE if is_wide else WandResult.PASSED

    @property
    def sentence(self) -> Sentence:
        """What came of it, for the reader."""
        fields = {
            "length_mm": MILLIMETRES * self.length_m,
            "measured_mm": MILLIMETRES * self.measured_m,
            "low_mm": MILLIMETRES * self.interval_m[0],
            "high_mm": MILLIMETRES * self.interval_m[1],
            "tolerance_mm": MILLIMETRES * self.tolerance_m,
        }
        return Sentence(TEXTS[self.result], fields)


def check_wand(
    ends_m: FloatArray,
    covariance_m2: FloatArray,
    length_m: float,
    params: WandParams | None = None,
) -> WandCheck:
    """Compare two measured markers with the length between them.

    Parameters
    ----------
    ends_m : (2, 3) array
        Positions of the markers, metres.
    covariance_m2 : (6, 6) array
        Of both, with what they share; see `adibas.geometry.uncertainty.independent`.
    length_m : float
        Between their centres, as measured with a ruler.

    Raises
    ------
    ValueError
        The length is not positive, or a position is missing.
    """
    params = params or WandParams()
    check_shape("ends_m", ends_m, (2, 3))
    check_shape("covariance_m2", covariance_m2, (6, 6))
    if not length_m > 0 or not np.isfinite(ends_m).all():
        raise ValueError("a wand has a positive length and two measured ends")
    found = uncertain_distances(ends_m[None], covariance_m2[None])
    measured_m = float(found.values[0])
    low_m, high_m = (float(value) for value in found.intervals[0])
    return WandCheck(length_m, measured_m, (low_m, high_m), params.tolerance_m)
