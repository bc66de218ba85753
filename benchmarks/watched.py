"""Runs a module, and writes down every attempt to reach a network and every file it removed.

``python -m benchmarks.watched NOTES MODULE ARGUMENTS`` appends lines to NOTES: ``network`` and what
was tried, or ``removed`` and a file that held one of the texts in ``ADIBAS_WATCHED`` (lines).
"""

import os
import runpy
import sys
from pathlib import Path
from typing import Any

SOCKETS = ("connect", "bind", "sendto", "sendmsg")
NAMES = ("getaddrinfo", "gethostbyname", "gethostbyaddr")
LIBRARIES = ("urllib.Request", "http.client.connect", "ftplib.connect", "smtplib.connect")
NETWORK = frozenset((*(f"socket.{one}" for one in (*SOCKETS, *NAMES)), *LIBRARIES))
LEAVING = ("os.remove", "os.rename", "shutil.rmtree")


def main() -> None:
    """Watch and run."""
    notes = os.open(sys.argv[1], os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)
    secrets = [text.encode() for text in os.environ.get("ADIBAS_WATCHED", "").split("\n") if text]
    sys.argv = sys.argv[2:]

    def watch(event: str, arguments: tuple[Any, ...]) -> None:
        if event in NETWORK and not _is_local(arguments):
            os.write(notes, f"network {event} {_told(arguments)}\n".encode())
        elif event in LEAVING and arguments and isinstance(arguments[0], (str, os.PathLike)):
            for path in _files(Path(arguments[0])):
                if any(text in path.read_bytes() for text in secrets):
                    os.write(notes, f"removed {path}\n".encode())

    sys.addaudithook(watch)
    runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)


def _told(arguments: tuple[Any, ...]) -> str:
    return repr([one for one in arguments if isinstance(one, (str, bytes, int, tuple))])


def _is_local(arguments: tuple[Any, ...]) -> bool:
    """Say whether this is a socket of the computer's own file system."""
    return any(isinstance(one, (str, bytes)) and str(one).startswith(("/", "b'/", "b'\\x00"))
               for one in arguments[1:2])  # fmt: skip


def _files(path: Path) -> list[Path]:
    if path.is_file() and not path.is_symlink():
        return [path]
    return [one for one in path.rglob("*") if one.is_file()] if path.is_dir() else []


if __name__ == "__main__":
    main()
