"""`adibas sessions retention`: whose time is over, their removal, and when the disk is full."""

import argparse
from typing import TYPE_CHECKING

from adibas.cli.console import Console
from adibas.cli.options import positive_count
from adibas.sessions.defaults import ADULT_AGE, CHILD_UNTIL_AGE, RETENTION_YEARS
from adibas.sessions.disk_words import forecast_text
from adibas.texts import translate as _
from adibas.texts import translate_plural

if TYPE_CHECKING:
    from adibas.sessions import SessionStore


def add_retention_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the action takes."""
    parser.add_argument(
        "--years",
        type=positive_count,
        default=RETENTION_YEARS,
        metavar="N",
        help=_("years that a patient is kept after the last session; 15 if not given"),
    )
    parser.add_argument(
        "--child-until-age",
        type=_adult_age,
        default=CHILD_UNTIL_AGE,
        metavar="N",
        help=_("who was a child then is kept up to this age at least; 25 if not given"),
    )
    parser.add_argument(
        "--apply", action="store_true", help=_("remove them for good; it cannot be undone")
    )


def retain(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    """List whose time is over; with --apply they are purged."""
    from adibas.sessions.retention import RetentionRules

    rules = RetentionRules(arguments.years, arguments.child_until_age)
    today = store.audit.now_utc().date()
    if arguments.apply:
        with console.progress(_("Removing")) as progress:
            over = store.retention.apply(rules, today, progress)
    else:
        over = store.retention.expired(rules, today)
    for one in over:
        sessions = translate_plural("{n} session", "{n} sessions", one.n_sessions)
        console.say(f"{one.pseudonym}  {sessions.format(n=one.n_sessions)}  {one.text}")
    console.say(_result(len(over), is_applied=arguments.apply))
    forecast = store.forecast_disk()
    console.say(forecast_text(forecast))
    console.give(
        {
            "applied": arguments.apply,
            "patients": [
                {
                    "pseudonym": one.pseudonym,
                    "n_sessions": one.n_sessions,
                    "last_utc": one.last_utc.isoformat(),
                    "reason": one.reason,
                    "since": one.since.isoformat(),
                }
                for one in over
            ],
            "free_bytes": forecast.free_bytes,
            "bytes_per_month": forecast.bytes_per_month,
            "months_left": forecast.months_left,
        }
    )
    return 0


def _result(n_over: int, *, is_applied: bool) -> str:
    if is_applied:
        text = translate_plural(
            "{n} patient was removed for good.", "{n} patients were removed for good.", n_over
        )
    else:
        text = translate_plural(
            "The time of {n} patient is over; nothing was removed. --apply removes.",
            "The time of {n} patients is over; nothing was removed. --apply removes.",
            n_over,
        )
    return text.format(n=n_over)


def _adult_age(text: str) -> int:
    if not text.isdecimal() or int(text) < ADULT_AGE:
        raise argparse.ArgumentTypeError(
            _("{text} is no age of an adult: give {least} or more").format(
                text=text, least=ADULT_AGE
            )
        )
    return int(text)
