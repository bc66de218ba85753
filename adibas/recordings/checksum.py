"""The identity of a recording: the hash of its bytes."""

import hashlib
from pathlib import Path


def recording_sha256(path: Path) -> str:
    """Return the SHA-256 of a file, or of a folder's file names and contents in sorted order."""
    digest = hashlib.sha256()
    if path.is_file():
        _add_file(digest, path)
    else:
        for part in sorted(part for part in path.rglob("*") if part.is_file()):
            digest.update(part.relative_to(path).as_posix().encode() + b"\0")
            _add_file(digest, part)
    return digest.hexdigest()


def _add_file(digest: "hashlib._Hash", path: Path) -> None:
    with path.open("rb") as file:
        while chunk := file.read(1 << 20):
            digest.update(chunk)
