"""`adibas sessions backup`, `restore`, `verify-backup`: the store in one sealed file, and back."""

import argparse
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.console import Console
from adibas.cli.options import add_json, positive_count
from adibas.cli.sessions_recovery import tell_how_to_make_one
from adibas.cli.store_options import (
    PASSPHRASE_VARIABLE,
    add_store,
    ask_passphrase,
    open_existing,
    read_passphrase,
)
from adibas.errors import BackupLockedError, FileError, PassphraseError
from adibas.files import cannot_write
from adibas.sessions.defaults import DAYS_BETWEEN_BACKUPS, N_BACKUPS_KEPT
from adibas.sessions.merge_words import merge_texts
from adibas.sessions.recovery_key import read_recovery_key
from adibas.texts import spoken, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.sessions import SessionStore, VerifyReport
    from adibas.sessions.backing_up import BackupSummary

SOMETHING_FOUND = 1
"""What `verify` and its kin return where something is damaged."""

Add = Callable[[str, str], argparse.ArgumentParser]


def add_backup_arguments(add: Add) -> None:
    """Say what the three actions take; `add` makes the parser of an action."""
    making = add("backup", _("The whole store into one encrypted file, also while it is in use."))
    making.set_defaults(alone=_backup)
    add_store(making)
    place = making.add_mutually_exclusive_group(required=True)
    place.add_argument("--out", type=Path, metavar=_("FILE"), help=_("file to write"))
    place.add_argument(
        "--if-due",
        type=Path,
        metavar=_("DIR"),
        help=_("in place of --out: into this folder, when its newest backup is old enough"),
    )
    making.add_argument(
        "--every",
        type=positive_count,
        default=DAYS_BETWEEN_BACKUPS,
        metavar="N",
        help=_("with --if-due: days between two backups; 7 if not given"),
    )
    making.add_argument(
        "--keep",
        type=positive_count,
        default=N_BACKUPS_KEPT,
        metavar="N",
        help=_("with --if-due: keep the N newest and remove older ones; 4 if not given"),
    )
    _add_backup_passphrase(making)
    making.add_argument("--overwrite", action="store_true", help=_("replace a file of that name"))

    restoring = add("restore", _("A backup into a new folder, or into the store in use."))
    restoring.set_defaults(alone=_restore)
    add_store(restoring)
    _add_backup(restoring)
    restoring.add_argument(
        "--into",
        type=Path,
        metavar=_("DIR"),
        help=_("new or empty folder; without it, what is missing is added to the store in use"),
    )
    _add_backup_passphrase(restoring)
    _add_recovery_key(restoring)

    verifying = add("verify-backup", _("Restore a backup for a moment and check all of it."))
    verifying.set_defaults(alone=_verify_backup)
    _add_backup(verifying)
    verifying.add_argument(
        "--passphrase-file",
        dest="backup_passphrase_file",
        type=Path,
        metavar=_("FILE"),
        help=_("file whose first line is the passphrase of the backup"),
    )
    _add_recovery_key(verifying)
    verifying.add_argument(
        "--temporary",
        type=Path,
        metavar=_("DIR"),
        help=_("folder with room for it; beside this user's patient store if not given"),
    )
    add_json(verifying)


def _add_backup(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("backup", type=Path, metavar=_("FILE"), help=_("the backup"))


def _add_backup_passphrase(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--backup-passphrase-file",
        type=Path,
        metavar=_("FILE"),
        help=_("file whose first line is the passphrase of the backup; the store's if not given"),
    )


def _add_recovery_key(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--recovery-key-file",
        type=Path,
        metavar=_("FILE"),
        help=_(
            "in place of a passphrase: file whose first line is the recovery key that held when "
            "the backup was made"
        ),
    )


def _backup(arguments: argparse.Namespace, console: Console) -> int:
    if arguments.out is not None:
        _refuse_to_replace(arguments.out, is_allowed=arguments.overwrite)
    with open_existing(arguments) as store:
        made = _made(store, arguments, console)
        days = None if arguments.if_due is None else store.backups.days_since(arguments.if_due)
    if made is None:
        console.say(
            _("No backup is due: the newest one is {days:.1f} days old.").format(days=spoken(days))
        )
        console.give({"out": None, "days": days})
        return 0
    out, summary = made
    _tell(out, summary, console)
    return SOMETHING_FOUND if summary.damaged else 0


def _refuse_to_replace(out: Path, *, is_allowed: bool) -> None:
    if out.exists() and not is_allowed:
        raise FileError(
            "{file} exists already, and a backup is not replaced by mistake. Choose another name, "
            "or add --overwrite.",
            file=out.name,
        )


def _made(
    store: "SessionStore", arguments: argparse.Namespace, console: Console
) -> "tuple[Path, BackupSummary] | None":
    passphrase = read_passphrase(arguments.backup_passphrase_file)
    with console.progress(_("Backup")) as progress:
        if arguments.out is not None:
            summary = store.backups.write(arguments.out, passphrase, progress=progress)
            return arguments.out, summary
        from adibas.sessions.backup_schedule import BackupPlan

        plan = BackupPlan(arguments.if_due, arguments.every, arguments.keep)
        return store.backups.write_planned(plan, passphrase, progress=progress)


def _tell(out: Path, summary: "BackupSummary", console: Console) -> None:
    for name in summary.damaged:
        console.warn(
            _(
                "{file} of the store is missing or not as it was saved. Everything else is in the "
                "backup; `adibas sessions verify` tells more."
            ).format(file=name)
        )
    text = translate_plural(
        "{file}: {n} file of the store.", "{file}: {n} files of the store.", summary.n_files
    )
    console.say(text.format(file=out, n=summary.n_files))
    console.give(
        {
            "out": str(out),
            "n_files": summary.n_files,
            "n_bytes": summary.n_bytes,
            "damaged": list(summary.damaged),
        }
    )


def _restore(arguments: argparse.Namespace, console: Console) -> int:
    with _telling_how("--backup-passphrase-file"):
        restore = _restore_used if arguments.into is None else _new
        return restore(arguments, console)


def _restore_used(arguments: argparse.Namespace, console: Console) -> int:
    with open_existing(arguments) as store, console.progress(arguments.backup.name) as progress:
        summary = store.backups.restore(
            arguments.backup, _passphrase_of_backup(arguments), progress
        )
    for line in merge_texts(summary):
        console.say(line)
    console.give(asdict(summary))
    return 0


def _new(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.sessions.restoring import restore_into

    with console.progress(arguments.backup.name) as progress:
        header = restore_into(
            arguments.backup, arguments.into, _passphrase_of_backup(arguments), progress
        )
    console.say(
        _(
            "The patient store of {time} is in {folder}; it opens with the backup's passphrase."
        ).format(time=header.created_utc[:16].replace("T", " "), folder=arguments.into)
    )
    if header.recovery is None:
        tell_how_to_make_one(arguments.into, console)
    elif arguments.recovery_key_file is not None:
        console.say(
            _(
                "Its recovery key gives it a new passphrase: adibas sessions recover --store "
                "{folder}"
            ).format(folder=arguments.into)
        )
    console.give({"into": str(arguments.into), "created_utc": header.created_utc})
    return 0


def _verify_backup(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.sessions.trial_restore import verify_backup

    with (
        _telling_how("--passphrase-file"),
        console.progress(arguments.backup.name) as progress,
    ):
        header, report = verify_backup(
            arguments.backup,
            _passphrase_of_backup(arguments),
            progress,
            room=arguments.temporary or _beside_own_store(),
        )
    console.give({**tell_report(report, console), "created_utc": header.created_utc})
    return 0 if report.is_sound else SOMETHING_FOUND


def _beside_own_store() -> Path:
    """Return this user's folder of data, into which no other user looks."""
    from adibas.sessions import default_store_folder

    folder = default_store_folder().parent
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(folder, error) from error
    return folder


def tell_report(report: "VerifyReport", console: Console) -> dict[str, object]:
    """Print what a check of a store found; return it for JSON."""
    for finding in report.findings:
        console.warn(finding.text)
    console.say(
        _(
            "{n_lines} lines of the audit log, {n_files} pictures and surfaces, {n_recordings} "
            "recordings: {found}."
        ).format(
            n_lines=report.n_lines,
            n_files=report.n_files,
            n_recordings=report.n_recordings,
            found=_("all is well") if report.is_sound else _("see what was found"),
        )
    )
    return {
        "is_sound": report.is_sound,
        "n_lines": report.n_lines,
        "n_files": report.n_files,
        "n_recordings": report.n_recordings,
        "findings": [
            {"kind": f.kind, "subject": f.subject, "text": f.text} for f in report.findings
        ],
    }


@contextmanager
def _telling_how(option: str) -> Iterator[None]:
    """Say of a locked backup with which option its passphrase is given."""
    try:
        yield
    except BackupLockedError as error:
        raise PassphraseError(
            "{file} is locked. Give a file with {option} FILE, whose first line is the passphrase "
            "that held when it was made, or set the environment variable {variable}.",
            file=error.fields["file"],
            option=option,
            variable=PASSPHRASE_VARIABLE,
        ) from error


def _passphrase_of_backup(arguments: argparse.Namespace) -> str | None:
    """Return what is given for the backup, else for the store, else by the environment.

    Where no store was opened before, somebody is asked.
    """
    if arguments.recovery_key_file is not None:
        # A mistyped one is told as such, not as a wrong passphrase.
        return read_recovery_key(read_passphrase(arguments.recovery_key_file) or "")
    for path in (arguments.backup_passphrase_file, getattr(arguments, "passphrase_file", None)):
        if path is not None:
            return read_passphrase(path)
    if PASSPHRASE_VARIABLE in os.environ:
        return os.environ[PASSPHRASE_VARIABLE]
    if "passphrase" in arguments:
        of_store: str | None = arguments.passphrase
        return of_store
    return ask_passphrase(_("Passphrase of the backup: "))
