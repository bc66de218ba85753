"""The body in the depth of a burst tells which marker is which: limbs and joints without markers.

What is found without markers is some centimetres off, and is no measure: it only tells markers
apart.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray
from adibas.body.floor import find_floor
from adibas.body.holes import fill_gaps
from adibas.body.mask import find_body
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.joints import JOINT_NAMES
from adibas.data.limbs import LimbParts
from adibas.geometry.distortion import project_distorted
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform
from adibas.limbs.around_points import shares_around
from adibas.limbs.judging import Judgement, judge_mask
from adibas.measures.sight_plane import vertical_of
from adibas.pipeline.body_marks_file import shipped_marks
from adibas.pipeline.mending import mended
from adibas.pipeline.person_evidence import PersonEvidence
from adibas.pipeline.pose_following import PoseEstimator, PoseParams, forest_segmenter
from adibas.pipeline.pose_model import joint_model_for
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.pipeline.skeleton_names import upright_turn
from adibas.pipeline.upright import turn_to_upright, turned_camera, turned_floor, turned_parts
from adibas.skeleton.body_marks import BodyOdds, mark_log_odds
from adibas.skeleton.namer import Namer

BEHIND = "posterior"


@dataclass(frozen=True, slots=True, eq=False)
class SeenBody:
    """A body that was found without its markers, in a depth camera's axes and pixels.

    Attributes
    ----------
    depth_m : (H, W) float32 array
    parts : LimbParts
        Left and right as the declared view has them.
    joints_m : (15, 3) array
        NaN where not seen.
    camera : CameraCalibration
    """

    depth_m: Float32Array
    parts: LimbParts
    joints_m: FloatArray
    camera: CameraCalibration

    def shares_around(self, points_m: FloatArray) -> FloatArray:
        """Return (M, 16) shares of the parts about points; NaN beside the body."""
        lens = self.camera.intrinsics
        pixels_uv = project_distorted(points_m, lens, self.camera.distortion)
        return shares_around(self.parts, self.depth_m, points_m, pixels_uv, lens.fx)


def with_body(
    namer: Namer,
    depth_m: Float32Array,
    view: str,
    calibration: RgbdCalibration,
    rotation_deg: int = 0,
    pixels: BoolArray | None = None,
) -> Namer:
    """Return the namer of a capture, who knows where the body is, if that tells anything.

    Parameters
    ----------
    namer : Namer
        Comes back as it is where it names other landmarks than the joints, where no view is
        declared, and where nobody is seen.
    depth_m : (H, W) float32 array
        Of the depth camera, bias corrected, metres; NaN where not measured.
    view : str
        As declared.
    calibration : RgbdCalibration
    rotation_deg : int
        How far the picture is turned clockwise to be upright.
    pixels : (H, W) bool array or None
        Of the person, where they are known.
    """
    if namer.names != JOINT_NAMES or not view:
        return namer
    body = see_body(depth_m, view, calibration, rotation_deg, pixels)
    if body is None:
        return namer
    upright = upright_from_depth(calibration, rotation_deg)
    return namer.who_sees(body_odds(body, view, upright))


def upright_from_depth(calibration: RgbdCalibration, rotation_deg: int) -> RigidTransform:
    """Return what turns the depth camera's axes into the upright ones of the colour camera."""
    turn = upright_turn(vertical_of(calibration, rotation_deg).up)
    return RigidTransform(turn, np.zeros(3)) @ calibration.color_from_depth


def body_odds(body: SeenBody, view: str, upright: RigidTransform) -> BodyOdds:
    """Return what a body that is seen from a view tells of points; `upright` from the depth's."""
    joints_m = upright.apply(body.joints_m)
    depth_from_upright = upright.inverse()
    marks = shipped_marks().of_view(view)

    def odds(points_m: FloatArray) -> FloatArray:
        shares = body.shares_around(depth_from_upright.apply(points_m))
        return mark_log_odds(marks, points_m, joints_m, shares)

    return odds


def see_body(
    depth_m: Float32Array,
    view: str,
    calibration: RgbdCalibration,
    rotation_deg: int = 0,
    pixels: BoolArray | None = None,
) -> SeenBody | None:
    """Return the body in an (H, W) depth image; None where nobody is found.

    `pixels` are those of the person, where they are known.
    """
    if calibration.depth is None:
        return None
    turn = turn_to_upright(calibration, rotation_deg)
    camera = turned_camera(calibration.depth, turn)
    upright_m, said = mended(turn.picture(depth_m))
    if not said.is_person:
        return None
    if pixels is None:
        shown = _pixels_of_body(upright_m, camera, turned_floor(calibration.floor, turn))
    else:
        shown = turn.picture(pixels)
    found = None if shown is None else body_in(upright_m, shown, view, camera)
    if found is None:
        return None
    back = turn.inverse()
    return SeenBody(
        depth_m, turned_parts(found.parts, back), back.points(found.joints_m), calibration.depth
    )


def _pixels_of_body(
    depth_m: Float32Array, camera: CameraCalibration, floor: Plane | None
) -> BoolArray | None:
    mask = find_body(depth_m, camera, floor or find_floor(depth_m, camera))
    return None if mask is None else mask.pixels


def body_in(
    depth_m: Float32Array, mask: BoolArray, view: str, camera: CameraCalibration
) -> SeenBody | None:
    """Return the body in an upright (H, W) picture, whose pixels are known.

    Who wears markers is a person, however much of a chair is among the pixels, and however much of
    dark clothes has no depth: small gaps are filled then.
    """
    if not judge_mask(depth_m, mask).is_person:
        depth_m = fill_gaps(depth_m)
    model = shipped_model()
    shown = BEHIND if view == BEHIND else "anterior"
    estimator = PoseEstimator(
        camera,
        forest_segmenter(model, camera),
        params=PoseParams(view=shown),
        joints=joint_model_for(model),
        judge=_wears_markers,
    )
    people = estimator.look_at(depth_m, [mask], 0.0).people
    if not people:
        return None
    parts = people[0].parts
    if view == BEHIND:
        parts = parts.with_sides_swapped()
    return SeenBody(depth_m, parts, people[0].joints.joints_m, camera)


def _wears_markers(
    _depth_m: Float32Array, _mask: BoolArray, _parts: LimbParts, _seen: PersonEvidence | None
) -> Judgement:
    return Judgement(True, ())
