"""Several recordings that are reached as one."""

import hashlib
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from adibas.errors import RecordingError
from adibas.pipeline.recording_access import FILES, RecordingAccess
from adibas.recordings.joined import JoinedRecording
from adibas.recordings.joints_csv import is_joint_table, recording_name


def joined_access(paths: Sequence[Path], access: RecordingAccess) -> RecordingAccess:
    """Return how recordings are opened one after another, whatever path is asked for.

    Parameters
    ----------
    paths : sequence of Path
        Files or ids, in the order of time.
    access : RecordingAccess
        How each of them is reached.
    """
    names = [recording_name(path) for path in paths]

    def opened(_path: Path) -> JoinedRecording:
        with ExitStack() as if_that_fails:
            parts = []
            for path in paths:
                parts.append(access.open(path))
                if_that_fails.callback(parts[-1].close)
            joined = JoinedRecording(parts, names)
            if_that_fails.pop_all()
        return joined

    def sha256(_path: Path) -> str:
        told = "\n".join(access.sha256(path) for path in paths)
        return hashlib.sha256(told.encode()).hexdigest()

    return RecordingAccess(opened, sha256)


def access_to(paths: Sequence[Path]) -> RecordingAccess:
    """Return how a file is reached, or several recordings as one.

    Raises
    ------
    RecordingError
        One of several is a table of joints.
    """
    if len(paths) == 1:
        return FILES
    for path in paths:
        if is_joint_table(path):
            raise RecordingError(
                "{file} is a table of joints: only recordings are watched one after another. "
                "Analyse each table by itself.",
                file=path.name,
            )
    return joined_access(paths, FILES)


def joined_name(names: Sequence[str]) -> str:
    """Return what recordings are called that are watched as one; of one recording its own name.

    The first one, how many more, and what tells these from others that begin with the same one.
    """
    if len(names) == 1:
        return names[0]
    return f"{names[0]}+{len(names) - 1}-{joined_key(names)}"


def joined_key(names: Sequence[str]) -> str:
    """Return a short text that is the same for the same parts in the same order."""
    return hashlib.sha256("\n".join(names).encode(errors="surrogateescape")).hexdigest()[:8]
