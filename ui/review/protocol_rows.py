"""The measures of a protocol in one capture as lines of a table, in the language in use. No Qt."""

from typing import TYPE_CHECKING

from adibas.texts import translate as _
from ui.widgets.rows import NOTHING, Row, interval_text, measure_text, number

if TYPE_CHECKING:
    from adibas.data.protocol_measures import MeasureResult, ProtocolMeasures


def protocol_headers() -> tuple[str, ...]:
    """Return the titles of the columns."""
    return (_("Measure"), _("Value"), _("95 % interval"))


def protocol_rows(measures: "ProtocolMeasures") -> tuple[Row, ...]:
    """Return a line for each measure; one without a value says why."""
    return tuple(_row(measures.view, one) for one in measures.results)


def _row(view: str, result: "MeasureResult") -> Row:
    definition, main = result.definition, result.main
    key, name = (view, definition.measure_id), measure_text(definition)
    if main is None:
        why = NOTHING if result.reason is None else result.reason.text
        return Row(key, (f"{name}: {why}", NOTHING, NOTHING), (name, None, None))
    value = main.value / definition.per_unit
    low, high = (limit / definition.per_unit for limit in main.interval)
    return Row(key, (name, number(value), interval_text((low, high))), (name, value, high - low))


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
