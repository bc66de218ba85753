"""Joint angles over time, and how far each joint moved."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from adibas.arrays import FloatArray, check_shape, read_only
from adibas.data.posture import Provenance
from adibas.data.sentence import Sentence

Origin = Literal["markers", "markerless", "unknown"]
"""Of joints: markers on the skin, the depth map alone, or a file that does not say."""


@dataclass(frozen=True, slots=True, eq=False)
class AngleCurve:
    """One joint angle over time.

    Attributes
    ----------
    name : str
        Such as ``left_elbow_flexion``.
    deg : (T,) array
        Smoothed, degrees; NaN where a joint was not seen.
    speed_deg_s : (T,) array
        Its derivative, degrees a second; NaN also next to where the curve begins or ends.
    sd_deg : float
        Standard deviation of what random noise of the joints leaves in the curve; NaN where it is
        not known. Where markers or joints lie wrongly all the time is not in it.
    speed_sd_deg_s : float
        The same of the speed.
    """

    name: str
    deg: FloatArray
    speed_deg_s: FloatArray
    sd_deg: float
    speed_sd_deg_s: float = float("nan")

    def __post_init__(self) -> None:
        check_shape("deg", self.deg, (None,))
        check_shape("speed_deg_s", self.speed_deg_s, self.deg.shape)
        read_only(self.deg)
        read_only(self.speed_deg_s)


@dataclass(frozen=True, slots=True)
class AngleRange:
    """How far an angle went.

    Attributes
    ----------
    name : str
        Of the angle.
    least_deg, greatest_deg : float
        Its extremes.
    least_at_s, greatest_at_s : float
        When they were.
    fastest_deg_s : float
        Greatest speed, either way.
    seen_share : float
        Of the time in which the angle is known, 0 to 1.
    sd_deg : float
        Of one extreme, from noise alone; NaN where it is not known.
    speed_sd_deg_s : float
        Of one speed, likewise.
    noise_deg_s : float
        The greatest speed that noise alone shows in 1 of 100 such recordings; NaN where it is
        not known.
    """

    name: str
    least_deg: float
    greatest_deg: float
    least_at_s: float
    greatest_at_s: float
    fastest_deg_s: float
    seen_share: float
    sd_deg: float
    speed_sd_deg_s: float = float("nan")
    noise_deg_s: float = float("nan")

    @property
    def is_speed_noise(self) -> bool:
        """Whether the greatest speed is not told from what noise alone would show."""
        return self.fastest_deg_s <= self.noise_deg_s

    @property
    def range_deg(self) -> float:
        """From the least to the greatest."""
        return self.greatest_deg - self.least_deg


@dataclass(frozen=True, slots=True)
class Symmetry:
    """The ranges of a joint of both sides.

    Attributes
    ----------
    name : str
        Of the angle, without its side.
    left_deg, right_deg : float
        Ranges.
    index_percent : float or None
        Symmetry index: positive where the right side moved more; None where neither side moved
        enough to tell.
    """

    name: str
    left_deg: float
    right_deg: float
    index_percent: float | None


@dataclass(frozen=True, slots=True, eq=False)
class Movement:
    """What a moving recording gives.

    Attributes
    ----------
    times_s : (T,) array
        Even times, from the first frame on.
    joints_m : (T, 15, 3) array
        Smoothed joints in the order of `JOINT_NAMES`, camera axes; NaN where not seen.
    up : (3,) array
        Against gravity, camera axes.
    is_up_measured : bool
        False where the camera's own upper side stands for it, in files with upright axes.
    curves : tuple of AngleCurve
    ranges : tuple of AngleRange
        Of the curves that are known anywhere.
    symmetries : tuple of Symmetry
    origin : str
        Where the joints come from.
    patient : str
        A pseudonym, never a name.
    provenance : Provenance
    smoothing : mapping
        The filter's settings.
    notices : tuple of Sentence
        What the reader must know about the input.
    """

    times_s: FloatArray
    joints_m: FloatArray
    up: FloatArray
    is_up_measured: bool
    curves: tuple[AngleCurve, ...]
    ranges: tuple[AngleRange, ...]
    symmetries: tuple[Symmetry, ...]
    origin: Origin
    patient: str
    provenance: Provenance
    smoothing: Mapping[str, float] = field(default_factory=dict)
    notices: tuple[Sentence, ...] = ()

    def __post_init__(self) -> None:
        n_times = len(self.times_s)
        check_shape("times_s", self.times_s, (None,))
        check_shape("joints_m", self.joints_m, (n_times, None, 3))
        check_shape("up", self.up, (3,))
        for curve in self.curves:
            check_shape(curve.name, curve.deg, (n_times,))
        for array in (self.times_s, self.joints_m, self.up):
            read_only(array)

    @property
    def rate_hz(self) -> float:
        """Samples a second; NaN of a single one."""
        if len(self.times_s) <= 1:
            return float("nan")
        return float((len(self.times_s) - 1) / (self.times_s[-1] - self.times_s[0]))
