"""Clocks that jump ahead: whatever is brought to even times would fill the gap with frames."""

import numpy as np

from adibas.arrays import FloatArray
from adibas.errors import RecordingError

LONGEST_STEP_S = 86_400.0
"""From a frame to the next: a day. No session pauses for longer, and a gap takes as much memory as
if somebody had been seen in it."""


def check_steps(file: str, times_s: FloatArray) -> None:
    """See that no frame comes absurdly long after all before it.

    Parameters
    ----------
    file : str
        Its name, for the error.
    times_s : (T,) array
        What goes back in time is passed over.

    Raises
    ------
    RecordingError
        There is such a frame.
    """
    latest_s = np.maximum.accumulate(times_s)
    jumps = np.flatnonzero(np.diff(latest_s) > LONGEST_STEP_S)
    if jumps.size:
        before_s, after_s = latest_s[jumps[0] : jumps[0] + 2]
        raise RecordingError(
            "{file}: the frame after the one at {before} s is at {after} s, more than a day later. "
            "The clock was set or files were joined: give the frames before and those after "
            "separately.",
            file=file,
            before=round(float(before_s), 3),
            after=round(float(after_s), 3),
        )
