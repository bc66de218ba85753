"""Counts on simulated scenes how often joints are where they are said to be.

Run as a module it makes ``resources/models/reliability.json`` again, for the shipped model of
limbs.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from adibas.clock import NS_PER_S
from adibas.data.frames import depth_in_metres
from adibas.limbs.model import LimbModel
from adibas.pipeline.pose_following import PersonNow, PoseEstimator, forest_segmenter
from adibas.pipeline.reliability_file import write_reliability
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.simulation.crowd_plans import PLANS, CrowdPlan
from adibas.simulation.crowds import CrowdScene, PersonTruth
from adibas.simulation.odd_plans import ODD_PLANS
from adibas.skeleton.reliability import (
    NEAR_M,
    Reliability,
    all_situations,
    fit_curve,
    situations,
)

SEED, N_SCENES = 7400, 12
ODD = ("person", "person", "cut_left", "cut_right", "upper_body", "legs")
"""Whole people twice: they are what is seen most."""
N_FRAMES, STEP = 6, 5


@dataclass(frozen=True, slots=True)
class SaidJoint:
    """One joint that was said.

    Attributes
    ----------
    scene : str
    names : tuple of str
        Its situations.
    raw, calibrated : float
        Confidence of the choice; and that of the curves in use, NaN where they say: not seen.
    is_right : bool
        Within `NEAR_M` of the truth.
    is_in_view : bool
    """

    scene: str
    names: tuple[str, ...]
    raw: float
    calibrated: float
    is_right: bool
    is_in_view: bool


def said_joints(
    model: LimbModel, seed: int, n_scenes: int, reliability: Reliability | None
) -> Iterator[SaidJoint]:
    """Yield every joint that is said in simulated scenes of a seed.

    `reliability` is what turns confidences into shares; None: raw ones stand for both.
    """
    for number in range(n_scenes):
        for k, name in enumerate((*ODD, *PLANS)):
            rng = np.random.default_rng([seed, number, k])
            plan = varied(ODD_PLANS[name] if name in ODD_PLANS else PLANS[name], rng)
            scene = CrowdScene(plan, int(rng.integers(2**31)))
            yield from _of_scene(model, name, scene, reliability)


def varied(plan: CrowdPlan, rng: np.random.Generator) -> CrowdPlan:
    """Return the plan from somewhat nearer or farther, higher or lower."""
    return replace(
        plan,
        distance_m=plan.distance_m * float(rng.uniform(0.85, 1.25)),
        camera_height_m=plan.camera_height_m * float(rng.uniform(0.85, 1.1)),
    )


def _of_scene(
    model: LimbModel, name: str, scene: CrowdScene, reliability: Reliability | None
) -> Iterator[SaidJoint]:
    calibration = scene.info.calibration
    if calibration is None or calibration.depth is None:
        raise ValueError("a simulated scene has a calibrated depth camera")
    segmenter = forest_segmenter(model, calibration.depth)
    estimator = PoseEstimator(calibration.depth, segmenter, calibration.floor)
    for index in range(0, min(scene.n_frames, N_FRAMES * STEP), STEP):
        frame = scene.frame(index)
        raw = frame.sensor_frame.depth_raw
        if raw is None:
            raise ValueError("a simulated frame has depth")
        depth_m = calibration.corrected_depth(depth_in_metres(raw, scene.info.depth_unit_m))
        time_s = frame.sensor_frame.timestamp_ns / NS_PER_S
        now = estimator.look(np.ascontiguousarray(depth_m, np.float32), time_s)
        for one in now.people:
            owner = int(np.bincount(frame.owners[one.pixels], minlength=1).argmax())
            if owner:
                yield from _of_person(name, one, frame.people[owner - 1], reliability)


def _of_person(
    name: str, found: PersonNow, truth: PersonTruth, reliability: Reliability | None
) -> Iterator[SaidJoint]:
    joints = found.raw
    is_front = joints.front_probability > 0.5  # noqa: PLR2004  (more likely than not)
    inside_m = found.picture.inside_m(joints.joints_m)
    given = joints if reliability is None else reliability.applied(joints, found.picture)
    for joint in np.flatnonzero(np.isfinite(joints.confidence)).tolist():
        far_m = float(np.linalg.norm(joints.joints_m[joint] - truth.joints_m[joint]))
        yield SaidJoint(
            name,
            tuple(situations(joint, found.picture.is_cut, inside_m[joint], is_front=is_front)),
            float(joints.confidence[joint]),
            float(given.confidence[joint]),
            far_m < NEAR_M,
            bool(truth.in_view[joint]),
        )


def learn() -> Reliability:
    """Return what the scenes teach; the same every time."""
    model = shipped_model()
    said = list(said_joints(model, SEED, N_SCENES, None))
    provenance = {
        "seed": SEED,
        "n_scenes": N_SCENES * len((*ODD, *PLANS)),
        "n_joints": len(said),
        "limbs_created_utc": model.created_utc,
    }
    return fit(said, provenance)


def fit(said: list[SaidJoint], provenance: dict[str, object]) -> Reliability:
    """Return the curves of joints that were said."""
    curves = {}
    for name in all_situations():
        mine = [one for one in said if name in one.names]
        alike = [one for one in said if any(_where(of) == _where(name) for of in one.names)]
        expected = float(np.mean([one.is_right for one in alike])) if alike else 0.0
        raw = np.array([one.raw for one in mine])
        is_right = np.array([one.is_right for one in mine], np.bool_)
        curves[name] = fit_curve(raw, is_right, expected)
    return Reliability(curves, provenance)


def _where(situation: str) -> str:
    return situation.rpartition(" ")[0]


if __name__ == "__main__":
    write_reliability(learn())
