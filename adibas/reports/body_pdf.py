"""The PDF report on the back: measures, and the pictures on a page of their own."""

from collections.abc import Iterator
from pathlib import Path

from reportlab.platypus import Flowable, PageBreak

from adibas.pipeline.body import MeasuredBody
from adibas.reports.body_facts import HEADING, body_facts, general_facts, measure_rows
from adibas.reports.body_plots import back_figure
from adibas.reports.facts import intended_use
from adibas.reports.figure_pictures import picture_of
from adibas.reports.pdf_document import write_document
from adibas.reports.pdf_layout import WIDTH, facts_table, note, picture, title, wrapped_table
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
        HEADING,
        lambda: (_story(body), (intended_use(), f"ADiBAS {version}")),
    )


def _story(body: MeasuredBody) -> Iterator[Flowable]:
    yield title(_(HEADING))
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
    yield title(_("About this report"), level=2)
    yield facts_table(general_facts(body))
    if body.back is not None:
        yield PageBreak()
        yield title(_("The back"), level=2)
        yield picture(
            picture_of(back_figure(body.back, WIDTH, PICTURE_HEIGHT)), WIDTH, PICTURE_HEIGHT
        )
