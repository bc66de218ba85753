"""`adibas demo`: a whole posture session of the bundled demo patient."""

import argparse
from pathlib import Path

from adibas.cli.console import Console
from adibas.cli.options import add_json, add_out
from adibas.cli.sessions_recovery import tell_how_to_make_one
from adibas.errors import AdibasError, FileError
from adibas.files import check_place
from adibas.texts import message, spoken_language
from adibas.texts import translate as _

SIMULATOR = "ADiBAS simulator"
"""Name of the sensor in recordings of the simulator."""

STORE = "store"
PASSPHRASE = "adibas-demo"  # noqa: S105  (of a store that keeps nobody)
"""Of the demo's own store; it is told on the screen."""

SUMMARY = message("run a whole posture session of the simulated demo patient")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    add_out(
        parser,
        _("DIR"),
        _(
            "folder for recording.mcap, colours.json, report.xlsx, report.pdf and the patient "
            "store with the demo session; made if missing"
        ),
    )
    add_json(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Record, learn, analyse, report, take a session, and say where everything lies."""
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
    session_id = _take_session(arguments.out / STORE, demo.colors, console)
    console.say(_("The recording lies in {file}.").format(file=demo.recording))
    console.say(_("The report lies in {file}.").format(file=report))
    console.say(_("The report to print lies in {file}.").format(file=report.with_suffix(".pdf")))
    console.say(
        _("The demo session lies in {folder}; its passphrase is {passphrase}").format(
            folder=arguments.out / STORE, passphrase=PASSPHRASE
        )
    )
    tell_how_to_make_one(arguments.out / STORE, console)
    console.give(
        {
            "recording": str(demo.recording),
            "colours": str(demo.colors),
            "report": str(report),
            "report_pdf": str(report.with_suffix(".pdf")),
            "store": str(arguments.out / STORE),
            "session": session_id,
            "posture": posture_to_json(demo.analysis),
        }
    )
    return 0


def _take_session(folder: Path, colors: Path, console: Console) -> str:
    """Take the demo session into the demo's own store; return its id."""
    from adibas.pipeline import demo
    from adibas.pipeline.demo_session import take_demo_session
    from adibas.pipeline.learning import read_target
    from adibas.sessions import open_store

    with (
        open_store(folder, PASSPHRASE, operator="demo") as store,
        console.progress(_("Four views into the store")) as progress,
    ):
        target = read_target(str(colors))
        return take_demo_session(store, target, demo.N_FRAMES, progress).session_id


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
