"""Orders of a work list, one of which is taken. Knows nothing of Qt."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import date, datetime
from typing import TYPE_CHECKING, Protocol

from adibas.errors import AdibasError
from adibas.texts import describe
from adibas.texts import translate as _
from ui.ports import Job, JobControl
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.exchange.orders import Order
    from adibas.exchange.servers import DicomServer


@dataclass(frozen=True, slots=True, repr=False)
class OrderLine:
    """One order: when it is to be done (None: not told), of whom, and what."""

    start: datetime | None
    name: str
    record_number: str
    procedure: str


class OrdersView(Protocol):
    """The dialog, as this presenter needs it."""

    def show_servers(self, names: tuple[str, ...]) -> None:
        """Offer the servers whose work lists can be looked at."""

    def show_looking(self) -> None:
        """Say that the server is being asked."""

    def show_orders(self, lines: tuple[OrderLine, ...]) -> None:
        """Show what is ordered; perhaps nothing."""

    def show_problem(self, sentence: str) -> None:
        """Say why there is no list."""


class OrdersPresenter:
    """Asks one server at a time; `take_over` is given the chosen order."""

    def __init__(
        self,
        view: OrdersView,
        workspace: Workspace,
        take_over: "Callable[[Order], None]",
        today: Callable[[], date] = date.today,
    ) -> None:
        self._view = view
        self._workspace = workspace
        self._take_over = take_over
        self._today = today
        self._servers: dict[str, DicomServer] = {}
        self._orders: tuple[Order, ...] = ()
        self._job: Job | None = None

    def open(self) -> bool:
        """Ask the first server for today; return whether there is one."""
        self._workspace.attempt(self._read)
        names = tuple(sorted(self._servers))
        if not names:
            return False
        self._view.show_servers(names)
        self.look(names[0], is_of_today=True)
        return True

    def look(self, name: str, *, is_of_today: bool) -> None:
        """Ask a server what is ordered for today, or in all."""
        from adibas.exchange.dicom_network import orders

        self.close()
        self._orders = ()
        self._view.show_looking()
        server, day = self._servers[name], self._today() if is_of_today else None

        def work(_control: JobControl) -> "tuple[Order, ...]":
            return orders(server, name, day)

        def failed(error: AdibasError) -> None:
            self._view.show_problem(describe(error))

        self._job = self._workspace.jobs.start(
            _("Looking at the work list"), work, self._show, failed
        )

    def take(self, index: int) -> None:
        """Give the chosen order to who asked for one."""
        self._take_over(self._orders[index])

    def close(self) -> None:
        """Wait for no answer any more."""
        if self._job is not None and self._job.is_running:
            self._job.cancel()

    def _show(self, found: "tuple[Order, ...]") -> None:
        from adibas.exchange.orders import ordered_person, start_of

        self._orders = found
        people = tuple(ordered_person(one) for one in found)
        self._view.show_orders(
            tuple(
                OrderLine(start_of(order), who.name, who.record_number, order.procedure)
                for order, who in zip(found, people, strict=True)
            )
        )

    def _read(self) -> None:
        self._servers = work_list_servers()


def work_list_servers() -> "dict[str, DicomServer]":
    """Return the servers that somebody named.

    Raises
    ------
    AdibasError
        Their list cannot be read.
    """
    from adibas.exchange.servers import read_servers, servers_file

    return read_servers(servers_file())


def has_work_list() -> bool:
    """Say whether any server is named; a list that cannot be read names none."""
    try:
        return bool(work_list_servers())
    except AdibasError:
        return False
