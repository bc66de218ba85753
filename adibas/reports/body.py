"""The report on a body's surface: the back in numbers and pictures."""

from pathlib import Path

from adibas.pipeline.body import MeasuredBody

BODY_KINDS = (".xlsx", ".pdf")


def write_body(body: MeasuredBody, path: Path, language: str) -> None:
    """Write the format that the file's ending, one of `BODY_KINDS`, names.

    Raises
    ------
    ValueError
        Another ending.
    FileError
        The disk is full, or the folder cannot be written.
    """
    match path.suffix.lower():
        case ".xlsx":
            from adibas.reports.body_excel import write_body_workbook

            write_body_workbook(body, path, language)
        case ".pdf":
            from adibas.reports.body_pdf import write_body_pdf

            write_body_pdf(body, path, language)
        case suffix:
            raise ValueError(f"no report of a body ends in {suffix!r}")
