"""What leaves the clinic, where to, and as whose: chosen, then handed over. Knows nothing of Qt.

Whatever is chosen, `ExportPresenter._start` is where it leaves.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from adibas.clock import day_here
from adibas.data.report import PictureChoice
from adibas.errors import AdibasError
from adibas.texts import describe, message, translate_plural
from adibas.texts import translate as _
from ui.export.content import ExportChoice, Kind, Shown
from ui.ports import JobControl
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.data.patients import Identity
    from adibas.exchange.handing_over import HandoverWish
    from adibas.exchange.orders import Order
    from adibas.exchange.servers import DicomServer
    from adibas.pipeline.protocol_measuring import ProtocolWish
    from adibas.sessions import SessionStore

CONTENTS: dict[Kind, str] = {
    "fhir": message(
        "One file: every measure with its unit and its 95 % interval, the sensor and its "
        "calibration, and the report as a PDF."
    ),
    "dicom": message(
        "A folder of files: a picture of each view with its markers, the report as a PDF, and the "
        "measures with their intervals."
    ),
    "server": message(
        "The same DICOM files: a picture of each view with its markers, the report as a PDF, and "
        "the measures with their intervals."
    ),
}
PSEUDONYM_ALONE = message(
    "The patient is a pseudonym: no name, birth date, record number, sex or notes go along."
)
NAMED = message(
    "Name, birth date, record number, sex and your notes go along: whoever gets it knows who it is."
)
ORDERED = message(
    "The files answer the order {order}: they belong to its study and carry its patient's name and "
    "birth date."
)
FACE_SEEN = message("The pictures show the face: who knows the patient knows who it is.")
NO_CONSENT = message("There is no consent of this patient on record.")


class ExportView(Protocol):
    """The dialog, as this presenter needs it."""

    def show_session(self, who: str, started_utc: datetime, n_views: int) -> None:
        """Say whose session it is, and which."""

    def show_servers(self, names: tuple[str, ...]) -> None:
        """Offer these; none is set up where there are none."""

    def show_protocols(self, titles: tuple[tuple[str, str], ...]) -> None:
        """Offer protocols by name and title, and the one that the session names."""

    def show_choice(self, shown: Shown) -> None:
        """Show what is chosen, and what follows from it."""

    def close_dialog(self) -> None:
        """Give the window back: the work goes on beside it."""


class ExportPresenter:
    """One session, one choice; the work runs as a job of the window."""

    def __init__(self, view: ExportView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self._servers: dict[str, DicomServer] = {}
        self._choice = ExportChoice(workspace.preferences.now.language)
        self._session_id = ""
        self._stem = ""
        self._has_consent = True
        self._identity: Identity | None = None
        self._problem = ""

    def open(self, session_id: str) -> bool:
        """Show a session and what can be done with it; return whether it is there."""
        return self._workspace.attempt(lambda: self._read(session_id))

    @property
    def proposed_name(self) -> str:
        """What a file would be called: pseudonym and day."""
        return f"{self._stem}.json"

    def choose(self, **changes: object) -> None:
        """Take what the user changed of the choice."""
        self._choice = replace(self._choice, **changes)  # type: ignore[arg-type]
        self._problem = ""
        self._show()

    def take_order(self, order: "Order") -> None:
        """Let the files answer an order, if it is of this patient."""
        from adibas.exchange.orders import check_same_patient

        if self._identity is None:
            return
        try:
            check_same_patient(order, self._identity)
        except AdibasError as error:
            self._problem = describe(error)
            self._show()
        else:
            self.choose(order=order)

    def export_to(self, path: Path) -> None:
        """Write the bundle to a file, or the DICOM files into a new folder in this one."""
        self._workspace.attempt(lambda: self._export_to(path))

    def _export_to(self, path: Path) -> None:
        store, wish, stem = self._workspace.store, self._wish(), self._stem
        if self._choice.kind == "fhir":
            self._start(lambda control: _write_fhir(store, wish, path, control))
        else:
            self._start(lambda control: _write_dicom(store, wish, path, stem, control))

    def send(self) -> None:
        """Send the DICOM files to the chosen server."""
        self._workspace.attempt(self._send)

    def _send(self) -> None:
        from adibas.exchange.handing_over import export_to_server

        name = self._choice.server
        store, wish, server = self._workspace.store, self._wish(), self._servers[name]

        def work(control: JobControl) -> str:
            uids = export_to_server(store, wish, server, name, control.progress)
            told = translate_plural("{server} has {n} file.", "{server} has {n} files.", len(uids))
            return told.format(server=name, n=len(uids))

        self._start(work)

    def _start(self, work: Callable[[JobControl], str]) -> None:
        """Let a session leave, beside the window; the work returns what the user is told."""
        self._view.close_dialog()
        self._workspace.jobs.start(
            _("Exporting the session"),
            work,
            lambda told: self._workspace.tell("good", told),
            stop="tells",
        )

    def _wish(self) -> "HandoverWish":
        from adibas.exchange.handing_over import HandoverWish

        choice = self._choice
        return HandoverWish(
            self._session_id,
            choice.language,
            choice.with_identity,
            choice.pictures,
            _wished_protocol(choice.protocol),
            choice.answered,
        )

    def _read(self, session_id: str) -> None:
        from adibas.exchange.servers import read_servers, servers_file
        from adibas.measures.protocol_store import protocol_titles

        store = self._workspace.store
        session = store.sessions.get(session_id)
        patient = store.patients.get(session.patient)
        self._session_id = session_id
        self._identity = patient.identity
        self._stem = f"{session.patient}_{day_here(session.started_utc)}"
        self._has_consent = any(one.withdrawn_utc is None for one in patient.consents)
        self._view.show_session(
            patient.identity.name, session.started_utc, len(session.capture_ids)
        )
        try:
            self._servers = read_servers(servers_file())
        except AdibasError as error:  # files can be written without
            self._workspace.report_problem(error)
        names = tuple(sorted(self._servers))
        self._choice = replace(self._choice, server=names[0] if names else "")
        self._view.show_servers(names)
        titles = tuple((name, title.text) for name, title in protocol_titles())
        self._view.show_protocols(titles)
        self._show()

    def _show(self) -> None:
        from adibas.exchange.handing_over import shown_pictures

        choice, order = self._choice, self._choice.answered
        tells_who = choice.with_identity or order is not None
        pictures = shown_pictures(choice.pictures, tells_who=tells_who)
        content = [_(CONTENTS[choice.kind])]
        if not tells_who:
            content.append(_(PSEUDONYM_ALONE))
        warnings = tuple(self._warnings(pictures))
        self._view.show_choice(Shown(choice, pictures, tuple(content), warnings))

    def _warnings(self, pictures: PictureChoice) -> Iterator[str]:
        """Yield what the user should know before it leaves."""
        if self._problem:
            yield self._problem
        choice, order = self._choice, self._choice.answered
        if choice.with_identity:
            yield _(NAMED)
        if order is not None:
            yield _(ORDERED).format(order=order.accession_number)
        elif not choice.with_identity and pictures is PictureChoice.AS_IS:
            yield _(FACE_SEEN)
        if not self._has_consent:
            yield _(NO_CONSENT)
        server = self._servers.get(choice.server)
        if choice.kind == "server" and server is not None and server.is_open_to_listeners:
            from adibas.exchange.servers import LISTENERS

            yield _(LISTENERS).format(server=choice.server)


def _wished_protocol(name: str) -> "ProtocolWish | None":
    """Return what to measure by; None: as the session says.

    Raises
    ------
    ProtocolError
        It is gone meanwhile, or has a mistake.
    """
    if not name:
        return None
    from adibas.measures.protocol_store import find_protocol
    from adibas.pipeline.protocol_measuring import ProtocolWish

    return ProtocolWish(find_protocol(name))


def _write_fhir(
    store: "SessionStore", wish: "HandoverWish", path: Path, control: JobControl
) -> str:
    from adibas.exchange.handing_over import export_fhir

    n_observations = export_fhir(store, wish, path, control.progress)
    told = translate_plural("{file}: {n} observation.", "{file}: {n} observations.", n_observations)
    return told.format(file=path.name, n=n_observations)


def _write_dicom(
    store: "SessionStore", wish: "HandoverWish", parent: Path, stem: str, control: JobControl
) -> str:
    """Write into a new folder, so that sessions never mix; return what was written."""
    from adibas.exchange.handing_over import export_dicom
    from adibas.reports.batch import free_path

    folder = free_path(parent, stem, "")
    n_files = len(export_dicom(store, wish, folder, control.progress))
    told = translate_plural(
        "{n} file is written into {folder}.", "{n} files are written into {folder}.", n_files
    )
    return told.format(n=n_files, folder=folder.name)
