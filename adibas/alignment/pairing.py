"""Where one moment lies in another, or why that cannot be said.

Source: thesis, figure 5.3 (RGBD-ICP). The result is checked by what both moments say of the space
between camera and surface: a place that one saw through cannot hold a surface of the other.
"""

from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol

import numpy as np

from adibas.alignment.features import (
    FeatureParams,
    Features,
    Pairs,
    find_features,
    follow_corners,
    pair_features,
)
from adibas.alignment.joint_fit import (
    JointFit,
    JointParams,
    cross_matrices,
    fit_joint,
    look_through,
)
from adibas.alignment.sights import Sight
from adibas.alignment.start_search import StartParams, search_start
from adibas.alignment.turn import TurnParams, fit_turn
from adibas.arrays import FloatArray
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import IDENTITY, RigidTransform
from adibas.texts import message

FEATURE_SD_PX = 0.7
"""Of SIFT's places, about their scale's half (assumed)."""


class Unaligned(Enum):
    """Why two moments were not aligned; `TEXTS` has the sentences."""

    TOO_FEW_FEATURES = "too few features"
    TOO_LITTLE_OVERLAP = "too little overlap"
    CONTRADICTION = "contradiction"
    DISAGREEMENT = "disagreement"
    UNDETERMINED = "undetermined"


TEXTS = {
    Unaligned.TOO_FEW_FEATURES: message(
        "Too little that can be recognised is seen in both frames."
    ),
    Unaligned.TOO_LITTLE_OVERLAP: message("The frames show too little of the same surface."),
    Unaligned.CONTRADICTION: message(
        "What one frame shows cannot be where the other saw through: something large moved, or the "
        "frames are of different places."
    ),
    Unaligned.DISAGREEMENT: message(
        "The surfaces fit where the picture says otherwise, such as along a wall."
    ),
    Unaligned.UNDETERMINED: message(
        "The surfaces leave the motion open, such as along a bare wall."
    ),
}


@dataclass(frozen=True, slots=True)
class PairingParams:
    """When two moments are said to be aligned.

    Attributes
    ----------
    least_overlap : float
        Share of each moment's pixels that lies on a surface of the other: 0.2.
    most_before : float
        Largest share that lies where the other saw through: 0.1.
    most_turn_sd_rad, most_shift_sd_m : float
        Of the motion in its least known direction, at the middle of what is seen: 0.002 and 0.004.
    least_pairs : int
        Features that must agree, be there a guess or not: 8. Surfaces alone slide along walls into
        a wrong fit that looks right.
    least_agreement : float
        And their share of all features: 0.1; right fits have 0.2 and more, wrong ones none.
    least_followed : int
        Patches that must be found there and back to be worth more than those: 40.
    """

    least_overlap: float = 0.2
    most_before: float = 0.1
    most_turn_sd_rad: float = 0.002
    most_shift_sd_m: float = 0.004
    least_pairs: int = 8
    least_agreement: float = 0.1
    least_followed: int = 40
    features: FeatureParams = field(default_factory=FeatureParams)
    start: StartParams = field(default_factory=StartParams)
    joint: JointParams = field(default_factory=JointParams)


class Moment:
    """A sight whose features are found when first wanted, and kept."""

    def __init__(self, sight: Sight, params: FeatureParams | None = None) -> None:
        self.sight = sight
        self._params = params
        self._features: Features | None = None

    @property
    def features(self) -> Features:
        """Return its features."""
        if self._features is None:
            self._features = find_features(self.sight, self._params)
        return self._features


class Aligner(Protocol):
    """Tells where one moment lies in another."""

    def near(self, target: Moment, source: Moment, guess: RigidTransform) -> JointFit | Unaligned:
        """Align from a guess, target from source, that is right to centimetres and degrees."""

    def anywhere(self, target: Moment, source: Moment) -> JointFit | Unaligned:
        """Align without one."""


class ByPictures:
    """By features and surfaces: of a camera that moves through a room."""

    def __init__(self, params: PairingParams) -> None:
        self._params = params

    def near(self, target: Moment, source: Moment, guess: RigidTransform) -> JointFit | Unaligned:
        """See `align`."""
        return align(target, source, guess, self._params)

    def anywhere(self, target: Moment, source: Moment) -> JointFit | Unaligned:
        """See `align_anywhere`."""
        return align_anywhere(target, source, self._params)


class ByShape:
    """By the surface alone, held to the floor: of a person who turns before a camera.

    Bare skin has no features, and what clothes show moves against the skin.
    """

    def __init__(self, floor: Plane, params: TurnParams) -> None:
        self._floor, self._params = floor, params

    def near(self, target: Moment, source: Moment, guess: RigidTransform) -> JointFit | Unaligned:
        """See `fit_turn`."""
        views = target.sight.view, source.sight.view
        fit = fit_turn(*views, guess, self._floor, self._params)
        return Unaligned.TOO_LITTLE_OVERLAP if fit is None else fit

    def anywhere(self, target: Moment, source: Moment) -> JointFit | Unaligned:
        """Align with a moment in which the person stood nearly the same."""
        return self.near(target, source, IDENTITY)


def align(
    target: Moment, source: Moment, guess: RigidTransform, params: PairingParams | None = None
) -> JointFit | Unaligned:
    """Align from a guess that is right to a few centimetres and degrees.

    Parameters
    ----------
    guess : RigidTransform
        Target from source.
    """
    params = params or PairingParams()
    rough = fit_joint(target.sight, source.sight, guess, params=params.joint)
    start = guess if rough is None else rough.target_from_source
    pairs = follow_corners(target.sight, source.sight, start, params.features)
    if len(pairs.pixels) < params.least_pairs:
        start = guess
        pairs = follow_corners(target.sight, source.sight, guess, params.features)
    return _judged(target, source, start, pairs, params)


def align_anywhere(
    target: Moment, source: Moment, params: PairingParams | None = None
) -> JointFit | Unaligned:
    """Align without a guess: by features first, then by all."""
    params = params or PairingParams()
    paired = pair_features(target.features, source.features, params.features)
    start = search_start(target.sight, target.features, source.features, paired, params.start)
    if start is None:
        return Unaligned.TOO_FEW_FEATURES
    found = Pairs(
        source.features.points_m[paired[1][start.agree]],
        target.features.pixels[paired[0][start.agree]],
        FEATURE_SD_PX,
    )
    fit = _judged(target, source, start.target_from_source, found, params)
    if isinstance(fit, Unaligned):
        return fit
    nearer = align(target, source, fit.target_from_source, params)
    is_finer = isinstance(nearer, JointFit) and nearer.n_pairs_kept >= params.least_followed
    return nearer if is_finer else fit


def _judged(
    target: Moment,
    source: Moment,
    start: RigidTransform,
    pairs: Pairs,
    params: PairingParams,
) -> JointFit | Unaligned:
    """Fit, and check from both sides."""
    fit = fit_joint(target.sight, source.sight, start, pairs, params.joint)
    if fit is None:
        return Unaligned.TOO_LITTLE_OVERLAP
    overlap, before = look_through(
        source.sight, target.sight, fit.target_from_source.inverse(), params.joint
    )
    if min(fit.overlap, overlap) < params.least_overlap:
        return Unaligned.TOO_LITTLE_OVERLAP
    if max(fit.before, before) > params.most_before:
        return Unaligned.CONTRADICTION
    return _doubt(fit, target.sight.view.middle_m, params) or fit


def _doubt(fit: JointFit, middle_m: FloatArray, params: PairingParams) -> Unaligned | None:
    """Return why what the features and the surfaces say is not enough; None where it is."""
    if fit.n_pairs < params.least_pairs:
        return Unaligned.TOO_FEW_FEATURES
    if fit.n_pairs_kept < max(params.least_pairs, params.least_agreement * fit.n_pairs):
        return Unaligned.DISAGREEMENT
    is_known = _is_determined(fit.information, middle_m, params)
    return None if is_known else Unaligned.UNDETERMINED


def _is_determined(information: FloatArray, middle_m: FloatArray, params: PairingParams) -> bool:
    """Say whether no direction of the motion is less known than allowed.

    Shifts are those of the middle of what is seen: those of the camera hold the turn, too, the more
    the farther away everything is.
    """
    at_middle = np.eye(6)
    at_middle[3:, :3] = cross_matrices(middle_m[None])[0]
    units = np.repeat([params.most_turn_sd_rad, params.most_shift_sd_m], 3)
    there = at_middle.T @ information @ at_middle
    least = np.linalg.eigvalsh(there * np.outer(units, units))[0]
    return bool(least > 1.0)
