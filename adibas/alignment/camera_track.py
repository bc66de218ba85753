"""Where a camera was, and what is known while it is followed."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from adibas.alignment.pairing import PairingParams, Unaligned
from adibas.alignment.pose_graph import Edge, GraphParams
from adibas.alignment.turn import TurnParams
from adibas.arrays import FloatArray
from adibas.geometry.rigid import IDENTITY, RigidTransform, rotation_vector


@dataclass(frozen=True, slots=True)
class KeyFrameParams:
    """When a moment becomes a key-frame, and which ones may close a loop with it.

    Attributes
    ----------
    least_overlap : float
        With the current key-frame: 0.75.
    largest_shift_m, largest_turn_rad : float
        From it: 0.25 and 0.26 (15 degrees).
    loop_gap : int
        Key-frames in between that make a loop: 4.
    loop_shift_m, loop_turn_rad : float
        Estimated distance within which a loop is tried: 1.0 and 0.8.
    n_loops : int
        Tried for each key-frame, the nearest first: 3.
    n_recovered : int
        Key-frames that are tried where the camera was lost, the latest first: 6.
    n_revisited : int
        Earlier ones that are tried then, in turn: 3; the camera may have come back.
    drift_m, drift_rad : float
        A loop that shows less drift changes no pose before the end: 0.002 and 0.001.
    least_weight : float
        A loop that counts less than this after all, beside the others, is wrong: 0.2.
    most_still_before : float
        Where more lies before what an earlier moment saw, something moved: 0.03; noise alone makes
        a tenth of that.
    n_kept : int
        Key-frames that are kept as they are, the last ones used: 16; others are asked for again,
        so that memory does not grow.
    """

    least_overlap: float = 0.75
    largest_shift_m: float = 0.25
    largest_turn_rad: float = 0.26
    loop_gap: int = 4
    loop_shift_m: float = 1.0
    loop_turn_rad: float = 0.8
    n_loops: int = 3
    n_recovered: int = 6
    n_revisited: int = 3
    drift_m: float = 0.002
    drift_rad: float = 0.001
    least_weight: float = 0.2
    most_still_before: float = 0.03
    n_kept: int = 16
    pairing: PairingParams = field(default_factory=PairingParams)
    turning: TurnParams = field(default_factory=TurnParams)
    graph: GraphParams = field(default_factory=GraphParams)


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Where the camera was.

    Attributes
    ----------
    world_from : tuple of (RigidTransform or None)
        Of each moment added; the depth camera of the first that was placed is the world. None where
        it was lost.
    problems : dict of int to Unaligned
        Why, by the number of the moment.
    n_key_frames, n_loops, n_wrong_loops : int
    n_moving : int
        Moments in which something moved.
    """

    world_from: tuple[RigidTransform | None, ...]
    problems: dict[int, Unaligned]
    n_key_frames: int
    n_loops: int
    n_wrong_loops: int
    n_moving: int


@dataclass(frozen=True, slots=True, eq=False)
class Following:
    """All that a tracker knows but the moments themselves; it can go on from there.

    Attributes
    ----------
    keys : tuple of int
        Numbers of the moments that are key-frames.
    world_from_key : tuple of RigidTransform
    edges : tuple of Edge
        Between key-frames.
    places : tuple of ((int, RigidTransform) or None)
        Of each moment: in which key-frame, and where in it; None where it was lost.
    problems : dict of int to Unaligned
    last : RigidTransform
        World from the latest moment that was placed.
    step : RigidTransform
        From the moment before to the latest one.
    information : (6, 6) array or None
        Of the latest moment's place in its key-frame; None where it is one, or was lost.
    n_moving : int
    """

    keys: tuple[int, ...] = ()
    world_from_key: tuple[RigidTransform, ...] = ()
    edges: tuple[Edge, ...] = ()
    places: tuple[tuple[int, RigidTransform] | None, ...] = ()
    problems: dict[int, Unaligned] = field(default_factory=dict)
    last: RigidTransform = IDENTITY
    step: RigidTransform = IDENTITY
    information: FloatArray | None = None
    n_moving: int = 0


def size_of(motion: RigidTransform) -> tuple[float, float]:
    """Return how far a motion goes, metres, and by how much it turns, radians."""
    return (
        float(np.linalg.norm(motion.translation_m)),
        float(np.linalg.norm(rotation_vector(motion.rotation))),
    )


def path_length_m(world_from: Sequence[RigidTransform | None]) -> float:
    """Return how far the camera went, over those moments where it is known."""
    places = np.array([one.translation_m for one in world_from if one is not None])
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum()) if len(places) else 0.0
