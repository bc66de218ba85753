"""`adibas demo`: a whole posture session of the bundled demo patient."""

import argparse

from adibas.cli.console import Console
from adibas.cli.options import add_json, add_out
from adibas.texts import translate as _

SUMMARY = "run a whole posture session of the simulated demo patient"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    add_out(parser, "DIR")
    add_json(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Record, learn, analyse, report, and say where the report lies."""
    from adibas.pipeline.demo import run_demo
    from adibas.reports import write_posture_report
    from adibas.reports.json_report import posture_to_json

    with console.progress(_("Demo session")) as progress:
        demo = run_demo(arguments.out, progress)
    report = arguments.out / "report.xlsx"
    write_posture_report(demo.analysis, report)
    console.say(_("The recording lies in {file}.").format(file=demo.recording))
    console.say(_("The report lies in {file}.").format(file=report))
    console.give(
        {
            "recording": str(demo.recording),
            "colours": str(demo.colors),
            "report": str(report),
            "posture": posture_to_json(demo.analysis),
        }
    )
    return 0
