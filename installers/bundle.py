"""What goes into the frozen program, and what its libraries bring along and nobody needs."""

import hashlib
import sys
from collections.abc import Iterable
from fnmatch import fnmatch
from pathlib import Path

ROOT = Path(__file__).parent.parent
MIGRATIONS = "adibas/sessions/migrations"

Collected = tuple[str, str, str]
"""A file as PyInstaller lists it: its name in the bundle, where it comes from, its kind."""

EXCLUDED = (
    *("benchmarks", "tests", "anny", "dask", "distributed", "torch"),
    *("IPython", "PySide6.QtDBus", "PySide6.QtNetwork", "PySide6.QtOpenGL", "PySide6.QtTest"),
    *("tkinter", "tornado"),
    *("_pytest", "babel", "coverage", "dtaidistance", "hypothesis", "mcap", "mypy", "pip"),
    *("pygments", "pypdf", "pytest", "rich", "setuptools", "lz4", "charset_normalizer"),
    *("jinja2", "markdown", "mkdocs", "watchdog"),
    *("open3d", "skimage"),
    *(f"sqlalchemy.dialects.{database}" for database in ("mssql", "mysql", "oracle")),
    *("matplotlib.tests", "numba.cuda", "numba.tests", "pydoc_data"),
    *("cffi", "pycparser", "zstandard.backend_cffi"),  # compilers of C; for other Pythons
    *(f"narwhals.{tables}" for tables in ("_arrow", "_dask", "_duckdb", "_ibis", "_pandas_like")),
    *("narwhals._polars", "narwhals._spark_like", "narwhals._sql"),
)
"""Modules that a library would use if they were there, and those that only developers have."""

WITH_DATA = ("highdicom",)
"""Libraries that read files of their own which PyInstaller does not know of."""

UNSEEN = (
    "PySide6.QtOpenGLWidgets",
    "numba._devicearray",
    "numba.mviewbuf",
    "numba.np.ufunc._num_threads",
)
"""Modules that are imported by machine code or by a name put together, which nobody sees."""

QT_LANGUAGES = ("en", "es", "ca", "pt_BR")
UNNEEDED = (
    "PySide6/*plugins/platformthemes/*gtk3*",
    "PySide6/*plugins/platforms/*eglfs*",
    "PySide6/*plugins/platforms/*linuxfb*",
    "PySide6/*plugins/platforms/*minimal*",
    "PySide6/*plugins/platforms/*vkkhr*",
    "PySide6/*plugins/platforms/*vnc*",
    "PySide6/*plugins/*wayland*",  # all was tried with X only; Wayland has X, too
    "PySide6/*Qt6Wayland*",
    "PySide6/*Qt6WlShell*",
    "PySide6/*plugins/egldeviceintegrations/*",
    "PySide6/*plugins/generic/*",
    "PySide6/*plugins/networkinformation/*",
    "PySide6/*plugins/tls/*",
    "PySide6/*plugins/imageformats/*[!g].*",  # all but JPEG and SVG
    "PySide6/*Qt6EglF[sS]*",
    "PySide6/*Qt6Network*",
    "matplotlib/mpl-data/sample_data/*",
    "matplotlib/mpl-data/images/*",
    "matplotlib/mpl-data/fonts/afm/*",
    "matplotlib/mpl-data/fonts/pdfcorefonts/*",
    "matplotlib/mpl-data/fonts/ttf/DejaVuSerif*",
    "matplotlib/mpl-data/fonts/ttf/DejaVuSansMono-*",  # bold and slanted
    "numba/np/ufunc/tbbpool.*",  # of a library that is not there
    "PIL/_avif.*",
    "PIL/_webp.*",
    "pillow.libs/libavif*",
    "pillow.libs/libsharpyuv*",
    "pillow.libs/libwebp*",
    "pyqtgraph/icons/peegee/*",  # its own mark, for programs that make no QApplication
    *(f"sklearn/*.{ending}" for ending in ("build", "c", "cpp", "h", "pxd", "pyi", "pyx", "tp")),
    "sklearn/datasets/data/*",
    "sklearn/datasets/descr/*",
    "sklearn/datasets/images/*",
    "zstandard/_cffi.*",
    "resources/translations/*.po",  # what translators write; .mo and .qm are what is read
    "resources/translations/*.ts",
    "*.dist-info/RECORD",  # what pip is to remove
    "*/tests/*",
)
"""Files of no use here: screens without a window system, the network, pictures of kinds that are
neither read nor written, letters that no report has, sources of machine code, examples, tests."""

SYSTEM_FOLDERS = ("/lib/", "/lib64/", "/usr/lib/")


def excluded_modules() -> list[str]:
    """Return what PyInstaller is to leave out, in a fixed order."""
    return sorted(EXCLUDED)


def data_files() -> list[tuple[str, str]]:
    """Return the files that the program opens by path: (where they are, their folder there)."""
    return [
        (str(ROOT / "resources"), "resources"),
        (str(ROOT / MIGRATIONS), MIGRATIONS),  # alembic reads its steps as files
        (str(ROOT / "LICENSE"), "."),
    ]


def is_own_module(name: str) -> bool:
    """Say whether a module of ours belongs to a user's program."""
    return name != "adibas.simulation.export_body" and not name.startswith(
        MIGRATIONS.replace("/", ".")
    )


def without_unneeded(files: Iterable[Collected]) -> list[Collected]:
    """Return the files that are needed."""
    return [file for file in files if _is_needed(file)]


def _is_needed(file: Collected) -> bool:
    name = Path(file[1] if file[2] == "SYMLINK" else file[0]).as_posix()
    if any(fnmatch(name, pattern) for pattern in UNNEEDED):
        return False
    if name.startswith("PySide6/Qt/translations/"):
        return name.endswith(tuple(f"qtbase_{language}.qm" for language in QT_LANGUAGES))
    return not _is_of_the_system(name, file[1])


def _is_of_the_system(name: str, source: str) -> bool:
    """Say whether Debian's own package brings this library; ours depends on that package."""
    return (
        sys.platform == "linux"
        and "/" not in name
        and name.startswith("lib")
        and not name.startswith("libpython")
        and source.startswith(SYSTEM_FOLDERS)
    )


def sources_mark() -> str:
    """Return a number of all sources of the core, which tells shipped machine code from others."""
    digest = hashlib.sha256()
    for file in sorted((ROOT / "adibas").rglob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()
