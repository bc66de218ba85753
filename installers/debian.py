"""Packs `dist/adibas` as a Debian package, with what a desktop wants to know of a program."""

import gzip
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from email.utils import formatdate
from pathlib import Path

from adibas import __version__
from installers import freezing
from installers.bundle import ROOT
from installers.icon_files import FOLDER as DRAWINGS
from installers.icon_files import SIZES, drawn

LINUX = ROOT / "installers" / "linux"
PACKAGE_LIST = ROOT / "installers" / "debian-packages.txt"
OUT = ROOT / "dist"
RUNTIME_HEADINGS = ("Hot loops", "Qt", "Sensors")
"""Of the list of system packages: parts that a built program needs, too."""

COMPRESSION = ("-Zzstd", "-z12")
"""Unpacked in seconds; Debian 12 is the first that reads it."""

MAINTAINER = "The ADiBAS authors <authors@adibas.invalid>"
PLACES = {
    "adibas.desktop": "usr/share/applications",
    "adibas-mime.xml": "usr/share/mime/packages",
    "org.adibas.ADiBAS.metainfo.xml": "usr/share/metainfo",
    "60-adibas-sensors.rules": "usr/lib/udev/rules.d",
}
"""Where the files of `installers/linux` go."""

ICONS = {"adibas": "apps", "adibas-recording": "mimetypes"}
CONTROL = """\
Package: adibas
Version: {version}
Architecture: {architecture}
Maintainer: {maintainer}
Installed-Size: {kilobytes}
Depends: {depends}
Section: science
Priority: optional
Description: posture and movement of people, measured with a depth camera
 Coloured stickers on the skin are found in the picture and measured in space;
 every distance and angle goes into a report with its 95 % interval. Patients
 are kept in an encrypted store on this computer.
 .
 For research, education and documentation. Not for diagnosis.
"""
NO_SOURCE = "Source: adibas\n\nPackage: adibas\nArchitecture: any\n"
COPYRIGHT = """\
Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: ADiBAS
Comment: The libraries in /usr/lib/adibas/_internal keep their own licences; the texts are beside
 them where their authors ship them.

Files: *
Copyright: the ADiBAS authors
License: GPL-3+

License: GPL-3+
 On Debian systems the whole text is in /usr/share/common-licenses/GPL-3.
"""
CHANGELOG = """\
adibas ({version}) stable; urgency=medium

  * See the project's own changelog.

 -- {maintainer}  {date}
"""


def build_package() -> Path:
    """Return the package that is made of the frozen program."""
    with tempfile.TemporaryDirectory(dir=freezing.WORK) as name:
        tree = Path(name) / "tree"
        lay_out(tree)
        write_control(tree)
        unfinished = Path(name) / f"adibas_{__version__}_{architecture()}.deb"
        _run("dpkg-deb", "--root-owner-group", *COMPRESSION, "--build", str(tree), str(unfinished))
        return unfinished.replace(OUT / unfinished.name)


def lay_out(tree: Path) -> None:
    """Put everything where it is to be on the user's disk."""
    shutil.copytree(freezing.BUILT, tree / "usr/lib/adibas", symlinks=True)
    for name, place in PLACES.items():
        _copy(LINUX / name, tree / place / name)
    (tree / "usr/bin").mkdir(parents=True)
    (tree / "usr/bin/adibas").symlink_to("../lib/adibas/adibas")
    draw_icons(tree / "usr/share/icons/hicolor")
    doc = tree / "usr/share/doc/adibas"
    doc.mkdir(parents=True)
    (doc / "copyright").write_text(COPYRIGHT, encoding="utf-8")
    now = formatdate(localtime=True)
    text = CHANGELOG.format(version=__version__, maintainer=MAINTAINER, date=now)
    _write_gzip(doc / "changelog.gz", text.encode())
    _write_gzip(tree / "usr/share/man/man1/adibas.1.gz", (LINUX / "adibas.1").read_bytes())
    _set_modes(tree)


def draw_icons(folder: Path) -> None:
    """Write each icon as a drawing and in all sizes."""
    for name, kind in ICONS.items():
        source = DRAWINGS / f"{name}.svg"
        _copy(source, folder / "scalable" / kind / source.name)
        for size in SIZES:
            path = folder / f"{size}x{size}" / kind / f"{name}.png"
            path.parent.mkdir(parents=True, exist_ok=True)
            drawn(source, size).save(path)


def write_control(tree: Path) -> None:
    """Write what dpkg wants to know."""
    linked = linked_packages(tree)
    names = {entry.split()[0] for entry in linked}
    depends = linked + [name for name in listed_packages() if name not in names]
    folder = tree / "DEBIAN"
    folder.mkdir()
    text = CONTROL.format(
        version=__version__,
        architecture=architecture(),
        maintainer=MAINTAINER,
        kilobytes=n_kilobytes(tree),
        depends=", ".join(sorted(depends)),
    )
    (folder / "control").write_text(text, encoding="utf-8")
    for script in ("postinst", "postrm"):
        shutil.copy(LINUX / script, folder / script)
        (folder / script).chmod(0o755)


def listed_packages() -> list[str]:
    """Return the system packages that a library is loaded from by name while the program runs."""
    names, is_needed = [], False
    for line in PACKAGE_LIST.read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            is_needed = line.removeprefix("# ").startswith(RUNTIME_HEADINGS)
        elif line.strip() and is_needed:
            names.append(line.strip())
    return names


def linked_packages(tree: Path) -> list[str]:
    """Return the packages, with least versions, of the libraries that ours are linked with."""
    with tempfile.TemporaryDirectory() as name:
        source = Path(name)
        (source / "debian").mkdir()
        (source / "debian/control").write_text(NO_SOURCE)
        folders = sorted({path.parent for path in libraries(tree)})
        options = [f"-l{folder}" for folder in folders] + ["--ignore-missing-info", "-O"]
        files = [f"-e{path}" for path in libraries(tree)]
        done = _run("dpkg-shlibdeps", *options, *files, folder=source)
    (line,) = [line for line in done.splitlines() if line.startswith("shlibs:Depends=")]
    return line.removeprefix("shlibs:Depends=").split(", ")


def libraries(tree: Path) -> Iterator[Path]:
    """Yield the machine code in a folder."""
    for path in sorted((tree / "usr/lib/adibas").rglob("*")):
        if path.is_file() and not path.is_symlink():
            with path.open("rb") as file:
                if file.read(4) == b"\x7fELF":
                    yield path


def n_kilobytes(tree: Path) -> int:
    """Return what the files take, as Debian counts it."""
    sizes = (path.lstat().st_size for path in tree.rglob("*"))
    return sum(-(-size // 1024) for size in sizes)


def architecture() -> str:
    """Return Debian's name of this machine's kind."""
    return _run("dpkg", "--print-architecture").strip()


def _copy(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(source, target)


def _write_gzip(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(gzip.compress(content, mtime=0))


def _set_modes(tree: Path) -> None:
    """Let everybody read, and nobody else write, whatever the builder's umask is."""
    program = tree / "usr/lib/adibas/adibas"
    for path in tree.rglob("*"):
        if not path.is_symlink():
            path.chmod(0o755 if path.is_dir() or path == program else 0o644)


def _run(*command: str, folder: Path | None = None) -> str:
    done = subprocess.run(command, check=False, capture_output=True, text=True, cwd=folder)  # noqa: S603
    if done.returncode:
        raise SystemExit(f"{command[0]} failed: {done.stderr}")
    return done.stdout


if __name__ == "__main__":
    sys.stdout.write(f"{build_package()}\n")
