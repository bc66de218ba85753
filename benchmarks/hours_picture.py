"""The picture of `reliability_hours`: memory, drift and missing frames over time."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from benchmarks.reliability_hours import Sample

FRAME_RATE_HZ = 30.0


def draw_hours(path: Path, samples: Sequence["Sample"]) -> None:
    """Draw what the samples hold into a PNG."""
    hours = np.array([one.elapsed_s for one in samples]) / 3600
    figure = Figure(figsize=(9, 8), layout="constrained")
    FigureCanvasAgg(figure)
    memory, drift, frames = figure.subplots(3, 1, sharex=True)
    memory.plot(hours, [one.memory_mb for one in samples])
    memory.set_ylabel("memory (resident), MB")
    memory.set_ylim(0, 1.2 * max(one.memory_mb for one in samples))
    drift.plot(hours, [1e3 * one.drift_s for one in samples])
    drift.set_ylabel("timestamps ahead of the clock, ms")
    missing = [one.elapsed_s * FRAME_RATE_HZ + 1 - one.n_frames for one in samples]
    frames.plot(hours, missing)
    frames.set_ylabel("frames that the clock expects\nand that have not come")
    frames.set_xlabel("hours")
    for axes in (memory, drift, frames):
        axes.grid(visible=True, alpha=0.3)
    figure.savefig(path, dpi=100)
