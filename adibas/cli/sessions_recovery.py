"""`adibas sessions recovery-key` and `recover`: a key for the day on which a passphrase is lost."""

import argparse
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.console import Console
from adibas.cli.options import add_json, add_overwrite, refuse_to_replace
from adibas.cli.sessions_people import add_new_passphrase, read_new_passphrase
from adibas.cli.store_options import (
    add_store,
    add_store_folder,
    ask_passphrase,
    open_existing,
    read_passphrase,
    read_server_password,
    store_folder,
    user_name,
)
from adibas.errors import PassphraseError
from adibas.files import check_place
from adibas.sessions.roles import Permission
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.sessions import SessionStore

RECOVERY_KEY_VARIABLE = "ADIBAS_RECOVERY_KEY"

Add = Callable[[str, str], argparse.ArgumentParser]


def add_recovery_arguments(add: Add) -> None:
    """Say what the two actions take; `add` makes the parser of an action."""
    making = add(
        "recovery-key",
        _("A new key that opens the store when its passphrase is lost; the one before ends."),
    )
    making.set_defaults(alone=_make)
    add_store(making)
    making.add_argument(
        "--out", type=Path, metavar=_("FILE.pdf"), help=_("a page to print with the key, too")
    )
    add_overwrite(making, _("replace a file of that name"))

    recovering = add(
        "recover", _("Open a store by its recovery key, and give it a new passphrase.")
    )
    recovering.set_defaults(alone=_recover)
    add_store_folder(recovering)
    recovering.add_argument(
        "--name",
        default="",
        metavar=_("NAME"),
        help=_("the administrator who gets the new passphrase; the only one if not given"),
    )
    add_recovery_key_file(recovering)
    add_new_passphrase(recovering)
    add_json(recovering)


def add_recovery_key_file(parser: argparse.ArgumentParser) -> None:
    """Offer `--recovery-key-file`."""
    parser.add_argument(
        "--recovery-key-file",
        type=Path,
        metavar=_("FILE"),
        help=_(
            "file whose first line is the recovery key; without it the environment variable "
            "{variable}, or it is asked for"
        ).format(variable=RECOVERY_KEY_VARIABLE),
    )


def tell_how_to_make_one(folder: Path, console: Console) -> None:
    """Say of a store that was just made how it gets a recovery key."""
    console.say(
        _(
            "It has no recovery key yet, which opens it when the passphrase is lost. Make one: "
            "adibas sessions recovery-key --store {folder}"
        ).format(folder=folder)
    )


def _make(arguments: argparse.Namespace, console: Console) -> int:
    out: Path | None = arguments.out
    if out is not None:
        check_place(out)
        refuse_to_replace(out, is_allowed=arguments.overwrite)
    with open_existing(arguments) as store:
        store.require(Permission.PROTECT, "people")
        return _tell_new_key(store, out, console)


def _tell_new_key(store: "SessionStore", out: Path | None, console: Console) -> int:
    from adibas.reports.recovery_sheet import recovery_sheet, write_recovery_pdf
    from adibas.sessions.recovery_key import make_recovery_key

    recovery_key, before_utc = make_recovery_key(), store.recovery.made_utc()
    made_utc, store_id = store.audit.now_utc(), store.recovery.store_id
    if out is not None:  # before it counts: a full disk leaves the key of before
        write_recovery_pdf(out, recovery_sheet(recovery_key, store_id, made_utc))
    store.recovery.hold(recovery_key)
    made_utc = store.recovery.made_utc() or made_utc
    console.give(
        {
            "recovery_key": recovery_key,
            "store_id": store_id,
            "made_utc": made_utc.isoformat(),
            "replaced": before_utc is not None,
            "out": None if out is None else str(out),
        }
    )
    console.tell(recovery_key)
    console.say(
        _(
            "This is the recovery key. It is told this once and kept nowhere: write it down, and "
            "keep it away from the computer. Whoever has it can read everything."
        )
    )
    if before_utc is not None:
        console.say(
            _("The recovery key of {day} opens the store no more.").format(
                day=f"{before_utc:%Y-%m-%d}"
            )
        )
    if out is not None:
        console.say(str(out))
    return 0


def _recover(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.sessions.recovering import (
        RecoveryWish,
        administrators,
        chosen_name,
        recover_store,
    )
    from adibas.sessions.server_address import read_server_file

    folder, recovery_key = store_folder(arguments), _recovery_key(arguments)
    name = chosen_name(administrators(folder, recovery_key), arguments.name)
    wish = RecoveryWish(recovery_key, read_new_passphrase(arguments), name)
    server = read_server_file(folder)
    password = None if server is None else read_server_password(server)
    recover_store(folder, wish, operator=user_name(), server_password=password).close()
    console.say(_("From now on the new passphrase opens the patient store."))
    console.say(
        _(
            "The recovery key still opens it, too. If somebody else saw it, make a new one: adibas "
            "sessions recovery-key"
        )
    )
    console.give({"name": name or None})
    return 0


def _recovery_key(arguments: argparse.Namespace) -> str:
    given = read_passphrase(arguments.recovery_key_file)
    given = os.environ.get(RECOVERY_KEY_VARIABLE) if given is None else given
    given = ask_passphrase(_("Recovery key: ")) if given is None else given
    if given is None:
        raise PassphraseError(
            "The recovery key is needed. Give a file with --recovery-key-file FILE, whose first "
            "line it is, or set the environment variable {variable}.",
            variable=RECOVERY_KEY_VARIABLE,
        )
    return given
