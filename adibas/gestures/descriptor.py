"""The posture of each frame as numbers that do not depend on place, size and facing direction.

Source: thesis, equation 7.1.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joints import JOINT_NAMES, mirror_order

NECK = JOINT_NAMES.index("neck")
DESCRIBED_JOINTS = tuple(name for name in JOINT_NAMES if name != "neck")
"""The 14 joints of the descriptor, three numbers each."""

SAME_TIME_S = 1e-6
LONGEST_HIDDEN_S = 3.0
"""So long the neck of who bends may be hidden, before and after it was seen."""
N_POSITIONS = 3 * len(DESCRIBED_JOINTS)

LIMBS = (
    ("left_shoulder", "left_elbow", 0.29),
    ("right_shoulder", "right_elbow", 0.29),
    ("left_elbow", "left_hand", 0.29),
    ("right_elbow", "right_hand", 0.29),
    ("neck", "torso", 0.26),
    ("left_shoulder", "right_shoulder", 0.35),
    ("left_hip", "left_knee", 0.43),
    ("right_hip", "right_knee", 0.43),
    ("left_knee", "left_foot", 0.41),
    ("right_knee", "right_foot", 0.41),
)
"""Pairs of joints and their distance on the body that stands for size 1, metres: our simulated
adult of 1.75 m, rounded."""

_STARTS = [JOINT_NAMES.index(start) for start, _, _ in LIMBS]
_ENDS = [JOINT_NAMES.index(end) for _, end, _ in LIMBS]
_LENGTHS_M = np.array([length for _, _, length in LIMBS])
SHOULDERS = (JOINT_NAMES.index("left_shoulder"), JOINT_NAMES.index("right_shoulder"))
_LEFT = [JOINT_NAMES.index(f"left_{part}") for part in ("shoulder", "hip")]
_RIGHT = [JOINT_NAMES.index(f"right_{part}") for part in ("shoulder", "hip")]


@dataclass(frozen=True, slots=True)
class DescriptorParams:
    """How frames are described; a model only fits streams described in the same way.

    Attributes
    ----------
    rate_hz : float
        Frames a second after resampling. 15: the slowest of the sensors we meet.
    longest_gap_s : float
        Missing joints are interpolated over so long, and frames that are further apart interrupt
        the stream. 0.5: no gesture of ours is shorter.
    facing_s : float
        The body is turned about the vertical axis until it faces the camera; its direction is
        averaged over so many seconds. 0: it is not turned. 3: longer than a turn of the trunk
        within a gesture, shorter than a person stands one way.
    velocity_s : float
        Factor of the velocities that are appended (sizes of the body a second). 0: none. 0.2: they
        weigh about as much as the positions.
    """

    rate_hz: float = 15.0
    longest_gap_s: float = 0.5
    facing_s: float = 3.0
    velocity_s: float = 0.2

    def __post_init__(self) -> None:
        if self.rate_hz <= 0 or self.longest_gap_s <= 0:
            raise ValueError("rate_hz and longest_gap_s must be positive")
        if self.facing_s < 0 or self.velocity_s < 0:
            raise ValueError("facing_s and velocity_s must not be negative")

    @property
    def n_numbers(self) -> int:
        """Return the length of a frame's descriptor."""
        return N_POSITIONS * (2 if self.velocity_s else 1)


def necks(neck_m: FloatArray, shoulders_m: FloatArray, longest: int) -> FloatArray:
    """Return (T, 3): the neck, where it is hidden at its usual place from the shoulders.

    In who bends towards the camera the head hides the neck, from which all is measured. Its
    offsets from the shoulders are taken from the frames before and after, `longest` frames away at
    most: what is never seen stays NaN.

    Parameters
    ----------
    neck_m : (T, 3) array
        NaN where not seen.
    shoulders_m : (T, 2, 3) array
        The same.
    longest : int
    """
    hidden = np.isnan(neck_m).any(axis=1)
    if not hidden.any():
        return neck_m
    total = np.zeros(neck_m.shape)
    n_known = np.zeros((len(neck_m), 1))
    for shoulder_m in np.moveaxis(shoulders_m, 1, 0):
        guess = shoulder_m + _held(neck_m - shoulder_m, longest)
        known = np.asarray(np.isfinite(guess).all(axis=1))
        total[known] += guess[known]
        n_known[known] += 1
    guess = np.where(n_known > 0, total / np.maximum(n_known, 1), np.nan)
    return np.where(np.asarray(hidden)[:, None], guess, neck_m)


def _held(values: FloatArray, longest: int) -> FloatArray:
    """Return (T, 3) values interpolated between known rows, held beyond them for `longest` rows."""
    known = np.flatnonzero(np.isfinite(values).all(axis=1))
    if not known.size:
        return np.full_like(values, np.nan)
    index = np.arange(len(values))
    after = np.searchsorted(known, index)
    nearest = np.minimum(
        abs(known[np.maximum(after - 1, 0)] - index),
        abs(known[np.minimum(after, len(known) - 1)] - index),
    )
    filled = np.stack([np.interp(index, known, axis[known]) for axis in values.T], axis=1)
    return np.where((nearest <= longest)[:, None], filled, np.nan)


def body_size(joints_m: FloatArray) -> float:
    """Return the size of a person relative to the body of `LIMBS`.

    Parameters
    ----------
    joints_m : (T, 15, 3) array
        NaN where not seen.
    """
    return size_of_limbs(limb_lengths(joints_m))


def limb_lengths(joints_m: FloatArray) -> FloatArray:
    """Return the lengths (T, limbs) of `LIMBS`, metres; NaN where not seen."""
    return np.asarray(np.linalg.norm(joints_m[:, _STARTS] - joints_m[:, _ENDS], axis=2))


def size_of_limbs(limbs_m: FloatArray) -> float:
    """Return the size of a person relative to the body of `LIMBS`.

    The median over frames of each limb, then the median over limbs: a few wrong joints do not
    matter. NaN where no limb was ever seen.

    Parameters
    ----------
    limbs_m : (T, limbs) array
        As `limb_lengths` gives them.
    """
    ratios = [
        float(np.median(limb[np.isfinite(limb)])) / length
        for limb, length in zip(limbs_m.T, _LENGTHS_M, strict=True)
        if np.isfinite(limb).any()
    ]
    return float(np.median(ratios)) if ratios else float("nan")


def facing_vectors(joints_m: FloatArray) -> FloatArray:
    """Return (T, 2): the line from the right to the left side, x and z, its length in metres.

    Zero where neither shoulders nor hips were seen: such a frame says nothing.
    """
    across = (joints_m[:, _LEFT] - joints_m[:, _RIGHT])[:, :, [0, 2]]
    known = np.asarray(np.isfinite(across).all(axis=2))
    return np.asarray(np.where(known[:, :, None], across, 0.0).sum(axis=1))


def turned(joints: FloatArray, facing: FloatArray) -> FloatArray:
    """Turn joints (T, J, 3) about y until `facing` (T, 2) or (2,) points to the image's right.

    A facing of zero turns nothing.
    """
    norm = np.linalg.norm(facing, axis=-1)
    cosine = np.where(norm > 0, facing[..., 0] / np.where(norm > 0, norm, 1.0), 1.0)[..., None]
    sine = np.where(norm > 0, facing[..., 1] / np.where(norm > 0, norm, 1.0), 0.0)[..., None]
    x, y, z = np.moveaxis(joints, -1, 0)
    return np.stack([cosine * x + sine * z, y, -sine * x + cosine * z], axis=-1)


def resampled(
    times_s: FloatArray, places_m: FloatArray, wanted_s: FloatArray, longest_gap_s: float
) -> FloatArray:
    """Return (n, 3): places of a joint at other times.

    Interpolated linearly over gaps of `longest_gap_s` and less, NaN in longer ones.

    Parameters
    ----------
    times_s : (T,) array
        Increasing.
    places_m : (T, 3) array
        NaN where not seen.
    wanted_s : (n,) array
    longest_gap_s : float
    """
    found = np.full((len(wanted_s), 3), np.nan)
    seen = np.isfinite(places_m).all(axis=1)
    if seen.any():
        known_s, known_m = times_s[seen], places_m[seen]
        near = _is_near(wanted_s, known_s, longest_gap_s)
        for axis in range(3):
            found[near, axis] = np.interp(wanted_s[near], known_s, known_m[:, axis])
    return found


def _is_near(wanted_s: FloatArray, known_s: FloatArray, longest_gap_s: float) -> FloatArray:
    after = np.searchsorted(known_s, wanted_s - SAME_TIME_S)
    before = np.clip(after - 1, 0, len(known_s) - 1)
    after = np.clip(after, 0, len(known_s) - 1)
    is_between = known_s[after] - known_s[before] <= longest_gap_s
    distance_s = np.minimum(abs(known_s[before] - wanted_s), abs(known_s[after] - wanted_s))
    at_edge = distance_s < SAME_TIME_S
    inside = (wanted_s >= known_s[0] - SAME_TIME_S) & (wanted_s <= known_s[-1] + SAME_TIME_S)
    return np.asarray((is_between | at_edge) & inside)


def described(joints_m: FloatArray, size: float, facing: FloatArray | None) -> FloatArray:
    """Return (T, 42): the joints without the neck, from the neck, in sizes of the body (7.1).

    Parameters
    ----------
    joints_m : (T, 15, 3) array
        NaN where not seen; without the neck nothing of the frame is known.
    size : float
        Of the body, see `body_size`.
    facing : (T, 2) or (2,) array or None
        See `turned`; None leaves the direction as it is.
    """
    from_neck = (joints_m - joints_m[:, NECK : NECK + 1]) / size
    others = np.delete(from_neck, NECK, axis=1)
    if facing is not None:
        others = turned(others, facing)
    return others.reshape(len(others), -1)


def mirrored(frames: FloatArray) -> FloatArray:
    """Return descriptors (T, d) of the same movement with the sides exchanged."""
    parts = frames.reshape(len(frames), -1, len(DESCRIBED_JOINTS), 3)
    order = mirror_order(DESCRIBED_JOINTS)
    return np.ascontiguousarray((parts[:, :, order] * [-1.0, 1.0, 1.0]).reshape(frames.shape))


def averaged(vectors: FloatArray, n_frames: int) -> FloatArray:
    """Return the mean of each row's neighbourhood of `n_frames`, cut off at the ends."""
    sums = np.concatenate([np.zeros((1, vectors.shape[1])), np.cumsum(vectors, axis=0)])
    index = np.arange(len(vectors))
    begin = np.maximum(index - n_frames // 2, 0)
    end = np.minimum(index + n_frames // 2 + 1, len(vectors))
    return np.asarray((sums[end] - sums[begin]) / (end - begin)[:, None])


def smoothed(frames: FloatArray) -> FloatArray:
    """Return each frame averaged with its neighbours, 1-2-1; where one is missing, as it is."""
    padded = np.concatenate([frames[:1], frames, frames[-1:]])
    mean = 0.25 * padded[:-2] + 0.5 * padded[1:-1] + 0.25 * padded[2:]
    return np.where(np.isfinite(mean), mean, frames)


def differences(frames: FloatArray) -> FloatArray:
    """Return the change from frame to frame, over both neighbours where there are two."""
    return np.gradient(frames, axis=0) if len(frames) > 1 else np.zeros_like(frames)
