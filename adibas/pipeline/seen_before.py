"""Who was seen in a recording just before a burst of it."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from adibas.arrays import FloatArray
from adibas.body.staying import Moment
from adibas.clock import NS_PER_S
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import RgbdFrame
from adibas.errors import RecordingError
from adibas.pipeline.pose_following import LONGEST_APART_S, SOON_S
from adibas.pipeline.posture import PostureParams, look_for_person
from adibas.pipeline.put_together import PutTogether
from adibas.recordings.decoding import to_rgbd
from adibas.recordings.ports import RecordingReader


def seen_before(
    recording: RecordingReader, first: int, calibration: RgbdCalibration, params: PostureParams
) -> Moment | None:
    """Return the person in the frame before a burst; None where nobody is seen there.

    As few frames of the ten seconds before it are looked at as follow one another closely enough.

    Parameters
    ----------
    recording : RecordingReader
    first : int
        Frame of the burst.
    calibration : RgbdCalibration
        Fits the recording.
    params : PostureParams
    """
    together = PutTogether()
    for frame in _readable(recording, _few_before(recording, first)):
        together.person(partial(look_for_person, frame, calibration, params), frame.timestamp_ns)
    return together.newest


def _readable(recording: RecordingReader, indices: list[int]) -> Iterator[RgbdFrame]:
    """Give frames; one that is damaged is none of the burst, and is left out."""
    for index in indices:
        try:
            yield to_rgbd(recording.read(index), recording.info)
        except RecordingError:
            continue


def _few_before(recording: RecordingReader, first: int) -> list[int]:
    """Return frames before one, each as long before the next as one still tells of the other."""
    times_s = _times_s(recording)
    begin = int(np.searchsorted(times_s, times_s[first] - LONGEST_APART_S))
    chosen, last = [], first
    while last > begin:
        last = min(int(np.searchsorted(times_s, times_s[last] - SOON_S)), last - 1)
        chosen.append(last)
    return [index for index in reversed(chosen) if index >= begin]


def _times_s(recording: RecordingReader) -> FloatArray:
    """Return times that never fall; a clock that was set back stands still."""
    return np.maximum.accumulate(np.asarray(recording.timestamps_ns, np.int64)) / NS_PER_S
