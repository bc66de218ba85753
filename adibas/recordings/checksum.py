"""The fingerprint of a recording, for the provenance of a report."""

import hashlib
from pathlib import Path

from adibas.recordings.reading import cannot_read

BLOCK_SIZE = 1 << 20


def recording_sha256(path: Path) -> str:
    """Return the SHA-256 of a file; of a folder that of its files' names and contents, by name.

    Raises
    ------
    RecordingError
        Something cannot be read.
    """
    digest = hashlib.sha256()
    try:
        if not path.is_dir():
            _add_file(digest, path)
            return digest.hexdigest()
        for file in sorted(item for item in path.rglob("*") if item.is_file()):
            name = file.relative_to(path).as_posix()
            digest.update(name.encode(errors="surrogateescape") + b"\0")
            _add_file(digest, file)
    except OSError as error:
        raise cannot_read(path.name, error) from error
    return digest.hexdigest()


def _add_file(digest: "hashlib._Hash", path: Path) -> None:
    with path.open("rb") as file:
        while block := file.read(BLOCK_SIZE):
            digest.update(block)
