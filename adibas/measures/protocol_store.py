"""Where protocols are found: those that come with the program, the user's own, and any file."""

from contextlib import suppress
from itertools import count, islice
from pathlib import Path

import platformdirs

from adibas.data.protocols import Protocol, Wording
from adibas.errors import ProtocolError
from adibas.files import remove_file, written_whole
from adibas.measures.protocol_file import load_protocol, read_protocol
from adibas.resources import resource_path

ENDING = ".json"
NEW_ID = "mine"
EXAMPLE_ID = "example"
"""As it stands in the file."""
UNSAVED = "protocol.json"
"""What a text is called before it has a file."""


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


def protocol_text(name: str) -> str:
    """Return the file of a protocol as it is written, mistakes and all.

    Raises
    ------
    ProtocolError
        There is none of that name, or it cannot be read.
    """
    path = protocol_files().get(name)
    if path is None:
        find_protocol(name)  # tells which there are
    path = path or Path(name)
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ProtocolError(
            "{file} cannot be read: {reason}. Check the name, and that the disk is there.",
            file=path.name,
            reason=getattr(error, "strerror", None) or str(error),
        ) from error


def new_protocol_text() -> str:
    """Return a small protocol without a mistake, to begin a new one with; its id is free."""
    taken = protocol_files()
    numbers = (f"{NEW_ID}-{number}" for number in count(2))
    name = next(one for one in (NEW_ID, *islice(numbers, len(taken) + 1)) if one not in taken)
    text = resource_path("protocol_example.json").read_text(encoding="utf-8")
    return text.replace(EXAMPLE_ID, name, 1)


def save_own_protocol(text: str, opened: str = "") -> Path:
    """Write a protocol into this user's folder, under its id.

    Parameters
    ----------
    opened : str
        Name of the protocol that was changed: that one is replaced, and no other.

    Raises
    ------
    ProtocolError
        It has a mistake, or the id of a protocol that comes with the program, or of another one
        of this user's.
    FileError
        The disk is full, or the folder cannot be written.
    """
    checked = read_protocol(text, UNSAVED)
    if checked.protocol is None:
        raise checked.errors[0]
    name = checked.protocol.protocol_id
    if resource_path("protocols", f"{name}{ENDING}").is_file():
        raise ProtocolError(
            "A protocol named {name} comes with the program and stays as it is. Give yours "
            "another id.",
            name=name,
        )
    path = _own_path(name)
    if name != opened and path.exists():
        raise ProtocolError(
            "There is a protocol named {name} among yours. Open it to change it, or give this one "
            "another id.",
            name=name,
        )
    with written_whole(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")
    return path


def is_own_protocol(name: str) -> bool:
    """Say whether a protocol of that name is among this user's, and not one of the program."""
    return protocol_files().get(name) == _own_path(name)


def delete_own_protocol(name: str) -> None:
    """Remove a protocol of this user's; one that is gone already is no mistake.

    Raises
    ------
    FileError
        The file cannot be removed.
    """
    remove_file(_own_path(name))


def _own_path(name: str) -> Path:
    return own_folder() / f"{name}{ENDING}"
