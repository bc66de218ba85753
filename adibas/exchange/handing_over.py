"""A session leaves the store as FHIR, as DICOM files, or to a server: all ways out are here.

The command and the window call the same functions. What leaves is made first, then noted in the
audit log, and only then written or sent: what the log does not take does not leave.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.data.report import PictureChoice
from adibas.exchange.content import Handover, hand_over
from adibas.exchange.dicom_files import (
    N_DOCUMENTS,
    check_unmixed,
    dicom_datasets,
    dicom_paths,
    remove_dicom,
    write_datasets,
)
from adibas.exchange.fhir_bundle import fhir_bundle, write_bundle
from adibas.exchange.orders import Order, check_same_patient
from adibas.exchange.servers import DicomServer
from adibas.files import check_place
from adibas.pipeline.protocol_measuring import ProtocolWish
from adibas.pipeline.stored_report import ReportWish, stored_report
from adibas.progress import Progress
from adibas.sessions import SessionStore

if TYPE_CHECKING:
    from pydicom import Dataset

N_MAKING = 2
"""Steps before anything is written or sent: the report is read, what leaves is made."""


@dataclass(frozen=True, slots=True)
class HandoverWish:
    """What of a session is wanted elsewhere.

    Attributes
    ----------
    session_id : str
        Of the store.
    language : str
        Two letters.
    with_identity : bool
        Name, birth date, record number, sex and the clinician's notes go along.
    pictures : PictureChoice or None
        How much they show; None: as they are where the person is told, else without a head.
    protocol : ProtocolWish or None
        What to measure; None: the protocol that the session names.
    order : Order or None
        Of a work list, that DICOM files answer.
    """

    session_id: str
    language: str
    with_identity: bool = False
    pictures: PictureChoice | None = None
    protocol: ProtocolWish | None = None
    order: Order | None = None

    @property
    def tells_who(self) -> bool:
        """Return whether the person goes along."""
        return self.with_identity or self.order is not None

    @property
    def shown(self) -> PictureChoice:
        """Return how much pictures show."""
        return shown_pictures(self.pictures, tells_who=self.tells_who)


def shown_pictures(wished: PictureChoice | None, *, tells_who: bool) -> PictureChoice:
    """Return how much pictures show: what is wished, else as fits whether the person is told."""
    if wished is not None:
        return wished
    return PictureChoice.AS_IS if tells_who else PictureChoice.BLURRED


def prepare(store: SessionStore, wish: HandoverWish) -> Handover:
    """Return a session with as much of the patient as is wished.

    Raises
    ------
    AdibasError
        The session is gone or has no captures, or the order is of another patient.
    """
    session = store.sessions.get(wish.session_id)
    if wish.order is not None:
        check_same_patient(wish.order, store.patients.get(session.patient).identity)
    report_wish = ReportWish(
        wish.language, wish.shown, wish.protocol, with_notes=wish.with_identity
    )
    report = stored_report(store, session.session_id, report_wish)
    person = store.patients.get(session.patient) if wish.with_identity else None
    return hand_over(session.session_id, report, person, wish.order)


def export_fhir(
    store: SessionStore, wish: HandoverWish, path: Path, progress: Progress | None = None
) -> int:
    """Write a session as a FHIR bundle and return how many observations are in it.

    Parameters
    ----------
    store : SessionStore
        Its audit log gets a line.
    wish : HandoverWish
        What leaves; a bundle answers no order.
    path : Path
        What stands there is replaced.
    progress : callable, optional
        Called with (steps done, steps in all). Where it raises, nothing more is written.

    Raises
    ------
    AdibasError
        The session or its pictures cannot be as wished, the log takes no line, or the file
        cannot be written.
    """
    check_place(path)
    steps = _Steps(progress, N_MAKING + 1)
    handover = prepare(store, wish)
    steps.advance()
    bundle = fhir_bundle(handover)
    steps.advance()
    _note(store, "fhir", handover)
    n_observations = write_bundle(bundle, path)
    steps.advance()
    return n_observations


def export_dicom(
    store: SessionStore,
    wish: HandoverWish,
    folder: Path,
    progress: Progress | None = None,
    *,
    can_replace: bool = False,
) -> list[Path]:
    """Write a session as DICOM files into a folder and return their paths; see `export_fhir`.

    A folder that holds DICOM files is refused, unless those of an earlier export may be replaced:
    all of them go then, also where the one before had more pictures.
    """
    if not can_replace:
        check_unmixed(folder)
    handover = prepare(store, wish)
    for path in dicom_paths(handover, folder):
        check_place(path)
    steps, datasets = _made(handover, progress)
    _note(store, "dicom", handover)
    if can_replace:
        remove_dicom(folder)
    return write_datasets(datasets, folder, steps.advance)


def export_to_server(
    store: SessionStore,
    wish: HandoverWish,
    server: DicomServer,
    name: str,
    progress: Progress | None = None,
) -> list[str]:
    """Send a session to a DICOM server that somebody named; return the UIDs of its files.

    Raises
    ------
    AdibasError
        As of `export_fhir`; or the server cannot be reached, refuses, or did not take all.
    """
    from adibas.exchange.dicom_network import send

    handover = prepare(store, wish)
    steps, datasets = _made(handover, progress)
    # First: a connection that breaks has sent something.
    _note(store, "dicom server", handover, receiver=f"{server.title} ({server.host})")
    send(server, name, datasets, lambda _done, _total: steps.advance())
    return [str(one.SOPInstanceUID) for one in datasets.values()]


def _made(handover: Handover, progress: Progress | None) -> "tuple[_Steps, dict[str, Dataset]]":
    """Return the DICOM files of a session, and what counts the steps with them."""
    n_files = len(handover.report.captures) + N_DOCUMENTS
    steps = _Steps(progress, N_MAKING + n_files)
    steps.advance()
    datasets = dicom_datasets(handover)
    steps.advance()
    return steps, datasets


def _note(store: SessionStore, kind: str, handover: Handover, receiver: str = "") -> None:
    """Write into the audit log what leaves the clinic, and whether it says who it is."""
    told = f"{kind}, with identity" if handover.tells_who else kind
    store.note_export(told, handover.session_id, receiver=receiver)


class _Steps:
    """Tells of one step after the other."""

    def __init__(self, progress: Progress | None, n_steps: int) -> None:
        self._progress = progress
        self._n_done, self._n_steps = 0, n_steps

    def advance(self) -> None:
        """Note that one more is done."""
        self._n_done += 1
        if self._progress is not None:
            self._progress(self._n_done, self._n_steps)
