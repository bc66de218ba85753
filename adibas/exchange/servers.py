"""The DICOM servers that somebody of the clinic named: nothing is ever sent elsewhere.

They stand in a small file of this user, without any patient.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import platformdirs

from adibas.errors import ExchangeError
from adibas.files import cannot_read, written_whole
from adibas.texts import message

FILE = "dicom-servers.json"
FORMAT, VERSION = "adibas-dicom-servers", 1
OWN_TITLE = "ADIBAS"
LONGEST_TITLE = 16
LAST_PORT = 65_535
LOOPBACK = ("localhost", "127.0.0.1", "::1")
LISTENERS = message(
    "What goes to {server} is not encrypted: whoever listens in the network can read it."
)
"""Said of a server that `is_open_to_listeners`."""


@dataclass(frozen=True, slots=True)
class DicomServer:
    """Where a server is, and what both sides are called.

    Attributes
    ----------
    host : str
        Name or address.
    port : int
        Such as 104 or 11112.
    title : str
        Application entity title of the server.
    own_title : str
        What this program calls itself; many servers know their clients by it.
    is_encrypted : bool
        The connection uses TLS, and the server must prove who it is.
    certificates : str
        File with the certificates that are trusted; empty for those of the system.
    """

    host: str
    port: int
    title: str
    own_title: str = OWN_TITLE
    is_encrypted: bool = False
    certificates: str = ""

    def __post_init__(self) -> None:
        if not can_be_server(self.host, self.port, self.title, self.own_title):
            raise ValueError(
                "a server needs a host, a port, and titles of 1 to 16 ASCII characters"
            )

    @property
    def is_open_to_listeners(self) -> bool:
        """Return whether others in the network can read what is sent."""
        return not self.is_encrypted and self.host not in LOOPBACK


def can_be_server(host: str, port: int, title: str, own_title: str) -> bool:
    """Say whether these are a host, a port and the titles of both sides."""
    return bool(host.strip()) and 0 < port <= LAST_PORT and is_title(title) and is_title(own_title)


def is_title(text: str) -> bool:
    """Say whether a text can be an application entity title."""
    is_short = len(text.strip()) > 0 and len(text) <= LONGEST_TITLE
    return is_short and text.isascii() and text.isprintable() and "\\" not in text


def servers_file() -> Path:
    """Return where this user's servers stand."""
    return platformdirs.user_data_path("adibas", appauthor=False) / FILE


def read_servers(path: Path) -> dict[str, DicomServer]:
    """Return the servers of a file by their names; none where there is no file.

    Raises
    ------
    ExchangeError
        The file is damaged.
    FileError
        It cannot be read.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise cannot_read(path, error) from error
    except UnicodeDecodeError as error:
        raise _damaged(path) from error
    try:
        return {str(name): _server(one) for name, one in json.loads(text)["servers"].items()}
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise _damaged(path) from error


def write_servers(path: Path, servers: Mapping[str, DicomServer]) -> None:
    """Write the servers.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    document = {
        "format": FORMAT,
        "version": VERSION,
        "servers": {name: asdict(server) for name, server in sorted(servers.items())},
    }
    with written_whole(path) as unfinished:
        unfinished.write_text(json.dumps(document, indent=1), encoding="utf-8")


def find_server(path: Path, name: str) -> DicomServer:
    """Return a server by its name.

    Raises
    ------
    ExchangeError
        Nobody named one so, or the file is damaged.
    FileError
        The file cannot be read.
    """
    servers = read_servers(path)
    if name not in servers:
        raise ExchangeError(
            "There is no DICOM server called {name}. Name one with: adibas export server {name} "
            "--host HOST --port PORT --title TITLE",
            name=name,
        )
    return servers[name]


def _server(document: dict[str, Any]) -> DicomServer:
    server = DicomServer(**document)
    for one in fields(DicomServer):
        if type(getattr(server, one.name)) is not one.type:
            raise TypeError(one.name)
    return server


def _damaged(path: Path) -> ExchangeError:
    return ExchangeError(
        "{file} is no list of DICOM servers, or it is damaged. Remove it and name the servers "
        "again.",
        file=path.name,
    )
