"""The table of changes since an earlier session in the PDF report."""

from reportlab.platypus import Flowable

from adibas.data.report import SessionReport
from adibas.reports.facts import comparison_facts, verdict_text, view_name
from adibas.reports.pdf_layout import SMALL_TEXT, WIDTH, note, number_table, paragraph, title
from adibas.texts import decimal_text
from adibas.texts import translate as _

DASH = "\N{EN DASH}"
MOST_CHANGES = 120
SHARES = (0.34, 0.11, 0.11, 0.11, 0.15, 0.08, 0.1)


def change_flowables(report: SessionReport) -> list[Flowable]:
    """Return a heading, the table, and what chance alone would mark."""
    if report.comparison is None:
        return []
    found = report.comparison.comparison
    cells: list[list[str | Flowable]] = []
    for one in found.changes[:MOST_CHANGES]:
        name = f"{one.name} ({one.measure_id}) [{_(one.unit)}], {view_name(one.view)}"
        low, high = one.interval or (None, None)
        cells.append(
            [
                paragraph(name, SMALL_TEXT),
                *(_number(value) for value in (one.before, one.after, one.difference)),
                DASH if one.interval is None else f"{_number(low)} {DASH} {_number(high)}",
                _number(one.mdc95),
                paragraph(verdict_text(one.verdict), SMALL_TEXT),
            ]
        )
    names = (_("Measure"), _("Before"), _("Now"), _("Difference"), _("95 %"))
    header = [*names, "MDC95", _("Change")]
    widths = [share * WIDTH for share in SHARES]
    flowables = [
        title(_("Changes"), level=2),
        number_table(header, cells, widths, text_columns=(0, 6)),
        *(note(f"{name}: {value}") for name, value in comparison_facts(report)),
    ]
    if len(found.changes) > MOST_CHANGES:
        text = _("The first {shown} of {total} measures; all are in the Excel report.")
        flowables.append(note(text.format(shown=MOST_CHANGES, total=len(found.changes))))
    return flowables


def _number(value: float | None) -> str:
    return DASH if value is None else decimal_text(value, 1)
