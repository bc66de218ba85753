"""Where protocols are found: those that come with the program, the user's own, and any file."""

from contextlib import suppress
from pathlib import Path

import platformdirs

from adibas.data.protocols import Protocol, Wording
from adibas.errors import ProtocolError
from adibas.measures.protocol_file import load_protocol
from adibas.resources import resource_path

ENDING = ".json"


def own_folder() -> Path:
    """Return the folder of this user's protocols; it need not exist."""
    return platformdirs.user_data_path("adibas", appauthor=False) / "protocols"


def protocol_files() -> dict[str, Path]:
    """Return the files of all protocols by the name of the file; own ones hide no shipped one."""
    folders = (own_folder(), resource_path("protocols"))
    return {
        path.stem: path
        for folder in folders
        if folder.is_dir()
        for path in sorted(folder.glob(f"*{ENDING}"))
    }


def protocol_titles() -> tuple[tuple[str, Wording], ...]:
    """Return name and title of every protocol that can be read, by name."""
    titles = []
    for name, path in sorted(protocol_files().items()):
        with suppress(ProtocolError):
            titles.append((name, load_protocol(path).title))
    return tuple(titles)


def find_protocol(name: str) -> Protocol:
    """Return a protocol by its name, or by the path of its file.

    Raises
    ------
    ProtocolError
        There is none of that name, or its file has a mistake.
    """
    if name.lower().endswith(ENDING):
        return load_protocol(Path(name))
    files = protocol_files()
    if name not in files:
        raise ProtocolError(
            "No protocol is named {name}. Known are: {names}. Or give the name of a protocol file.",
            name=name,
            names=", ".join(sorted(files)),
        )
    return load_protocol(files[name])
