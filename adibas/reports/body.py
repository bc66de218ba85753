"""The report on a body's surface: body and back in numbers and pictures."""

from pathlib import Path

from adibas.data.sessions import Session
from adibas.errors import ReportError
from adibas.pipeline.body import MeasuredBody
from adibas.pipeline.stored_body import stored_body
from adibas.progress import Progress
from adibas.sessions import SessionStore
from adibas.sessions.roles import Permission

BODY_KINDS = (".xlsx", ".pdf")


def write_body(body: MeasuredBody, path: Path, language: str) -> None:
    """Write the format that the file's ending, one of `BODY_KINDS`, names.

    Raises
    ------
    ValueError
        Another ending.
    FileError
        The disk is full, or the folder cannot be written.
    """
    match path.suffix.lower():
        case ".xlsx":
            from adibas.reports.body_excel import write_body_workbook

            write_body_workbook(body, path, language)
        case ".pdf":
            from adibas.reports.body_pdf import write_body_pdf

            write_body_pdf(body, path, language)
        case suffix:
            raise ValueError(f"no report of a body ends in {suffix!r}")


def write_stored_body(
    store: SessionStore, session: Session, path: Path, language: str, progress: Progress
) -> None:
    """Write the report on the body in a session's captures; the audit log is told.

    Raises
    ------
    ReportError
        The file has another ending than those of `BODY_KINDS`.
    BodyError
        The captures do not show it.
    StoreError
        A file of them is missing or damaged.
    NotAllowedError
        Reports are for another role.
    FileError
        The disk is full, or the folder cannot be written.
    """
    if path.suffix.lower() not in BODY_KINDS:
        raise ReportError("Reports on the back end in .pdf or .xlsx. Give the file such a name.")
    store.require(Permission.REPORT, session.session_id)
    body = stored_body(store, session, progress)
    store.note_export("body" if body.back is None else "back", session.session_id)
    write_body(body, path, language)
