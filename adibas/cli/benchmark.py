"""`adibas benchmark`: our figures beside their references."""

import argparse
import importlib
import os
import platform
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

from adibas.cli.console import Console
from adibas.cli.options import add_json, positive
from adibas.errors import FileError
from adibas.texts import message
from adibas.texts import translate as _

SUMMARY = message(
    "measure accuracy, speed or reliability and print our figures beside their references"
)
RELIABILITY = "reliability"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.add_argument("kind", choices=("accuracy", "speed", RELIABILITY))
    parser.add_argument("names", nargs="*", metavar=_("NAME"), help=_("which; all of them if none"))
    parser.add_argument(
        "--quick", action="store_true", help=_("a small part of each, to see that it runs")
    )
    parser.add_argument(
        "--amount",
        type=positive,
        metavar=_("NUMBER"),
        help=_(
            "reliability: do so many now (kills, files of each kind, hours, ...); the next run "
            "goes on where this one ended"
        ),
    )
    add_json(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Run the benchmarks one after the other and print a table for each."""
    if arguments.amount is not None and arguments.kind != RELIABILITY:
        raise FileError("--amount is for reliability alone. Leave it out, or give --quick.")
    available = _available(arguments.kind)
    unknown = sorted(set(arguments.names) - set(available))
    if unknown:
        raise FileError(
            "There is no {kind} benchmark named {name}. There are: {names}.",
            kind=arguments.kind,
            name=unknown[0],
            names=", ".join(available),
        )
    table = importlib.import_module("benchmarks.table")
    console.say(
        _("{n_cores} cores, {machine}, Python {python}").format(
            n_cores=os.cpu_count(), machine=platform.machine(), python=platform.python_version()
        )
    )
    results: dict[str, object] = {}
    for name in arguments.names or available:
        module = importlib.import_module(f"benchmarks.{arguments.kind}_{name.replace('-', '_')}")
        console.say(f"\n{arguments.kind} {name}\n{table.HEADER}")
        rows = []
        for row in _rows(module, arguments, console):
            console.say(table.format_row(row))
            rows.append(row)
        results[name] = [
            {
                "name": row.name,
                "ours": row.ours,
                "unit": row.unit,
                "reference": row.reference,
                "reference_name": row.reference_name,
                "ratio": row.ratio,
            }
            for row in rows
        ]
    console.give({"kind": arguments.kind, "results": results})
    return 0


def _rows(module: ModuleType, arguments: argparse.Namespace, console: Console) -> Iterator[Any]:
    """Give the rows of one benchmark, with a bar where it takes hours."""
    if arguments.kind != RELIABILITY:
        yield from module.rows(quick=arguments.quick)
        return
    runs = importlib.import_module("benchmarks.long_run")
    with console.progress(module.__name__.rpartition("_")[2]) as progress:
        yield from module.rows(runs.Run(arguments.quick, arguments.amount, progress))


def _available(kind: str) -> list[str]:
    """Return the names of the benchmarks beside the package."""
    folder = Path(__file__).parents[2] / "benchmarks"
    stems = sorted(path.stem.removeprefix(f"{kind}_") for path in folder.glob(f"{kind}_*.py"))
    names = [stem.replace("_", "-") for stem in stems]
    if not names:
        raise FileError(
            "The benchmarks are not part of an installed program. Run this command in a source "
            "tree of ADiBAS."
        )
    return names
