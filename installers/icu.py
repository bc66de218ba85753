"""Takes from ICU's data what this program has no use for: other languages, dictionaries, old codes.

Qt asks ICU for the order of words, for capital letters, for names of time zones and for text in
codes of former times. Its data, all languages of the world, takes 31 MB; the rules for all and the
languages of the window stay. Where a table is missing, ICU goes by the rules for all.

Source: ICU's icu4c/source/common/ucmndata.h: a header, then a count, then for each table the places
of its name and of its content, counted from behind the header, in the order of the names.
"""

import re
import struct
import subprocess
import tempfile
from pathlib import Path, PurePosixPath

from installers.bundle import QT_LANGUAGES

LIBRARY = "PySide6/Qt/lib/libicudata.so.*"
MAGIC = b"\xda\x27"
ENTRY = struct.Struct("<II")
UNASKED = ("brkitr", "curr", "lang", "rbnf", "region", "translit", "unit")
"""Folders that Qt never asks for: words in scripts without spaces, currencies, names of languages,
numbers in words, countries, other scripts, units."""

UNASKED_KINDS = (".cfu", ".spp")
UNASKED_TABLE = "unames.icu"
"""Letters that look alike, names in networks (Qt has its own rules), names of letters."""

LANGUAGE = re.compile(r"[a-z]{2,3}(_\w+)?")
KEPT = ("root", *(name.partition("_")[0] for name in QT_LANGUAGES))
LARGEST_CODE = 16_000
"""Bytes; codes of one byte a letter are smaller, those of East Asia larger."""

ALIGNED = 16


def shorten(internal: Path) -> None:
    """Change the library of ICU's data, in the folder of all libraries."""
    (library,) = internal.glob(LIBRARY)
    symbol = _told("nm", "-D", "--defined-only", str(library)).split()[-1]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        whole, part, source = folder / "whole", folder / "part", folder / "source.s"
        _told("objcopy", "-O", "binary", "-j", ".rodata", str(library), str(whole))
        part.write_bytes(with_tables(whole.read_bytes()))
        source.write_text(
            f".section .rodata\n.balign {ALIGNED}\n.globl {symbol}\n.type {symbol},@object\n"
            f'{symbol}: .incbin "{part}"\n.size {symbol},.-{symbol}\n'
            '.section .note.GNU-stack,"",@progbits\n'
        )
        made = folder / library.name
        options = ["-shared", "-nostdlib", "-s", f"-Wl,-soname,{library.name}"]
        _told("gcc", *options, "-o", str(made), str(source))
        library.write_bytes(made.read_bytes())


def with_tables(data: bytes) -> bytes:
    """Return ICU's data with those tables alone that are needed."""
    (length,) = struct.unpack_from("<H", data)
    if data[2:4] != MAGIC:
        raise ValueError("ICU's data has another form. Leave it whole, or mend installers/icu.py.")
    header, body = data[:length], data[length:]
    kept = [(name, content) for name, content in _tables(body) if is_needed(name, len(content))]
    names, contents, places = b"", b"", []
    begin = 4 + ENTRY.size * len(kept)
    text = sum(len(name) + 1 for name, _content in kept)
    first = _rounded(begin + text)
    for name, content in kept:
        places.append(ENTRY.pack(begin + len(names), first + len(contents)))
        names += name.encode() + b"\0"
        contents += content.ljust(_rounded(len(content)), b"\0")
    table = struct.pack("<I", len(kept)) + b"".join(places) + names
    return header + table.ljust(first, b"\0") + contents


def _tables(body: bytes) -> list[tuple[str, bytes]]:
    (count,) = struct.unpack_from("<I", body)
    places = [ENTRY.unpack_from(body, 4 + ENTRY.size * at) for at in range(count)]
    ends = [content for _name, content in places[1:]] + [len(body)]
    return [
        (body[name : body.index(b"\0", name)].decode("ascii"), body[content:end])
        for (name, content), end in zip(places, ends, strict=True)
    ]


def is_needed(name: str, n_bytes: int) -> bool:
    """Say whether a table stays, such as ``icudt73l/coll/es.res``."""
    path = PurePosixPath(name)
    if path.parent.name in UNASKED or path.suffix in UNASKED_KINDS or path.name == UNASKED_TABLE:
        return False
    if path.suffix == ".cnv":
        return n_bytes <= LARGEST_CODE
    is_language = path.suffix == ".res" and LANGUAGE.fullmatch(path.stem) is not None
    return not is_language or path.stem.partition("_")[0] in (*KEPT, "pool", "res")


def _rounded(length: int) -> int:
    return -(-length // ALIGNED) * ALIGNED


def _told(*command: str) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout  # noqa: S603
