"""Reads the command line, runs one command, turns failures of the world into sentences."""

import argparse
import gettext
import importlib
import io
import os
import signal
import sys
from collections.abc import Sequence
from types import FrameType
from typing import Protocol, cast

from adibas import __version__
from adibas.cli.console import Console
from adibas.cli.interrupts import WorkKept, is_interrupt, no_interrupt_lost
from adibas.cli.options import sentence
from adibas.errors import AdibasError
from adibas.resources import resource_path
from adibas.texts import DOMAIN, describe, system_language
from adibas.texts import translate as _

WORLD_FAILED = 1

COMMANDS = (
    "demo",
    "posture",
    "movement",
    "pose",
    "map",
    "body",
    "skeleton",
    "calibrate",
    "wand",
    "markers",
    "convert",
    "record",
    "sessions",
    "export",
    "protocols",
    "doctor",
    "gestures",
    "limbs",
    "behaviour",
    "coding",
    "benchmark",
)


class CommandModule(Protocol):
    """What the modules of `COMMANDS` offer; each imports its heavy parts in `run`."""

    SUMMARY: str

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Say what the command takes."""

    def run(self, arguments: argparse.Namespace, console: Console) -> int:
        """Do it and return the exit code."""


def main(argv: Sequence[str]) -> int:
    """Run one command and return the exit code: 0 done, 1 the world failed, 2 wrong usage."""
    signal.signal(signal.SIGTERM, _interrupt)
    _print_any_text()
    console = Console(is_json=False)
    _translate_argparse()
    try:
        arguments = build_parser().parse_args(argv)
        console = Console(is_json=getattr(arguments, "json", False))
        with no_interrupt_lost():
            code = cast(CommandModule, arguments.module).run(arguments, console)
        console.flush()
    except AdibasError as error:
        console.warn(describe(error))
    except (KeyboardInterrupt, SystemError) as error:
        if not is_interrupt(error):
            raise
        console.warn(_stopped(error))
    except BrokenPipeError:
        _forget_stdout()
    except OSError as error:
        # Files have sentences of their own; this is what nobody foresaw, such as a full stdout.
        _forget_stdout()
        console.warn(_unforeseen(error))
    else:
        return code
    return WORLD_FAILED


def _stopped(error: BaseException) -> str:
    if isinstance(error, WorkKept):
        told = _("Stopped. What is done lies in {name}; the same command goes on from there.")
        return told.format(name=error.place.name)
    return _("Stopped. No unfinished file was left behind.")


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of all commands."""
    parser = argparse.ArgumentParser(
        prog="adibas", description=_("Posture and movement, measured with a depth camera.")
    )
    parser.add_argument(
        "--version",
        action="version",
        version=f"adibas {__version__}",
        help=_("show the version of the program and exit"),
    )
    subparsers = parser.add_subparsers(metavar=_("COMMAND"), required=True)
    for name in COMMANDS:
        module = cast(CommandModule, importlib.import_module(f"adibas.cli.{name}"))
        subparser = subparsers.add_parser(
            name, help=_(module.SUMMARY), description=sentence(_(module.SUMMARY))
        )
        module.add_arguments(subparser)
        subparser.set_defaults(module=module)
    return parser


def _translate_argparse() -> None:
    """Let argparse take its own words from our catalogues: it asks gettext's default domain."""
    os.environ.setdefault("LANGUAGE", system_language())  # Windows has no such variable
    gettext.bindtextdomain(DOMAIN, resource_path("translations"))
    gettext.textdomain(DOMAIN)


def _print_any_text() -> None:
    """Let stdout escape what its encoding lacks, as stderr does."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def _forget_stdout() -> None:
    """Let nothing more go to a stdout that takes nothing; Python would fail on it at its end."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (AttributeError, OSError, ValueError):  # there is none, or it is no file
        return


def _unforeseen(error: OSError) -> str:
    reason = error.strerror or str(error)
    if error.filename is None:
        return _("The output cannot be written: {reason}. Free some space and try again.").format(
            reason=reason
        )
    return _("{file} cannot be used: {reason}. Check the name, and that the disk is there.").format(
        file=os.path.basename(os.fsdecode(error.filename)),  # noqa: PTH119  (may be a number)
        reason=reason,
    )


def _interrupt(_signal: int, _frame: FrameType | None) -> None:
    """End a SIGTERM as Ctrl-C ends, so that files are closed whole."""
    raise KeyboardInterrupt
