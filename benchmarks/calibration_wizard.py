"""The calibration wizard's live picture: what one frame takes, from the sensor to the screen."""

import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from adibas.data.board import Board
from adibas.data.printed_boards import PRINTED_BOARDS
from adibas.pipeline.acquisition import Arrival
from adibas.pipeline.calibration_watch import MomentWatch
from adibas.pipeline.live_frames import LiveFrame
from adibas.pipeline.looking import Look, Looker
from adibas.simulation.boards_scenes import BoardScene, BoardSceneSettings
from benchmarks.table import Row

BOARD: Board = PRINTED_BOARDS["A0"].board
EVERY = 37
"""Of the scene's frames: places and ways between them in turn."""

GOAL_HZ = 10.0


def arrivals(n: int) -> list[Arrival]:
    """Return frames of somebody who carries a board about, 1280x1024 with depth."""
    scene = BoardScene(BoardSceneSettings())
    frames = [scene.frame(EVERY * index).sensor_frame for index in range(n)]
    return [Arrival(frame, scene.info, 30.0, 0) for frame in frames]


def rows(*, quick: bool) -> Iterator[Row]:
    """Measure; with `quick` ten frames."""
    n = 10 if quick else 100
    some, looker = arrivals(n), Looker()
    looker.look(some[0], Look(board=BOARD))  # compiles
    watch = MomentWatch(BOARD)
    spent_s = []
    n_found = 0
    for arrival in some:
        start_s = time.thread_time()
        frame = looker.look(arrival, Look(board=BOARD))
        watch.see(frame, ())
        spent_s.append(time.thread_time() - start_s)
        n_found += frame.board is not None and frame.board.corners is not None
    drawn_s = _drawn_s(n)
    told = f"calibration wizard, {n} frames 1280x1024 of a carried board, one core"
    yield Row(f"{told}: board found", 100.0 * n_found / n, "%")
    yield Row(f"{told}: search and advice, median", 1e3 * float(np.median(spent_s)), "ms")
    yield Row(f"{told}: the slowest of twenty", 1e3 * float(np.quantile(spent_s, 0.95)), "ms")
    yield Row(f"{told}: drawing with all lines", 1e3 * drawn_s, "ms")
    rate_hz = 1.0 / (float(np.mean(spent_s)) + drawn_s)
    yield Row(f"{told}: frames a second, all of that", rate_hz, "1/s", GOAL_HZ, "goal >=")


def _drawn_s(n: int) -> float:
    """Return what the window spends on a frame, in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.calibration_drawing_probe", str(n)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)  # noqa: S603
    return float(done.stdout)


def live_frames(n: int) -> list[LiveFrame]:
    """Return the same as the live view tells it."""
    looker = Looker()
    frames = [looker.look(arrival, Look(board=BOARD)) for arrival in arrivals(n)]
    return [replace(frame, sequence=index) for index, frame in enumerate(frames)]
