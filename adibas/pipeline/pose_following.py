"""From depth images of one camera to the joints of everybody in view, frame by frame."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray
from adibas.body.absence import why_nobody
from adibas.body.floor import find_floor
from adibas.body.people import PeopleParams, find_people
from adibas.body.rays import viewing_rays
from adibas.body.staying import Moment
from adibas.data.calibration import CameraCalibration
from adibas.data.limbs import FULL_BODY, LimbParts
from adibas.data.sentence import Sentence
from adibas.geometry.picture_edges import Box, cut_px, seen_box
from adibas.geometry.planes import Plane
from adibas.limbs.facing import FacingParams
from adibas.limbs.judging import (
    HALF,
    UNLIKE,
    Judgement,
    judge_absence,
    judge_mask,
    judge_parts,
)
from adibas.limbs.model import LimbModel
from adibas.limbs.proposals import ProposalParams
from adibas.limbs.segmentation import LimbParams, segment
from adibas.pipeline.mending import mended
from adibas.pipeline.person_evidence import PersonEvidence, evidence_of
from adibas.pipeline.person_judge import Judge
from adibas.pipeline.pose_model import JointModel, shipped_joint_model
from adibas.pipeline.trust import Acquaintance, Trust
from adibas.skeleton.following import ChosenJoints, FollowParams, PersonFollower
from adibas.skeleton.identities import Identities, IdentityParams
from adibas.skeleton.picture import Picture

Segmenter = Callable[[Float32Array, BoolArray], LimbParts]

UP = (0.0, -1.0, 0.0)
TOP_PERCENTILE = 98.0
PLACE_STEP = 4
"""Of how many rows and columns one is looked at for where somebody stands."""
COARSEST_FOCAL_PX = 250.0
"""Of the pixels that are looked at: a hand of 8 cm is 10 of them wide at 2 m."""
SOON_S = 0.2
"""Who was there so long ago has hardly moved: five frames a second are looked at at least."""
LONGEST_APART_S = 10.0
"""So long somebody whose outline fell apart is put together: two who part are not one for ever."""
LEAST_CUT = 0.03
"""Share of the picture's height: so much of an edge is touched by somebody whom it cuts off."""
FLOOR_TRIALS = 30
"""Frames in which a floor is looked for where the calibration has none."""


@dataclass(frozen=True, slots=True)
class PoseParams:
    """Settings of all stages.

    Attributes
    ----------
    view : str
        ``anterior`` or ``posterior`` where it is known which side is shown, else empty.
    people, limbs, proposals, facing, follow, identities : parameters of the stages
    """

    view: str = ""
    people: PeopleParams = field(default_factory=PeopleParams)
    limbs: LimbParams = field(default_factory=LimbParams)
    proposals: ProposalParams = field(default_factory=ProposalParams)
    facing: FacingParams = field(default_factory=FacingParams)
    follow: FollowParams = field(default_factory=FollowParams)
    identities: IdentityParams = field(default_factory=IdentityParams)


@dataclass(frozen=True, slots=True, eq=False)
class PersonNow:
    """One person in one frame.

    Attributes
    ----------
    person : int
        1, 2, ..., the same from frame to frame.
    pixels : (H, W) bool array
        Of the depth image.
    parts : LimbParts
    joints : ChosenJoints
        Depth camera's axes, not smoothed; confidences are shares of right joints where the
        joint model knows how reliable they are.
    raw : ChosenJoints
        As they were chosen, before that.
    picture : Picture
        What the depth picture shows of the person.
    """

    person: int
    pixels: BoolArray
    parts: LimbParts
    joints: ChosenJoints
    raw: ChosenJoints
    picture: Picture


@dataclass(frozen=True, slots=True, eq=False)
class PoseNow:
    """Everybody in one frame, and what is to be said of those who are no people."""

    people: tuple[PersonNow, ...]
    notices: tuple[Sentence, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """Somebody's limbs and what they tell, the person's middle, and how high the top is.

    `is_whole`: no edge of the picture cuts the person off; `notices`: what is to be said already.
    """

    pixels: BoolArray
    is_whole: bool
    notices: tuple[Sentence, ...]
    parts: LimbParts
    evidence: PersonEvidence
    middle_m: FloatArray
    top_m: float


def _middles_m(seen: Sequence[_Seen]) -> FloatArray:
    return np.array([one.middle_m for one in seen]).reshape(-1, 3)


def forest_segmenter(
    model: LimbModel, camera: CameraCalibration, params: LimbParams | None = None
) -> Segmenter:
    """Return what finds limbs with a trained model.

    Of an image so coarse that a pixel is a whole step already, every pixel is looked at: the cut
    would smooth hands away.

    Raises
    ------
    LimbError
        The model is for other limbs than those of the whole body.
    """
    model.require(FULL_BODY)
    params = params or LimbParams()
    if camera.intrinsics.fx / params.step < COARSEST_FOCAL_PX:
        params = replace(params, step=1)

    def segmented(depth_m: Float32Array, pixels: BoolArray) -> LimbParts:
        return segment(depth_m, pixels, camera.intrinsics.fx, model, params)

    return segmented


class PoseEstimator:
    """Follows everybody in view; causal, without delay, for one thread at a time.

    Parameters
    ----------
    camera : CameraCalibration
        Of the depth images.
    segmenter : callable
        Takes depth and the mask of a person and returns `LimbParts`; see `forest_segmenter`.
    floor : Plane or None
        In the camera's axes; None: it is looked for in the first frames.
    params : PoseParams or None
    joints : JointModel or None
        None: the shipped one, with confidences as they are; see `joint_model_for`.
    judge : callable or None
        Says whether limbs are a person's; see `person_judge`. None: by how many are seen.
    """

    def __init__(
        self,
        camera: CameraCalibration,
        segmenter: Segmenter,
        floor: Plane | None = None,
        params: PoseParams | None = None,
        joints: JointModel | None = None,
        judge: Judge | None = None,
    ) -> None:
        self.camera = camera
        self.floor = floor
        self._segmenter = segmenter
        self._params = params or PoseParams()
        self._joints = joints or shipped_joint_model()
        self._identities = Identities(self._params.identities)
        self._followers: dict[int, PersonFollower] = {}
        self._judge = judge
        self._n_trials = 0
        self._known_m = np.empty((0, 3))
        self._before: Moment | None = None
        self._before_s = self._whole_s = -np.inf
        self._trust = Trust()

    def follower(self, person: int) -> PersonFollower:
        """Return what is known of somebody."""
        return self._followers[person]

    def look(self, depth_m: Float32Array, time_s: float) -> PoseNow:
        """Return everybody in the next frame.

        Parameters
        ----------
        depth_m : (H, W) float32 array
            Corrected depth, metres; NaN where not measured.
        time_s : float
            Later than the frame before.
        """
        depth_m, said = mended(depth_m)
        if not said.is_person:
            return PoseNow((), said.notices)
        if self.floor is None and self._n_trials < FLOOR_TRIALS:
            self._n_trials += 1
            self.floor = find_floor(depth_m, self.camera)
        masks = find_people(
            *(depth_m, self.camera, self.floor, self._params.people, self._known_m),
            self._moment_before(time_s),
        )
        now = self.look_at(depth_m, [mask.pixels for mask in masks], time_s)
        self._before = Moment(depth_m, [one.pixels for one in now.people])
        self._before_s = time_s
        if not any(mask.is_put_together for mask in masks):
            self._whole_s = time_s
        return PoseNow(now.people, said.notices + now.notices)

    def _moment_before(self, time_s: float) -> Moment | None:
        """Return the frame before, by which people are put together, where it tells enough."""
        is_soon = time_s - self._before_s <= SOON_S
        return self._before if is_soon and time_s - self._whole_s <= LONGEST_APART_S else None

    def look_at(self, depth_m: Float32Array, masks: Sequence[BoolArray], time_s: float) -> PoseNow:
        """Return the people whose (H, W) masks are known; as `look`, for the rest."""
        notices: tuple[Sentence, ...] = () if masks else self._absence(depth_m)
        seen = []
        for pixels in masks:
            said = judge_mask(depth_m, pixels)
            if said.is_person:
                seen.append(self._seen(depth_m, pixels, said.notices))
            else:
                notices += said.notices
        people = []
        met = self._trust.meet(_middles_m(seen), time_s)
        for one, known in zip(seen, met, strict=True):
            found = self._verdict(depth_m, one, known, time_s)
            notices += (*one.notices, *found.notices)
            if found.is_person:
                people.append(one)
        return PoseNow(tuple(self._named(depth_m, people, time_s)), notices)

    def _absence(self, depth_m: Float32Array) -> tuple[Sentence, ...]:
        return judge_absence(
            why_nobody(depth_m, self.camera, self.floor, self._params.people.body)
        ).notices

    def _seen(
        self, depth_m: Float32Array, pixels: BoolArray, notices: tuple[Sentence, ...]
    ) -> _Seen:
        is_whole = all(notice.message != HALF for notice in notices)
        parts = self._segmenter(depth_m, pixels)
        evidence = self._evidence(depth_m, parts)
        return _Seen(pixels, is_whole, notices, parts, evidence, *self._place(depth_m, pixels))

    def _verdict(
        self, depth_m: Float32Array, one: _Seen, known: Acquaintance, time_s: float
    ) -> Judgement:
        """Judge limbs; of somebody new the most of some frames decide."""
        if self._judge is None or not known.is_to_be_judged(time_s, is_whole=one.is_whole):
            return judge_parts(one.parts, one.pixels)
        found = self._judge(depth_m, one.pixels, one.parts, one.evidence)
        is_person = known.judged(found, time_s)
        if known.is_trusted:
            return judge_parts(one.parts, one.pixels)
        if is_person == found.is_person:
            return found
        return Judgement(is_person, () if is_person else (Sentence(UNLIKE),))

    def _evidence(self, depth_m: Float32Array, parts: LimbParts) -> PersonEvidence:
        rays, params = viewing_rays(self.camera), self._params
        return evidence_of(depth_m, parts, rays, self._joints, params.proposals, params.facing)

    def _named(self, depth_m: Float32Array, seen: list[_Seen], time_s: float) -> list[PersonNow]:
        middles_m = _middles_m(seen)
        people = []
        box = seen_box(np.asarray(np.isfinite(depth_m)))
        pictures = [self._picture(box, one.pixels) for one in seen]
        tops_m = np.array(
            [
                one.top_m if picture.shows_stature else np.nan
                for one, picture in zip(seen, pictures, strict=True)
            ]
        )
        self._known_m = middles_m
        numbers = self._identities.match(middles_m, tops_m, time_s)
        for person, one, picture in zip(numbers, seen, pictures, strict=True):
            pixels, parts = one.pixels, one.parts
            if person not in self._followers:
                self._followers[person] = PersonFollower(
                    self._joints.proportions, self._params.view, self._params.follow
                )
            evidence = one.evidence
            raw = self._followers[person].follow(
                evidence.proposals, time_s, evidence.front, evidence.cloud, picture
            )
            people.append(
                PersonNow(person, pixels, parts, self._reliable(raw, picture), raw, picture)
            )
        return people

    def _reliable(self, raw: ChosenJoints, picture: Picture) -> ChosenJoints:
        reliability = self._joints.reliability
        return raw if reliability is None else reliability.applied(raw, picture)

    def _picture(self, box: Box, pixels: BoolArray) -> Picture:
        """Return what the picture, which can show anything within a box, shows of somebody."""
        least_px = LEAST_CUT * self.camera.height
        top, bottom, left, right = (cut_px(pixels, box) > least_px).tolist()
        return Picture(self.camera, box, (top, bottom, left, right))

    def _place(self, depth_m: Float32Array, pixels: BoolArray) -> tuple[FloatArray, float]:
        """Return where a person is, and how high the person reaches over the camera."""
        every = np.s_[::PLACE_STEP, ::PLACE_STEP]
        measured = pixels[every] & np.isfinite(depth_m[every])
        points_m = viewing_rays(self.camera)[every][measured] * depth_m[every][measured][:, None]
        up = np.array(UP) if self.floor is None else self.floor.normal
        heights_m = points_m @ up
        return np.median(points_m, axis=0), float(np.percentile(heights_m, TOP_PERCENTILE))
