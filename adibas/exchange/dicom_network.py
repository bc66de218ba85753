"""Speaks to a DICOM server that somebody named: is it there, take this, what is ordered.

Source: DICOM PS3.4, annexes A (verification), B (storage) and K (modality worklist).
"""

import socket
import ssl
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import date
from typing import TYPE_CHECKING

from adibas.errors import ExchangeError
from adibas.exchange.orders import Order
from adibas.exchange.servers import DicomServer
from adibas.progress import Progress

if TYPE_CHECKING:
    from pydicom import Dataset
    from pynetdicom.association import Association

CONNECT_S, ANSWER_S = 10.0, 60.0
ATTEMPTS = 2
"""pynetdicom loses a refusal at times where the server hangs up at once, on a busy computer."""
"""How long a server may take to open a connection, and to answer."""
VERIFICATION, WORK_LIST = "1.2.840.10008.1.1", "1.2.840.10008.5.1.4.31"
"""SOP classes of a question without content, and of the modality worklist."""
SUCCESS = 0x0000
PENDING = (0xFF00, 0xFF01)
WARNINGS = range(0xB000, 0xC000)
"""The server took it, and changed or missed something."""
MOST_ORDERS = 1000


def verify(server: DicomServer, name: str) -> None:
    """See that a server answers.

    Raises
    ------
    ExchangeError
        It cannot be reached, refuses, or fails.
    """
    with _associated(server, name, [VERIFICATION]) as association:
        status = association.send_c_echo().get("Status")
    if status != SUCCESS:
        raise _failed(name, status)


def send(
    server: DicomServer,
    name: str,
    datasets: "Mapping[str, Dataset]",
    progress: Progress | None = None,
) -> None:
    """Let a server keep the files of a session.

    Parameters
    ----------
    server : DicomServer
        Somebody of the clinic named it.
    name : str
        Its name, for errors.
    datasets : mapping
        The files by what they are called in errors; see `dicom_datasets`.
    progress : callable, optional
        Called with (files sent, files in all).

    Raises
    ------
    ExchangeError
        It cannot be reached, refuses, or did not take all; what it has then is told.
    """
    kinds = sorted({str(one.SOPClassUID) for one in datasets.values()})
    with _associated(server, name, kinds) as association:
        accepted = {str(one.abstract_syntax) for one in association.accepted_contexts}
        for n_sent, (file, dataset) in enumerate(datasets.items()):
            if str(dataset.SOPClassUID) not in accepted:
                raise ExchangeError(
                    "{server} does not keep files such as {file}; {n} files are there. Ask those "
                    "who run it to accept {kind}.",
                    server=name,
                    file=file,
                    n=n_sent,
                    kind=dataset.SOPClassUID.name,
                )
            status = association.send_c_store(dataset).get("Status")
            if status != SUCCESS and status not in WARNINGS:
                raise _failed(name, status)
            if progress is not None:
                progress(n_sent + 1, len(datasets))


def orders(
    server: DicomServer, name: str, day: date | None = None, accession_number: str = ""
) -> tuple[Order, ...]:
    """Return what a work list holds for a day, of an order, or in all.

    Raises
    ------
    ExchangeError
        It cannot be reached, refuses, or fails.
    """
    found: list[Order] = []
    with _associated(server, name, [WORK_LIST]) as association:
        answers = association.send_c_find(_question(day, accession_number), WORK_LIST)
        for answer, dataset in answers:
            status = answer.get("Status")
            if status in PENDING and dataset is not None and len(found) < MOST_ORDERS:
                found.append(_order(dataset))
            elif status not in (SUCCESS, *PENDING):
                raise _failed(name, status)
    return tuple(sorted(found, key=lambda one: (one.start, one.accession_number)))


@contextmanager
def _associated(server: DicomServer, name: str, kinds: Sequence[str]) -> "Iterator[Association]":
    """Give a connection on which `kinds` are asked for, and close it."""
    from pydicom.uid import ExplicitVRLittleEndian
    from pynetdicom import AE, _config
    from pynetdicom.presentation import build_context

    # Nothing of a patient goes into a log.
    _config.LOG_REQUEST_IDENTIFIERS = _config.LOG_RESPONSE_IDENTIFIERS = False
    entity = AE(ae_title=server.own_title)
    entity.connection_timeout = entity.acse_timeout = CONNECT_S
    entity.dimse_timeout = entity.network_timeout = ANSWER_S
    contexts = [build_context(kind, [ExplicitVRLittleEndian]) for kind in kinds]
    tls = _tls(server, name)
    _reach(server, name, tls)
    for _attempt in range(ATTEMPTS):
        association = entity.associate(
            server.host,
            server.port,
            contexts,
            ae_title=server.title,
            tls_args=None if tls is None else (tls, server.host),
        )
        if association.is_established or association.is_rejected:
            break
    if not association.is_established:
        raise _refused(association, server, name)
    try:
        yield association
    except RuntimeError as error:  # pynetdicom's word for a connection that the server ended
        raise _unreachable(name) from error
    finally:
        if association.is_established:
            association.release()


def _reach(server: DicomServer, name: str, tls: ssl.SSLContext | None) -> None:
    """See that somebody listens there: pynetdicom does not tell why it fails, nor tidy up."""
    try:
        with socket.create_connection((server.host, server.port), CONNECT_S) as reached:
            if tls is not None:
                tls.wrap_socket(reached, server_hostname=server.host).close()
    except ssl.SSLCertVerificationError as error:
        raise ExchangeError(
            "{server} cannot prove who it is: {reason}. Nothing was sent. Name its certificate in "
            "the settings, or with --certificates.",
            server=name,
            reason=error.verify_message,
        ) from error
    except OSError as error:
        raise _unreachable(name) from error


def _refused(association: "Association", server: DicomServer, name: str) -> ExchangeError:
    """Say why there is no connection."""
    if association.is_rejected:
        return ExchangeError(
            "{server} refuses the connection. Check the titles of both sides; its own list of "
            "clients may need this program's title, {title}.",
            server=name,
            title=server.own_title,
        )
    if association.rejected_contexts:
        return ExchangeError(
            "{server} does not offer what it is asked for. Ask those who run it, or name the "
            "server that does.",
            server=name,
        )
    return _unreachable(name)


def _tls(server: DicomServer, name: str) -> ssl.SSLContext | None:
    if not server.is_encrypted:
        return None
    try:
        return ssl.create_default_context(cafile=server.certificates or None)
    except OSError as error:
        raise ExchangeError(
            "The certificates for {server} cannot be read. Name the file again in the settings, "
            "or with --certificates.",
            server=name,
        ) from error


def _unreachable(name: str) -> ExchangeError:
    return ExchangeError(
        "{server} does not answer. Check its address and port, the network, and whether both "
        "sides use encryption.",
        server=name,
    )


def _failed(name: str, status: int | None) -> ExchangeError:
    """Say that a server failed; without a status it went away."""
    if status is None:
        return _unreachable(name)
    return ExchangeError(
        "{server} failed with the status {status}. Try again, or ask those who run it.",
        server=name,
        status=f"0x{status:04X}",
    )


def _question(day: date | None, accession_number: str) -> "Dataset":
    """Return what is asked of a work list; empty fields are asked back."""
    from pydicom import Dataset

    step = Dataset()
    step.ScheduledProcedureStepStartDate = "" if day is None else day.strftime("%Y%m%d")
    for field in ("ScheduledProcedureStepStartTime", "ScheduledProcedureStepDescription"):
        setattr(step, field, "")
    question = Dataset()
    question.SpecificCharacterSet = "ISO_IR 192"
    question.AccessionNumber = accession_number
    for field in (
        "PatientName",
        "PatientID",
        "PatientBirthDate",
        "PatientSex",
        "StudyInstanceUID",
        "RequestedProcedureID",
        "RequestedProcedureDescription",
    ):
        setattr(question, field, "")
    question.ScheduledProcedureStepSequence = [step]
    return question


def _order(dataset: "Dataset") -> Order:
    steps = dataset.get("ScheduledProcedureStepSequence") or [None]
    step = steps[0]
    day = _text(step, "ScheduledProcedureStepStartDate")
    time = _text(step, "ScheduledProcedureStepStartTime").partition(".")[0]
    procedure = _text(dataset, "RequestedProcedureDescription")
    return Order(
        accession_number=_text(dataset, "AccessionNumber"),
        study_uid=_text(dataset, "StudyInstanceUID"),
        patient_id=_text(dataset, "PatientID"),
        patient_name=_text(dataset, "PatientName"),
        birth_date=_text(dataset, "PatientBirthDate"),
        sex=_text(dataset, "PatientSex"),
        procedure_id=_text(dataset, "RequestedProcedureID"),
        procedure=procedure or _text(step, "ScheduledProcedureStepDescription"),
        start=day + time,
    )


def _text(dataset: "Dataset | None", field: str) -> str:
    value = None if dataset is None else dataset.get(field)
    return "" if value is None else str(value).strip()
