"""Whether a folder lies on the disk of another computer."""

from pathlib import Path

MOUNTS = Path("/proc/self/mountinfo")
KINDS = ("nfs", "cifs", "smb", "fuse.", "9p", "afs", "ceph", "davfs", "glusterfs", "lustre")
"""How the names begin that Linux gives to file systems whose server can go."""


def is_on_network(folder: Path, mounts: Path = MOUNTS) -> bool:
    """Say so as far as the system tells; False where it does not tell (other than Linux).

    Parameters
    ----------
    mounts : Path
        Source: Linux, Documentation/filesystems/proc.rst, section 3.5.
    """
    try:
        lines = mounts.read_text(encoding="utf-8", errors="surrogateescape").splitlines()
        places = dict(_place_and_kind(line) for line in lines)
        whole = folder.resolve()
    except (OSError, ValueError):
        return False
    kinds = (places[place] for place in (whole, *whole.parents) if place in places)
    kind = next(kinds, "")
    return kind == "fuse" or kind.startswith(KINDS)  # fuseblk is a disk of this computer


def _place_and_kind(line: str) -> tuple[Path, str]:
    """Return mount point and kind of one line; spaces in names are written in octal."""
    before, _, after = line.partition(" - ")
    place = before.split(" ")[4] if before.count(" ") >= 4 else ""  # noqa: PLR2004  (their fifth)
    for mark, letter in (("\\040", " "), ("\\011", "\t"), ("\\134", "\\")):
        place = place.replace(mark, letter)
    return Path(place), after.partition(" ")[0]
