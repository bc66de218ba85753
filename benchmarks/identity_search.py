"""Searches every byte of files for who somebody is, also within what is packed.

Unpacked are: zip archives (workbooks, arrays), whatever zlib or zstandard has packed (PNG, PDF,
recordings), base64 (pictures and PDFs within JSON), PDFs as a reader decodes them, text and all.
"""

import base64
import binascii
import io
import re
import zipfile
import zlib
from collections.abc import Iterable, Iterator
from pathlib import Path

import zstandard
from pypdf import PdfReader
from pypdf.errors import PyPdfError
from pypdf.generic import StreamObject

from adibas.data.patients import Identity

ENCODINGS = ("utf-8", "latin-1", "utf-16-le", "utf-16-be", "cp1252")
ZLIB_HEADS = (b"\x78\x01", b"\x78\x5e", b"\x78\x9c", b"\x78\xda")
ZSTD_HEAD = b"\x28\xb5\x2f\xfd"
BASE64 = re.compile(rb"[A-Za-z0-9+/]{64,}={0,2}")
MOST_BYTES = 64 * 2**20
DEEPEST = 4
LEAST_LETTERS = 5
"""Of a part of a name that is searched alone: shorter ones stand in any picture by chance."""


def secrets_of(identity: Identity) -> tuple[str, ...]:
    """Return what must not be found: the name and its parts, birth date and record number."""
    parts = re.split(r"[\s,-]+", identity.name)
    texts = [identity.name, identity.record_number, *parts]
    born = identity.birth_date
    if born is not None:
        day, month, year = born.day, born.month, born.year
        texts += [
            born.isoformat(), f"{year}{month:02}{day:02}", f"{day:02}/{month:02}/{year}",
            f"{day}/{month}/{year}", f"{month}/{day}/{year}", f"{day:02}.{month:02}.{year}",
        ]  # fmt: skip
    return tuple(dict.fromkeys(text for text in texts if len(text) >= LEAST_LETTERS))


def found_in(data: bytes, secrets: Iterable[str]) -> set[str]:
    """Return which of the texts stand in `data`, in large or small letters, however packed."""
    wanted = [(text, _written(text)) for text in secrets]
    found = set()
    for piece in unpacked(data):
        small = piece.lower()
        found |= {text for text, ways in wanted if any(way in small for way in ways)}
    return found


def found_below(folder: Path, secrets: Iterable[str]) -> dict[str, set[str]]:
    """Return what of the texts stands in names and contents of all files below a folder."""
    secrets = tuple(secrets)
    told = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        found = found_in(name.encode(), secrets)
        if path.is_file() and not path.is_symlink():
            found |= found_in(path.read_bytes(), secrets)
        if found:
            told[name] = found
    return told


def unpacked(data: bytes, depth: int = 0) -> Iterator[bytes]:
    """Give `data` and all that is packed in it."""
    yield data
    if depth == DEEPEST:
        return
    inner: list[bytes] = []
    if data[:2] == b"PK":
        inner += _of_zip(data)
    if b"%PDF-" in data[:1024]:
        inner += _of_pdf(data)
    inner += _of_zlib(data)
    inner += _of_zstd(data)
    inner += _of_base64(data)
    for piece in inner:
        yield from unpacked(piece, depth + 1)


def _written(text: str) -> set[bytes]:
    ways = set()
    for encoding in ENCODINGS:
        for one in (text, text.lower()):
            try:
                ways.add(one.encode(encoding).lower())
            except UnicodeEncodeError:
                continue
    escaped = text.encode("unicode_escape").lower()  # as JSON writes other than ASCII
    return {*ways, escaped, re.sub(rb"\\x([0-9a-f]{2})", rb"\\u00\1", escaped)}


def _of_zip(data: bytes) -> Iterator[bytes]:
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            yield archive.comment
            for part in archive.infolist():
                yield part.filename.encode() + part.comment + part.extra
                yield archive.read(part)
    except (zipfile.BadZipFile, zlib.error, RuntimeError):
        return


def _of_pdf(data: bytes) -> Iterator[bytes]:
    try:
        reader = PdfReader(io.BytesIO(data))
        yield str(dict(reader.metadata or {})).encode()
        for page in reader.pages:
            yield page.extract_text().encode()
        for number in range(1, len(reader.xref_objStm) + sum(map(len, reader.xref.values())) + 1):
            thing = reader.get_object(number)
            yield thing.get_data() if isinstance(thing, StreamObject) else str(thing).encode()
    except (PyPdfError, ValueError, KeyError, NotImplementedError):
        return


def _of_zlib(data: bytes) -> Iterator[bytes]:
    for head in ZLIB_HEADS:
        at = data.find(head)
        while at >= 0:
            try:
                plain = zlib.decompressobj().decompress(data[at:], MOST_BYTES)
            except zlib.error:
                plain = b""
            if len(plain) >= LEAST_LETTERS:
                yield plain
            at = data.find(head, at + 1)


def _of_zstd(data: bytes) -> Iterator[bytes]:
    at = data.find(ZSTD_HEAD)
    while at >= 0:
        try:
            with zstandard.ZstdDecompressor().stream_reader(data[at:]) as reader:
                yield reader.read(MOST_BYTES)
        except zstandard.ZstdError:
            pass
        at = data.find(ZSTD_HEAD, at + 1)


def _of_base64(data: bytes) -> Iterator[bytes]:
    for match in BASE64.finditer(data):
        try:
            yield base64.b64decode(match.group(), validate=True)
        except binascii.Error:
            continue
