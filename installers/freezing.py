"""Makes `dist/adibas` (macOS: `dist/ADiBAS.app`), which runs where no Python is installed.

PyInstaller collects; then parts that are of no use go, and debug symbols, and the program that was
just built compiles its own hot loops, so that no user waits for that.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import zstandard

from adibas.shipped_kernels import MARK_FILE, PACKED, processor_kind
from installers.bundle import ROOT, sources_mark
from installers.lightening import is_for_this_machine, lighten
from installers.start import COMPILE

BUILT = ROOT / "dist" / ("ADiBAS.app/Contents" if sys.platform == "darwin" else "adibas")
PROGRAMS = {"darwin": "MacOS/adibas", "win32": "adibas.exe"}
RESOURCES = {"darwin": "Frameworks/resources"}
"""Where they lie in the built folder, where it is not as on Linux."""

WORK = ROOT / "build"
MANUAL = ROOT / "resources" / "manual" / "index.html"
SPEC = ROOT / "installers" / "adibas.spec"
MOST_PACKED = 19
STRIP = "llvm-strip-22"
"""That of binutils breaks libraries that were renamed within wheels."""


def freeze() -> Path:
    """Build the whole folder and return it."""
    need_manual()
    collect()
    if is_for_this_machine():
        lighten(BUILT / "_internal", WORK)
    if sys.platform == "linux":
        strip_symbols(BUILT)
    add_kernels(BUILT)
    return BUILT


def need_manual() -> None:
    """End where the manual was not built: the program would have no help but the short one."""
    if not MANUAL.is_file():
        raise SystemExit("There is no manual. Build it: python -m installers.manual.build")


def collect() -> None:
    """Run PyInstaller."""
    folders = ["--distpath", str(ROOT / "dist"), "--workpath", str(WORK / "pyinstaller")]
    command = [sys.executable, "-m", "PyInstaller", "--noconfirm", "--log-level", "WARN"]
    subprocess.run([*command, *folders, str(SPEC)], check=True, cwd=ROOT)  # noqa: S603


def strip_symbols(folder: Path) -> None:
    """Take away what only a debugger reads: a tenth of the size."""
    found = (path for ending in (".so", ".so.*") for path in folder.rglob(f"*{ending}"))
    files = [str(path) for path in found if path.is_file() and not path.is_symlink()]
    subprocess.run([STRIP, "--strip-unneeded", *files], check=True)  # noqa: S603


def add_kernels(folder: Path) -> None:
    """Compile the hot loops, by the program that will look for them."""
    program = folder / PROGRAMS.get(sys.platform, "adibas")
    place = folder / RESOURCES.get(sys.platform, "_internal/resources") / "kernels"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    mark = sources_mark()
    (place / MARK_FILE).write_text(mark + "\n", encoding="utf-8")
    kept = WORK / "kernels" / mark / processor_kind()
    if not kept.is_dir():
        compile_into(kept, program)
    shutil.copytree(kept, place / kept.name)
    pack(place)


def pack(folder: Path) -> None:
    """Pack the machine code in a folder as `adibas/shipped_kernels.py` reads it."""
    packer = zstandard.ZstdCompressor(level=MOST_PACKED)
    for path in folder.rglob("*.nbc"):
        path.with_name(path.name + PACKED).write_bytes(packer.compress(path.read_bytes()))
        path.unlink()


def compile_into(kept: Path, program: Path) -> None:
    """Compile the hot loops for every processor of this kind, not only for the one that is here."""
    kept.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=kept.parent) as folder:
        made = Path(folder) / "numba"
        places = {"NUMBA_CACHE_DIR": str(made), "MPLCONFIGDIR": str(Path(folder) / "matplotlib")}
        kind = {"NUMBA_CPU_NAME": kept.name, "NUMBA_CPU_FEATURES": ""}
        environment = {**os.environ, **places, **kind}
        subprocess.run([program, COMPILE, folder], check=True, env=environment)  # noqa: S603
        made.rename(kept)


if __name__ == "__main__":
    freeze()
