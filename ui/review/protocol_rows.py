"""The measures of a protocol in one capture as lines of a table, in the language in use. No Qt."""

from typing import TYPE_CHECKING

from adibas.texts import translate as _
from ui.widgets.rows import Row, interval_text, measure_text, number

if TYPE_CHECKING:
    from adibas.data.protocol_measures import MeasureResult, ProtocolMeasures


def protocol_headers() -> tuple[str, ...]:
    """Return the titles of the columns."""
    return (_("Measure"), _("Value"), _("95 % interval"))


def protocol_rows(measures: "ProtocolMeasures") -> tuple[Row, ...]:
    """Return a line for each measure."""
    return tuple(_row(measures.view, one) for one in measures.results)


def _row(view: str, result: "MeasureResult") -> Row:
    """Return the line of a measure as reports have it."""
    from adibas.reports.rows import measure_row

    told, name = measure_row(result), measure_text(result.definition)
    value, interval = (
        (None, None) if told.main is None else (told.main.value, (told.main.low, told.main.high))
    )
    return Row(
        (view, told.measure_id),
        (name, number(value), interval_text(interval)),
        (name, value, None if interval is None else interval[1] - interval[0]),
    )


def measure_details(measures: "ProtocolMeasures", measure_id: str) -> str:
    """Say why a measure has no value, what its sign means, and what others found."""
    from adibas.reports.rows import measure_row

    results = [one for one in measures.results if one.definition.measure_id == measure_id]
    if not results:
        return ""
    told = measure_row(results[0])
    titled = (
        ("{title}: {text}.", _("Positive means"), told.positive),
        ("{title}: {text}", _("Reference"), told.reference),
    )
    return "\n".join(
        [
            f"{told.name}.",
            *([f"{told.remark}."] if told.remark else []),
            *(form.format(title=title, text=text) for form, title, text in titled if text),
        ]
    )


def protocol_notices(measures: "ProtocolMeasures") -> tuple[str, ...]:
    """Return what the reader must know of them."""
    return tuple(notice.text for notice in measures.notices)


def rests_on(measures: "ProtocolMeasures") -> str:
    """Say which protocol it is, and on what its values and intervals rest."""
    from adibas.data.protocol_measures import INSTRUMENT_ONLY, PLANE_TEXTS, VERTICAL_TEXTS

    told = _("{protocol}. Plane: {plane}. Vertical: {vertical}. Interval: {interval}")
    return told.format(
        protocol=measures.protocol.title.text,
        plane=_(PLANE_TEXTS[measures.plane]),
        vertical=_(VERTICAL_TEXTS[measures.vertical]),
        interval=_(INSTRUMENT_ONLY),
    )
