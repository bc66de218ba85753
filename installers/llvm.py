"""Builds llvmlite's library for the one kind of processor that the program runs on.

The wheel's library compiles for twenty kinds and takes 153 MB. Here the same release is linked with
Debian's LLVM of the same version, of which the linker keeps what can be reached: 39 MB.
"""

import hashlib
import subprocess
import sys
import tarfile
import tempfile
from importlib.metadata import version
from pathlib import Path

LOCK = Path(__file__).parent / "requirements.lock"
NAME = "libllvmlite.so"
CONFIG = "llvm-config-22"
"""Of the LLVM that this llvmlite is for; its package stands in `debian-packages.txt`."""

KIND = "X86"
PARTS = ("mcjit", "orcjit", "orcdebugging", "asmprinter", "passes", KIND.lower())
LISTS = {
    "Targets.def": "LLVM_TARGET",
    "AsmPrinters.def": "LLVM_ASM_PRINTER",
    "AsmParsers.def": "LLVM_ASM_PARSER",
}
"""Headers that list the kinds of processors, by what they call each of them."""

COMPILE = ("-O2", "-w", "-fPIC", "-fvisibility=hidden", "-ffunction-sections", "-fdata-sections")
COMPILE_FOR = "-DLLVMLITE_LLVM_ASSERTIONS_STATE=0"
LINK = ("-shared", "-s", f"-Wl,-soname,{NAME}", "-Wl,--gc-sections", "-Wl,--exclude-libs,ALL")
LINK_FULLY = ("-Wl,--no-undefined", "-Wl,-Bsymbolic", "-Wl,--as-needed")
LINKER = ("-fuse-ld=gold", "-Wl,--icf=safe")
"""That one joins functions of the same code."""

SYSTEM = ("-ldl", "-lm", "-lz", "-lzstd")
RANDOM = """\
#include <sys/random.h>
extern "C" unsigned arc4random() {
    unsigned number = 0;
    return getrandom(&number, sizeof number, 0) == sizeof number ? number : 0;
}
"""
"""Names temporary files. The C library has it since 2.36 only, and the program asks for 2.35."""


def built_library(work: Path) -> Path:
    """Return the library, which is built in a folder of `work` unless it is there."""
    release = version("llvmlite")
    recipe = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()[:12]
    place = work / f"llvmlite-{release}-{recipe}" / NAME
    if not place.is_file():
        work.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=work) as name:
            made = build(unpacked_source(Path(name), release), Path(name))
            place.parent.mkdir(exist_ok=True)
            made.rename(place)
    return place


def unpacked_source(folder: Path, release: str) -> Path:
    """Fetch the locked release as its authors wrote it, and return where its C++ lies."""
    asked = folder / "requirement.txt"
    asked.write_text(locked_requirement(LOCK.read_text(encoding="utf-8"), "llvmlite"))
    options = ["--no-deps", "--no-binary", ":all:", "--no-build-isolation", "--require-hashes"]
    quiet = ["-q", "--disable-pip-version-check"]
    pip = [sys.executable, "-m", "pip", "download", *quiet, *options]
    _run(*pip, "--dest", str(folder), "--requirement", str(asked))
    with tarfile.open(folder / f"llvmlite-{release}.tar.gz") as archive:
        archive.extractall(folder, filter="data")
    return folder / f"llvmlite-{release}" / "ffi"


def locked_requirement(lock: str, name: str) -> str:
    """Return the lines of one package in a lock: its version and the sums of its files."""
    lines = lock.splitlines(keepends=True)
    first = next(at for at, line in enumerate(lines) if line.startswith(f"{name}=="))
    last = next(at for at in range(first, len(lines)) if not lines[at].endswith("\\\n"))
    return "".join(lines[first : last + 1])


def build(source: Path, folder: Path) -> Path:
    """Compile and link in a folder; return the library."""
    headers = folder / "include" / "llvm" / "Config"
    headers.mkdir(parents=True)
    for name, call in LISTS.items():
        (headers / name).write_text(f"{call}({KIND})\n#undef {call}\n")
    (folder / "random.cpp").write_text(RANDOM)
    files = [*sorted(source.glob("*.cpp")), folder / "random.cpp"]
    flags = _run(CONFIG, "--cxxflags").split()
    include = f"-I{folder / 'include'}"  # before LLVM's own
    objects = folder / "objects"
    objects.mkdir()
    compile_all = ["g++", *COMPILE, COMPILE_FOR, include, *flags, "-c", *map(str, files)]
    _run(*compile_all, folder=objects)
    libraries = _run(CONFIG, "--link-static", "--ldflags", "--libs", *PARTS).split()
    made = [str(path) for path in sorted(objects.glob("*.o"))]
    _run("g++", *LINK, *LINK_FULLY, *LINKER, "-o", NAME, *made, *libraries, *SYSTEM, folder=folder)
    return folder / NAME


def _run(*command: str, folder: Path | None = None) -> str:
    done = subprocess.run(command, check=False, capture_output=True, text=True, cwd=folder)  # noqa: S603
    if done.returncode:
        raise SystemExit(f"{command[0]} failed: {done.stderr}")
    return done.stdout
