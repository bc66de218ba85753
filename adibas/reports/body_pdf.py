"""The PDF report on body and back: measures, and the pictures on pages of their own."""

from collections.abc import Iterator
from pathlib import Path

from reportlab.platypus import Flowable, PageBreak

from adibas.data.protocol_measures import INSTRUMENT_ONLY
from adibas.pipeline.body import MeasuredBody
from adibas.reports.body_facts import (
    body_facts,
    general_facts,
    has_looks,
    heading_of,
    landmark_rows,
    measure_rows,
)
from adibas.reports.body_look_plots import looks_figure
from adibas.reports.body_plots import back_figure
from adibas.reports.body_protocol import side_rows
from adibas.reports.facts import intended_use, view_name
from adibas.reports.figure_pictures import picture_of
from adibas.reports.pdf_document import write_document
from adibas.reports.pdf_layout import (
    SMALL_TEXT,
    WIDTH,
    facts_table,
    note,
    number_table,
    paragraph,
    picture,
    title,
    wrapped_table,
)
from adibas.reports.pdf_views import MOST_MEASURES, measured, shown_of
from adibas.texts import translate as _

PICTURE_HEIGHT = 420.0


def write_body_pdf(body: MeasuredBody, path: Path, language: str) -> None:
    """Write facts, measures and pictures.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    version = next(iter(body.provenances.values())).version
    write_document(
        path,
        language,
        version,
        heading_of(body),
        lambda: (_story(body), (intended_use(), f"ADiBAS {version}")),
    )


def _story(body: MeasuredBody) -> Iterator[Flowable]:
    heading = heading_of(body)
    yield title(_(heading))
    yield facts_table(body_facts(body))
    rows = measure_rows(body)
    if rows:
        yield title(_("Measures"), level=2)
        header = [
            _("Measure"),
            _("Meaning"),
            _("Value"),
            _("Interval (95 %)"),
            _("Unit"),
            _("Source"),
        ]
        yield wrapped_table(header, rows)
        yield note(
            _(
                "No value is called normal here: whoever compares, compares with a source that "
                "measured the same way."
            )
        )
    yield from _landmarks(body)
    yield from _protocol(body)
    yield title(_("About this report"), level=2)
    yield facts_table(general_facts(body))
    if has_looks(body):
        yield PageBreak()
        yield title(_("The body"), level=2)
        looks = looks_figure(body, WIDTH, PICTURE_HEIGHT)
        yield picture(picture_of(looks), WIDTH, PICTURE_HEIGHT)
    if body.back is not None:
        yield PageBreak()
        yield title(_("The back"), level=2)
        yield picture(
            picture_of(back_figure(body.back, WIDTH, PICTURE_HEIGHT)), WIDTH, PICTURE_HEIGHT
        )


def _landmarks(body: MeasuredBody) -> Iterator[Flowable]:
    """Yield where the landmarks lie, and how well the views agree on them."""
    rows = landmark_rows(body)
    if not rows:
        return
    yield title(_("Landmarks"), level=2)
    header = [
        _("Landmark"),
        _("To the right [mm]"),
        _("Height over the floor [mm]"),
        _("To the back [mm]"),
        _("Views"),
        _("Views apart [mm]"),
    ]
    yield wrapped_table(header, rows)


def _protocol(body: MeasuredBody) -> Iterator[Flowable]:
    """Yield the protocol's measures, as each view and as all views give them."""
    if not body.protocol:
        return
    protocol = body.protocol[0].fused.protocol
    yield title(_("Measures of {protocol}").format(protocol=protocol.title.text), level=2)
    yield note(_(INSTRUMENT_ONLY))
    rows = list(side_rows(body.protocol))
    cells: list[list[str | Flowable]] = []
    for row in rows[:MOST_MEASURES]:
        fused = row.fused
        name = f"{view_name(row.view)}: {fused.name} ({fused.measure_id})"
        told = fused.remark if fused.main is None else fused.positive
        cells.append(
            [
                paragraph(name, SMALL_TEXT),
                *measured(row.seen, fused.unit),
                *measured(fused.main, fused.unit),
                paragraph(told, SMALL_TEXT),
            ]
        )
    header = [_("Measure"), _("In this view"), _("95 %"), _("From all views"), _("95 %"), ""]
    widths = [share * WIDTH for share in (0.29, 0.1, 0.13, 0.16, 0.13, 0.19)]
    yield number_table(header, cells, widths, text_columns=(0, 5))
    yield from shown_of(rows)
