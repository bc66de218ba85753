"""`adibas demo`: a whole posture session of the bundled demo patient."""

import argparse
from pathlib import Path

from adibas.cli.console import Console
from adibas.cli.options import add_json, add_out
from adibas.errors import AdibasError, FileError
from adibas.files import check_place
from adibas.texts import message, spoken_language
from adibas.texts import translate as _

SIMULATOR = "ADiBAS simulator"
"""Name of the sensor in recordings of the simulator."""

SUMMARY = message("run a whole posture session of the simulated demo patient")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    add_out(
        parser,
        _("DIR"),
        _("folder for recording.mcap, colours.json, report.xlsx and report.pdf; made if missing"),
    )
    add_json(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Record, learn, analyse, report, and say where the report lies."""
    from adibas.pipeline.demo import run_demo
    from adibas.pipeline.session_report import report_of_analysis
    from adibas.reports import write_report
    from adibas.reports.json_report import posture_to_json

    report = arguments.out / "report.xlsx"
    _see_that_nothing_is_lost(arguments.out / "recording.mcap")
    check_place(report)
    with console.progress(_("Demo session")) as progress:
        demo = run_demo(arguments.out, progress)
    shown = report_of_analysis(demo.analysis, spoken_language())
    write_report(shown, report)
    write_report(shown, report.with_suffix(".pdf"))
    console.say(_("The recording lies in {file}.").format(file=demo.recording))
    console.say(_("The report lies in {file}.").format(file=report))
    console.say(_("The report to print lies in {file}.").format(file=report.with_suffix(".pdf")))
    console.give(
        {
            "recording": str(demo.recording),
            "colours": str(demo.colors),
            "report": str(report),
            "report_pdf": str(report.with_suffix(".pdf")),
            "posture": posture_to_json(demo.analysis),
        }
    )
    return 0


def _see_that_nothing_is_lost(recording: Path) -> None:
    """Refuse to replace a recording that is not an earlier demo's."""
    from adibas.recordings import open_recording

    if not recording.exists():
        return
    try:
        with open_recording(recording) as reader:
            is_demo = reader.info.sensor_name == SIMULATOR
    except AdibasError:
        is_demo = False
    if not is_demo:
        raise FileError(
            "The folder {folder} has a {file} that is no demo, and the demo would replace it. Give "
            "--out another folder.",
            folder=recording.parent.name,
            file=recording.name,
        )
