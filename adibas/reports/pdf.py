"""The PDF report of a session: a page that sums up, then every view with picture and numbers."""

from pathlib import Path

from reportlab.platypus import Flowable, PageBreak

from adibas.data.report import SessionReport
from adibas.files import written_whole
from adibas.reports.facts import (
    calibration_age,
    calibration_text,
    capture_facts,
    capture_names,
    comparison_facts,
    general_facts,
    intended_use,
    notices,
    protocol_facts,
    session_facts,
)
from adibas.reports.pdf_changes import change_flowables
from adibas.reports.pdf_document import encoded_document
from adibas.reports.pdf_layout import facts_table, note, picture_row, title, wrapped_table
from adibas.reports.pdf_views import ViewPage, view_flowables
from adibas.reports.pictures import draw_markers, picture_of
from adibas.texts import message
from adibas.texts import translate as _

PICTURE_HEIGHT_PX = 1100
HEADING = message("Posture report")


def write_pdf(report: SessionReport, path: Path) -> None:
    """Write the summary, and for every view its picture, markers, free measures and distances.

    The angles of all triplets would fill dozens of pages; they are in the Excel report, and the
    page says so.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    ReportError
        The pictures cannot be as the report asks.
    """
    encoded = encoded_pdf(report)
    with written_whole(path) as unfinished:
        unfinished.write_bytes(encoded)


def encoded_pdf(report: SessionReport) -> bytes:
    """Return the bytes that `write_pdf` writes: nothing of the patient touches the disk.

    Raises
    ------
    ReportError
        The pictures cannot be as the report asks.
    """
    return encoded_document(
        report.language,
        report.version,
        HEADING,
        lambda: (_story(report), _footer(report)),
    )


def _story(report: SessionReport) -> list[Flowable]:
    pages = [
        ViewPage(
            name,
            capture,
            draw_markers(
                picture_of(capture.analysis, report.pictures, report.rotation_deg, is_cropped=True),
                PICTURE_HEIGHT_PX,
            ),
            report.rotation_deg,
        )
        for name, capture in zip(capture_names(report), report.captures, strict=True)
    ]
    story: list[Flowable] = [
        title(_(HEADING)),
        facts_table([*session_facts(report), *comparison_facts(report), *general_facts(report)]),
        picture_row([(page.name, page.picture_rgb) for page in pages]),
    ]
    story += [title(_("Views"), level=2), _views_table(report)]
    for page in pages:
        told = [*protocol_facts(page.capture.analysis), *notices(page.capture.analysis)]
        story += [title(page.name, level=2), facts_table(told)] if told else []
    story.append(
        note(_("Positions are in the axes of the colour camera: x right, y down, z ahead."))
    )
    story += change_flowables(report)
    for page in pages:
        story += [PageBreak(), *view_flowables(page)]
    return story


def _views_table(report: SessionReport) -> Flowable:
    """Return a line for each view: when, how many markers, on what calibration."""
    lines = [capture_facts(report, capture) for capture in report.captures]
    header = [name for name, _value in lines[0]]
    names = capture_names(report)
    cells = [
        [name, *(str(value) for _name, value in line[1:])]
        for name, line in zip(names, lines, strict=True)
    ]
    return wrapped_table(header, cells)


def _footer(report: SessionReport) -> tuple[str, str]:
    """Return the two lines under every page."""
    calibrations = {
        (calibration_text(capture.analysis), calibration_age(report, capture.analysis))
        for capture in report.captures
    }
    if len(calibrations) > 1:
        calibration = _("several calibrations, see the summary")
    else:
        text, age = calibrations.pop()
        calibration = _("calibration {calibration}, {age}").format(
            calibration=text or _("not known"), age=age or _("age not known")
        )
    return intended_use(), f"ADiBAS {report.version} · {calibration}"
