"""`adibas doctor`: what this machine has and lacks."""

import argparse

from adibas.cli.console import Console
from adibas.cli.options import add_json
from adibas.texts import message
from adibas.texts import translate as _

SUMMARY = message("show what this machine has and lacks, and how to get it")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    add_json(parser)


def run(_arguments: argparse.Namespace, console: Console) -> int:
    """Print one line a finding; what is lacking is told, it is no failure."""
    from adibas.sensors.doctor import findings

    found = findings()
    width = max(len(finding.name) for finding in found)
    for finding in found:
        mark = _("ok") if finding.ok else "--"
        console.say(f"{mark:>3}  {finding.name:<{width}}  {finding.detail}")
        if finding.remedy:
            console.say(f"{'':>3}  {'':<{width}}  -> {finding.remedy}")
    console.give(
        {
            "findings": [
                {"name": f.name, "ok": f.ok, "detail": f.detail, "remedy": f.remedy} for f in found
            ]
        }
    )
    return 0
