"""How well measures repeat in this clinic, and what that says of a change."""

from dataclasses import dataclass
from enum import Enum

from adibas.data.sentence import Sentence

Interval = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Repeat:
    """One measure of one patient, once.

    Attributes
    ----------
    patient : str
        A pseudonym.
    value : float
        In the unit of the measure.
    is_placed_anew : bool
        Whether the markers were taken off and placed again since the repeat before.
    """

    patient: str
    value: float
    is_placed_anew: bool


@dataclass(frozen=True, slots=True)
class Correlation:
    """An intraclass correlation with its interval of 95 %."""

    value: float
    interval: Interval


@dataclass(frozen=True, slots=True)
class Agreement:
    """Two values of each patient against each other, for a Bland-Altman plot.

    Attributes
    ----------
    means, differences : tuple of float
        Of each pair, the difference as first minus second.
    bias, sd : float
        Mean and standard deviation of the differences.
    bias_interval : (float, float)
        95 % of the bias.
    limits : (float, float)
        Between which 95 % of differences lie.
    limits_intervals : two (float, float)
        95 % of the lower and of the upper limit.
    """

    means: tuple[float, ...]
    differences: tuple[float, ...]
    bias: float
    sd: float
    bias_interval: Interval
    limits: Interval
    limits_intervals: tuple[Interval, Interval]


@dataclass(frozen=True, slots=True)
class Reliability:
    """What the repeats of one measure say; None where they do not suffice.

    Attributes
    ----------
    n_patients, n_values : int
        What the figures rest on: patients with two repeats at least, and their values; those with
        the markers placed anew alone where there are such.
    sem, sem_interval : float and (float, float), or None
        Standard deviation within a patient (standard error of measurement), and its 95 %.
    icc_2_1, icc_3_1 : Correlation or None
        Absolute agreement and consistency of single values.
    mdc95 : float or None
        Smallest change that chance alone exceeds in 5 of 100 unchanged patients.
    reasons : tuple of Sentence
        Why something is None.
    agreement : Agreement or None
        Of the first two repeats of each patient; None for fewer than two patients.
    """

    n_patients: int
    n_values: int
    sem: float | None = None
    sem_interval: Interval | None = None
    icc_2_1: Correlation | None = None
    icc_3_1: Correlation | None = None
    mdc95: float | None = None
    reasons: tuple[Sentence, ...] = ()
    agreement: Agreement | None = None


class Verdict(Enum):
    """What a change is against the smallest detectable one."""

    INSIDE = "inside"
    BEYOND = "beyond"
    UNKNOWN = "not known"


@dataclass(frozen=True, slots=True)
class Change:
    """One measure in two sessions, in its unit.

    Attributes
    ----------
    measure_id, name, unit, view : str
        Which.
    before, after : float or None
        None where it was not measured.
    difference : float or None
        After minus before; angles the shorter way round.
    interval : (float, float) or None
        95 % of the difference, instrument only, with errors of the two sessions independent.
    mdc95 : float or None
        Of this measure.
    verdict : Verdict
        Whether the difference is beyond it.
    """

    measure_id: str
    name: str
    unit: str
    view: str
    before: float | None
    after: float | None
    difference: float | None
    interval: Interval | None
    mdc95: float | None
    verdict: Verdict


@dataclass(frozen=True, slots=True)
class Comparison:
    """Two sessions of one patient, measure by measure."""

    protocol: str
    changes: tuple[Change, ...]

    @property
    def n_judged(self) -> int:
        """Return how many measures could be marked."""
        return sum(change.verdict is not Verdict.UNKNOWN for change in self.changes)

    @property
    def n_beyond(self) -> int:
        """Return how many were."""
        return sum(change.verdict is Verdict.BEYOND for change in self.changes)

    @property
    def expected_by_chance(self) -> float:
        """Return how many would be marked on average if nothing had changed: 5 of 100."""
        return 0.05 * self.n_judged
