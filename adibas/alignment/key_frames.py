"""Where the camera was at every moment: key-frames, loops back to them, and drift spread over both.

Source: thesis, section 5.2.1: key-frames by visual overlap, loop candidates near the current
estimate, a geometric check of each.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from adibas.alignment.joint_fit import JointFit
from adibas.alignment.pairing import Moment, PairingParams, Unaligned, align, align_anywhere
from adibas.alignment.pose_graph import Edge, Graph, GraphParams, optimise
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
    least_weight : float
        A loop that counts less than this after all, beside the others, is wrong: 0.2.
    """

    least_overlap: float = 0.75
    largest_shift_m: float = 0.25
    largest_turn_rad: float = 0.26
    loop_gap: int = 4
    loop_shift_m: float = 1.0
    loop_turn_rad: float = 0.8
    n_loops: int = 3
    n_recovered: int = 6
    least_weight: float = 0.2
    pairing: PairingParams = field(default_factory=PairingParams)
    graph: GraphParams = field(default_factory=GraphParams)


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Where the camera was.

    Attributes
    ----------
    world_from : tuple of (RigidTransform or None)
        Of each moment added; the first one's depth camera is the world. None where it was lost.
    problems : dict of int to Unaligned
        Why, by the number of the moment.
    n_key_frames, n_loops, n_wrong_loops : int
    """

    world_from: tuple[RigidTransform | None, ...]
    problems: dict[int, Unaligned]
    n_key_frames: int
    n_loops: int
    n_wrong_loops: int


class Tracker:
    """Follows a camera from moment to moment."""

    def __init__(self, params: KeyFrameParams | None = None) -> None:
        self._params = params or KeyFrameParams()
        self._keys: list[Moment] = []
        self._world_from_key: list[RigidTransform] = []
        self._edges: list[Edge] = []
        self._places: list[tuple[int, RigidTransform] | None] = []
        self._problems: dict[int, Unaligned] = {}
        self._last: RigidTransform | None = None
        self._step = IDENTITY

    def add(self, moment: Moment) -> Unaligned | None:
        """Take the next moment; return why it could not be placed, None if it was."""
        if not self._keys:
            self._keys.append(moment)
            self._world_from_key.append(IDENTITY)
            self._places.append((0, IDENTITY))
            self._last = IDENTITY
            return None
        found = self._place(moment)
        if isinstance(found, Unaligned):
            self._problems[len(self._places)] = found
            self._places.append(None)
            self._last, self._step = None, IDENTITY
            return found
        number, fit = found
        motion = fit.target_from_source
        self._places.append((number, motion))
        world_from_moment = self._world_from_key[number] @ motion
        if self._last is not None:
            self._step = self._last.inverse() @ world_from_moment
        self._last = world_from_moment
        if self._is_far(fit):
            self._add_key(moment, number, fit)
        return None

    def track(self) -> Track:
        """Return where the camera was, all loops considered."""
        graph = self._graph()
        places = [
            None if place is None else graph.world_from[place[0]] @ place[1]
            for place in self._places
        ]
        loops = [w for w, edge in zip(graph.weights, self._edges, strict=True) if edge.is_doubtful]
        n_wrong = int(sum(weight < self._params.least_weight for weight in loops))
        return Track(
            tuple(places), dict(self._problems), len(self._keys), len(loops) - n_wrong, n_wrong
        )

    def _place(self, moment: Moment) -> tuple[int, JointFit] | Unaligned:
        """Align with the latest key-frame, else with others."""
        latest = len(self._keys) - 1
        pairing = self._params.pairing
        problem = Unaligned.TOO_LITTLE_OVERLAP
        if self._last is not None:
            guess = self._world_from_key[latest].inverse() @ self._last @ self._step
            fit = align(self._keys[latest], moment, guess, pairing)
            if isinstance(fit, JointFit):
                return latest, fit
            problem = fit
        for number in range(latest, max(latest - self._params.n_recovered, -1), -1):
            fit = align_anywhere(self._keys[number], moment, pairing)
            if isinstance(fit, JointFit):
                return number, fit
        return problem

    def _is_far(self, fit: JointFit) -> bool:
        shift_m, turn_rad = size_of(fit.target_from_source)
        params = self._params
        return (
            fit.overlap < params.least_overlap
            or shift_m > params.largest_shift_m
            or turn_rad > params.largest_turn_rad
        )

    def _add_key(self, moment: Moment, number: int, fit: JointFit) -> None:
        own = len(self._keys)
        self._keys.append(moment)
        self._world_from_key.append(self._world_from_key[number] @ fit.target_from_source)
        self._edges.append(Edge(number, own, fit.target_from_source, fit.information))
        self._places[-1] = (own, IDENTITY)
        loops = self._loops(own, number)
        if loops:
            self._edges += loops
            self._world_from_key = list(self._graph().world_from)
            self._last = self._world_from_key[own]

    def _loops(self, own: int, before: int) -> list[Edge]:
        """Return motions from earlier key-frames that see the same."""
        params = self._params
        distances = []
        for number in range(own - params.loop_gap):
            motion = self._world_from_key[number].inverse() @ self._world_from_key[own]
            shift_m, turn_rad = size_of(motion)
            if shift_m < params.loop_shift_m and turn_rad < params.loop_turn_rad:
                distances.append((shift_m + turn_rad, number, motion))
        edges = []
        for _, number, guess in sorted(distances, key=lambda one: one[:2])[: params.n_loops]:
            if number == before:
                continue
            fit = align(self._keys[number], self._keys[own], guess, params.pairing)
            if not isinstance(fit, JointFit):
                fit = align_anywhere(self._keys[number], self._keys[own], params.pairing)
            if isinstance(fit, JointFit):
                edges.append(
                    Edge(number, own, fit.target_from_source, fit.information, is_doubtful=True)
                )
        return edges

    def _graph(self) -> Graph:
        return optimise(self._world_from_key, self._edges, self._params.graph)


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
