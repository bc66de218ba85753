"""The report of a calibration on paper: Excel and PDF."""

from pathlib import Path

from adibas.data.calibration_report import CalibrationReport

KINDS = (".xlsx", ".pdf")


def write_calibration_report(report: CalibrationReport, path: Path) -> None:
    """Write the format that the file's ending, one of `KINDS`, names.

    Raises
    ------
    ValueError
        Another ending.
    FileError
        The disk is full, or the folder cannot be written.
    """
    match path.suffix.lower():
        case ".xlsx":
            from adibas.reports.calibration_excel import write_calibration_workbook

            write_calibration_workbook(report, path)
        case ".pdf":
            from adibas.reports.calibration_pdf import write_calibration_pdf

            write_calibration_pdf(report, path)
        case suffix:
            raise ValueError(f"no report of a calibration ends in {suffix!r}")
