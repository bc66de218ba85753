"""Machine code that comes with an installed program, so that nobody waits for the compiler.

numba knows its cache by the path and the content of a source file. A frozen program has neither:
here the module's name takes the place of the path, and the mark of the build that of the content.
`installers.freezing` fills the folder; in a source tree there is none, and nothing here is used.
"""

import os
import platform
from collections.abc import Callable
from copy import copy
from functools import cache
from pathlib import Path
from typing import Any

from adibas.resources import resource_path

MARK_FILE = "sources.txt"
PACKED = ".zst"
"""Added to the names of numba's files of machine code, which are packed to two fifths."""

X86_KIND = "x86-64-v2"
X86_FEATURES = frozenset({"popcnt", "sse4.1", "sse4.2", "ssse3"})
"""What compilers call a kind of processor, and LLVM's names of what it has over the first of them.
With less numpy does not run either; code for newer kinds was not faster (docs/installers.md)."""


@cache
def shipped_folder() -> Path | None:
    """Return the folder of the shipped machine code that this processor can run, or None."""
    if build_mark() is None:
        return None
    folder = resource_path("kernels", processor_kind())
    return folder if folder.is_dir() else None


@cache
def build_mark() -> str | None:
    """Return what distinguishes the shipped sources from others; None where nothing is shipped."""
    path = resource_path("kernels", MARK_FILE)
    return path.read_text(encoding="utf-8").strip() if path.is_file() else None


def processor_kind() -> str:
    """Return the kind that code is shipped for, or ``host`` where this processor is less."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return "generic"
    from llvmlite import binding

    has = {name for name, is_there in binding.get_host_cpu_features().items() if is_there}
    return X86_KIND if has >= X86_FEATURES else "host"


def use_shipped_kernels() -> None:
    """Let numba, which is not imported yet, compile as the shipped code was, and find that."""
    if build_mark() is None:
        return
    os.environ["NUMBA_CACHE_LOCATOR_CLASSES"] = f"{__name__}.ModuleLocator"
    if shipped_folder() is not None:
        os.environ["NUMBA_CPU_NAME"] = processor_kind()
        os.environ["NUMBA_CPU_FEATURES"] = ""  # those of that kind, no others


class ModuleLocator:
    """Names the places of numba's cache for the functions of one module.

    numba asks for the methods of its own locators by these names.
    """

    def __init__(self, function: Callable[..., Any], source: str) -> None:
        self._py_file = source
        self._module = function.__module__
        self._line = function.__code__.co_firstlineno

    @classmethod
    def from_function(cls, function: Callable[..., Any], source: str) -> "ModuleLocator":
        """Return the locator of a function."""
        return cls(function, source)

    def get_cache_path(self) -> str:
        """Return the folder of this user for what was not shipped."""
        return str(Path(os.environ["NUMBA_CACHE_DIR"]) / self._module)

    def ensure_cache_path(self) -> None:
        """Make that folder; numba asks before it writes."""
        Path(self.get_cache_path()).mkdir(parents=True, exist_ok=True)

    def get_source_stamp(self) -> str | None:
        """Return the mark of the build."""
        return build_mark()

    def get_disambiguator(self) -> str:
        """Return what distinguishes two functions of one name."""
        return str(self._line)


def look_among_shipped(dispatcher: Any) -> None:
    """Let a compiled function look among the shipped machine code before it asks its own cache."""
    folder = shipped_folder()
    if folder is None:
        return
    from numba.core import caching

    own = dispatcher._cache  # noqa: SLF001  (numba offers no other place)
    shipped, load = copy(own), own.load_overload
    place = str(folder / dispatcher.py_func.__module__), own._impl.filename_base  # noqa: SLF001
    files: Any = caching.IndexDataCacheFile
    shipped._cache_file = files(*place, build_mark())  # noqa: SLF001
    shipped._cache_file._load_data = lambda name: _unpacked(Path(place[0]) / name)  # noqa: SLF001

    def load_shipped_first(signature: object, context: object) -> object:
        found = shipped.load_overload(signature, context)
        return load(signature, context) if found is None else found

    own.load_overload = load_shipped_first


def _unpacked(path: Path) -> object:
    """Return what numba wrote to a file, which was packed afterwards."""
    import pickle  # noqa: TID251  (numba's own form; the builder wrote the file)

    import zstandard

    packed = path.with_name(path.name + PACKED).read_bytes()
    return pickle.loads(zstandard.decompress(packed))  # noqa: S301
