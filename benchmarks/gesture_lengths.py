"""What endless streams cost: time and memory against length, from a minute to ten hours, drawn."""

import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from adibas.arrays import FloatArray
from adibas.timeseries.stream import StreamAligner
from benchmarks.mapping_walk import FOLDER
from benchmarks.process_memory import resident_memory_mib
from benchmarks.table import Row

MINUTES = (1, 3, 10, 30, 60, 180, 600)
QUICK_MINUTES = (1, 10)
N_EXAMPLES, EXAMPLE_FRAMES, FRAMES_A_MINUTE = 120, 30, 900
"""Ten gestures of twelve examples at 15 frames a second."""


def length_rows(
    examples: Sequence[FloatArray], minute: FloatArray, *, quick: bool
) -> Iterator[Row]:
    """Yield the time of each length; unless `quick`, draw it into ``build/benchmarks``.

    Parameters
    ----------
    examples : (k, d) arrays
    minute : (900, d) array
        One minute of stream, again and again.
    """
    aligner = StreamAligner(examples)
    aligner.feed(minute)
    lengths = QUICK_MINUTES if quick else MINUTES
    spent_s, resident_mib = [], []
    for length in lengths:
        aligner.reset()
        start = time.thread_time()
        for _ in range(length):
            aligner.feed(minute)
        spent_s.append(time.thread_time() - start)
        resident_mib.append(resident_memory_mib())
        told = f"stream of {length} min at 15 frames/s, {len(examples)} examples"
        yield Row(told, spent_s[-1], "s")
    slope = float(np.polyfit(np.log(lengths), np.log(spent_s), 1)[0])
    yield Row("same: time grows with the length to the power of", slope, "", 1.0, "a straight line")
    yield Row("same: memory, last length less first", resident_mib[-1] - resident_mib[0], "MiB")
    if not quick:
        FOLDER.mkdir(parents=True, exist_ok=True)
        _draw(FOLDER / "gesture-lengths.png", lengths, spent_s, resident_mib)


def _draw(
    path: Path, minutes: Sequence[int], spent_s: Sequence[float], resident_mib: Sequence[float]
) -> None:
    figure = Figure(figsize=(9, 6), layout="constrained")
    FigureCanvasAgg(figure)
    cost, memory = figure.subplots(2, 1, sharex=True)
    cost.loglog(minutes, spent_s, "o-")
    cost.set_ylabel("processor time, s")
    memory.semilogx(minutes, resident_mib, "o-")
    memory.set_ylabel("memory (resident), MB")
    memory.set_ylim(0, 1.2 * max(resident_mib))
    memory.set_xlabel("minutes of stream at 15 frames/s, 120 examples of 2 s")
    memory.set_xticks(list(minutes), [str(one) for one in minutes])
    for axes in (cost, memory):
        axes.grid(visible=True, alpha=0.3)
    figure.savefig(path, dpi=100)
