"""A movement on paper and in the files of other programs."""

from pathlib import Path

from adibas.data.movement import Movement

MOVEMENT_KINDS = (".xlsx", ".pdf", ".csv", ".c3d", ".trc")


def write_movement(movement: Movement, path: Path, language: str) -> None:
    """Write the format that the file's ending, one of `MOVEMENT_KINDS`, names.

    Raises
    ------
    ValueError
        Another ending.
    ReportError
        The format cannot hold the movement.
    FileError
        The disk is full, or the folder cannot be written.
    """
    match path.suffix.lower():
        case ".xlsx":
            from adibas.reports.movement_excel import write_movement_workbook

            write_movement_workbook(movement, path, language)
        case ".pdf":
            from adibas.reports.movement_pdf import write_movement_pdf

            write_movement_pdf(movement, path, language)
        case ".csv":
            from adibas.reports.movement_json import write_movement_csv

            write_movement_csv(movement, path)
        case ".c3d":
            from adibas.reports.motion_files import write_c3d

            write_c3d(movement, path)
        case ".trc":
            from adibas.reports.motion_files import write_trc

            write_trc(movement, path)
        case suffix:
            raise ValueError(f"no report of a movement ends in {suffix!r}")
