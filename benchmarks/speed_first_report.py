"""A first session in the window with the demo sensor: from the start to the Excel report."""

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable

from adibas.simulation.scenes import open_scene
from benchmarks.table import Row

GOAL_S = 180.0
N_CLICKS = 3
COLOR_SIZE = (1024, 1280)
WAYS = {"mouse": "by mouse", "keys": "by keyboard alone"}


def rows(*, quick: bool) -> Iterable[Row]:
    """Go through the session by mouse and by keyboard; with `quick` by mouse only."""
    stickers = _stickers()
    for way, told in WAYS.items():
        if quick and way != "mouse":
            continue
        total_s, n_actions, waited_s, cpu_s, n_distances = _trial(way, stickers)
        name = f"first start to report, {told}"
        yield Row(
            f"{name}, 1 s before each action and 0.2 s a letter", total_s, "s", GOAL_S, "goal <"
        )
        yield Row(f"{name}: clicks, keys and fields", n_actions, "")
        yield Row(f"{name}: of this the program was waited for", waited_s, "s")
        yield Row(f"{name}: CPU time of program and simulated sensor", cpu_s, "s")
        yield Row(f"{name}: distances read back from the Excel file", n_distances, "")


def _stickers() -> list[tuple[float, float]]:
    """Return where the simulated patient's markers are that are seen best: a user sees them."""
    markers = open_scene("anterior", color_size=COLOR_SIZE).frame(0).truth.markers
    seen = sorted((one for one in markers if one.is_visible), key=lambda one: one.view_angle_rad)
    return [(one.u, one.v) for one in seen[:N_CLICKS]]


def _trial(way: str, stickers: list[tuple[float, float]]) -> list[float]:
    """Start the program over an empty folder in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "benchmarks.first_report_probe", way]
        started = subprocess.run(  # noqa: S603
            [*command, folder, json.dumps(stickers), str(time.time())],
            check=True,
            stdout=subprocess.PIPE,
            text=True,
        )
    return [float(word) for word in started.stdout.split()]
