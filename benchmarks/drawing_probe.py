"""Started as a process of its own: prints what drawing takes, and the slowest step of the slider.

Usage: ``python -m benchmarks.drawing_probe BLOCKS``. The first two numbers are the share of one
core that drawing 640x480 colour and depth at 30 frames/s takes, on a window of 1280x800 and on one
of 1920x1080: the median of blocks of a second. The third is that of the least disturbed block on
the first window: whatever else uses the machine's memory makes the same work dearer. The last is
in milliseconds.
"""

import os
import statistics
import sys
import threading
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from PySide6.QtWidgets import QApplication

    from adibas.pipeline.live_frames import LiveFrame, SensorState

FRAME_RATE_HZ = 30
WINDOWS = (1280, 800), (1920, 1080)
SLIDER_STEPS = (6, 12, 18, 24, 30, 36, 42, 48, 54, 60)
PATIENCE_S = 120.0


def main() -> None:
    """Measure both, and print them."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from PySide6.QtWidgets import QApplication

    import ui  # noqa: F401  (sets OpenCV up before it is loaded)

    app = QApplication([])
    frames = _live_frames(n_frames=4, color_size=(640, 480))
    small, large = (_shares_of_a_core(app, frames, window, int(sys.argv[1])) for window in WINDOWS)
    shares = statistics.median(small), statistics.median(large), min(small)
    told = " ".join(f"{share:.5f}" for share in shares)
    sys.stdout.write(f"{told} {1e3 * _slowest_step_s(app):.2f}\n")


def _shares_of_a_core(
    app: "QApplication", frames: "tuple[LiveFrame, ...]", window: tuple[int, int], n_blocks: int
) -> list[float]:
    """Count the CPU time of drawing alone: conversion, overlays and painting of both pictures."""
    from ui.capture.view import CaptureScreen

    screen = CaptureScreen()
    screen.show_both()
    screen.resize(*window)
    screen.show()
    for frame in frames:
        screen.show_frame(frame)
        app.processEvents()
    shares = []
    for _block in range(n_blocks):
        start_s = time.process_time()
        for index in range(FRAME_RATE_HZ):
            screen.show_frame(frames[index % len(frames)])
            app.processEvents()
        shares.append(time.process_time() - start_s)
    screen.close()
    return shares


def _slowest_step_s(app: "QApplication") -> float:
    """Time each step of the sensitivity: the region grows, and the picture with it is drawn."""
    from adibas.markers.color_model import LearningParams
    from adibas.pipeline.frozen import freeze
    from adibas.pipeline.learning_board import LearningBoard
    from ui.widgets.image_view import ImageView
    from ui.widgets.overlays import Region

    (frame,) = _live_frames(n_frames=1, color_size=(1280, 1024))
    picture = freeze(frame, None)
    if picture is None:
        raise ValueError("the simulator gives no colour")
    board = LearningBoard(picture.color_rgb, LearningParams())
    board.click(640, 300)
    view = ImageView()
    view.resize(900, 720)
    view.show()
    view.set_picture(picture.color_rgb)
    slowest_s = 0.0
    for number, sensitivity in enumerate((*SLIDER_STEPS, *SLIDER_STEPS)):
        start_s = time.perf_counter()
        board.set_sensitivity(sensitivity)
        view.set_overlays((Region(board.taken(), "selected", is_filled=True),))
        app.processEvents()
        if number >= len(SLIDER_STEPS):
            slowest_s = max(slowest_s, time.perf_counter() - start_s)
    view.close()
    return slowest_s


class _Keeper:
    """Keeps frames in which somebody is seen, of a view that has come to its rate."""

    def __init__(self, n_frames: int) -> None:
        self.frames: list[LiveFrame] = []
        self.is_full = threading.Event()
        self._n_frames = n_frames
        self._n_seen = 0

    def frame_arrived(self, frame: "LiveFrame") -> None:
        """Keep a frame."""
        self._n_seen += 1
        if frame.outline is not None and self._n_seen > FRAME_RATE_HZ:
            self.frames.append(frame)
        if len(self.frames) >= self._n_frames:
            self.is_full.set()

    def state_changed(self, state: "SensorState") -> None:
        """Want no states."""


def _live_frames(n_frames: int, color_size: tuple[int, int]) -> "tuple[LiveFrame, ...]":
    """Return frames as the live view of the simulator gives them."""
    from adibas.pipeline.live import LiveView
    from adibas.sensors.ports import SensorOptions

    keeper = _Keeper(n_frames)
    live = LiveView(keeper)
    live.open("simulator", SensorOptions(color_size=color_size))
    keeper.is_full.wait(PATIENCE_S)
    live.close()
    return tuple(keeper.frames[:n_frames])


if __name__ == "__main__":
    main()
