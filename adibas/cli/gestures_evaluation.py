"""What `adibas gestures evaluate` prints: how often each gesture is told, and for which others."""

from typing import TYPE_CHECKING

import numpy as np

from adibas.arrays import FloatArray
from adibas.texts import decimal_text
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.gestures.evaluation import Evaluation
    from adibas.gestures.training import TrainingParams
    from adibas.pipeline.gesture_work import Evaluated

HIGH_PERCENTILE = 95.0


def evaluation_lines(evaluated: "Evaluated", params: "TrainingParams") -> list[str]:
    """Return the lines: the whole, begins and ends, and a table of the gestures."""
    result = evaluated.result
    return [*_summary(evaluated, params), *_bounds(result), "", *_gestures(result)]


def _summary(evaluated: "Evaluated", params: "TrainingParams") -> list[str]:
    result = evaluated.result
    every = range(len(result.labels))
    precision, recall, f1 = (decimal_text(rate, 2) for rate in result.rates_of(every))
    return [
        _("{protocol}, {n} groups, method {method}, seed {seed}").format(
            protocol=evaluated.protocol, n=evaluated.groups, method=params.method, seed=params.seed
        ),
        _("Best class right: {percent} %; by equation 7.7: {by_7_7} %").format(
            percent=decimal_text(100 * result.accuracy, 1),
            by_7_7=decimal_text(result.accuracy_7_7, 1),
        ),
        _(
            "Precision {precision}, recall {recall}, F1 {f1}; {missed} not "
            "classified, {alarms} false alarms"
        ).format(
            precision=precision,
            recall=recall,
            f1=f1,
            missed=int(result.missed.sum()),
            alarms=result.false_alarms,
        ),
    ]


def _bounds(result: "Evaluation") -> list[str]:
    """Return how far begins and ends are off; nothing where gestures come cut out."""
    if not result.begin_errors.size:
        return []
    (begin, begin_high), (end, end_high) = map(
        _median_and_high, (result.begin_errors, result.end_errors)
    )
    return [
        _(
            "Begins are off by {begin} frames (median), 95 % by {begin_high} at most; ends by "
            "{end} and {end_high}"
        ).format(begin=begin, begin_high=begin_high, end=end, end_high=end_high)
    ]


def _median_and_high(errors: FloatArray) -> tuple[str, str]:
    median, high = np.percentile(errors, (50.0, HIGH_PERCENTILE))
    return decimal_text(float(median), 1), decimal_text(float(high), 1)


def _gestures(result: "Evaluation") -> list[str]:
    rows: list[tuple[str, ...]] = [
        (_("Gesture"), _("Precision"), _("Recall"), "F1", _("Eq. 7.7"), _("Reported as"))
    ]
    for number, label in enumerate(result.labels):
        rates = (decimal_text(rate, 2) for rate in result.rates_of([number]))
        right = f"{decimal_text(result.accuracy_of(number), 1)} %"
        rows.append((label, *rates, right, _reported(result, number)))
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return [
        "  ".join(
            (
                row[0].ljust(widths[0]),
                *(cell.rjust(width) for cell, width in zip(row[1:-1], widths[1:-1], strict=True)),
                row[-1],
            )
        ).rstrip()
        for row in rows
    ]


def _reported(result: "Evaluation", number: int) -> str:
    """Return a row of the confusion matrix in words: what was right first, then the mistakes."""
    counts = result.confusion[number]
    others = [k for k in np.argsort(-counts, kind="stable") if k != number]
    told = [f"{result.labels[int(k)]} {counts[k]}" for k in (number, *others) if counts[k] > 0]
    if result.missed[number]:
        told.append(_("nothing {n}").format(n=int(result.missed[number])))
    return ", ".join(told)
