"""Numbers on paper: Excel, PDF, CSV and JSON."""

from pathlib import Path

from adibas.data.report import SessionReport

KINDS = (".xlsx", ".pdf", ".csv", ".json")


def write_report(report: SessionReport, path: Path) -> None:
    """Write the format that the file's ending, one of `KINDS`, names.

    Raises
    ------
    ValueError
        Another ending.
    ReportError
        The pictures cannot be as the report asks.
    FileError
        The disk is full, or the folder cannot be written.
    """
    match path.suffix.lower():
        case ".xlsx":
            from adibas.reports.excel import write_workbook

            write_workbook(report, path)
        case ".pdf":
            from adibas.reports.pdf import write_pdf

            write_pdf(report, path)
        case ".csv":
            from adibas.reports.csv_report import write_csv

            write_csv(report, path)
        case ".json":
            from adibas.reports.json_report import write_json

            write_json(report, path)
        case suffix:
            raise ValueError(f"no report ends in {suffix!r}")
