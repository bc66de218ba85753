"""`adibas coding`: what observers coded: count it, compare it, sample it, and convert it."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from adibas.cli.console import Console
from adibas.cli.options import add_json, add_out, positive, sentence
from adibas.cli.report_options import add_language, check_report
from adibas.files import check_place
from adibas.texts import SpokenNumber, decimal_text, message, spoken_language, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.behaviour.agreement import Figure
    from adibas.data.ethogram import Ethogram
    from adibas.pipeline.behaviour_agreement import ComparedSession

SUMMARY = message("count, compare, sample and convert what observers coded")
AGREEMENT = message("say how far observers agree, by named methods, and where they do not")
CONVERT = message("convert codings between BORIS, ELAN, CSV and Excel")
SAMPLE = message("see what interval or momentary sampling would have seen")
COUNT = message("count a coding: totals, rates, time bins, conditions, transitions")
ETHOGRAM = message("write the example of an ethogram, to be changed")
METHODS = (
    *("all", "time-unit-kappa", "time-unit-pabak", "time-unit-ac1", "fleiss-kappa", "event-kappa"),
    *("total-count", "mean-count-per-interval", "exact-count-per-interval"),
    *("interval-by-interval", "scored-intervals", "unscored-intervals", "total-duration"),
    *("mean-duration-per-occurrence", "icc-count", "icc-duration"),
)
SAMPLINGS = ("partial", "whole", "momentary")
MS_PER_S = 1000
DASH = "\N{EN DASH}"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    actions = parser.add_subparsers(metavar=_("ACTION"), required=True)
    _add_agreement(actions.add_parser("agreement", **_told(AGREEMENT)))
    convert = actions.add_parser("convert", **_told(CONVERT))
    _add_coding(convert)
    convert.add_argument("target", type=Path, metavar=_("FILE"), help=_("file to write"))
    convert.set_defaults(action=_convert)
    sample = actions.add_parser("sample", **_told(SAMPLE))
    _add_coding(sample)
    sample.add_argument(
        "--method", choices=SAMPLINGS, default=SAMPLINGS[0], help=_("the first if not given")
    )
    _add_seconds(sample, "--interval", 10.0, _("length of an interval, seconds; 10 if not given"))
    sample.set_defaults(action=_sample)
    count = actions.add_parser("count", **_told(COUNT))
    _add_coding(count)
    _add_seconds(count, "--bin", 60.0, _("length of a time bin, seconds; 60 if not given"))
    count.add_argument("--out", type=Path, metavar="report.xlsx", help=_("report to write"))
    add_language(count)
    count.set_defaults(action=_count)
    ethogram = actions.add_parser("ethogram", **_told(ETHOGRAM))
    add_out(ethogram, "ethogram.json", _("file to write"))
    ethogram.set_defaults(action=_ethogram)
    for action in (convert, sample, count, ethogram):
        add_json(action)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Do one of the actions."""
    code: int = arguments.action(arguments, console)
    return code


def _told(summary: str) -> dict[str, Any]:
    return {"help": _(summary), "description": sentence(_(summary))}


def _add_coding(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "coding", type=Path, metavar=_("CODING"), help=_(".csv, .tsv, .xlsx, .boris or .eaf")
    )
    _add_ethogram(parser)


def _add_ethogram(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--ethogram",
        type=Path,
        metavar=_("FILE"),
        help=_("in place of the coding's own (JSON); every event must fit"),
    )


def _add_seconds(parser: argparse.ArgumentParser, name: str, default: float, text: str) -> None:
    parser.add_argument(name, type=positive, default=default, metavar="S", help=text)


def _add_agreement(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "codings",
        type=Path,
        nargs="+",
        metavar=_("CODING"),
        help=_("one file an observer: .csv, .tsv, .xlsx, .boris or .eaf"),
    )
    _add_ethogram(parser)
    parser.add_argument(
        "--method", choices=METHODS, default=METHODS[0], help=_("what is printed; all if not given")
    )
    _add_seconds(parser, "--unit", 1.0, _("unit of time, seconds; 1 if not given"))
    _add_seconds(
        parser, "--tolerance", 1.0, _("events within so many seconds are the same; 1 if not given")
    )
    _add_seconds(parser, "--interval", 10.0, _("length of an interval, seconds; 10 if not given"))
    parser.add_argument("--out", type=Path, metavar="report.xlsx", help=_("report to write"))
    add_language(parser)
    add_json(parser)
    parser.set_defaults(action=_agreement)


def _scheme(arguments: argparse.Namespace) -> "Ethogram | None":
    from adibas.recordings.ethogram_json import read_ethogram

    return None if arguments.ethogram is None else read_ethogram(arguments.ethogram)


def _ms(seconds: float) -> int:
    from adibas.data.coding import whole_ms

    return max(whole_ms(seconds), 1)


def _agreement(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.behaviour.agreement import AgreementParams
    from adibas.pipeline.behaviour_agreement import compare_files

    if arguments.out is not None:
        check_report(arguments.out, (".xlsx",))
    params = AgreementParams(_ms(arguments.unit), _ms(arguments.tolerance), _ms(arguments.interval))
    report = compare_files(arguments.codings, _scheme(arguments), params)
    for notice in report.notices:
        console.warn(notice.text)
    documents = []
    for session in report.sessions:
        _tell_session(session, arguments.method, console)
        documents.append(_session_document(session, arguments.method))
    if arguments.out is not None:
        from adibas.reports.agreement_excel import write_agreement_workbook

        write_agreement_workbook(report, arguments.out, arguments.language)
        console.say(str(arguments.out))
    console.give(
        {
            "files": list(report.files),
            "unit_s": params.unit_ms / MS_PER_S,
            "tolerance_s": params.tolerance_ms / MS_PER_S,
            "interval_s": params.interval_ms / MS_PER_S,
            "sessions": documents,
            "notices": [notice.text for notice in report.notices],
        }
    )
    return 0


def _chosen(session: "ComparedSession", method: str) -> "list[Figure]":
    return [one for one in session.result.figures if method in ("all", one.coefficient.method)]


def _tell_session(session: "ComparedSession", method: str, console: Console) -> None:
    from adibas.reports.agreement_texts import method_text
    from adibas.reports.behaviour_texts import subject_text

    for notice in session.result.notices:
        console.warn(notice.text)
    observers = ", ".join(name or DASH for name in session.result.observers)
    console.say(f"{session.name} ({observers})")
    for figure in _chosen(session, method):
        found = figure.coefficient
        value = DASH if found.value is None else decimal_text(found.value, 3)
        whose = f"{subject_text(figure.subject)}, {figure.behaviour}" if figure.behaviour else ""
        reason = "" if found.reason is None else f"  {found.reason.text}"
        console.say(f"  {value:>7}  {method_text(found.method)}  {whose}{reason}".rstrip())
    n = sum(not one.is_agreed for one in session.result.matches)
    seconds = sum(one.end_ms - one.begin_ms for one in session.result.differences) / MS_PER_S
    console.say(
        _("  {events} not agreed on, and {seconds:.1f} s of states seen by one alone").format(
            events=translate_plural("{n} event", "{n} events", n).format(n=n),
            seconds=SpokenNumber(seconds),
        )
    )


def _session_document(session: "ComparedSession", method: str) -> dict[str, Any]:
    result = session.result
    return {
        "session": session.name,
        "observers": list(result.observers),
        "within_s": [time / MS_PER_S for time in result.within_ms],
        "figures": [
            {
                "method": one.coefficient.method,
                "subject": one.subject,
                "behaviour": one.behaviour,
                "value": one.coefficient.value,
                "observed": one.coefficient.observed,
                "expected": one.coefficient.expected,
                "n": one.coefficient.n,
                "reason": None if one.coefficient.reason is None else one.coefficient.reason.text,
            }
            for one in _chosen(session, method)
        ],
        "tables": [
            {"method": one.method, "names": list(one.names), "counts": one.counts.tolist()}
            for one in result.tables
        ],
        "disagreements": [
            {
                "subject": one.subject,
                "behaviour": one.behaviour,
                "begin_s": one.begin_ms / MS_PER_S,
                "end_s": one.end_ms / MS_PER_S,
                "seen_by": 1 if one.is_first else 2,
            }
            for one in result.differences
        ],
        "events": [
            {
                "first": None if one.first is None else one.first.behaviour,
                "second": None if one.second is None else one.second.behaviour,
                "begin_s": one.begin_ms / MS_PER_S,
            }
            for one in result.matches
            if not one.is_agreed
        ],
        "notices": [notice.text for notice in result.notices],
    }


def _convert(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.recordings.codings import read_codings
    from adibas.reports.codings import write_codings

    check_place(arguments.target)
    found = read_codings(arguments.coding, _scheme(arguments))
    paths = write_codings(arguments.target, found, spoken_language())
    for path in paths:
        console.say(str(path))
    n_events = sum(len(one.occurrences) for one in found)
    console.give({"out": [str(path) for path in paths], "sessions": len(found), "events": n_events})
    return 0


def _sample(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.behaviour.sampling import samples
    from adibas.recordings.codings import read_codings
    from adibas.reports.behaviour_texts import subject_text

    documents = []
    for coding in read_codings(arguments.coding, _scheme(arguments)):
        console.say(f"{coding.name} ({coding.observer or DASH})")
        for one in samples(coding, arguments.method, _ms(arguments.interval)):
            scored, true = (_percent(share) for share in (one.share, one.true_share))
            console.say(
                _("  {scored} of intervals, {true} of time: {who}, {behaviour}").format(
                    scored=scored,
                    true=true,
                    who=subject_text(one.subject),
                    behaviour=one.behaviour,
                )
            )
            documents.append(
                {
                    "session": coding.name,
                    "subject": one.subject,
                    "behaviour": one.behaviour,
                    "share": one.share,
                    "true_share": one.true_share,
                    "scores": list(one.scores),
                }
            )
    console.give(
        {"method": arguments.method, "interval_s": arguments.interval, "samples": documents}
    )
    return 0


def _percent(share: float | None) -> str:
    return DASH if share is None else f"{decimal_text(100 * share, 1)} %"


def _count(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.behaviour.budget import budgets
    from adibas.recordings.codings import read_codings
    from adibas.reports.behaviour_json import coding_to_json
    from adibas.reports.behaviour_texts import subject_text
    from adibas.reports.coding_report import CODING_REPORT_KINDS, write_coding_report

    if arguments.out is not None:
        check_report(arguments.out, CODING_REPORT_KINDS)
    documents = []
    codings = read_codings(arguments.coding, _scheme(arguments))
    for coding in codings:
        console.say(f"{coding.name} ({coding.observer or DASH})")
        for one in budgets(coding):
            console.say(
                _("  {count} times, {total} s ({share}): {who}, {behaviour}").format(
                    count=one.count,
                    total=decimal_text(one.total_ms / MS_PER_S, 3) if one.is_state else DASH,
                    share=_percent(one.share),
                    who=subject_text(one.subject),
                    behaviour=one.behaviour,
                )
            )
        document = coding_to_json(coding, _ms(arguments.bin))
        documents.append({"session": coding.name, **document})
    if arguments.out is not None:
        write_coding_report(codings, _ms(arguments.bin), arguments.out, arguments.language)
        console.say(str(arguments.out))
    console.give({"bin_s": arguments.bin, "sessions": documents})
    return 0


def _ethogram(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.recordings.ethogram_json import (
        ethogram_document,
        shipped_ethogram,
        write_ethogram,
    )

    check_place(arguments.out)
    ethogram = shipped_ethogram()
    write_ethogram(arguments.out, ethogram)
    console.say(
        _("{file} holds an ethogram. Change it, and code by it.").format(file=arguments.out)
    )
    console.give({"out": str(arguments.out), "ethogram": ethogram_document(ethogram)})
    return 0
