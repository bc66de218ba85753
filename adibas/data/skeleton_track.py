"""The joints of one person over time."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray, check_shape, read_only
from adibas.clock import NS_PER_S
from adibas.data.joints import JOINT_NAMES


@dataclass(frozen=True, slots=True, eq=False)
class SkeletonTrack:
    """Joints of one person, frame after frame; safe to share between threads.

    Attributes
    ----------
    timestamps_ns : (T,) integer array
        Sensor clock, strictly increasing.
    joints_m : (T, 15, 3) array
        In the order of `JOINT_NAMES`, axes x right, y down, z forward of the camera; NaN where a
        joint was not seen.
    confidence : (T, 15) array
        0 to 1; NaN where the joint was not seen or the source says nothing.
    person : int
        1, 2, ... within the recording.
    """

    timestamps_ns: IntArray
    joints_m: FloatArray
    confidence: FloatArray
    person: int = 1

    def __post_init__(self) -> None:
        n_frames, n_joints = len(self.timestamps_ns), len(JOINT_NAMES)
        check_shape("timestamps_ns", self.timestamps_ns, (None,))
        check_shape("joints_m", self.joints_m, (n_frames, n_joints, 3))
        check_shape("confidence", self.confidence, (n_frames, n_joints))
        if (np.diff(self.timestamps_ns) <= 0).any():
            raise ValueError("timestamps_ns must increase from frame to frame")
        for array in (self.timestamps_ns, self.joints_m, self.confidence):
            read_only(array)

    def __len__(self) -> int:
        return len(self.timestamps_ns)

    @property
    def times_s(self) -> FloatArray:
        """Return the time of each frame on the sensor's clock, seconds."""
        return np.asarray(self.timestamps_ns / NS_PER_S, np.float64)

    @property
    def seen(self) -> BoolArray:
        """Return (T, 15): whether the joint has a position in the frame."""
        return np.asarray(np.isfinite(self.joints_m).all(axis=2))

    def between(self, begin_s: float, end_s: float) -> "SkeletonTrack":
        """Return the frames from `begin_s` to `end_s`, both included."""
        begin_ns, end_ns = round(begin_s * NS_PER_S), round(end_s * NS_PER_S)
        kept = (self.timestamps_ns >= begin_ns) & (self.timestamps_ns <= end_ns)
        return SkeletonTrack(
            self.timestamps_ns[kept], self.joints_m[kept], self.confidence[kept], self.person
        )


def track_of(times_s: FloatArray, joints_m: FloatArray, person: int = 1) -> SkeletonTrack:
    """Return a track of which nothing is known but times (T,) and joints (T, 15, 3)."""
    timestamps_ns = np.round(np.asarray(times_s) * NS_PER_S).astype(np.int64)
    joints_m = np.array(joints_m, np.float64)
    confidence = np.where(np.isfinite(joints_m).all(axis=2), 1.0, np.nan)
    return SkeletonTrack(timestamps_ns, joints_m, confidence, person)
