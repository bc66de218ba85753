"""The frames of a recorded movement: what each shows of the markers, and of who wears them."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.body.staying import Moment
from adibas.calibration.files import check_fits
from adibas.clock import NS_PER_S
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import RgbdFrame
from adibas.measures.sight_plane import vertical_of
from adibas.pipeline.in_order import in_order
from adibas.pipeline.movement_markers import FrameMarkers, markers_of_frame
from adibas.pipeline.posture import N_THREADS, MarkerTarget, PostureParams, Sight
from adibas.pipeline.put_together import PutTogether
from adibas.pipeline.skeleton_names import upright_turn
from adibas.recordings.decoding import to_rgbd
from adibas.recordings.ports import RecordingReader

_Looked: TypeAlias = tuple[FrameMarkers, Sight | None]


@dataclass(frozen=True, slots=True, eq=False)
class SeenFrame:
    """What one frame shows.

    Attributes
    ----------
    time_s : float
        Since the first frame.
    markers : FrameMarkers
    person : Sight or None
        Who wears them; None where nobody is seen.
    upright_m : (N, 3) array
        The markers, turned so that y is down.
    """

    time_s: float
    markers: FrameMarkers
    person: Sight | None
    upright_m: FloatArray


class MovementFrames:
    """The frames of a recording in the order of time; one that is not after all before is left out.

    Parameters
    ----------
    recording : RecordingReader
        With at least one frame.
    calibration : RgbdCalibration
    target : MarkerTarget
        What markers look like.
    params : PostureParams
    """

    def __init__(
        self,
        recording: RecordingReader,
        calibration: RgbdCalibration,
        target: MarkerTarget,
        params: PostureParams,
    ) -> None:
        self._recording, self._calibration = recording, calibration
        self._target, self._params = target, params
        every_ns = np.asarray(recording.timestamps_ns, np.int64)
        self._kept = np.flatnonzero(
            np.diff(np.maximum.accumulate(every_ns), prepend=every_ns[0] - 1)
        )
        self.timestamps_ns: IntArray = every_ns[self._kept]
        self.times_s: FloatArray = (self.timestamps_ns - self.timestamps_ns[0]) / NS_PER_S

    @contextmanager
    def seen(self, numbers: IntArray | None = None) -> Iterator[Iterator[SeenFrame]]:
        """Give what each frame shows, in their order; `numbers`: of these alone.

        Frames are looked at side by side, each by itself; where less is seen of the person than a
        moment ago they are looked at again, together with that moment: who bends down falls apart.

        Raises
        ------
        CalibrationError
            It is for another resolution.
        MarkerError
            The colour model fits everything.
        RecordingError
            A frame cannot be read.
        """
        numbers = np.arange(len(self._kept)) if numbers is None else numbers
        with in_order(self._alone, self._frames(numbers), N_THREADS) as looked:
            yield self._one_after_the_other(looked, self.times_s[numbers])

    def _alone(self, frame: RgbdFrame) -> tuple[RgbdFrame, _Looked]:
        return frame, self._looked(frame)

    def _looked(self, frame: RgbdFrame, before: Moment | None = None) -> _Looked:
        return markers_of_frame(frame, self._calibration, self._target, self._params, before)

    def _one_after_the_other(
        self, looked: Iterable[tuple[RgbdFrame, _Looked]], times_s: FloatArray
    ) -> Iterator[SeenFrame]:
        together = PutTogether()
        up = vertical_of(self._calibration, self._params.rotation_deg).up
        upright_from_camera = upright_turn(up)
        for (frame, by_itself), time_s in zip(looked, times_s.tolist(), strict=True):
            moment = together.moment_of(by_itself[1], frame.timestamp_ns)
            markers, person = by_itself if moment is None else self._looked(frame, moment)
            together.saw(person, frame.timestamp_ns, by_itself=moment is None)
            yield SeenFrame(time_s, markers, person, markers.points_m @ upright_from_camera.T)

    def _frames(self, numbers: IntArray) -> Iterator[RgbdFrame]:
        for place, index in enumerate(self._kept[numbers].tolist()):
            frame = to_rgbd(self._recording.read(index), self._recording.info)
            if place == 0:
                check_fits(self._calibration, frame.color_rgb.shape[:2], frame.depth_m.shape)
            yield frame
