"""Options with which commands open the patient store."""

import argparse
import getpass
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.options import add_json
from adibas.errors import FileError, PassphraseError, StoreError
from adibas.texts import message
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.sessions import SessionStore
    from adibas.sessions.server_address import ServerAddress

PASSPHRASE_VARIABLE = "ADIBAS_PASSPHRASE"  # noqa: S105  (its name, not its content)
SERVER_PASSWORD_VARIABLE = "ADIBAS_SERVER_PASSWORD"  # noqa: S105  (its name, not its content)
LONGEST_PASSPHRASE = 4096
"""What is longer is no passphrase but some other file, perhaps one without an end."""

NO_TEXT = message("it is no text")
TOO_LONG = message("its first line is too long")


def add_store(parser: argparse.ArgumentParser) -> None:
    """Offer `--store`, `--passphrase-file` and `--json`."""
    add_store_folder(parser)
    parser.add_argument(
        "--passphrase-file",
        type=Path,
        metavar=_("FILE"),
        help=_(
            "file whose first line is the passphrase; without it, where a passphrase is needed, "
            "the environment variable {variable}, or it is asked for"
        ).format(variable=PASSPHRASE_VARIABLE),
    )
    add_json(parser)


def add_store_folder(parser: argparse.ArgumentParser) -> None:
    """Offer `--store`."""
    parser.add_argument(
        "--store",
        type=Path,
        metavar=_("DIR"),
        help=_("folder of the patient store; this user's if not given"),
    )


def open_existing(arguments: argparse.Namespace) -> "SessionStore":
    """Open the store that the options name; none is made.

    From then on `arguments.passphrase` is its passphrase, so that nobody types it twice.

    Raises
    ------
    StoreError
        There is none, or it does not open.
    PassphraseError
        The passphrase is wrong, or is not given where nobody can be asked.
    FileError
        The file of the passphrase cannot be read.
    """
    from adibas.sessions import KeyState, key_state, open_store
    from adibas.sessions.server_address import read_server_file

    folder = store_folder(arguments)
    state = key_state(folder)
    if not any(folder.glob("*.db")) and state in (KeyState.NEW_KEYRING, KeyState.NEW_PASSPHRASE):
        raise StoreError(
            "There is no patient store in {folder}. Give its folder with --store DIR.",
            folder=str(folder),
        )
    passphrase, server = passphrase_of(arguments, folder), read_server_file(folder)
    arguments.passphrase = passphrase
    password = None if server is None else read_server_password(server)
    return open_store(folder, passphrase, operator=user_name(), server_password=password)


def store_folder(arguments: argparse.Namespace) -> Path:
    """Return the folder that `--store` names, or this user's."""
    from adibas.sessions import default_store_folder

    folder: Path = arguments.store or default_store_folder()
    return folder


def passphrase_of(arguments: argparse.Namespace, folder: Path) -> str | None:
    """Return the store's passphrase as it is given; None where it needs none.

    Raises
    ------
    PassphraseError
        It needs one that is not given, and nobody can be asked.
    FileError
        The file of the passphrase cannot be read.
    """
    from adibas.sessions import key_state
    from adibas.sessions.keys import BEHIND_PASSPHRASE

    given = read_passphrase(arguments.passphrase_file)
    if given is not None or key_state(folder) not in BEHIND_PASSPHRASE:
        return given
    given = os.environ.get(PASSPHRASE_VARIABLE)
    if given is None:
        given = ask_passphrase(_("Passphrase of the patient store: "))
    if given is None:
        raise PassphraseError(
            "The patient store is locked. Give a file with --passphrase-file FILE, whose first "
            "line is its passphrase, or set the environment variable {variable}.",
            variable=PASSPHRASE_VARIABLE,
        )
    return given


def ask_passphrase(question: str) -> str | None:
    """Return what somebody types in a terminal, unseen; None where nobody types anything."""
    if sys.stdin is None or not sys.stdin.isatty():
        return None
    try:
        return getpass.getpass(question) or None
    except EOFError:
        return None


def read_server_password(address: "ServerAddress") -> str | None:
    """Return the password of the database's server; in a terminal it is asked for.

    Returns
    -------
    password : str or None
        None where nobody can be asked; a server on this computer may need none.
    """
    from adibas.sessions.server_password import kept_password

    given = os.environ.get(SERVER_PASSWORD_VARIABLE) or kept_password(address)
    if given is None and not address.is_socket:
        question = _("Password of {user} on {server}: ")
        given = ask_passphrase(
            question.format(user=address.user or user_name(), server=address.host)
        )
    return given or None


def read_passphrase(path: Path | None) -> str | None:
    """Return the first line of a file; None where none is named.

    Raises
    ------
    FileError
        It cannot be read, or is no text.
    """
    if path is None:
        return None
    try:
        with path.open(encoding="utf-8-sig") as file:  # Windows' editor begins texts with a mark
            line = file.readline(LONGEST_PASSPHRASE + 1).rstrip("\r\n")
    except (OSError, UnicodeDecodeError) as error:
        raise _no_passphrase(path, getattr(error, "strerror", None) or NO_TEXT) from error
    if len(line) > LONGEST_PASSPHRASE:
        raise _no_passphrase(path, TOO_LONG)
    return line


def _no_passphrase(path: Path, reason: str) -> FileError:
    return FileError(
        "{file} cannot be read: {reason}. Choose a text file whose first line is the passphrase.",
        file=path.name,
        reason=reason,
    )


def user_name() -> str:
    """Return what the computer calls who works; empty for an account without a name."""
    try:
        name = getpass.getuser()
    except (ImportError, KeyError, OSError):  # an account without a name
        return ""
    return name.encode("utf-8", "replace").decode()
