"""How well a measure repeats: standard error of measurement, correlations, detectable change.

Source: Shrout & Fleiss, Intraclass correlations, Psychological Bulletin 86 (1979), for the two-way
analysis of variance and ICC(2,1) and ICC(3,1) with their intervals, that of ICC(2,1) as in McGraw &
Wong, Psychological Methods 1 (1996); Bland & Altman, Statistical methods for assessing agreement,
Lancet 327 (1986), for limits of agreement and their intervals.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.special import chdtri, fdtri, ndtri, stdtrit

from adibas.arrays import FloatArray, check_shape
from adibas.data.reliability import Agreement, Correlation, Reliability, Repeat
from adibas.data.sentence import Sentence
from adibas.texts import message

LEAST_PATIENTS = 10
LEAST_REPEATS = 2
TAIL = 0.025
FULL_TURN_DEG = 360.0

NO_REPEATS = message("No patient was measured twice, so that nothing is known of repeats.")
FEW_PATIENTS = message(
    "An intraclass correlation takes {least} patients with two repeats each, and there are {n}."
)
NOT_PLACED_ANEW = message(
    "The smallest detectable change takes repeats with the markers placed anew, and there are none."
)
NO_SPREAD = message("The values do not differ, so that a correlation has no meaning.")


def reliability_of(repeats: Sequence[Repeat]) -> Reliability:
    """Return what the repeats of one measure say.

    Parameters
    ----------
    repeats : sequence of Repeat
        By one operator and protocol, those of one patient in the order they were taken.

    Returns
    -------
    reliability : Reliability
        The standard error of measurement rests on all repeats of all patients who have two at
        least, and on those with the markers placed anew alone where there are such; correlations
        on as many first repeats of each patient as all have.
    """
    rows = [values for values in _by_patient(repeats) if len(values) >= LEAST_REPEATS]
    anew = [values for values in _by_patient(_placed_anew(repeats)) if len(values) >= LEAST_REPEATS]
    if not rows:
        return Reliability(0, 0, reasons=(Sentence(NO_REPEATS),))
    reasons = []
    used = anew or rows
    sem, interval = within_subject_sd(used)
    if not anew:
        reasons.append(Sentence(NOT_PLACED_ANEW))
    consistency = agreement = None
    if len(used) < LEAST_PATIENTS:
        fields = {"least": LEAST_PATIENTS, "n": len(used)}
        reasons.append(Sentence(FEW_PATIENTS, fields))
    else:
        n_common = min(map(len, used))
        table = np.array([values[:n_common] for values in used])
        if np.ptp(table) > 0:
            agreement, consistency = icc_2_1(table), icc_3_1(table)
        else:
            reasons.append(Sentence(NO_SPREAD))
    n_values = sum(map(len, used))
    mdc95 = detectable_change(sem, n_values - len(used)) if anew else None
    pairs = [(values[0], values[1]) for values in used]
    return Reliability(
        n_patients=len(used),
        n_values=n_values,
        sem=sem,
        sem_interval=interval,
        icc_2_1=agreement,
        icc_3_1=consistency,
        mdc95=mdc95,
        reasons=tuple(reasons),
        agreement=agreement_of(pairs) if len(pairs) >= LEAST_REPEATS else None,
    )


def unwrap_repeats(repeats: Sequence[Repeat]) -> list[Repeat]:
    """Return repeats of an angle in degrees without the jump from 180 to -180.

    Returns
    -------
    repeats : list of Repeat
        Whole turns are added so that the first value of each patient lies within half a turn of the
        circular mean of all, and the others within half a turn of that first one.
    """
    if not repeats:
        return []
    angles_rad = np.radians([repeat.value for repeat in repeats])
    up, right = float(np.sin(angles_rad).sum()), float(np.cos(angles_rad).sum())
    of_all = math.degrees(math.atan2(up, right))
    firsts: dict[str, float] = {}
    unwrapped = []
    for repeat in repeats:
        center = firsts.get(repeat.patient, of_all)
        n_turns = round((center - repeat.value) / FULL_TURN_DEG)
        value = repeat.value + FULL_TURN_DEG * n_turns
        firsts.setdefault(repeat.patient, value)
        unwrapped.append(replace(repeat, value=value))
    return unwrapped


def within_subject_sd(rows: Sequence[Sequence[float]]) -> tuple[float, tuple[float, float]]:
    """Return the standard deviation within patients and its 95 %.

    Parameters
    ----------
    rows : sequence of sequences
        The values of each patient, two at least.

    Raises
    ------
    ValueError
        A patient has fewer, or there is none.
    """
    if not rows or min(map(len, rows)) < LEAST_REPEATS:
        raise ValueError("every patient needs two values")
    square_sum = math.fsum(
        (value - float(np.mean(values))) ** 2 for values in rows for value in values
    )
    freedom = sum(len(values) - 1 for values in rows)
    low, high = (math.sqrt(square_sum / chdtri(freedom, tail)) for tail in (TAIL, 1.0 - TAIL))
    return math.sqrt(square_sum / freedom), (low, high)


def detectable_change(sem: float, freedom: float) -> float:
    """Return the change that chance alone exceeds in 5 of 100 unchanged patients.

    The two values of a patient who has not changed differ by sqrt(2) SEM (standard deviation), and
    that over an estimate of it follows Student's distribution. With many repeats it is the usual
    1.96 sqrt(2) SEM, which of few repeats chance would exceed more often: with one pair in 30 of
    100, with ten in 8.

    Parameters
    ----------
    sem : float
        Standard deviation within patients.
    freedom : float
        Degrees of freedom it was estimated with.
    """
    return float(stdtrit(freedom, 1.0 - TAIL)) * math.sqrt(2.0) * sem


def icc_2_1(table: FloatArray) -> Correlation:
    """Return the absolute agreement of single values, occasions drawn at random.

    Parameters
    ----------
    table : (n, k) array
        A row a patient, a column an occasion; two of each at least.
    """
    n, k = table.shape
    rows, columns, error = mean_squares(table)
    value = _ratio(rows - error, rows + (k - 1) * error + k * (columns - error) / n)
    ratio = _ratio(columns, error)
    spread = n * (1 + (k - 1) * value) - k * value
    top = (k - 1) * (n - 1) * (k * value * ratio + spread) ** 2
    bottom = (n - 1) * (k * value * ratio) ** 2 + spread**2
    freedom = _ratio(top, bottom)
    if not math.isfinite(freedom):  # no error at all
        return Correlation(value, (value, value))
    upper, lower = fdtri(n - 1, freedom, 1 - TAIL), fdtri(freedom, n - 1, 1 - TAIL)
    rest = k * columns + (k * n - k - n) * error
    low = n * (rows - upper * error) / (upper * rest + n * rows)
    high = n * (lower * rows - error) / (rest + n * lower * rows)
    return Correlation(value, (float(low), float(high)))


def icc_3_1(table: FloatArray) -> Correlation:
    """Return the consistency of single values, these occasions and no others.

    Parameters
    ----------
    table : (n, k) array
        A row a patient, a column an occasion; two of each at least.
    """
    n, k = table.shape
    rows, _columns, error = mean_squares(table)
    value = _ratio(rows - error, rows + (k - 1) * error)
    if not error > 0:
        return Correlation(value, (value, value))
    first, second = n - 1, (n - 1) * (k - 1)
    low = rows / error / fdtri(first, second, 1 - TAIL)
    high = rows / error * fdtri(second, first, 1 - TAIL)
    return Correlation(
        value, (float((low - 1) / (low + k - 1)), float((high - 1) / (high + k - 1)))
    )


class MeanSquares(NamedTuple):
    """Of a two-way analysis of variance without repeats in a cell."""

    rows: float
    columns: float
    error: float


def mean_squares(table: FloatArray) -> MeanSquares:
    """Return the mean squares between patients, between occasions, and of the rest."""
    check_shape("table", table, (None, None))
    n, k = table.shape
    if min(n, k) < LEAST_REPEATS:
        raise ValueError(f"a table needs two patients and two occasions, got {table.shape}")
    mean = table.mean()
    by_row, by_column = table.mean(axis=1) - mean, table.mean(axis=0) - mean
    rest = table - mean - by_row[:, None] - by_column
    return MeanSquares(
        float(k * (by_row**2).sum() / (n - 1)),
        float(n * (by_column**2).sum() / (k - 1)),
        float((rest**2).sum() / ((n - 1) * (k - 1))),
    )


def agreement_of(pairs: Sequence[tuple[float, float]]) -> Agreement:
    """Return means and differences of pairs, with the limits of agreement.

    Parameters
    ----------
    pairs : sequence of (float, float)
        Two values of each patient; two patients at least.

    Raises
    ------
    ValueError
        There are fewer.
    """
    n = len(pairs)
    if n < LEAST_REPEATS:
        raise ValueError(f"agreement takes two pairs, got {n}")
    first, second = np.array(pairs, float).T
    differences = first - second
    bias, sd = float(differences.mean()), float(differences.std(ddof=1))
    t = float(stdtrit(n - 1, 1 - TAIL))
    reach = float(ndtri(1 - TAIL)) * sd
    # Bland & Altman 1986: the variance of a limit is about 3 sd^2 / n.
    of_bias, of_limit = t * sd / math.sqrt(n), t * sd * math.sqrt(3.0 / n)
    low, high = bias - reach, bias + reach
    return Agreement(
        tuple(((first + second) / 2).tolist()),
        tuple(differences.tolist()),
        bias,
        sd,
        (bias - of_bias, bias + of_bias),
        (low, high),
        ((low - of_limit, low + of_limit), (high - of_limit, high + of_limit)),
    )


def _by_patient(repeats: Sequence[Repeat]) -> list[list[float]]:
    rows: dict[str, list[float]] = {}
    for repeat in repeats:
        rows.setdefault(repeat.patient, []).append(repeat.value)
    return list(rows.values())


def _placed_anew(repeats: Sequence[Repeat]) -> list[Repeat]:
    """Return the first repeat of each placing of the markers, the first placing included."""
    seen: set[str] = set()
    kept = []
    for repeat in repeats:
        if repeat.is_placed_anew or repeat.patient not in seen:
            kept.append(repeat)
        seen.add(repeat.patient)
    return kept


def _ratio(above: float, below: float) -> float:
    return above / below if below else math.inf
