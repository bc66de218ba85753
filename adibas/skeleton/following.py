"""One person over time: for each joint one of the proposed places, or "not seen"."""

import math
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joint_proposals import JointProposals
from adibas.data.joints import JOINT_NAMES
from adibas.data.part_cloud import PartCloud
from adibas.skeleton.choice_kernels import FAR, choose
from adibas.skeleton.limb_fit import LimbFitParams, fit_limbs
from adibas.skeleton.person_size import PersonSize, SizeParams
from adibas.skeleton.picture import Picture
from adibas.skeleton.proportions import ORDER, PARENTS, Proportions
from adibas.skeleton.sides import SideKeeper, SideParams

TREE = (np.array(PARENTS, np.int64), np.array(ORDER, np.int64))
FAST_JOINTS = np.array([name.endswith(("hand", "elbow", "foot", "knee")) for name in JOINT_NAMES])


@dataclass(frozen=True, slots=True)
class FollowParams:
    """How places are chosen; costs are in nats.

    Attributes
    ----------
    unseen_cost : float
        Of a joint that is not seen: 4; a place is taken for worse than that.
    place_error_m : float
        Of a proposed place, standard deviation; both ends of a bone have it: 0.035.
    most_bone_cost : float
        Of a bone that cannot be: 6.
    most_jump_cost : float
        Of a place that nobody can reach from the one before: 2.
    still_m : float
        Error of a joint from frame to frame, standard deviation: 0.05.
    slow_m_s, fast_m_s : float
        Change of speed that trunk and head, and limbs, are thought to make: 0.6 and 2.
    memory_s : float
        How long a joint's place and speed are kept that was not seen again: 0.4.
    reach : float
        Shoulder to hand, or hip to foot, is at most so many times both bones: 1.25.
    sure_cost, cost_scale : float
        A joint's confidence is 1 / (1 + exp((c - sure_cost) / cost_scale)) of the cost c of its
        place: 2.2 and 0.7.
    fitted_confidence : float
        Of a joint that had no place of its own and was found by its limb's surface: 0.5.
    size, sides, limbs : SizeParams, SideParams, LimbFitParams
    """

    unseen_cost: float = 4.0
    place_error_m: float = 0.035
    most_bone_cost: float = 6.0
    most_jump_cost: float = 2.0
    still_m: float = 0.05
    slow_m_s: float = 0.6
    fast_m_s: float = 2.0
    memory_s: float = 0.4
    reach: float = 1.25
    sure_cost: float = 2.2
    cost_scale: float = 0.7
    fitted_confidence: float = 0.5
    size: SizeParams = field(default_factory=SizeParams)
    sides: SideParams = field(default_factory=SideParams)
    limbs: LimbFitParams = field(default_factory=LimbFitParams)


@dataclass(frozen=True, slots=True, eq=False)
class ChosenJoints:
    """The joints of one person in one frame.

    Attributes
    ----------
    joints_m : (15, 3) array
        Metres; NaN: not seen.
    confidence : (15,) array
        0 to 1; NaN: not seen.
    front_probability : float
        That the person shows the front.
    is_view_sure : bool
        Whether, as the frame came, it was known which side is seen, and the joints lie so.
    """

    joints_m: FloatArray
    confidence: FloatArray
    front_probability: float
    is_view_sure: bool = False

    @property
    def n_seen(self) -> int:
        """Joints that have a place."""
        return int(np.isfinite(self.confidence).sum())


class PersonFollower:
    """Chooses joints frame by frame; causal, without delay.

    Parameters
    ----------
    proportions : Proportions
    view : str
        ``anterior``, ``posterior``, or empty: inferred.
    """

    def __init__(
        self, proportions: Proportions, view: str = "", params: FollowParams | None = None
    ) -> None:
        self._params = params or FollowParams()
        self._proportions = proportions
        self.size = PersonSize(proportions, self._params.size)
        self.sides = SideKeeper(view, self._params.sides)
        self._places_m = np.full((len(JOINT_NAMES), 3), np.nan)
        self._speeds_m_s = np.zeros((len(JOINT_NAMES), 3))
        self._seen_s = np.full(len(JOINT_NAMES), -math.inf)

    def follow(
        self,
        proposals: JointProposals,
        time_s: float,
        front_evidence: float = 0.0,
        cloud: PartCloud | None = None,
        picture: Picture | None = None,
    ) -> ChosenJoints:
        """Return the joints of the next frame.

        Parameters
        ----------
        front_evidence : float
            Log odds of front against back that the shape tells.
        cloud : PartCloud or None
            Surface that arms and legs are laid into; None: places stay as proposed.
        picture : Picture or None
            Joints that it cannot show are not seen; None: it is without end.
        """
        if self.sides.is_exchanged(proposals, time_s, front_evidence):
            proposals = proposals.with_sides_swapped()
            cloud = None if cloud is None else cloud.with_sides_swapped()
        places_m = np.ascontiguousarray(proposals.positions_m)
        lengths_m, spreads_m = self.size.bones_m(self.size.guess_m(places_m[:, 0]))
        spreads_m = np.sqrt(spreads_m**2 + 2.0 * self._params.place_error_m**2)
        costs = self._costs(proposals, time_s)
        chosen, margins = choose(
            places_m, costs, TREE, (lengths_m, spreads_m), self._params.most_bone_cost
        )
        n_places = places_m.shape[1]
        joints_m = np.full((len(JOINT_NAMES), 3), np.nan)
        confidence = np.full(len(JOINT_NAMES), np.nan)
        for joint, place in enumerate(chosen):
            if place < n_places:
                joints_m[joint] = places_m[joint, place]
                # What the whole would cost more without it, against the price of not seeing it.
                confidence[joint] = self._confidence(self._params.unseen_cost - margins[joint])
        self._drop_unreachable(joints_m, lengths_m)
        if cloud is not None:
            joints_m, confidence = self._laid(cloud, joints_m, confidence, lengths_m, time_s)
        if picture is not None:
            joints_m[~picture.shows(joints_m)] = np.nan
        confidence[~np.isfinite(joints_m[:, 0])] = np.nan
        self._learn(joints_m, time_s)
        sides = self.sides
        return ChosenJoints(
            joints_m, confidence, sides.front_probability, sides.is_view_sure(joints_m)
        )

    def _laid(
        self,
        cloud: PartCloud,
        joints_m: FloatArray,
        confidence: FloatArray,
        lengths_m: FloatArray,
        time_s: float,
    ) -> tuple[FloatArray, FloatArray]:
        """Return joints and confidence after arms and legs were laid into their surface."""
        recent = time_s - self._seen_s <= self._params.memory_s
        latest_m = np.where(recent[:, None], self._places_m, np.nan)
        fitted_m = fit_limbs(cloud, joints_m, latest_m, lengths_m, self._params.limbs)
        found = np.isfinite(fitted_m[:, 0])
        was_found = np.isfinite(joints_m[:, 0])
        confidence = np.where(found & ~was_found, self._params.fitted_confidence, confidence)
        return fitted_m, np.where(found, confidence, np.nan)

    def _costs(self, proposals: JointProposals, time_s: float) -> FloatArray:
        """Return (15, K + 1) costs of each place, and of "not seen"."""
        params = self._params
        expected_m2 = self._proportions.areas * self.size.stature_m**2
        weights = proposals.weights_m2 / expected_m2[:, None]
        total = proposals.weights_m2.sum(axis=1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            costs = -np.log(np.minimum(weights, 1.0)) - np.log(proposals.weights_m2 / total)
        costs += self._jump_costs(proposals.positions_m, time_s)
        costs[~np.isfinite(proposals.positions_m[..., 0]) | ~np.isfinite(costs)] = FAR
        unseen = np.full((len(costs), 1), params.unseen_cost)
        return np.ascontiguousarray(np.concatenate([costs, unseen], axis=1))

    def _jump_costs(self, places_m: FloatArray, time_s: float) -> FloatArray:
        params = self._params
        since_s = time_s - self._seen_s
        known = since_s <= params.memory_s
        since_s = np.where(known, since_s, 0.0)
        expected_m = self._places_m + self._speeds_m_s * np.minimum(since_s, 0.1)[:, None]
        spread_m = params.still_m + since_s * np.where(
            FAST_JOINTS, params.fast_m_s, params.slow_m_s
        )
        far = np.linalg.norm(places_m - expected_m[:, None], axis=2) / spread_m[:, None]
        costs = np.minimum(0.5 * far**2, params.most_jump_cost)
        costs[~known] = 0.0
        return np.asarray(costs)

    def _confidence(self, cost: float) -> float:
        params = self._params
        off = float(np.clip((cost - params.sure_cost) / params.cost_scale, -30.0, 30.0))
        return 1.0 / (1.0 + math.exp(off))

    def _drop_unreachable(self, joints_m: FloatArray, lengths_m: FloatArray) -> None:
        """Take away hands and feet that no arm or leg reaches; the joint between may be hidden."""
        for name in ("left_hand", "right_hand", "left_foot", "right_foot"):
            end = JOINT_NAMES.index(name)
            middle = PARENTS[end]
            start = PARENTS[middle]
            longest_m = self._params.reach * (lengths_m[end] + lengths_m[middle])
            if np.linalg.norm(joints_m[end] - joints_m[start]) > longest_m:
                joints_m[end] = np.nan

    def _learn(self, joints_m: FloatArray, time_s: float) -> None:
        seen = np.isfinite(joints_m[:, 0])
        since_s = time_s - self._seen_s
        moved = seen & (since_s <= self._params.memory_s) & (since_s > 0)
        speeds = (joints_m[moved] - self._places_m[moved]) / since_s[moved, None]
        self._speeds_m_s[moved] = 0.5 * (self._speeds_m_s[moved] + speeds)
        self._speeds_m_s[seen & ~moved] = 0.0
        self._places_m[seen] = joints_m[seen]
        self._seen_s[seen] = time_s
        self.sides.learn(joints_m, time_s)
        self.size.learn(joints_m)
