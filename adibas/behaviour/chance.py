"""Agreement beyond chance, from tables of counts; a reason where a number would mean nothing.

Source: Cohen, A coefficient of agreement for nominal scales, Educational and Psychological
Measurement 20 (1960); Byrt, Bishop & Carlin, Bias, prevalence and kappa, Journal of Clinical
Epidemiology 46 (1993), for PABAK; Gwet, Computing inter-rater reliability and its variance in the
presence of high agreement, British Journal of Mathematical and Statistical Psychology 61 (2008),
for AC1; Fleiss, Measuring nominal scale agreement among many raters, Psychological Bulletin 76
(1971); Holle & Rein, EasyDIAg: a tool for easy determination of interrater agreement, Behavior
Research Methods 47 (2015), doi 10.3758/s13428-014-0506-7, for a table whose corner cannot be
counted.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape
from adibas.data.sentence import Sentence
from adibas.texts import message

ENOUGH = 1e-12
"""Nearer to 1 than this, agreement by chance is complete."""

NOTHING = message("Nothing was counted, so that there is nothing to agree on.")
ONE_CATEGORY = message(
    "All observers used one category alone: chance explains all agreement, and the coefficient has "
    "no meaning. Look at the share of agreement."
)
ONE_RATER = message("Agreement takes two observers at least.")


@dataclass(frozen=True, slots=True)
class Coefficient:
    """One figure of agreement.

    Attributes
    ----------
    method : str
        Its name, for programs.
    value : float or None
        1 is perfect; None with a reason.
    n : float
        Units, events or intervals that it rests on.
    observed, expected : float or None
        Share of agreement, and that by chance where the method has one.
    reason : Sentence or None
        Why there is no value.
    """

    method: str
    value: float | None
    n: float
    observed: float | None = None
    expected: float | None = None
    reason: Sentence | None = None


def cohen_kappa(table: FloatArray) -> Coefficient:
    """Return Cohen's kappa.

    Parameters
    ----------
    table : (k, k) array
        Counts; row: what the first observer said, column: the second.
    """
    shares, n = _shares(table)
    if n == 0:
        return Coefficient("cohen-kappa", None, 0, reason=Sentence(NOTHING))
    expected = float(shares.sum(axis=1) @ shares.sum(axis=0))
    return _beyond("cohen-kappa", float(np.trace(shares)), expected, n)


def pabak(table: FloatArray) -> Coefficient:
    """Return kappa as if all categories were equally frequent; `table` as in `cohen_kappa`."""
    shares, n = _shares(table)
    if n == 0:
        return Coefficient("pabak", None, 0, reason=Sentence(NOTHING))
    expected = 1.0 / len(shares)
    return _beyond("pabak", float(np.trace(shares)), expected, n)


def gwet_ac1(table: FloatArray) -> Coefficient:
    """Return Gwet's first-order coefficient; `table` as in `cohen_kappa`."""
    shares, n = _shares(table)
    if n == 0:
        return Coefficient("gwet-ac1", None, 0, reason=Sentence(NOTHING))
    if len(shares) == 1:
        return _beyond("gwet-ac1", 1.0, 1.0, n)
    mean = 0.5 * (shares.sum(axis=0) + shares.sum(axis=1))
    expected = float((mean * (1.0 - mean)).sum() / (len(shares) - 1))
    return _beyond("gwet-ac1", float(np.trace(shares)), expected, n)


def fleiss_kappa(counts: FloatArray) -> Coefficient:
    """Return Fleiss' kappa of many observers.

    Parameters
    ----------
    counts : (n, k) array
        A row a unit, a column a category: how many observers chose it. Rows have the same sum.

    Raises
    ------
    ValueError
        Rows have different sums.
    """
    check_shape("counts", counts, (None, None))
    n_units = len(counts)
    if n_units == 0:
        return Coefficient("fleiss-kappa", None, 0, reason=Sentence(NOTHING))
    raters = counts.sum(axis=1)
    if (raters != raters[0]).any():
        raise ValueError("every unit needs the same number of observers")
    n_raters = float(raters[0])
    if n_raters < 2:  # noqa: PLR2004
        return Coefficient("fleiss-kappa", None, n_units, reason=Sentence(ONE_RATER))
    by_unit = ((counts**2).sum(axis=1) - n_raters) / (n_raters * (n_raters - 1))
    shares = counts.sum(axis=0) / (n_units * n_raters)
    return _beyond("fleiss-kappa", float(by_unit.mean()), float((shares**2).sum()), n_units)


def event_kappa(table: FloatArray) -> Coefficient:
    """Return kappa of events, of which nobody can count those that both observers missed.

    Every event of either observer is one judgement: a pair counts twice, and what one of them
    alone saw once, as in the program of Holle & Rein (EasyDIAg, after GSEQ 5.1) and in ELAN.

    Parameters
    ----------
    table : (k + 1, k + 1) array
        Counts of pairs, as in `cohen_kappa`; the last row and column are events that the other
        did not see, and its corner is 0. Chance is that of independence in all other cells.

    Returns
    -------
    coefficient : Coefficient
        `n` is the number of events of both observers together.
    """
    judgements = np.array(table, np.float64)
    judgements[:-1, :-1] *= 2
    shares, n = _shares(judgements)
    if n == 0:
        return Coefficient("event-kappa", None, 0, reason=Sentence(NOTHING))
    expected = without_corner(shares)
    return _beyond("event-kappa", float(np.trace(shares)), float(np.trace(expected)), n)


def without_corner(shares: FloatArray) -> FloatArray:
    """Return the table with the margins of `shares`, independent but for an empty last corner.

    What iterative proportional fitting tends to: cell (i, j) is proportional to its row's and its
    column's margin, the corner is 0. What the sum holds beyond the margins of the last row and the
    last column is for the cells that are in neither of them.
    """
    rows, columns = shares.sum(axis=1), shares.sum(axis=0)
    of_rows, of_columns = _parts(rows[:-1]), _parts(columns[:-1])
    fitted = np.zeros_like(shares)
    inner = max(float(rows.sum() - rows[-1] - columns[-1]), 0.0)
    fitted[:-1, :-1] = inner * np.outer(of_rows, of_columns)
    fitted[:-1, -1] = columns[-1] * of_rows
    fitted[-1, :-1] = rows[-1] * of_columns
    return fitted


def _parts(margin: FloatArray) -> FloatArray:
    """Return what share of their sum each is; zeros where there is nothing."""
    total = float(margin.sum())
    return margin / total if total > 0 else np.zeros_like(margin)


def _shares(table: FloatArray) -> tuple[FloatArray, float]:
    check_shape("table", table, (None, table.shape[0]))
    total = float(table.sum())
    return np.asarray(table / total if total else table, np.float64), total


def _beyond(method: str, observed: float, expected: float, n: float) -> Coefficient:
    if 1.0 - expected < ENOUGH:
        return Coefficient(method, None, n, observed, expected, Sentence(ONE_CATEGORY))
    return Coefficient(method, (observed - expected) / (1.0 - expected), n, observed, expected)
