"""Gestures in live frames: joints without markers, watched person by person."""

from collections.abc import Sequence
from dataclasses import dataclass

from adibas.arrays import Float32Array
from adibas.clock import NS_PER_S
from adibas.data.calibration import RgbdCalibration
from adibas.data.sentence import Sentence
from adibas.gestures.model import GestureModel
from adibas.gestures.watching import GestureWatcher, Seen, WatchParams
from adibas.pipeline.limb_segmenting import shipped_model
from adibas.pipeline.person_judge import person_judge
from adibas.pipeline.pose_following import PoseEstimator, forest_segmenter
from adibas.pipeline.pose_model import joint_model_for

MOST_PEOPLE = 8
"""Who is watched; whoever was seen longest ago is forgotten first."""


@dataclass(frozen=True, slots=True)
class LiveGesture:
    """What somebody did."""

    person: int
    seen: Seen


class LiveGestures:
    """Takes the depth of a frame as often as there is time; for one thread at a time.

    Parameters
    ----------
    models : sequence of GestureModel

    Attributes
    ----------
    unseen : Sentence or None
        Why nobody is watched in the latest frame; None where somebody is.
    """

    def __init__(self, models: Sequence[GestureModel]) -> None:
        self._models = tuple(models)
        self._params = WatchParams()
        self._calibration: RgbdCalibration | None = None
        self._estimator: PoseEstimator | None = None
        self._watchers: dict[int, GestureWatcher] = {}
        self._before_ns: int | None = None
        self.unseen: Sentence | None = None

    def look(
        self, depth_m: Float32Array, timestamp_ns: int, calibration: RgbdCalibration
    ) -> list[LiveGesture]:
        """Return what was recognised and was not told yet.

        Parameters
        ----------
        depth_m : (H, W) float32 array
            Corrected, metres; NaN where not measured.
        timestamp_ns : int
            A frame that is not later than the one before is left out; where the clock was set
            back, as by a sensor that is opened anew, everybody is looked at anew.
        calibration : RgbdCalibration
            Of the sensor; with another one than before everybody is looked at anew.
        """
        if calibration is not self._calibration or self._is_set_back(timestamp_ns):
            self._begin(calibration)
        is_old = self._before_ns is not None and timestamp_ns <= self._before_ns
        if self._estimator is None or is_old:
            return []
        self._before_ns = timestamp_ns
        found = []
        now = self._estimator.look(depth_m, timestamp_ns / NS_PER_S)
        # What is said last of somebody is what refuses them.
        self.unseen = None if now.people or not now.notices else now.notices[-1]
        for one in now.people:
            watcher = self._watchers.pop(one.person, None) or GestureWatcher(
                self._models, self._params
            )
            self._watchers[one.person] = watcher  # the last one in the dictionary: seen last
            seen = watcher.see(timestamp_ns, one.joints.joints_m)
            found += [LiveGesture(one.person, gesture) for gesture in seen]
        while len(self._watchers) > MOST_PEOPLE:
            del self._watchers[next(iter(self._watchers))]
        return found

    def _is_set_back(self, timestamp_ns: int) -> bool:
        if self._before_ns is None:
            return False
        return self._before_ns - timestamp_ns > self._params.anew_s * NS_PER_S

    def _begin(self, calibration: RgbdCalibration) -> None:
        self._calibration, self._estimator, self._before_ns = calibration, None, None
        self._watchers.clear()
        if calibration.depth is not None:
            model = shipped_model()
            self._estimator = PoseEstimator(
                calibration.depth,
                forest_segmenter(model, calibration.depth),
                calibration.floor,
                joints=joint_model_for(model),
                judge=person_judge(model, calibration.depth),
            )
