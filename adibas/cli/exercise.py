"""`adibas gestures check`: an exercise of a patient beside the therapist's."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from adibas.cli.console import Console
from adibas.cli.options import add_json, seconds_range
from adibas.cli.recording_options import add_person, add_rotation
from adibas.cli.report_options import add_language, add_patient, check_report
from adibas.texts import decimal_text, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.pipeline.exercise import ExerciseCheck


def add_check_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the action takes."""
    parser.add_argument(
        "source",
        type=Path,
        metavar=_("RECORDING"),
        help=_(
            "of the patient: a recording, in which joints are found without markers, or a "
            "JOINTS.csv"
        ),
    )
    parser.add_argument(
        "--therapist",
        type=Path,
        required=True,
        metavar=_("RECORDING"),
        help=_("the same, in which the therapist shows the exercise"),
    )
    parser.add_argument(
        "--repetition",
        type=seconds_range,
        metavar="A:B",
        help=_("seconds of the therapist's recording that are one repetition; all if not given"),
    )
    add_rotation(parser)
    add_person(parser, _("who is the patient; the one who was seen longest if not given"))
    add_patient(parser)
    add_language(parser)
    parser.add_argument("--out", type=Path, metavar="report.xlsx", help=_("report to write"))
    add_json(parser)
    parser.set_defaults(action=run_check)


def run_check(arguments: argparse.Namespace, console: Console) -> int:
    """Find the repetitions, compare them, and say how they went."""
    from adibas.pipeline.exercise import ExerciseRequest, check_exercise

    if arguments.out is not None:
        check_report(arguments.out, (".xlsx",))
    request = ExerciseRequest(
        arguments.source,
        arguments.therapist,
        arguments.repetition,
        arguments.person,
        arguments.patient,
        rotation_deg=arguments.rotation,
    )
    with console.progress(_("Looking for repetitions")) as progress:
        check = check_exercise(request, progress)
    for notice in check.notices:
        console.warn(notice.text)
    _tell(check, console)
    if arguments.out is not None:
        from adibas.reports.exercise_excel import write_exercise_workbook

        write_exercise_workbook(check, arguments.out, arguments.language)
        console.say(str(arguments.out))
    console.give(_document(check))
    return 0


def _tell(check: "ExerciseCheck", console: Console) -> None:
    n = len(check.repetitions)
    console.say(translate_plural("{n} repetition found", "{n} repetitions found", n).format(n=n))
    for number, one in enumerate(check.repetitions, 1):
        reached = 100.0 * one.range_deg / _shown(check)
        lowest = min((value for value in reached if value == value), default=0.0)  # noqa: PLR0124
        console.say(
            _(
                "  {number}: {begin} to {end} s, {tempo} times the therapist's time, at least "
                "{reached} % of the range, distance {cost}"
            ).format(
                number=number,
                begin=decimal_text(one.begin_s, 2),
                end=decimal_text(one.end_s, 2),
                tempo=decimal_text(one.duration_s / check.model.duration_s, 2),
                reached=decimal_text(float(lowest), 0),
                cost=decimal_text(one.cost, 2),
            )
        )


def _shown(check: "ExerciseCheck") -> Any:
    return check.model.angles.deg.max(axis=0) - check.model.angles.deg.min(axis=0)


def _document(check: "ExerciseCheck") -> dict[str, Any]:
    from adibas.reports.exercise_rows import range_rows, symmetry_rows

    ranges = list(range_rows(check))
    symmetries = list(symmetry_rows(check))
    return {
        "angles": list(check.model.angles.names),
        "origin": check.done_origin,
        "therapist": {
            "origin": check.shown_origin,
            "duration_s": check.model.duration_s,
            "range_deg": _shown(check).tolist(),
        },
        "repetitions": [
            {
                "begin_s": one.begin_s,
                "end_s": one.end_s,
                "tempo": one.duration_s / check.model.duration_s,
                "distance": one.cost,
                "phases_s": dict(zip(("out", "held", "back"), one.phases_s, strict=True)),
                "ranges": [
                    {
                        "angle": row.angle,
                        "deg": row.range_deg,
                        "share": row.share,
                        "deviation_deg": row.deviation_deg,
                    }
                    for row in ranges
                    if row.number == number
                ],
                "symmetry": [
                    {"motion": row.motion, "index_percent": row.index_percent}
                    for row in symmetries
                    if row.number == number
                ],
            }
            for number, one in enumerate(check.repetitions, 1)
        ],
        "notices": [notice.text for notice in check.notices],
        "provenance": {
            "recording_sha256": check.provenance.recording_sha256,
            "version": check.provenance.version,
        },
    }
