"""The names of methods of agreement for a reader, and what each of them says."""

from adibas.texts import Message, message
from adibas.texts import translate as _

NAMES: dict[str, Message] = {
    "time-unit-kappa": message("Kappa by units of time (Cohen)"),
    "time-unit-pabak": message("PABAK by units of time"),
    "time-unit-ac1": message("AC1 by units of time (Gwet)"),
    "fleiss-kappa": message("Kappa of all observers (Fleiss)"),
    "event-kappa": message("Kappa by events"),
    "total-count": message("Agreement of total counts"),
    "mean-count-per-interval": message("Mean agreement of counts in intervals"),
    "exact-count-per-interval": message("Exact counts in intervals"),
    "interval-by-interval": message("Interval by interval"),
    "scored-intervals": message("Scored intervals"),
    "unscored-intervals": message("Unscored intervals"),
    "total-duration": message("Agreement of total durations"),
    "mean-duration-per-occurrence": message("Mean agreement of durations"),
    "icc-count": message("ICC(2,1) of counts in intervals"),
    "icc-duration": message("ICC(2,1) of durations in intervals"),
}
METHOD_TEXTS: tuple[tuple[str, Message], ...] = (
    (
        "time-unit-kappa",
        message(
            "Every unit of time is one judgement: which states last at its middle. Agreement "
            "beyond the chance that follows from how often each observer uses each state (1960)."
        ),
    ),
    (
        "time-unit-pabak",
        message("The same as if all states were equally frequent (Byrt, Bishop & Carlin 1993)."),
    ),
    (
        "time-unit-ac1",
        message(
            "The same with a chance that stays low where one state is far more frequent (2008)."
        ),
    ),
    ("fleiss-kappa", message("The same of any number of observers (1971).")),
    (
        "event-kappa",
        message(
            "Events that begin within the tolerance are paired, the same behaviour first. A pair "
            "counts as two events, one of each observer. What nobody saw cannot be counted; chance "
            "is computed without it (Holle & Rein 2015)."
        ),
    ),
    (
        "interval-by-interval",
        message(
            "Intervals and counts as in applied behaviour analysis (Cooper, Heron & Heward 2007); "
            "chance is not taken off."
        ),
    ),
    (
        "icc-count",
        message(
            "Absolute agreement of single observers over the intervals of the session "
            "(Shrout & Fleiss 1979)."
        ),
    ),
)


def method_text(method: str) -> str:
    """Return the name of a method for a reader."""
    return _(NAMES[method])


def table_name(method: str) -> str:
    """Return what the empty name of a table's row says."""
    return _("not seen") if method == "event-kappa" else _("nothing")
