"""When the frames of a simulated sensor are taken."""

import numpy as np

FRAME_RATE_HZ = 30.0
CLOCK_JITTER_NS = 150_000
FIRST_FRAME_NS = 1_000_000_000


def frame_time_ns(seed: int, index: int) -> int:
    """Return the sensor clock of frame `index`: even, but for a small jitter of its own."""
    rng = np.random.default_rng([seed, 0x71, index])
    jitter = int(rng.normal(0.0, CLOCK_JITTER_NS))
    return FIRST_FRAME_NS + round(index * 1e9 / FRAME_RATE_HZ) + jitter


def check_index(index: int, n_frames: int | None) -> None:
    """Raise IndexError where a scene of so many frames (None: without end) has no such one."""
    if index < 0 or (n_frames is not None and index >= n_frames):
        raise IndexError(f"frame {index} of {n_frames}")
