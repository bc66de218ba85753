"""One row of a benchmark, and how rows are shown.

A module `benchmarks/accuracy_NAME.py` or `benchmarks/speed_NAME.py` offers
``rows(*, quick: bool) -> Iterable[Row]``; with `quick` it measures a subset and says so in a row's
name. `adibas benchmark` finds it by its file name.
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Row:
    """Our figure beside its reference.

    Attributes
    ----------
    name : str
        What was measured, on what.
    ours : float
        Our figure.
    unit : str
        Of both figures.
    reference : float or None
        The thesis', a peer's, or the goal; None where there is none.
    reference_name : str
        Whose figure that is, such as ``thesis`` or ``goal <=``.
    """

    name: str
    ours: float
    unit: str
    reference: float | None = None
    reference_name: str = ""

    @property
    def ratio(self) -> float | None:
        """Reference / ours; None without a reference or where ours is 0."""
        return self.reference / self.ours if self.reference is not None and self.ours else None


HEADER = (
    "| What | Ours | Unit | Reference | Whose | Reference / ours |\n|---|---:|---|---:|---|---:|"
)


def format_row(row: Row) -> str:
    """Return one line of a Markdown table that begins with `HEADER`."""
    reference = "" if row.reference is None else f"{row.reference:.4g}"
    ratio = "" if row.ratio is None else f"{row.ratio:.2f}"
    return (
        f"| {row.name} | {row.ours:.4g} | {row.unit} | {reference} | {row.reference_name} | "
        f"{ratio} |"
    )
