"""Disks of a process' own, that fill up or vanish; they go with the process.

A script that is run by `on_own_disks` may mount: it is root in a namespace of its own, which Linux
allows to any user, unless it was told not to.
"""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PROJECT = Path(__file__).parents[1]
SECONDS_TO_MOUNT = 20.0


def can_mount() -> bool:
    """Say whether disks of one's own are allowed."""
    words = ["unshare", "--user", "--map-root-user", "--mount", "true"]
    try:
        return subprocess.run(words, check=False, capture_output=True).returncode == 0  # noqa: S603
    except OSError:
        return False


@contextmanager
def on_own_disks(module: str, *words: str) -> Iterator[Iterator[str]]:
    """Run ``python -m MODULE WORDS`` where it may mount; give its lines."""
    command = ["unshare", "--user", "--map-root-user", "--mount", sys.executable, "-m", module]
    with subprocess.Popen(  # noqa: S603  (our own module)
        [*command, *words], cwd=PROJECT, stdout=subprocess.PIPE, text=True
    ) as process:
        if process.stdout is None:
            raise RuntimeError("the process says nothing")
        yield iter(process.stdout)
        if process.wait() != 0:
            raise RuntimeError(f"{module} ended with {process.returncode}")


def mount_small(place: Path, n_bytes: int) -> None:
    """Mount a disk in memory at `place`."""
    place.mkdir(exist_ok=True)
    _run("mount", "-t", "tmpfs", "-o", f"size={n_bytes}", "tmpfs", str(place))


def mount_share(kept: Path, place: Path) -> subprocess.Popen[bytes]:
    """Show `kept` at `place` as a share does, served by a process that can be killed."""
    place.mkdir(exist_ok=True)
    server = subprocess.Popen(["bindfs", "-f", str(kept), str(place)])  # noqa: S603, S607
    until_s = time.monotonic() + SECONDS_TO_MOUNT
    while not place.is_mount():
        if time.monotonic() > until_s or server.poll() is not None:
            raise RuntimeError("bindfs does not start")
        time.sleep(0.01)
    return server


def unmount(place: Path) -> None:
    """Take away what is mounted at `place`, even where its server is gone."""
    _run("umount", "--lazy", str(place))


def vanish(server: subprocess.Popen[bytes]) -> None:
    """Let the share be gone at once."""
    os.kill(server.pid, signal.SIGKILL)
    server.wait()


def _run(*words: str) -> None:
    subprocess.run(words, check=True, capture_output=True)  # noqa: S603
