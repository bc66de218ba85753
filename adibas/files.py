"""Files appear whole or not at all: written beside themselves, then renamed."""

import errno
import os
import re
import tokenize
import uuid
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from adibas.errors import FileError

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""No space on the disk, in the user's share of it, or in one file."""
DAMAGED_ARCHIVE = (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError)
"""What zipfile raises of a damaged archive, be it a workbook or arrays; RuntimeError where a part
seems encrypted, or packed in a way that it does not know."""
DAMAGED_ARRAYS = (
    *(*DAMAGED_ARCHIVE, ValueError, KeyError, TypeError, AttributeError, MemoryError),
    *(SyntaxError, tokenize.TokenError),
)
"""What NumPy raises of a damaged file of arrays, and what follows where one of them is of another
kind: heads of arrays are read as Python, and may tell of more numbers than there is memory."""
DAMAGED_JSON = (ValueError, RecursionError)
"""What json raises: it is none, no UTF-8, has a number of thousands of digits, or is nested too
deeply."""
UNFINISHED = re.compile(r"\.[0-9a-f]{32}(\.[\w-]+)?")
"""Names of files in the making."""
UNPRINTABLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff\ufffe\uffff]")
"""No XML file holds these; tab and line feed may stay."""
HALVES = re.compile("[\ud800-\udfff]")
"""Halves of characters, as of bytes that are no text, or escaped in JSON; no UTF-8 holds them."""


def printable(text: str) -> str:
    """Return the text with a box in place of characters that no file holds."""
    return UNPRINTABLE.sub("\N{WHITE SQUARE}", text)


def whole_letters(text: str) -> str:
    """Return the text with a box in place of halves of characters, which no UTF-8 holds."""
    return HALVES.sub("\N{WHITE SQUARE}", text)


def check_document(document: Mapping[str, Any], kind: str, version: int) -> None:
    """Refuse a JSON document of another format or version than is asked for.

    Raises
    ------
    ValueError
        It is.
    """
    if (document.get("format"), document.get("version")) != (kind, version):
        raise ValueError(f"the document is no {kind} of version {version}")


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Give a path beside `path` to write to, and rename it to `path` when all went well.

    The folder is made where it is missing. After any exception the unfinished file is removed and
    what stood at `path` is untouched.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = path.parent / f".{uuid.uuid4().hex}{path.suffix}"
        unfinished.open("xb").close()
    except OSError as error:
        raise cannot_write(path, error) from error
    try:
        yield unfinished
        _flush_to_disk(unfinished)
        unfinished.replace(path)
        flush_folder(path.parent)
    except OSError as error:
        raise cannot_write(path, error) from error
    finally:
        unfinished.unlink(missing_ok=True)


def unfinished_in(folder: Path) -> list[Path]:
    """Return what is in the making in `folder`, or was left so by a crash in `written_whole`.

    Raises
    ------
    OSError
        The folder cannot be read.
    """
    return [path for path in folder.iterdir() if UNFINISHED.fullmatch(path.name)]


def remove_unfinished(folder: Path) -> int:
    """Remove what a crash within `written_whole` left in `folder`; return how many files.

    Only where no other process writes: a file in the making looks the same.

    Raises
    ------
    OSError
        The folder cannot be read or written.
    """
    unfinished = unfinished_in(folder)
    for path in unfinished:
        path.unlink(missing_ok=True)
    return len(unfinished)


def is_there(path: Path) -> bool:
    """Say whether a file or a folder is there.

    Raises
    ------
    FileError
        Nobody can say, as where a network share is gone.
    """
    try:
        return path.exists()
    except OSError as error:
        raise cannot_read(path, error) from error


def check_place(path: Path) -> None:
    """See, before long work, that a file can be written at `path`; nothing is written yet.

    Raises
    ------
    FileError
        A folder has that name, a file stands where a folder must be, or it may not be written.
    """
    try:
        if path.is_dir():
            raise FileError(
                "{file} is a folder. Give the name of a file in it.", file=path.name or str(path)
            )
        folder = next(parent for parent in path.absolute().parents if parent.exists())
        if not folder.is_dir():
            raise FileError(
                "{file} cannot be written: {folder} is a file and no folder. Choose another "
                "folder.",
                file=path.name,
                folder=folder.name,
            )
    except OSError as error:
        raise cannot_write(path, error) from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise FileError(
            "{file} cannot be written: nothing may be written into {folder}. Choose another "
            "folder.",
            file=path.name,
            folder=folder.name or str(folder),
        )


def cannot_read(path: Path, error: OSError) -> FileError:
    """Say in words why `path` cannot be read."""
    return FileError(
        "{file} cannot be read: {reason}. Check the name, and that the disk is there.",
        file=path.name,
        reason=error.strerror or str(error),
    )


def cannot_write(path: Path, error: OSError) -> FileError:
    """Say in words why `path` cannot be written."""
    if error.errno in FULL:
        return FileError(
            "{file} cannot be written: the disk is full. Free some space and try again.",
            file=path.name,
        )
    return FileError(
        "{file} cannot be written: {reason}. Choose another folder, or close the program that "
        "uses it.",
        file=path.name,
        reason=error.strerror or str(error),
    )


def remove_file(path: Path) -> None:
    """Remove a file; one that is gone already is no mistake.

    Raises
    ------
    FileError
        It cannot be removed.
    """
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise FileError(
            "{file} cannot be removed: {reason}. Close the program that uses it.",
            file=path.name,
            reason=error.strerror or str(error),
        ) from error


def flush_folder(folder: Path) -> None:
    """Wait until the names in `folder` are on the disk; Windows keeps them in its journal."""
    if os.name == "nt":
        return
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except PermissionError:  # it may be written into but not read
        return
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:  # network disks that flush files alone
            raise
    finally:
        os.close(descriptor)


def _flush_to_disk(path: Path) -> None:
    with path.open("rb+") as file:
        os.fsync(file.fileno())
