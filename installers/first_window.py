"""Times how long the window takes to appear: the installed program beside the source tree.

Each runs in a home of its own that is empty before the first start; the starts take turns, so that
a busy computer is busy for both.
"""

import argparse
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from PIL import ImageGrab

N_STARTS = 7
LONGEST_S = 120.0
STEP_S = 0.01
SETTLE_S = 4.0
"""After the window: what it does at first, such as loading screens, is part of what is tried."""

TITLE = b'"ADiBAS"'


def main() -> int:
    """Print the times; the exit code says whether all was well."""
    arguments = _parser().parse_args()
    inside = ["chroot", f"--userspec={arguments.user}:{arguments.user}", arguments.root]
    home = f"/home/{arguments.user}"
    installed = [*inside, "/usr/bin/env", "-C", home, f"HOME={home}", "/usr/bin/adibas"]
    times: dict[str, list[float]] = {"installed": [], "source tree": []}
    with tempfile.TemporaryDirectory() as own_home:
        shared = {"PATH": os.environ["PATH"], "DISPLAY": arguments.display, "LC_ALL": "C.UTF-8"}
        environments = {"installed": shared, "source tree": {**shared, "HOME": own_home}}
        commands = {"installed": installed, "source tree": [arguments.source]}
        for start in range(N_STARTS):
            for name, command in commands.items():
                picture = arguments.picture if (start, name) == (0, "installed") else None
                times[name].append(time_start(command, environments[name], picture))
    return _tell(times, arguments.at_most)


def time_start(
    command: Sequence[str], environment: Mapping[str, str], picture: Path | None
) -> float:
    """Start the program, wait for its window, end it; return the seconds to the window."""
    start = time.monotonic()
    process = subprocess.Popen(command, env=dict(environment), stderr=subprocess.PIPE)  # noqa: S603
    while not has_window(environment):
        if process.poll() is not None or time.monotonic() - start > LONGEST_S:
            process.kill()
            raise SystemExit("the window did not appear: " + _said(process))
        time.sleep(STEP_S)
    took_s = time.monotonic() - start
    time.sleep(SETTLE_S)
    if picture is not None:
        _take(picture, environment)
    process.send_signal(signal.SIGTERM)
    said = _said(process)
    if process.returncode or said:
        raise SystemExit(f"the window ended with {process.returncode}: {said}")
    return took_s


def has_window(environment: Mapping[str, str]) -> bool:
    """Say whether the program's window is there."""
    command = ["xwininfo", "-root", "-tree"]
    done = subprocess.run(command, env=dict(environment), capture_output=True, check=False)  # noqa: S603
    return TITLE in done.stdout


def _take(picture: Path, environment: Mapping[str, str]) -> None:
    ImageGrab.grab(xdisplay=environment["DISPLAY"]).save(picture)


def _said(process: subprocess.Popen[bytes]) -> str:
    return process.communicate()[1].decode(errors="replace").strip()


def _tell(times: Mapping[str, Sequence[float]], at_most: float) -> int:
    for name, starts in times.items():
        first, others = starts[0], statistics.median(starts[1:])
        print(f"        {name}: first start {first:.2f} s, median of the others {others:.2f} s")  # noqa: T201
    installed, source = (statistics.median(starts) for starts in times.values())
    print(f"        ratio of the medians {installed / source:.2f}, at most {at_most}")  # noqa: T201
    return 0 if installed <= at_most * source else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--display", required=True)
    parser.add_argument("--picture", type=Path)
    parser.add_argument("--root", required=True)
    parser.add_argument("--user", required=True)
    parser.add_argument("--source", required=True)
    parser.add_argument("--at-most", type=float, required=True)
    return parser


if __name__ == "__main__":
    sys.exit(main())
