"""Makes the built folder smaller, where what is left out is of no use to this program (Linux).

What a whole file of a library is, `installers/bundle.py` leaves out; here are the parts of files.
docs/installers.md has the sizes.
"""

import hashlib
import json
import os
import platform
import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from installers import icu, llvm, stand_ins

TABLES = "highdicom/_standard"
KINDS_OF_FILES = ("comprehensive-sr", "secondary-capture-image")
"""What DICOM calls the kinds of files that `adibas/exchange` lets highdicom write."""

SMALLEST_DUPLICATE = 4096
"""Bytes: smaller ones take a block on a disk, as a link does."""


def is_for_this_machine() -> bool:
    """Say whether the parts below are known for this system and processor."""
    return sys.platform == "linux" and platform.machine() == "x86_64"


def lighten(internal: Path, work: Path) -> None:
    """Change the folder of all libraries; what is compiled for that is kept in `work`."""
    shutil.copy(llvm.built_library(work), internal / "llvmlite" / "binding" / llvm.NAME)
    stand_ins.stand_in_for_all(internal)
    icu.shorten(internal)
    shorten_tables(internal / TABLES)
    link_duplicates(internal)


def shorten_tables(folder: Path) -> None:
    """Keep of DICOM's tables of modules what belongs to the kinds of files that are written."""
    paths = [folder / f"{name}_map.json" for name in ("iod_module", "module_attribute")]
    modules, attributes = (json.loads(path.read_text(encoding="utf-8")) for path in paths)
    kept = attributes_of(KINDS_OF_FILES, modules, attributes)
    of_kinds = {kind: modules[kind] for kind in KINDS_OF_FILES}
    for path, table in zip(paths, (of_kinds, kept), strict=True):
        path.write_text(json.dumps(table, separators=(",", ":")), encoding="utf-8")


def attributes_of(
    kinds: Sequence[str],
    modules: Mapping[str, Sequence[Mapping[str, str]]],
    attributes: Mapping[str, object],
) -> dict[str, object]:
    """Return the attributes of each module that one of some kinds of files has."""
    names = {module["key"] for kind in kinds for module in modules[kind]}
    return {name: found for name, found in attributes.items() if name in names}


def link_duplicates(folder: Path) -> None:
    """Put a link in the place of each file that is there twice."""
    first: dict[bytes, Path] = {}
    for path in _large_files(folder):
        same = first.setdefault(hashlib.sha256(path.read_bytes()).digest(), path)
        if same is not path:
            path.unlink()
            path.symlink_to(os.path.relpath(same, path.parent))


def _large_files(folder: Path) -> Iterator[Path]:
    for path in sorted(folder.rglob("*")):
        if path.is_file() and not path.is_symlink() and path.stat().st_size >= SMALLEST_DUPLICATE:
            yield path
