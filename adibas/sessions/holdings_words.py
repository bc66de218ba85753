"""Everything that is held of a patient, in lines under titles, for the window and the commands."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import date, datetime

from adibas.sessions.audit_words import PURPOSE_NAMES, kind_text, subject_text
from adibas.sessions.holdings import (
    HeldBackup,
    HeldCapture,
    HeldConsent,
    HeldFile,
    HeldRecording,
    HeldSession,
    Holdings,
    LeftStore,
)
from adibas.texts import decimal_text, translate_plural
from adibas.texts import translate as _

BYTES_PER_KB, BYTES_PER_MB = 1e3, 1e6
LEAST_MB = 0.1
NS_PER_S = 1e9


@dataclass(frozen=True, slots=True)
class Section:
    """Lines under a title; those of what belongs to a line follow it, indented."""

    title: str
    lines: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Spelling:
    """How a reader is told moments, days and views."""

    moment: Callable[[datetime], str]
    day: Callable[[date], str]
    view: Callable[[str], str]


def plain_spelling() -> Spelling:
    """Return that of the commands: times in UTC, views by their ids."""
    return Spelling(
        moment=lambda time: f"{time:%Y-%m-%d %H:%M} UTC",
        day=lambda day: day.isoformat(),
        view=lambda view: view or "-",
    )


def holdings_sections(held: Holdings, spelling: Spelling) -> tuple[Section, ...]:
    """Say all that is held of a patient, and what the program cannot reach."""
    sections = (
        Section(_("The patient"), tuple(_patient(held, spelling))),
        Section(_("Sessions"), tuple(_sessions(held, spelling))),
        Section(_("Kept for learning"), tuple(_learning(held))),
        Section(_("What left the store"), tuple(_left(held, spelling))),
        Section(_("Backups and copies"), tuple(_backups(held, spelling))),
        Section(_("What can be done"), tuple(_actions(held))),
        Section(_("What the program cannot reach"), tuple(_out_of_reach())),
    )
    return tuple(one for one in sections if one.lines)


def _patient(held: Holdings, spelling: Spelling) -> Iterator[str]:
    if held.gone_utc is not None:
        yield _("Removed for good on {moment}.").format(moment=spelling.moment(held.gone_utc))
    else:
        yield _("In the store since {moment}.").format(moment=spelling.moment(held.since_utc))
    if held.is_deleted:
        yield _("Hidden, not removed.")
    if held.has_identity:
        yield _("Name, birth date and record number.")
    if held.has_notes:
        yield _("Notes on the patient.")
    for consent in held.consents:
        yield _consent(consent, spelling)
    if held.n_log_lines is not None:
        text = translate_plural(
            "{n} line of the audit log under the pseudonym; such lines stay, also after a removal.",
            "{n} lines of the audit log under the pseudonym; such lines stay, also after a "
            "removal.",
            held.n_log_lines,
        )
        yield text.format(n=held.n_log_lines)


def _consent(consent: HeldConsent, spelling: Spelling) -> str:
    purposes = ", ".join(_(PURPOSE_NAMES[one]) for one in consent.purposes)
    given, withdrawn = spelling.moment(consent.given_utc), consent.withdrawn_utc
    if withdrawn is None:
        return _("Consent: {purposes}. Given {given}; it stands.").format(
            purposes=purposes, given=given
        )
    return _("Consent: {purposes}. Given {given}, withdrawn {withdrawn}.").format(
        purposes=purposes, given=given, withdrawn=spelling.moment(withdrawn)
    )


def _sessions(held: Holdings, spelling: Spelling) -> Iterator[str]:
    if not held.sessions:
        yield _("None.")
        return
    for session in held.sessions:
        yield _session(session, spelling)
        for capture in session.captures:
            yield f"    {_capture(capture, spelling)}"
        for recording in session.recordings:
            yield f"    {_recording(recording)}"
    text = translate_plural(
        "{n} sealed file in all, {size}.", "{n} sealed files in all, {size}.", len(held.files)
    )
    yield text.format(n=len(held.files), size=_megabytes(held.size_bytes))


def _session(session: HeldSession, spelling: Spelling) -> str:
    parts = [
        spelling.moment(session.started_utc),
        *([session.operator] if session.operator else []),
        *([_("with notes")] if session.has_notes else []),
        *([_("hidden")] if session.is_deleted else []),
        session.session_id,
    ]
    return "  ".join(parts)


def _capture(capture: HeldCapture, spelling: Spelling) -> str:
    n = capture.n_corrections
    corrections = translate_plural("{n} correction", "{n} corrections", n).format(n=n)
    parts = [
        _("capture: {view}").format(view=spelling.view(capture.view)),
        _("picture {size}").format(size=_size(capture.picture)),
        *([_("surface {size}").format(size=_size(capture.surface))] if capture.surface else []),
        *([corrections] if n else []),
        *([_("hidden")] if capture.is_deleted else []),
    ]
    return ", ".join(parts)


def _recording(recording: HeldRecording) -> str:
    n, n_frames = len(recording.codings), recording.n_frames
    codings = translate_plural("{n} file of codings", "{n} files of codings", n).format(n=n)
    frames = translate_plural("{n} frame", "{n} frames", n_frames).format(n=n_frames)
    seconds = decimal_text(recording.duration_ns / NS_PER_S, 1)
    parts = [
        _("recording: {frames}, {seconds} s").format(frames=frames, seconds=seconds),
        _size(recording.file),
        *([codings] if n else []),
        *([] if recording.is_closed else [_("not finished")]),
    ]
    return ", ".join(parts)


def _size(file: HeldFile) -> str:
    return _("(missing)") if file.size_bytes is None else _megabytes(file.size_bytes)


def _megabytes(size_bytes: int) -> str:
    if size_bytes < LEAST_MB * BYTES_PER_MB:
        return _("{size} kB").format(size=decimal_text(size_bytes / BYTES_PER_KB, 1))
    return _("{size} MB").format(size=decimal_text(size_bytes / BYTES_PER_MB, 1))


def _learning(held: Holdings) -> Iterator[str]:
    n = sum(one.n_corrections for one in held.captures)
    if not n:
        return
    text = translate_plural(
        "{n} correction of a marker, from which the names of markers may be learned.",
        "{n} corrections of markers, from which the names of markers may be learned.",
        n,
    )
    yield text.format(n=n)


def _left(held: Holdings, spelling: Spelling) -> Iterator[str]:
    if held.left is None:
        yield _("The audit log tells, which is for administrators: ask one of them for this list.")
        return
    if not held.left:
        yield _("The audit log knows of nothing.")
    sessions = _sessions_by_id(held)
    for one in held.left:
        yield _left_line(one, sessions.get(one.subject), spelling)


def _sessions_by_id(held: Holdings) -> dict[str, HeldSession]:
    """Return the session of each id that the log may name."""
    found: dict[str, HeldSession] = {}
    for session in held.sessions:
        captures = (one.capture_id for one in session.captures)
        recordings = (one.recording_id for one in session.recordings)
        found |= dict.fromkeys((session.session_id, *captures, *recordings), session)
    return found


def _left_line(left: LeftStore, session: HeldSession | None, spelling: Spelling) -> str:
    subject = subject_text(left.subject)
    if session is not None:
        subject = _("session of {moment}").format(moment=spelling.moment(session.started_utc))
    parts = [
        spelling.moment(left.time_utc),
        left.operator or "-",
        kind_text(left.kind),
        subject,
        *([left.receiver] if left.receiver else []),
    ]
    return "  ".join(parts)


def _backups(held: Holdings, spelling: Spelling) -> Iterator[str]:
    if held.backups is None:
        yield _("The folder of backups cannot be read. Connect its disk and look again.")
    for one in held.backups or ():
        yield _backup(one, spelling)
    if held.backups_made:
        text = translate_plural(
            "The audit log knows of {n} backup of that time, wherever it is kept: {moments}",
            "The audit log knows of {n} backups of that time, wherever they are kept: {moments}",
            len(held.backups_made),
        )
        moments = ", ".join(spelling.moment(one) for one in held.backups_made)
        yield text.format(n=len(held.backups_made), moments=moments)
    for name in held.copies:
        text = _("Copy of the database in the store's folder: {file}. A removal takes it along.")
        yield text.format(file=name)
    if not held.backups and not held.backups_made and not held.copies:
        yield _("None is known.")


def _backup(backup: HeldBackup, spelling: Spelling) -> str:
    fields = {"file": backup.file, "made": spelling.moment(backup.created_utc)}
    if backup.until is None:
        return _("{file}, made {made}: kept until somebody removes it.").format(**fields)
    return _("{file}, made {made}: kept until {day} at least.").format(
        **fields, day=spelling.day(backup.until)
    )


def _actions(held: Holdings) -> Iterator[str]:
    if held.gone_utc is not None:
        return
    yield _(
        "A withdrawal ends every further capture; what was measured before stays until somebody "
        "removes it."
    )
    if not held.is_deleted:
        yield _("Delete hides the patient in the window, and can be undone.")
    yield _(
        "Remove for good, which is for administrators: tables, pictures, recordings and codings "
        "go, with their keys. Whether the law lets you, or makes you keep the records for years, "
        "is for the clinic to decide."
    )


def _out_of_reach() -> Iterator[str]:
    yield _(
        "Files that left the store, and what others made of them: ask whoever got them. A model "
        "that learned from corrections keeps what it learned."
    )
    yield _(
        "Backups in other places, copies of the whole folder, and a database server's own "
        "backups: remove them, or wait until they are replaced. A backup that is restored into "
        "this store does not bring back who was removed here for good."
    )
