"""Numbers on paper: Excel, CSV and JSON."""

from pathlib import Path

from adibas.data.posture import PostureAnalysis


def write_posture_report(analysis: PostureAnalysis, path: Path) -> None:
    """Write the format that the file's ending names: ``.xlsx`` or ``.csv``.

    Raises
    ------
    ValueError
        Another ending.
    FileError
        The disk is full, or the folder cannot be written.
    """
    match path.suffix.lower():
        case ".xlsx":
            from adibas.reports.excel import write_posture_workbook

            write_posture_workbook(analysis, path)
        case ".csv":
            from adibas.reports.csv_report import write_posture_csv

            write_posture_csv(analysis, path)
        case suffix:
            raise ValueError(f"no report ends in {suffix!r}")
