"""DICOM servers of the clinic: named, asked whether they answer, forgotten. Knows nothing of Qt."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from adibas.texts import translate as _
from ui.ports import JobControl
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.exchange.servers import DicomServer

USUAL_PORT, OWN_TITLE = 104, "ADIBAS"


@dataclass(frozen=True, slots=True)
class ServerEntry:
    """A server as typed; see `DicomServer`."""

    name: str = ""
    host: str = ""
    port: int = USUAL_PORT
    title: str = ""
    own_title: str = OWN_TITLE
    is_encrypted: bool = False
    certificates: str = ""


class ServersView(Protocol):
    """The page, as this presenter needs it."""

    def show_servers(self, names: tuple[str, ...], chosen: str) -> None:
        """Offer servers; none chosen: a new one is described."""

    def show_entry(self, entry: ServerEntry) -> None:
        """Show how one is reached."""


class ServersPresenter:
    """The program connects to what stands here and to nothing else."""

    def __init__(self, view: ServersView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self._servers: dict[str, DicomServer] = {}
        self._chosen = ""
        self._has_entered = False

    def enter(self) -> None:
        """Show the servers there are; later on what is being described stays."""
        if self._has_entered or not self._workspace.attempt(self._read):
            return
        self._has_entered = True
        self._chosen = next(iter(sorted(self._servers)), "")
        self._view.show_servers(tuple(sorted(self._servers)), self._chosen)
        self._view.show_entry(self._entry())

    def choose(self, name: str) -> None:
        """Show a server, or an empty description for a new one."""
        self._chosen = name
        self._view.show_entry(self._entry())

    def save(self, entry: ServerEntry) -> None:
        """Name a server, in place of the one that is shown."""
        server = self._described(entry)
        if server is None:
            return
        name = entry.name.strip()

        def save() -> None:
            self._read()
            others = {one: known for one, known in self._servers.items() if one != self._chosen}
            self._write({**others, name: server})

        if self._workspace.attempt(save):
            self._chosen = name
            self._view.show_servers(tuple(sorted(self._servers)), name)
            self._workspace.tell("good", _("{server} is set up.").format(server=name))

    def test(self, entry: ServerEntry) -> None:
        """Ask a server whether it answers, as it is described now."""
        from adibas.exchange.dicom_network import verify
        from adibas.exchange.servers import LISTENERS

        server, name = self._described(entry), entry.name.strip()
        if server is None:
            return

        def work(_control: JobControl) -> None:
            verify(server, name)

        def done(_nothing: None) -> None:
            told = _("{server} answers.").format(server=name)
            if server.is_open_to_listeners:
                listeners = _(LISTENERS).format(server=name)
                self._workspace.tell("warning", f"{told} {listeners}")
            else:
                self._workspace.tell("good", told)

        self._workspace.jobs.start(_("Asking the DICOM server"), work, done)

    def remove(self) -> None:
        """Forget the server that is shown."""
        name = self._chosen

        def remove() -> None:
            self._read()
            self._write({one: known for one, known in self._servers.items() if one != name})

        if name and self._workspace.attempt(remove):
            self._chosen = ""
            self._view.show_servers(tuple(sorted(self._servers)), "")
            self._view.show_entry(ServerEntry())
            self._workspace.tell("good", _("{server} is forgotten.").format(server=name))

    def _entry(self) -> ServerEntry:
        server = self._servers.get(self._chosen)
        if server is None:
            return ServerEntry()
        return ServerEntry(
            self._chosen,
            server.host,
            server.port,
            server.title,
            server.own_title,
            server.is_encrypted,
            server.certificates,
        )

    def _described(self, entry: ServerEntry) -> "DicomServer | None":
        """Return what was typed as a server; None where it cannot be one, which is told."""
        from adibas.exchange.servers import DicomServer, can_be_server

        host, title, own_title = (
            text.strip() for text in (entry.host, entry.title, entry.own_title)
        )
        if not entry.name.strip() or not can_be_server(host, entry.port, title, own_title):
            self._workspace.tell(
                "bad",
                _(
                    "A DICOM server needs a name, an address, a port, and titles with 1 to 16 "
                    "letters without accents. Those who run it know them."
                ),
            )
            return None
        return DicomServer(
            host, entry.port, title, own_title, entry.is_encrypted, entry.certificates.strip()
        )

    def _read(self) -> None:
        from adibas.exchange.servers import read_servers, servers_file

        self._servers = read_servers(servers_file())

    def _write(self, servers: "dict[str, DicomServer]") -> None:
        from adibas.exchange.servers import servers_file, write_servers

        write_servers(servers_file(), servers)
        self._servers = servers
