"""Protocols as they were read; a file that changed is read anew."""

from pathlib import Path

from adibas.data.protocols import Protocol
from adibas.errors import ProtocolError
from adibas.measures.protocol_file import load_protocol
from adibas.measures.protocol_store import find_protocol, protocol_files


class KnownProtocols:
    """Reads each protocol once: the one of 1,470 measures takes a while."""

    def __init__(self) -> None:
        self._read: dict[Path, tuple[int, Protocol]] = {}

    def titles(self) -> tuple[tuple[str, str], ...]:
        """Return name and title of every protocol that can be read."""
        titles = []
        for name in sorted(protocol_files()):
            try:
                titles.append((name, self.find(name).title.text))
            except ProtocolError:
                continue
        return tuple(titles)

    def find(self, name: str) -> Protocol:
        """Return a protocol by its name.

        Raises
        ------
        ProtocolError
            There is none of that name, or its file has a mistake.
        """
        path = protocol_files().get(name)
        if path is None:
            return find_protocol(name)
        changed_ns = path.stat().st_mtime_ns
        if path not in self._read or self._read[path][0] != changed_ns:
            self._read[path] = (changed_ns, load_protocol(path))
        return self._read[path][1]
