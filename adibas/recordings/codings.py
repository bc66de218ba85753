"""Codings from whatever file an observer's program wrote."""

from pathlib import Path

from adibas.data.coding import Coding
from adibas.data.ethogram import Ethogram
from adibas.errors import BehaviourError
from adibas.recordings.boris_project import read_boris
from adibas.recordings.coding_csv import read_coding_csv
from adibas.recordings.coding_excel import read_coding_excel
from adibas.recordings.elan import read_elan

CODING_KINDS = (".csv", ".tsv", ".xlsx", ".boris", ".eaf")


def read_codings(path: Path, ethogram: Ethogram | None = None) -> tuple[Coding, ...]:
    """Read the codings of a file; its ending, one of `CODING_KINDS`, says which kind it is.

    Parameters
    ----------
    path : Path
    ethogram : Ethogram, optional
        In place of the file's own; every event must fit it.

    Raises
    ------
    BehaviourError
        The file is missing, of another kind, or broken: where, is told.
    """
    match path.suffix.lower():
        case ".csv" | ".tsv":
            return read_coding_csv(path, ethogram)
        case ".xlsx":
            return read_coding_excel(path, ethogram)
        case ".boris":
            return read_boris(path, ethogram)
        case ".eaf":
            return (read_elan(path, ethogram),)
    raise BehaviourError(
        "{file} is no coding. Its name must end in one of: {endings}.",
        file=path.name,
        endings=", ".join(CODING_KINDS),
    )
