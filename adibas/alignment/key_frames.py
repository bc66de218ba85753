"""Where the camera was at every moment: key-frames, loops back to them, and drift spread over both.

Source: thesis, section 5.2.1: key-frames by visual overlap, loop candidates near the current
estimate, a geometric check of each.
"""

from collections import OrderedDict
from collections.abc import Callable

from adibas.alignment.camera_track import Following, KeyFrameParams, Track, size_of
from adibas.alignment.gtsam_graph import optimise_by_gtsam
from adibas.alignment.joint_fit import JointFit
from adibas.alignment.pairing import Aligner, ByPictures, Moment, Unaligned
from adibas.alignment.pose_graph import Edge, Graph, optimise
from adibas.geometry.rigid import IDENTITY, RigidTransform


class Tracker:
    """Follows a camera from moment to moment.

    Parameters
    ----------
    recall : callable
        Gives a moment that was added again, by its number from 0 on.
    aligner : Aligner or None
        By pictures if None.
    before : Following or None
        Where an earlier tracker stood; the next moment is the one after its last.
    """

    def __init__(
        self,
        recall: Callable[[int], Moment],
        params: KeyFrameParams | None = None,
        before: Following | None = None,
        aligner: Aligner | None = None,
    ) -> None:
        self._params = params or KeyFrameParams()
        self._aligner = aligner or ByPictures(self._params.pairing)
        self._recall = recall
        before = before or Following()
        self._keys = list(before.keys)
        self._kept: OrderedDict[int, Moment] = OrderedDict()
        self._world_from_key = list(before.world_from_key)
        self._edges = list(before.edges)
        self._places = list(before.places)
        self._problems = dict(before.problems)
        self._last, self._step = before.last, before.step
        self._is_lost = bool(self._places) and self._places[-1] is None
        self._information = before.information
        self._previous: Moment | None = None
        self._n_moving = before.n_moving

    @property
    def following(self) -> Following:
        """All that is known now."""
        return Following(
            tuple(self._keys),
            tuple(self._world_from_key),
            tuple(self._edges),
            tuple(self._places),
            dict(self._problems),
            self._last,
            self._step,
            self._information,
            self._n_moving,
        )

    @property
    def keys(self) -> tuple[int, ...]:
        """Numbers of the moments that are key-frames."""
        return tuple(self._keys)

    @property
    def world_from_key(self) -> tuple[RigidTransform, ...]:
        """Where the key-frames are, as far as is known now."""
        return tuple(self._world_from_key)

    def add(self, moment: Moment) -> Unaligned | None:
        """Take the next moment; return why it does not fit what was placed, None if it does."""
        if not self._keys:
            self._begin(moment)
            return None
        found = self._place(moment)
        if isinstance(found, Unaligned):
            self._lose(moment, found)
            return found
        number, fit = found
        motion = fit.target_from_source
        self._places.append((number, motion))
        self._information, self._previous = fit.information, moment
        self._n_moving += fit.before > self._params.most_still_before
        world_from_moment = self._world_from_key[number] @ motion
        if not self._is_lost:
            self._step = self._last.inverse() @ world_from_moment
        self._last, self._is_lost = world_from_moment, False
        if self._is_far(fit):
            self._make_key(moment)
        return None

    def track(self) -> Track:
        """Return where the camera was, all loops considered."""
        if not self._keys:
            return Track((), {}, 0, 0, 0, 0)
        graph = self._graph()
        places = [
            None if place is None else graph.world_from[place[0]] @ place[1]
            for place in self._places
        ]
        loops = [w for w, edge in zip(graph.weights, self._edges, strict=True) if edge.is_doubtful]
        n_wrong = int(sum(weight < self._params.least_weight for weight in loops))
        return Track(
            tuple(places),
            dict(self._problems),
            len(self._keys),
            len(loops) - n_wrong,
            n_wrong,
            self._n_moving,
        )

    def _begin(self, moment: Moment) -> None:
        """Take a moment for the world."""
        self._keys = [len(self._places)]
        self._kept.clear()
        self._keep(0, moment)
        self._world_from_key = [IDENTITY]
        self._places.append((0, IDENTITY))
        self._last, self._step, self._is_lost = IDENTITY, IDENTITY, False
        self._information = None

    def _lose(self, moment: Moment, why: Unaligned) -> None:
        """Note that a moment was not placed; where nothing was yet, begin anew from it."""
        if sum(place is not None for place in self._places) > 1:
            self._problems[len(self._places)] = why
            self._places.append(None)
            self._step, self._is_lost, self._information = IDENTITY, True, None
            return
        self._problems[self._keys[0]] = why
        self._places[self._keys[0]] = None
        self._begin(moment)

    def _keep(self, key: int, moment: Moment) -> None:
        """Keep a key-frame at hand, and let go of the one that was longest not used."""
        self._kept[key] = moment
        self._kept.move_to_end(key)
        if len(self._kept) > self._params.n_kept:
            self._kept.popitem(last=False)

    def _key(self, key: int) -> Moment:
        """Return a key-frame by its number among them."""
        moment = self._kept.get(key)
        if moment is None:
            moment = self._recall(self._keys[key])
        self._keep(key, moment)
        return moment

    def _place(self, moment: Moment) -> tuple[int, JointFit] | Unaligned:
        """Align with the key-frame in use, else with the moment before, else with any other."""
        problem = self._follow(moment)
        if isinstance(problem, Unaligned) and self._information is not None:
            self._make_key(self._previous or self._recall(len(self._places) - 1))
            problem = self._follow(moment)
        if not isinstance(problem, Unaligned):
            return problem
        for number in self._to_recover():
            fit = self._aligner.anywhere(self._key(number), moment)
            if isinstance(fit, JointFit):
                return number, fit
        return problem

    def _to_recover(self) -> list[int]:
        """Return key-frames in which a lost camera may be found again."""
        params, n = self._params, len(self._keys)
        first = max(n - params.n_recovered, 0)
        begin = params.n_revisited * len(self._places)
        earlier = {(begin + step) % first for step in range(params.n_revisited)} if first else set()
        return [*range(n - 1, first - 1, -1), *sorted(earlier)]

    def _follow(self, moment: Moment) -> tuple[int, JointFit] | Unaligned:
        """Align with the key-frame of the latest moment that was placed, from where it was."""
        number = next(place[0] for place in reversed(self._places) if place is not None)
        guess = self._world_from_key[number].inverse() @ self._last @ self._step
        fit = self._aligner.near(self._key(number), moment, guess)
        return fit if isinstance(fit, Unaligned) else (number, fit)

    def _is_far(self, fit: JointFit) -> bool:
        shift_m, turn_rad = size_of(fit.target_from_source)
        params = self._params
        return (
            fit.overlap < params.least_overlap
            or shift_m > params.largest_shift_m
            or turn_rad > params.largest_turn_rad
        )

    def _make_key(self, moment: Moment) -> None:
        """Make a key-frame of the latest moment, which was placed in another one."""
        place, information = self._places[-1], self._information
        if place is None or information is None:
            raise ValueError("the latest moment is no other than a key-frame")
        own, (number, motion) = len(self._keys), place
        self._keys.append(len(self._places) - 1)
        self._keep(own, moment)
        self._world_from_key.append(self._world_from_key[number] @ motion)
        self._edges.append(Edge(number, own, motion, information))
        self._places[-1], self._information = (own, IDENTITY), None
        loops = self._loops(own, number)
        self._edges += loops
        if any(self._shows_drift(loop) for loop in loops):
            self._world_from_key = list(self._graph().world_from)
            self._last = self._world_from_key[own]

    def _shows_drift(self, loop: Edge) -> bool:
        """Say whether a loop disagrees with the poses as they are."""
        motion = self._world_from_key[loop.target].inverse() @ self._world_from_key[loop.source]
        shift_m, turn_rad = size_of(motion @ loop.target_from_source.inverse())
        return shift_m > self._params.drift_m or turn_rad > self._params.drift_rad

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
            fit = self._aligner.near(self._key(number), self._key(own), guess)
            if not isinstance(fit, JointFit):
                fit = self._aligner.anywhere(self._key(number), self._key(own))
            if isinstance(fit, JointFit):
                edges.append(
                    Edge(number, own, fit.target_from_source, fit.information, is_doubtful=True)
                )
        return edges

    def _graph(self) -> Graph:
        params = self._params.graph
        solve = optimise_by_gtsam if params.solver == "gtsam" else optimise
        return solve(self._world_from_key, self._edges, params)
