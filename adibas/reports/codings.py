"""Codings into whatever file an observer's program reads."""

from collections.abc import Sequence
from pathlib import Path

from adibas.data.coding import Coding
from adibas.errors import BehaviourError
from adibas.files import check_place
from adibas.recordings.boris_tables import write_boris_table
from adibas.recordings.boris_writing import write_boris
from adibas.recordings.coding_csv import write_coding_csv
from adibas.recordings.codings import CODING_KINDS
from adibas.recordings.elan_writing import write_elan


def write_codings(path: Path, codings: Sequence[Coding], language: str) -> tuple[Path, ...]:
    """Write codings in the format that the file's ending, one of `CODING_KINDS`, names.

    An ELAN file holds one session: of several each gets a file, ``NAME-1.eaf`` and so on.

    Raises
    ------
    BehaviourError
        Another ending, nothing to write, or codings that do not fit in one file.
    FileError
        The file cannot be written.
    """
    if not codings:
        raise BehaviourError("There is no coding to write. Code a session first.")
    match path.suffix.lower():
        case ".csv":
            write_coding_csv(path, codings)
        case ".tsv":
            write_boris_table(path, codings)
        case ".boris":
            write_boris(path, codings)
        case ".xlsx":
            from adibas.reports.coding_excel import write_coding_excel

            write_coding_excel(path, codings, language)
        case ".eaf":
            return _write_elan(path, codings)
        case _:
            raise BehaviourError(
                "{file} is no coding. Its name must end in one of: {endings}.",
                file=path.name,
                endings=", ".join(CODING_KINDS),
            )
    return (path,)


def _write_elan(path: Path, codings: Sequence[Coding]) -> tuple[Path, ...]:
    paths: tuple[Path, ...] = (path,)
    if len(codings) > 1:
        paths = tuple(
            path.with_name(f"{path.stem}-{number}{path.suffix}")
            for number in range(1, len(codings) + 1)
        )
    for one in paths:
        check_place(one)
    for one, coding in zip(paths, codings, strict=True):
        write_elan(one, coding)
    return paths
