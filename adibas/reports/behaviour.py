"""An analysis of behaviour on paper."""

from pathlib import Path

from adibas.pipeline.behaviour import BehaviourAnalysis

BEHAVIOUR_KINDS = (".xlsx", ".csv")


def write_behaviour(analysis: BehaviourAnalysis, path: Path, language: str) -> None:
    """Write the format that the file's ending, one of `BEHAVIOUR_KINDS`, names.

    A CSV holds what the program saw as a coding, to be read beside that of an observer.

    Raises
    ------
    ValueError
        Another ending.
    FileError
        The disk is full, or the folder cannot be written.
    """
    match path.suffix.lower():
        case ".xlsx":
            from adibas.reports.behaviour_excel import write_behaviour_workbook

            write_behaviour_workbook(analysis, path, language)
        case ".csv":
            from adibas.recordings.coding_csv import write_coding_csv

            write_coding_csv(path, [analysis.detected])
        case suffix:
            raise ValueError(f"no report of behaviour ends in {suffix!r}")
