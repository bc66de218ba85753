"""Where the database of a store is that several workstations share; it holds no password.

`server.json` in the store's folder names it, so that every workstation that opens the folder finds
the same server.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, quote, unquote, urlsplit

from adibas.errors import StoreError
from adibas.files import written_whole
from adibas.sessions.lock import cannot_use
from adibas.texts import message

SERVER_FILE = "server.json"
FORMAT, VERSION = "adibas-server", 1
SCHEMES = ("postgresql", "postgres")
DEFAULT_PORT = 5432
LOOPBACK = ("localhost", "127.0.0.1", "::1")
ENCRYPTED = ("verify-full", "verify-ca", "require")
"""What `sslmode` may be to another computer: with its certificate checked, or only encrypted."""
OPEN = "disable"
"""Without TLS; to another computer only where somebody says so."""

NO_TEXT = message("it is no text")
NO_JSON = message("it is cut short or was changed")
NO_SERVER = message("it names no server")


@dataclass(frozen=True, slots=True)
class ServerAddress:
    """A database on a PostgreSQL server.

    Attributes
    ----------
    host : str
        Name or number of the computer, or the folder of a socket (``/run/postgresql``).
    port : int
    database : str
    user : str
        Of the server; empty = the name of whoever is logged in.
    sslmode : str
        As libpq names it; empty = TLS with the certificate checked, and to this very computer
        whatever the server offers.
    sslrootcert : str
        File with the certificate that the server's own is checked against; empty = what this
        computer trusts.
    """

    host: str
    port: int
    database: str
    user: str = ""
    sslmode: str = ""
    sslrootcert: str = ""

    def __str__(self) -> str:
        user = f"{quote(self.user, safe='')}@" if self.user else ""
        host = quote(self.host, safe="") if self.is_socket else self.host
        host = f"[{host}]" if ":" in host else host
        settings = [
            f"{name}={quote(value, safe='/')}"
            for name, value in (("sslmode", self.sslmode), ("sslrootcert", self.sslrootcert))
            if value
        ]
        query = f"?{'&'.join(settings)}" if settings else ""
        database = quote(self.database, safe="")
        return f"postgresql://{user}{host}:{self.port}/{database}{query}"

    @property
    def is_socket(self) -> bool:
        """Whether it is reached through a file of this computer."""
        return self.host.startswith("/")

    @property
    def is_here(self) -> bool:
        """Whether nothing goes over a network."""
        return self.is_socket or self.host in LOOPBACK

    def connection(self) -> dict[str, Any]:
        """Return what libpq is told, without the password."""
        told: dict[str, Any] = {
            "host": self.host,
            "port": self.port,
            "dbname": self.database,
            "sslmode": self.sslmode or ("prefer" if self.is_here else "verify-full"),
        }
        if self.user:
            told["user"] = self.user
        if self.sslrootcert:
            told["sslrootcert"] = self.sslrootcert
        elif told["sslmode"] == "verify-full":
            told["sslrootcert"] = "system"
        return told


def parse_address(text: str) -> ServerAddress:
    """Return what an address such as ``postgresql://adibas@server/adibas`` says.

    Raises
    ------
    StoreError
        It is none, or holds a password, or leaves the way to another computer open by chance. The
        text itself is not told: it may hold a password.
    """
    try:
        parts = urlsplit(text.strip())
        port = parts.port or DEFAULT_PORT
    except ValueError as error:
        raise _no_address() from error
    if parts.scheme not in SCHEMES or not parts.hostname:
        raise _no_address()
    if parts.password is not None:
        raise StoreError(
            "A password has no place in the address of the server, where everybody reads it. Leave "
            "it out; it is asked for, or taken from the desktop's keyring."
        )
    settings = parse_qs(parts.query, strict_parsing=False, keep_blank_values=True)
    if set(settings) - {"sslmode", "sslrootcert"} or not unquote(parts.path.strip("/")):
        raise _no_address()
    host = _host(parts.netloc) or parts.hostname
    address = ServerAddress(
        host,
        port,
        unquote(parts.path.strip("/")),
        unquote(parts.username or ""),
        settings.get("sslmode", [""])[-1],
        settings.get("sslrootcert", [""])[-1],
    )
    if address.sslmode not in ("", OPEN, *ENCRYPTED):
        raise StoreError(
            "{mode} leaves it to chance whether others can listen. Give sslmode=verify-full, "
            "verify-ca or require; or disable, where the network is safe by other means.",
            mode=f"sslmode={address.sslmode}",
        )
    return address


def read_server_file(folder: Path) -> ServerAddress | None:
    """Return the server of the store in `folder`; None where its database is a file.

    Raises
    ------
    StoreError
        The folder cannot be used, or `server.json` is damaged or of a later version.
    """
    try:
        text = (folder / SERVER_FILE).read_text(encoding="utf-8")
    except FileNotFoundError:
        return None
    except OSError as error:
        raise cannot_use(folder, error) from error
    except UnicodeDecodeError as error:
        raise _damaged(NO_TEXT) from error
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise _damaged(NO_JSON) from error
    is_ours = isinstance(document, dict) and document.get("format") == FORMAT
    if not is_ours or not isinstance(document.get("address"), str):
        raise _damaged(NO_SERVER)
    if document.get("version") != VERSION:
        raise StoreError(
            "{file} of the patient store was made by a later version of ADiBAS. Update the "
            "program.",
            file=SERVER_FILE,
        )
    return parse_address(document["address"])


def write_server_file(folder: Path, address: ServerAddress) -> None:
    """Write `server.json`, whole or not at all.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    document = {"format": FORMAT, "version": VERSION, "address": str(address)}
    with written_whole(folder / SERVER_FILE) as path:
        path.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")


def _host(netloc: str) -> str:
    """Return the host with its capitals, which matter in the name of a folder."""
    host = netloc.rpartition("@")[2]
    return "" if host.startswith("[") else unquote(host.partition(":")[0])


def _no_address() -> StoreError:
    return StoreError(
        "That is no address of a database. Give it like postgresql://USER@SERVER/DATABASE, with "
        "?sslmode= or ?sslrootcert= where the server needs it."
    )


def _damaged(reason: str) -> StoreError:
    return StoreError(
        "{file} of the patient store cannot be used: {reason}. Restore it from a backup, or write "
        "it anew.",
        file=SERVER_FILE,
        reason=reason,
    )
