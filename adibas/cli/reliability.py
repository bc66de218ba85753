"""`adibas sessions reliability`: how well the measures of a protocol repeat in this clinic."""

import argparse
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from adibas.cli.console import Console
from adibas.cli.protocol_options import add_protocol, wished_protocol
from adibas.errors import ProtocolError
from adibas.texts import decimal_text
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.data.reliability import Correlation, Reliability
    from adibas.sessions import SessionStore

DASH = "\N{EN DASH}"
MOST_SESSIONS = 1_000_000


def add_reliability_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the action takes."""
    add_protocol(parser)
    parser.add_argument(
        "--operator",
        metavar=_("NAME"),
        help=_("whose sessions count; those of the store's present operator if not given"),
    )


def tell_reliability(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    """Print what repeats say of each measure."""
    from adibas.pipeline.clinic_repeats import reliability_in_clinic

    wish = wished_protocol(arguments)
    if wish is None:
        raise ProtocolError(
            "Repeats are those of the measures of one protocol. Say which with --protocol."
        )
    operator = store.operator if arguments.operator is None else arguments.operator
    found = reliability_in_clinic(store, wish, operator)
    reasons: dict[str, int] = {}
    documents = []
    units = {one.measure_id: one.unit for one in wish.protocol.measures}
    for (view, measure_id), one in found.by_measure.items():
        unit = units[measure_id]
        console.say(f"{view}  {measure_id}  {_line(one, unit)}")
        for reason in one.reasons:
            reasons[reason.text] = reasons.get(reason.text, 0) + 1
        documents.append({"view": view, "id": measure_id, "unit": unit, **_document(one)})
    if not found.by_measure:
        console.warn(
            _(
                "No session of {operator} has a measure of this protocol. The store has sessions "
                "of: {others}. Choose one with --operator."
            ).format(operator=operator or DASH, others=_others(store) or DASH)
        )
    for text, count in reasons.items():
        console.warn(f"{count} \N{MULTIPLICATION SIGN} {text}")
    console.give(
        {"protocol": wish.protocol.protocol_id, "operator": operator, "measures": documents}
    )
    return 0


def _others(store: "SessionStore") -> str:
    """Return who took the sessions of a store."""
    sessions = store.sessions.recent(MOST_SESSIONS)
    return ", ".join(sorted({one.operator for one in sessions if one.operator}))


def _line(one: "Reliability", unit: str) -> str:
    parts = [
        f"n = {one.n_patients}",
        f"SEM {_number(one.sem, unit)}",
        f"MDC95 {_number(one.mdc95, unit)}",
        f"ICC(2,1) {_correlation(one.icc_2_1)}",
        f"ICC(3,1) {_correlation(one.icc_3_1)}",
    ]
    return "  ".join(parts)


def _number(value: float | None, unit: str) -> str:
    return DASH if value is None else f"{decimal_text(value, 2)} {unit}"


def _correlation(found: "Correlation | None") -> str:
    if found is None:
        return DASH
    low, high = (decimal_text(limit, 2) for limit in found.interval)
    return f"{decimal_text(found.value, 2)} ({low} {DASH} {high})"


def _document(one: "Reliability") -> dict[str, Any]:
    def correlation(found: "Correlation | None") -> dict[str, Any] | None:
        return None if found is None else {"value": found.value, "ci95": list(found.interval)}

    return {
        "n_patients": one.n_patients,
        "n_values": one.n_values,
        "sem": one.sem,
        "sem_ci95": None if one.sem_interval is None else list(one.sem_interval),
        "mdc95": one.mdc95,
        "icc_2_1": correlation(one.icc_2_1),
        "icc_3_1": correlation(one.icc_3_1),
        "bland_altman": None if one.agreement is None else asdict(one.agreement),
        "reasons": [str(reason.message).format(**reason.fields) for reason in one.reasons],
    }
