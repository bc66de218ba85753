"""Collects the texts of the program, brings the catalogues up to date, and compiles them.

Run by `make translations`. A text is collected where it is an argument of `_` (`translate`),
`translate_plural`, `message`, an `AdibasError`, or of a function with a parameter ``message_id``.
What has no translation yet is told, and left empty for the translator. What Qt itself does not say
in a language stands in ``qt.ts`` beside the catalogue; Qt's own program compiles it.
"""

import ast
import inspect
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from babel.messages import Catalog
from babel.messages.extract import extract_from_file
from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po, write_po
from PySide6 import __file__ as qt_file

from adibas import errors
from adibas.resources import resource_path
from adibas.texts import DOMAIN, LANGUAGES

ROOT = Path(__file__).parent.parent
PACKAGES = ("adibas", "ui")
SOURCE_LANGUAGE = "en"
LINE_WIDTH = 100
HEADER = """\
# Texts of ADiBAS. Translate here, then run `make translations`.
#"""

Keywords = dict[str, tuple[int, ...] | None]
MessageId = str | tuple[str, ...]

ARGPARSE_MESSAGES: tuple[MessageId, ...] = (
    "usage: ",
    "positional arguments",
    "options",
    "subcommands",
    "show this help message and exit",
    "%(prog)s: error: %(message)s\n",
    "argument %(argument_name)s: %(message)s",
    "the following arguments are required: %s",
    "one of the arguments %s is required",
    "unrecognized arguments: %s",
    "not allowed with argument %s",
    "ignored explicit argument %r",
    "ambiguous option: %(option)s could match %(matches)s",
    "unexpected option string: %s",
    "invalid %(type)s value: %(value)r",
    "invalid choice: %(value)r (choose from %(choices)s)",
    "unknown parser %(parser_name)r (choices: %(choices)s)",
    "expected one argument",
    "expected at most one argument",
    "expected at least one argument",
    ("expected %s argument", "expected %s arguments"),
)
"""What argparse of Python 3.11 to 3.13 says to a user; it looks them up in our catalogue."""


def source_files() -> Iterator[Path]:
    """Yield the files that may hold texts, in a fixed order."""
    for package in PACKAGES:
        yield from sorted((ROOT / package).rglob("*.py"))


def error_names() -> frozenset[str]:
    """Return the names of `AdibasError` and its children."""
    return frozenset(
        name
        for name, kind in inspect.getmembers(errors, inspect.isclass)
        if issubclass(kind, errors.AdibasError)
    )


def functions_with_message_id() -> dict[str, int]:
    """Return the names of the functions that take a ``message_id``, and its place from 1."""
    places: dict[str, int] = {}
    for file in source_files():
        text = file.read_text(encoding="utf-8")
        if "message_id" not in text:  # parsing all files takes seconds
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef) and node.name != "__init__":
                names = [argument.arg for argument in node.args.args if argument.arg != "self"]
                if "message_id" in names:
                    places[node.name] = names.index("message_id") + 1
    return places


def keywords() -> Keywords:
    """Return what marks a text, as Babel takes it."""
    marks: Keywords = dict.fromkeys(("_", "translate", "message", *error_names()), (1,))
    marks |= {name: (place,) for name, place in functions_with_message_id().items()}
    return marks | {"translate_plural": (1, 2)}


def collected() -> Catalog:
    """Return all texts of the source tree, without translations."""
    template = Catalog(project="ADiBAS", version="texts", charset="utf-8")
    marks = keywords()
    for file in source_files():
        name = file.relative_to(ROOT).as_posix()
        for line, text, _comments, _context in extract_from_file("python", file, keywords=marks):
            template.add(text, locations=[(name, line)])
    for text in ARGPARSE_MESSAGES:
        template.add(text, locations=[("argparse", 1)])
    return template


def catalogue_path(language: str, suffix: str = ".po") -> Path:
    """Return where the catalogue of a language lies."""
    folder = resource_path("translations", language, "LC_MESSAGES")
    return (folder / DOMAIN).with_suffix(suffix)


def read_catalogue(language: str) -> Catalog:
    """Return the translations of a language; none where it is new."""
    path = catalogue_path(language)
    if not path.is_file():
        return Catalog(locale=language, project="ADiBAS", version="texts", charset="utf-8")
    with path.open("rb") as file:
        return read_po(file, locale=language, abort_invalid=True)


def bring_up_to_date(catalogue: Catalog, template: Catalog) -> None:
    """Add what is new in `template` and forget what is gone; no translation is guessed."""
    template.creation_date = catalogue.creation_date  # else every run would change the file
    catalogue.update(template, no_fuzzy_matching=True)
    catalogue.obsolete.clear()
    catalogue.header_comment = HEADER
    for text in catalogue:
        if "argparse" not in (name for name, _line in text.locations):
            text.flags.discard("python-format")  # "95 % from" is no format


def write_catalogue(catalogue: Catalog, language: str) -> None:
    """Write the catalogue for people and, compiled, for the program."""
    path = catalogue_path(language)
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as file:
        write_po(file, catalogue, width=LINE_WIDTH, sort_output=True, include_lineno=False)
    with catalogue_path(language, ".mo").open("wb") as file:
        write_mo(file, catalogue)


def untranslated(catalogue: Catalog) -> list[str]:
    """Return the texts with an empty form."""
    empty = []
    for text in catalogue:
        forms = text.string if isinstance(text.string, tuple | list) else (text.string,)
        if text.id and not all(forms):
            empty.append(text.id if isinstance(text.id, str) else text.id[0])
    return empty


def compile_qt(source: Path, compiled: Path) -> None:
    """Compile what Qt lacks in a language, as Qt reads it."""
    program = Path(qt_file).with_name("lrelease")
    command = [program, "-silent", source, "-qm", compiled]
    subprocess.run(command, check=True)  # noqa: S603


def main() -> int:
    """Bring all catalogues up to date; the exit code tells whether a text lacks a translation."""
    n_missing = 0
    for language in LANGUAGES:
        if language == SOURCE_LANGUAGE:
            continue
        catalogue = read_catalogue(language)
        bring_up_to_date(catalogue, collected())
        write_catalogue(catalogue, language)
        missing = untranslated(catalogue)
        n_missing += len(missing)
        for text in missing:
            sys.stderr.write(f"{language}: no translation of {text!r}\n")
    for source in sorted(resource_path("translations").glob("*/qt.ts")):
        compile_qt(source, source.with_suffix(".qm"))
    return 1 if n_missing else 0


if __name__ == "__main__":
    sys.exit(main())
