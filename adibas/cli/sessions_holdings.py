"""`adibas sessions holdings` and `withdraw`: what is held of a patient, and the end of consents."""

import argparse
from collections.abc import Callable
from dataclasses import asdict
from datetime import date, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from adibas.cli.console import Console
from adibas.cli.options import positive_count
from adibas.sessions.defaults import DAYS_BETWEEN_BACKUPS, N_BACKUPS_KEPT
from adibas.texts import translate as _
from adibas.texts import translate_plural

if TYPE_CHECKING:
    from adibas.sessions import SessionStore

Work = Callable[["SessionStore", argparse.Namespace, Console], int]


def add_holdings_actions(add: Callable[[str, str, Work], argparse.ArgumentParser]) -> None:
    """Say what both actions take; `add` makes the parser of an action."""
    held = _("All that is held of a patient, and what left the store.")
    _add_arguments(add("holdings", held, tell_holdings))
    ended = _("End a patient's consents, and list all that is held.")
    _add_arguments(add("withdraw", ended, withdraw))


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("pseudonym", metavar=_("PSEUDONYM"), help=_("as `list` shows it"))
    parser.add_argument(
        "--backups",
        type=Path,
        metavar=_("DIR"),
        help=_("folder of the planned backups: those that may hold the patient are listed, too"),
    )
    parser.add_argument(
        "--every",
        type=positive_count,
        default=DAYS_BETWEEN_BACKUPS,
        metavar="N",
        help=_("with --backups: days between two backups; 7 if not given"),
    )
    parser.add_argument(
        "--keep",
        type=positive_count,
        default=N_BACKUPS_KEPT,
        metavar="N",
        help=_("with --backups: how many are kept; 4 if not given"),
    )


def tell_holdings(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    """List all that is held of a patient; nothing is changed."""
    console.give(_told(store, arguments, console))
    return 0


def withdraw(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    """End all consents of a patient that stand, then list all that is held."""
    pseudonym, n_ended = arguments.pseudonym, 0
    for index, consent in enumerate(store.patients.get(pseudonym).consents):
        if consent.is_standing:
            store.patients.withdraw_consent(pseudonym, index)
            n_ended += 1
    console.say(_ended(n_ended))
    console.give({"withdrawn": n_ended, **_told(store, arguments, console)})
    return 0


def _ended(n: int) -> str:
    if not n:
        return _("No consent of this patient stands; nothing was changed.")
    text = translate_plural("{n} consent was withdrawn.", "{n} consents were withdrawn.", n)
    return text.format(n=n)


def _told(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> dict[str, Any]:
    from adibas.sessions.backup_schedule import BackupPlan
    from adibas.sessions.holdings_words import holdings_sections, plain_spelling

    folder = arguments.backups
    plan = None if folder is None else BackupPlan(folder, arguments.every, arguments.keep)
    held = store.holdings.of(arguments.pseudonym, plan)
    for section in holdings_sections(held, plain_spelling()):
        console.say(section.title)
        for line in section.lines:
            console.say(f"    {line}")
    document: dict[str, Any] = _plain(asdict(held))
    return {**document, "size_bytes": held.size_bytes}


def _plain(value: Any) -> Any:
    """Return a document with times and days as texts."""
    if isinstance(value, dict):
        return {name: _plain(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    return value.isoformat() if isinstance(value, datetime | date) else value
