"""Whether limbs that were found are a person's: one answer for all that looks for limbs."""

from collections.abc import Callable

from adibas.arrays import BoolArray, Float32Array
from adibas.data.calibration import CameraCalibration
from adibas.data.limbs import FULL_BODY, LimbParts
from adibas.limbs.judging import Judgement, judge_likeness, judge_parts
from adibas.limbs.likeness import Likeness
from adibas.limbs.model import LimbModel
from adibas.pipeline.likeness_file import shipped_likeness
from adibas.pipeline.person_evidence import PersonEvidence
from adibas.pipeline.person_quantities import describer

Judge = Callable[[Float32Array, BoolArray, LimbParts, PersonEvidence | None], Judgement]
"""Takes depth, the mask of somebody, the limbs in it, and what they tell, if that is known yet."""


def person_judge(model: LimbModel, camera: CameraCalibration) -> Judge:
    """Return what judges limbs that this model finds in images of this camera.

    How much like a person something is can be told for the model alone that it was learned with:
    the shipped one. Limbs of other models are judged by how many of them are seen.
    """
    likeness = shipped_likeness()
    describe = describer(camera)
    is_learned = model.labels is FULL_BODY and is_of(likeness, model)

    def judged(
        depth_m: Float32Array,
        pixels: BoolArray,
        parts: LimbParts,
        seen: PersonEvidence | None = None,
    ) -> Judgement:
        found = judge_parts(parts, pixels)
        if not (found.is_person and is_learned):
            return found
        score = likeness.score(describe(depth_m, pixels, parts, seen))
        return judge_likeness(score, likeness.threshold)

    return judged


def is_of(likeness: Likeness, model: LimbModel) -> bool:
    """Say whether a likeness was learned with a model."""
    return model.is_made(likeness.provenance.get("limbs_created_utc"))
