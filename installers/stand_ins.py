"""Small libraries in the place of large ones that wheels are linked with and nobody here uses.

OpenCV brings FFmpeg for video files, a coder for AVIF pictures, and an OpenBLAS of its own; Pillow
brings X for pictures of the screen. They do not load without these, but nothing here opens a video
or an AVIF picture, or takes a picture of the screen by Pillow: stand-ins have the names that are
asked for, and every function of theirs finds nothing. What OpenCV calculates with OpenBLAS goes to
the one that SciPy brings. Of three copies of Fortran's library one serves all.
"""

import subprocess
import tempfile
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

OPENCV, PILLOW = "opencv_python_headless.libs", "pillow.libs"
VIDEO = ("libavcodec-*", "libavformat-*", "libavutil-*", "libswscale-*")
EMPTY = (*(f"{OPENCV}/{name}" for name in VIDEO), f"{OPENCV}/libaom-*", f"{PILLOW}/libxcb-*")
"""Libraries of which only the names stay."""

OF_VIDEO = ("libvpx-*", "libswresample-*", "libdrm-*", "libcrypto-*", "libssl-*")
OF_BLAS = ("libgfortran-*", "libquadmath-*")
ORPHANS = (*(f"{OPENCV}/{name}" for name in (*OF_VIDEO, *OF_BLAS)), f"{PILLOW}/libXau-*")
"""Libraries that only those asked for, and that go."""

USERS = ("cv2/*.so", f"{OPENCV}/libavif-*", "PIL/_imaging.*")
BLAS = f"{OPENCV}/libopenblas*"
SHARED_BLAS = "scipy.libs/libscipy_openblas-*.so"
PREFIX = "scipy_"
"""What the names in SciPy's OpenBLAS begin with."""

FORTRAN = ("*.libs/libgfortran-*.so.5.*", "*.libs/libquadmath-*.so.0.*")

NOTHING = "void *{name}(void) {{ return 0; }}"
JUMP = '__asm__(".globl {name}\\n.type {name},@function\\n{name}: jmp {target}@PLT\\n");'


def stand_in_for_all(internal: Path) -> None:
    """Change the folder of all libraries."""
    users = _matching(internal, USERS)
    for library in _matching(internal, EMPTY):
        names = asked_names(users, library)
        link(library, [NOTHING.format(name=name) for name in sorted(names)], names)
    lead_to(internal, users)
    for library in _matching(internal, ORPHANS):
        library.unlink()
        (internal / library.name).unlink()  # PyInstaller's link to it
    for kind in FORTRAN:
        first, *others = _matching(internal, [kind])
        for library in others:
            library.unlink()
            library.symlink_to(f"../{first.parent.name}/{first.name}")


def lead_to(internal: Path, users: Sequence[Path]) -> None:
    """Let OpenCV calculate with SciPy's OpenBLAS."""
    (blas,), (shared,) = internal.glob(BLAS), internal.glob(SHARED_BLAS)
    names = asked_names(users, blas)
    lines = [JUMP.format(name=name, target=PREFIX + name) for name in sorted(names)]
    place = f"-Wl,-rpath,$ORIGIN/../{shared.parent.name}"
    link(blas, lines, names, [str(shared), place, "-Wl,--no-undefined"])


def asked_names(users: Iterable[Path], library: Path) -> dict[str, str]:
    """Return the functions of a library that others ask for, each with its version or nothing."""
    given = {name.partition("@")[0] for name in _names(library, "--defined-only")}
    asked = (name.split("@") for user in users for name in _names(user, "--undefined-only"))
    return {name: "".join(at) for name, *at in asked if name in given}


def _names(library: Path, which: str) -> list[str]:
    command = ["nm", "--dynamic", which, "--with-symbol-versions", str(library)]
    told = subprocess.run(command, check=True, capture_output=True, text=True)  # noqa: S603
    return [line.split()[-1].replace("@@", "@") for line in told.stdout.splitlines()]


def link(
    library: Path, lines: Sequence[str], names: Mapping[str, str], more: Sequence[str] = ()
) -> None:
    """Put a library of these lines of C in the place of another, under its name and versions."""
    by_version = defaultdict(list)
    for name, at in names.items():
        if at:
            by_version[at].append(name)
    with tempfile.TemporaryDirectory() as folder:
        source, versions = Path(folder) / "source.c", Path(folder) / "versions"
        source.write_text("\n".join(lines) + "\n")
        versions.write_text(
            "".join(f"{at} {{ global: {'; '.join(n)}; }};\n" for at, n in by_version.items())
        )
        options = [f"-Wl,--version-script={versions}"] if by_version else []
        library.unlink()
        base = ["gcc", "-shared", "-s", "-w", "-fPIC", f"-Wl,-soname,{library.name}"]
        command = [*base, *options, "-o", str(library), str(source), *more]
        subprocess.run(command, check=True)  # noqa: S603


def _matching(folder: Path, patterns: Iterable[str]) -> list[Path]:
    return sorted(path for pattern in patterns for path in folder.glob(pattern))
