"""`adibas protocols`: which protocols there are, what is in one, and whether a file is right."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from adibas.cli.console import Console
from adibas.cli.options import add_json
from adibas.texts import describe, message, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.data.protocols import Protocol

SUMMARY = message("list, show or check protocols of landmarks and measures")

HAS_MISTAKES = 1

Work = Callable[[argparse.Namespace, Console], int]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    actions = parser.add_subparsers(metavar=_("ACTION"), required=True)

    def add(name: str, summary: str, work: Work) -> argparse.ArgumentParser:
        action = actions.add_parser(name, help=summary, description=summary)
        action.set_defaults(work=work)
        add_json(action)
        return action

    add("list", _("Protocols that come with the program, and your own."), _list)
    showing = add("show", _("Landmarks and measures of one protocol, view by view."), _show)
    showing.add_argument("protocol", metavar=_("NAME"), help=_("its name, or a .json file"))
    checking = add("check", _("Every mistake of a protocol file, with its line."), _check)
    checking.add_argument("file", type=Path, metavar=_("FILE"), help=_("a protocol file"))


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Do what was asked."""
    work: Work = arguments.work
    return work(arguments, console)


def _list(_arguments: argparse.Namespace, console: Console) -> int:
    from adibas.measures.protocol_file import check_protocol
    from adibas.measures.protocol_store import own_folder, protocol_files

    documents = []
    for name, path in sorted(protocol_files().items()):
        checked = check_protocol(path)
        if checked.protocol is None:
            console.warn(describe(checked.errors[0]))
            continue
        protocol = checked.protocol
        console.say(f"{name}  {protocol.title.text}  {_measures(protocol)}")
        documents.append(_summary(name, protocol))
    console.say(_("Your own protocols lie in {folder}.").format(folder=own_folder()))
    console.give({"protocols": documents})
    return 0


def _show(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.measures.protocol_store import find_protocol

    protocol = find_protocol(arguments.protocol)
    console.say(f"{protocol.title.text}  {_measures(protocol)}")
    console.say(protocol.source)
    views = []
    for view in protocol.views:
        definitions = protocol.measures_of(view)
        needed = protocol.marked_for(tuple(p for one in definitions for p in one.points))
        console.say(f"{view}: {', '.join(needed)}")
        for one in definitions:
            positive = "" if one.positive is None else f"  (+ {one.positive.text})"
            console.say(f"    {one.measure_id}  {one.name.text} [{_(one.unit)}]{positive}")
        views.append(
            {
                "view": view,
                "landmarks": list(needed),
                "measures": [one.measure_id for one in definitions],
            }
        )
    console.give({**_summary(protocol.protocol_id, protocol), "views": views})
    return 0


def _check(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.measures.protocol_file import check_protocol

    checked = check_protocol(arguments.file)
    for error in checked.errors:
        console.warn(describe(error))
    mistakes = [
        {"line": error.fields.get("line"), "message": str(error)} for error in checked.errors
    ]
    console.give({"file": arguments.file.name, "is_valid": not mistakes, "mistakes": mistakes})
    if checked.protocol is None:
        return HAS_MISTAKES
    console.say(
        _("{file} is right: {measures}.").format(
            file=arguments.file.name, measures=_measures(checked.protocol)
        )
    )
    return 0


def _measures(protocol: "Protocol") -> str:
    n_measures = len(protocol.measures)
    return translate_plural("{n} measure", "{n} measures", n_measures).format(n=n_measures)


def _summary(name: str, protocol: "Protocol") -> dict[str, Any]:
    return {
        "name": name,
        "title": protocol.title.text,
        "revision": protocol.revision,
        "source": protocol.source,
        "n_measures": len(protocol.measures),
        "views": list(protocol.views),
    }
