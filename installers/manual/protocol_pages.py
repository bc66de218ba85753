"""Figures and tables of one protocol, as Markdown: from its file, in the language in use."""

from collections.abc import Iterator

from adibas.data.protocols import CONVENTION, MeasureDefinition, Protocol, ReferenceValue
from adibas.measures.protocol_store import find_protocol
from adibas.texts import decimal_text
from adibas.texts import translate as _
from installers.manual.landmarks import figure_views, numbered
from installers.manual.words import WORDS
from ui.view_names import VIEW_NAMES

UNIT_SIGNS = {"deg": "°", "%": " %"}


def protocol_part(protocol_id: str, language: str) -> str:
    """Return what a protocol marks and measures, view by view."""
    protocol, words = find_protocol(protocol_id), WORDS[language]
    views = figure_views(protocol)
    blocks: list[str] = []
    for view in views:
        name = _(VIEW_NAMES[view])
        if len(views) > 1:
            blocks.append(f"## {name} {{: #{view.replace('_', '-')} }}")
        alt = words["figure"].format(title=protocol.title.text, view=name.lower())
        blocks.append(f"![{alt}](../figures/{protocol_id}-{view}.png){{: .body }}")
        blocks.append(_landmark_table(protocol_id, view, words))
        blocks.append(_measure_table(protocol, view, words))
    return "\n\n".join(block for block in blocks if block)


def _landmark_table(protocol_id: str, view: str, words: dict[str, str]) -> str:
    rows = [f"| {words['number']} | {words['landmark']} |", "|---:|---|"]
    rows += [f"| {one.number} | {one.landmark.name.text} |" for one in numbered(protocol_id, view)]
    return "\n".join(rows)


def _measure_table(protocol: Protocol, view: str, words: dict[str, str]) -> str:
    measures = [one for one in protocol.measures_of(view) if not one.is_one_of_all]
    if not measures:
        return ""
    rows = [
        f"| {words['measure']} | {words['positive']} | {words['others']} |",
        "|---|---|---|",
        *(_row(one, words) for one in measures),
    ]
    return "\n".join(rows)


def _row(measure: MeasureDefinition, words: dict[str, str]) -> str:
    positive = measure.positive.text if measure.positive else words["unsigned"]
    others = "<br>".join(_references(measure, words))
    return f"| {measure.name.text} (`{measure.measure_id}`) | {positive} | {others} |"


def _references(measure: MeasureDefinition, words: dict[str, str]) -> Iterator[str]:
    sign = UNIT_SIGNS.get(measure.unit, f" {measure.unit}")
    for one in measure.references:
        yield f"{_value(one, sign)}: {one.who}{_remark(one, words)} ({one.source})"


def _value(reference: ReferenceValue, sign: str) -> str:
    sd = "" if reference.sd is None else f" ± {decimal_text(reference.sd, 1)}"
    return f"{decimal_text(reference.mean, 1)}{sd}{sign}"


def _remark(reference: ReferenceValue, words: dict[str, str]) -> str:
    return f"; {words['convention']}" if reference.kind == CONVENTION else ""
