"""A home of one's own without a network, in which a part of the program is run and watched."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import platformdirs

PROJECT = Path(__file__).parents[1]
WITHOUT_NETWORK = ("unshare", "--user", "--map-root-user", "--net")
TRACE = ("strace", "-f", "-qq", "--seccomp-bpf", "-e", "trace=connect,sendto,sendmsg,bind")
COMPILED = platformdirs.user_cache_path("adibas") / "numba"
"""Code that is compiled already is taken along: it knows nobody."""
FOLDERS = ("home", "config", "data", "state", "cache", "run", "tmp", "work")


@dataclass(frozen=True, slots=True)
class Watched:
    """What a run tried and left.

    Attributes
    ----------
    attempts : tuple of str
        To reach a network: Python's own events, and calls of the system where strace is there.
    removed : tuple of str
        Files that held one of the texts before they were removed or renamed.
    is_traced : bool
        Whether the system's calls were watched, too.
    """

    attempts: tuple[str, ...]
    removed: tuple[str, ...]
    is_traced: bool


def can_be_alone() -> bool:
    """Say whether namespaces without a network are allowed."""
    try:
        words = [*WITHOUT_NETWORK, "true"]
        return subprocess.run(words, check=False, capture_output=True).returncode == 0  # noqa: S603
    except OSError:
        return False


def run_alone(folder: Path, words: Iterable[str], secrets: Iterable[str]) -> Watched:
    """Run ``python -m WORDS`` with homes below `folder`; it must end well.

    What it prints is left there, too.

    Parameters
    ----------
    secrets : iterable of str
        Texts that must not stand in files that come and go.
    """
    for name in FOLDERS:
        (folder / name).mkdir(exist_ok=True)
    (folder / "run").chmod(0o700)
    notes, trace = folder / "notes.txt", folder / "trace.txt"
    is_traced = shutil.which("strace") is not None
    tracing = [*TRACE, "-o", str(trace)] if is_traced else []
    command = [*WITHOUT_NETWORK, *tracing, sys.executable, "-m", "benchmarks.watched", str(notes)]
    with (folder / "said.txt").open("wb") as said:
        subprocess.run(  # noqa: S603  (our own module)
            [*command, *words],
            check=True,
            cwd=PROJECT,
            env=_environment(folder, secrets),
            stdout=said,
            stderr=said,
        )
    lines = notes.read_text().splitlines() if notes.exists() else []
    calls = trace.read_text().splitlines() if trace.exists() else []
    attempts = [line for line in lines if line.startswith("network")]
    attempts += [line for line in calls if "AF_INET" in line]
    removed = tuple(line for line in lines if line.startswith("removed"))
    return Watched(tuple(attempts), removed, is_traced)


def _environment(folder: Path, secrets: Iterable[str]) -> dict[str, str]:
    kept = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("XDG_", "DBUS_", "QT_")) and name not in ("HOME", "DISPLAY")
    }
    own = {
        "HOME": "home", "XDG_CONFIG_HOME": "config", "XDG_DATA_HOME": "data",
        "XDG_STATE_HOME": "state", "XDG_CACHE_HOME": "cache", "XDG_RUNTIME_DIR": "run",
        "TMPDIR": "tmp",
    }  # fmt: skip
    return kept | {
        **{name: str(folder / place) for name, place in own.items()},
        "QT_QPA_PLATFORM": "offscreen",
        "PYTHON_KEYRING_BACKEND": "keyring.backends.fail.Keyring",
        "ADIBAS_WATCHED": "\n".join(secrets),
        "NUMBA_CACHE_DIR": os.environ.get("NUMBA_CACHE_DIR", str(COMPILED)),
    }
