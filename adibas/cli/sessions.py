"""`adibas sessions`: what the patient store holds, out of it, and whether it is whole."""

import argparse
import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from adibas.cli.console import Console
from adibas.cli.options import add_out, add_overwrite, positive_count, refuse_to_replace
from adibas.cli.protocol_options import add_protocol, wished_protocol
from adibas.cli.reliability import add_reliability_arguments, tell_reliability
from adibas.cli.report_options import add_report_options
from adibas.cli.sessions_backup import SOMETHING_FOUND, add_backup_arguments, tell_report
from adibas.cli.sessions_holdings import add_holdings_actions
from adibas.cli.sessions_people import add_people_arguments
from adibas.cli.sessions_recovery import add_recovery_arguments
from adibas.cli.sessions_retention import add_retention_arguments, retain
from adibas.cli.sessions_server import add_server_arguments
from adibas.cli.store_options import add_store, open_existing
from adibas.clock import NS_PER_S
from adibas.errors import StoreError
from adibas.files import check_place, remove_file
from adibas.sessions.audit_words import action_text, subject_text
from adibas.sessions.roles import Permission
from adibas.texts import message, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.data.markers import Marker
    from adibas.data.sessions import Capture, Session
    from adibas.pipeline.stored_report import ReportWish
    from adibas.sessions import AuditEntry, PatientRow, RecordingFacts, SessionStore

SUMMARY = message("list, show, export, verify, back up or purge what the patient store holds")

ALL_PATIENTS = 1_000_000
REPORTS = ("posture.json", "report.xlsx", "report.pdf")
EXPORTED_RECORDING = re.compile(r"recording-\d{2,}\.mcap")

Work = Callable[["SessionStore", argparse.Namespace, Console], int]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    actions = parser.add_subparsers(metavar=_("ACTION"), required=True)

    def add(name: str, summary: str, work: Work) -> argparse.ArgumentParser:
        action = actions.add_parser(name, help=summary, description=summary)
        action.set_defaults(work=work)
        add_store(action)
        return action

    listing = add("list", _("Patients by their pseudonyms, and their sessions."), _list)
    listing.add_argument(
        "--names", action="store_true", help=_("names too, which are left out if not given")
    )
    listing.add_argument("--deleted", action="store_true", help=_("hidden ones too"))
    showing = add("show", _("One session with its captures and markers."), _show)
    exporting = add("export", _("Recordings of a session as plain MCAP, and its report."), _export)
    calling = add(
        "repeat", _("Say that a session repeats the one before it, markers placed anew."), _repeat
    )
    for action in (showing, exporting, calling):
        action.add_argument("session", metavar=_("SESSION"), help=_("its id, as `list` shows it"))
    _add_export_options(exporting)
    repeating = add("reliability", _("How well measures repeat in this clinic."), tell_reliability)
    add_reliability_arguments(repeating)
    calling.add_argument("--no", action="store_true", help=_("it is no repeat"))
    verifying = add("verify", _("Check the database, the audit log and every file."), _verify)
    verifying.add_argument(
        "--entries",
        type=positive_count,
        default=0,
        metavar="N",
        help=_("print the last N lines of the audit log, too"),
    )
    purging = add("purge", _("Remove a patient or a session for good."), _purge)
    purging.add_argument("id", metavar="ID", help=_("a pseudonym or the id of a session"))
    purging.add_argument("--yes", action="store_true", help=_("yes, it cannot be undone"))
    add_holdings_actions(add)

    def add_alone(name: str, summary: str) -> argparse.ArgumentParser:
        return actions.add_parser(name, help=summary, description=summary)

    for add_more in (
        add_backup_arguments,
        add_recovery_arguments,
        add_server_arguments,
        add_people_arguments,
    ):
        add_more(add_alone)
    add_retention_arguments(
        add("retention", _("Patients whose time is over, and when the disk is full."), retain)
    )


def _add_export_options(exporting: argparse.ArgumentParser) -> None:
    add_report_options(exporting)
    add_protocol(exporting)
    exporting.add_argument(
        "--compared-with",
        default="",
        metavar=_("SESSION"),
        help=_("id of an earlier session of the patient: the report tells what changed"),
    )
    exporting.add_argument(
        "--with-notes",
        action="store_true",
        help=_(
            "tell the session's notes where the pictures hide who it is, too; they are left out "
            "then if not given, because people are named in notes"
        ),
    )
    add_out(exporting, _("DIR"), _("folder to write into"))
    add_overwrite(exporting, _("replace what an earlier export left in that folder"))


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Open the store and do what was asked."""
    if "alone" in arguments:
        return int(arguments.alone(arguments, console))
    work: Work = arguments.work
    with open_existing(arguments) as store:
        return work(store, arguments, console)


def _list(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    if arguments.names:
        store.require(Permission.SEE_ALL_NAMES, "patients")
    rows = store.patients.search("", limit=ALL_PATIENTS, with_deleted=arguments.deleted)
    patients = []
    for row in sorted(rows, key=lambda row: row.pseudonym):
        sessions = store.sessions.of_patient(row.pseudonym, with_deleted=arguments.deleted)
        console.say(_line(row, with_name=arguments.names))
        for session in sessions:
            console.say(f"    {_session_line(session)}")
        patients.append(_patient_document(row, sessions, with_name=arguments.names))
    if not rows:
        console.say(_("The patient store is empty."))
    console.give({"patients": patients})
    return 0


def _show(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    session = store.sessions.get(arguments.session)
    captures = store.captures.of_session(session.session_id)
    console.say(f"{session.patient}  {_session_line(session)}")
    for capture in captures:
        console.say(f"    {_capture_line(capture)}")
        for marker in capture.markers():
            console.say(f"        {_marker_line(marker)}")
    recordings = store.recordings.of_session(session.session_id)
    console.give(
        {
            **_session_document(session),
            "patient": session.patient,
            "notes": session.notes,
            "captures": [_capture_document(capture) for capture in captures],
            "recordings": [
                {
                    "recording_id": facts.recording_id,
                    "n_frames": facts.n_frames,
                    "n_dropped": facts.n_dropped,
                    "seconds": facts.duration_ns / NS_PER_S,
                    "size_bytes": facts.size_bytes,
                    "notice": facts.notice,
                }
                for facts in recordings
            ],
        }
    )
    return 0


def _repeat(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    session = store.sessions.get(arguments.session)
    setup = replace(session.setup, is_repeat=not arguments.no)
    changed = store.sessions.change(session.session_id, setup=setup, seen=session)
    console.say(_session_line(changed))
    console.give({**_session_document(changed), "is_repeat": changed.setup.is_repeat})
    return 0


def _export(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    from adibas.data.report import PictureChoice
    from adibas.pipeline.stored_report import ReportWish

    protocol = wished_protocol(arguments)
    session = store.sessions.get(arguments.session)
    store.require(Permission.EXPORT, session.session_id)
    recordings = store.recordings.of_session(session.session_id)
    folder: Path = arguments.out
    paths = [folder / f"recording-{number:02d}.mcap" for number in range(1, len(recordings) + 1)]
    reports = [folder / name for name in REPORTS] if session.capture_ids else []
    _make_place([*paths, *reports], folder, is_allowed=arguments.overwrite)
    pictures = PictureChoice(arguments.pictures)
    is_hidden = pictures is not PictureChoice.AS_IS
    _export_recordings(store, recordings, paths, console, depth_only=is_hidden)
    if recordings and is_hidden:
        console.say(_("The recordings hold the depth alone: in colour the face would be seen."))
    if reports:
        with_notes = arguments.with_notes or not is_hidden
        wish = ReportWish(
            arguments.language, pictures, protocol, arguments.compared_with, with_notes
        )
        if session.notes and not with_notes:
            console.say(_("The notes on the session are left out; --with-notes tells them."))
        for path in _export_reports(store, session, reports, wish):
            paths.append(path)
            console.say(str(path))
    if not paths:
        console.warn(_("The session has neither recordings nor captures; nothing was written."))
    console.give({"out": [str(path) for path in paths]})
    return 0


def _make_place(wanted: Sequence[Path], folder: Path, *, is_allowed: bool) -> None:
    """Let nothing of an earlier export stay in the folder: sessions are not mixed there."""
    for path in wanted:
        check_place(path)
    recordings = (path for path in folder.glob("*") if EXPORTED_RECORDING.fullmatch(path.name))
    earlier = {*recordings, *(folder / name for name in REPORTS), *wanted}
    for path in sorted(earlier):
        refuse_to_replace(path, is_allowed=is_allowed)
    for path in earlier - {*wanted}:
        remove_file(path)


def _export_recordings(
    store: "SessionStore",
    recordings: "Sequence[RecordingFacts]",
    paths: Sequence[Path],
    console: Console,
    *,
    depth_only: bool,
) -> None:
    for facts, path in zip(recordings, paths, strict=True):
        with console.progress(path.name) as progress:
            summary = store.recordings.export(
                facts.recording_id, path, progress, depth_only=depth_only
            )
        if summary.notice:
            console.warn(summary.notice)
        text = translate_plural(
            "{file}: {n_frames} frame.", "{file}: {n_frames} frames.", summary.n_frames
        )
        console.say(text.format(file=path, n_frames=summary.n_frames))


def _export_reports(
    store: "SessionStore", session: "Session", paths: Sequence[Path], wish: "ReportWish"
) -> Iterator[Path]:
    """Write the session's report in every kind that has all of it."""
    from adibas.pipeline.stored_report import stored_report
    from adibas.reports import write_report

    report = stored_report(store, session.session_id, wish)
    for path in paths:
        # First: half a report has left the store, too.
        store.note_export(path.suffix.removeprefix("."), session.session_id)
        write_report(report, path)
        yield path


def _verify(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    entries = store.audit.entries(arguments.entries) if arguments.entries else ()
    for entry in reversed(entries):
        console.say(_entry_line(entry))
    with console.progress(_("Checking")) as progress:
        report = store.verify(progress)
    console.give(
        {
            **tell_report(report, console),
            "entries": [_entry_document(entry) for entry in entries],
        }
    )
    return 0 if report.is_sound else SOMETHING_FOUND


def _purge(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    from adibas.sessions.patients import PREFIX

    if not arguments.yes:
        raise StoreError(
            "Purging {id} removes it with all pictures and recordings, and nobody can bring it "
            "back. Add --yes if you mean it.",
            id=arguments.id,
        )
    if arguments.id.startswith(PREFIX):
        store.patients.purge(arguments.id)
    else:
        store.sessions.purge(arguments.id)
    console.say(_("{id} is gone for good.").format(id=arguments.id))
    console.give({"purged": arguments.id})
    return 0


def _line(row: "PatientRow", *, with_name: bool) -> str:
    parts = [
        row.pseudonym,
        *([_on_one_line(row.identity.name)] if with_name else []),
        translate_plural("{n} session", "{n} sessions", row.n_sessions).format(n=row.n_sessions),
        *([_("hidden")] if row.is_deleted else []),
    ]
    return "  ".join(parts)


def _on_one_line(text: str) -> str:
    """Return what somebody typed without line ends and what else would steer the terminal."""
    letters = (one if one.isprintable() else "\N{WHITE SQUARE}" for one in " ".join(text.split()))
    return "".join(letters)


def _session_line(session: "Session") -> str:
    n_captures = len(session.capture_ids)
    parts = [
        session.session_id,
        f"{session.started_utc:%Y-%m-%d %H:%M} UTC",
        translate_plural("{n} capture", "{n} captures", n_captures).format(n=n_captures),
        *([_on_one_line(session.operator)] if session.operator else []),
        *([_("hidden")] if session.is_deleted else []),
    ]
    return "  ".join(parts)


def _entry_line(entry: "AuditEntry") -> str:
    parts = [
        f"{entry.time_utc:%Y-%m-%d %H:%M:%S} UTC",
        _on_one_line(entry.operator) or "-",
        action_text(entry.action),
        subject_text(entry.subject),
        *([entry.patient] if entry.patient not in ("", entry.subject) else []),
    ]
    return "  ".join(parts)


def _capture_line(capture: "Capture") -> str:
    n_done = capture.history.n_done
    parts = [
        capture.view or "-",
        f"{capture.captured_utc:%H:%M:%S} UTC",
        translate_plural("{n} frame", "{n} frames", capture.n_frames).format(n=capture.n_frames),
        translate_plural("{n} correction", "{n} corrections", n_done).format(n=n_done),
    ]
    return "  ".join(parts)


def _marker_line(marker: "Marker") -> str:
    if marker.position_m is None:
        place = _("no position")
    else:
        place = " ".join(f"{1000 * value:8.1f}" for value in marker.position_m) + " mm"
    line = f"{marker.label:<12}  {marker.u:8.2f} {marker.v:8.2f} px  {place}"
    if marker.named_by is None:
        return line
    sure = _("named automatically, {percent} %").format(
        percent=math.floor(100.0 * marker.named_by.confidence)
    )
    return f"{line}  {sure}"


def _patient_document(
    row: "PatientRow", sessions: tuple["Session", ...], *, with_name: bool
) -> dict[str, Any]:
    name = {"name": row.identity.name} if with_name else {}
    return {
        "pseudonym": row.pseudonym,
        **name,
        "is_deleted": row.is_deleted,
        "sessions": [_session_document(session) for session in sessions],
    }


def _entry_document(entry: "AuditEntry") -> dict[str, Any]:
    return {
        "sequence": entry.sequence,
        "time_utc": entry.time_utc.isoformat(),
        "operator": entry.operator,
        "action": entry.action,
        "subject": entry.subject,
        "patient": entry.patient,
        "detail": dict(entry.detail),
    }


def _session_document(session: "Session") -> dict[str, Any]:
    return {
        "session_id": session.session_id,
        "started_utc": session.started_utc.isoformat(),
        "operator": session.operator,
        "protocol": session.setup.protocol,
        "n_captures": len(session.capture_ids),
        "is_deleted": session.is_deleted,
    }


def _capture_document(capture: "Capture") -> dict[str, Any]:
    return {
        "capture_id": capture.capture_id,
        "view": capture.view,
        "captured_utc": capture.captured_utc.isoformat(),
        "recording_id": capture.recording_id,
        "first_frame": capture.first_frame,
        "n_frames": capture.n_frames,
        "n_corrections": capture.history.n_done,
        "markers": [
            {
                "label": marker.label,
                "u": marker.u,
                "v": marker.v,
                "named_by": None if marker.named_by is None else asdict(marker.named_by),
                "position_m": None if marker.position_m is None else marker.position_m.tolist(),
            }
            for marker in capture.markers()
        ],
    }
