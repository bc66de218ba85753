"""Left and right of people of whom nobody said which side they show.

The simulator's scenes `anterior` and `posterior`: somebody stands 2 m away, the feet out of the
picture. Live is what each frame says when it comes; in a recording the first frames are told again
once the view is sure (`adibas.skeleton.settled_sides`). Until then the view that each frame tells
live is said to be unsure. Seeds have no part in what was learned.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.clock import NS_PER_S
from adibas.data.frames import depth_in_metres
from adibas.data.joints import JOINT_NAMES
from adibas.pipeline.pose_following import PoseEstimator, forest_segmenter
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.simulation.scenes import open_scene
from adibas.skeleton.following import ChosenJoints
from adibas.skeleton.settled_sides import settled
from adibas.skeleton.sides import SideParams
from benchmarks.table import Row

SCENES = {"anterior": "from the front", "posterior": "from behind"}
SEEDS = range(9600, 9620)
N_FRAMES = 45
PAIRS = tuple(
    (JOINT_NAMES.index(f"{side}_shoulder"), JOINT_NAMES.index(f"{other}_shoulder"))
    for side, other in (("left", "right"), ("right", "left"))
)


@dataclass(frozen=True, slots=True)
class _Told:
    """Of each shoulder that was seen whether it lies at the other one, live and in a recording.

    `when_sure`: live, of the frames that are sure of the view; `unsure`: of each frame, whether it
    is not.
    """

    live: FloatArray
    when_sure: FloatArray
    recorded: FloatArray
    unsure: FloatArray


def rows(*, quick: bool) -> Iterator[Row]:
    """Measure; with `quick` two people."""
    seeds = SEEDS[:2] if quick else SEEDS
    for scene, said in SCENES.items():
        told = [_told(scene, seed) for seed in seeds]
        name = f"{len(seeds)} people {said}, feet not seen, view not told, {N_FRAMES} frames"
        exchanged = f"{name}: shoulders exchanged"
        yield Row(f"{exchanged}, live", _share(one.live for one in told), "%", 0, "goal")
        yield Row(
            f"{exchanged}, live, frames that are sure of the view",
            _share(one.when_sure for one in told),
            *("%", 0, "goal"),
        )
        yield Row(f"{exchanged}, recording", _share(one.recorded for one in told), "%", 0, "goal")
        yield Row(
            f"{name}: frames that are not sure of the view, live",
            _share(one.unsure for one in told),
            "%",
        )


def _share(found: Iterable[FloatArray]) -> float:
    return 100.0 * float(np.concatenate(list(found)).mean())


def _told(name: str, seed: int) -> _Told:
    scene = open_scene(name, seed=seed, has_color=False)
    calibration = scene.info.calibration
    if calibration is None or calibration.depth is None:
        raise ValueError("a simulated scene has a calibrated depth camera")
    camera = calibration.depth
    estimator = PoseEstimator(camera, forest_segmenter(shipped_model(), camera), calibration.floor)
    found: list[ChosenJoints] = []
    truths_m = []
    for index in range(N_FRAMES):
        frame = scene.frame(index)
        raw = frame.sensor_frame.depth_raw
        if raw is None:
            raise ValueError("a simulated frame has depth")
        depth_m = calibration.corrected_depth(depth_in_metres(raw, scene.info.depth_unit_m))
        time_s = frame.sensor_frame.timestamp_ns / NS_PER_S
        for one in estimator.look(np.ascontiguousarray(depth_m, np.float32), time_s).people[:1]:
            found.append(one.joints)
            truths_m.append(frame.truth.joints_m)
    if not found:
        return _Told(*[np.empty(0)] * 4)
    truth_m = np.stack(truths_m)
    sure = np.array([one.is_view_sure for one in found])
    when_sure = [one for one, is_sure in zip(found, sure, strict=True) if is_sure]
    return _Told(
        _at_other(found, truth_m),
        _at_other(when_sure, truth_m[sure]) if when_sure else np.empty(0),
        _at_other(settled(found, SideParams()), truth_m),
        1.0 - sure,
    )


def _at_other(found: list[ChosenJoints], truth_m: FloatArray) -> FloatArray:
    joints_m = np.stack([one.joints_m for one in found])
    wrong = []
    for own, other in PAIRS:
        to_own = np.linalg.norm(joints_m[:, own] - truth_m[:, own], axis=1)
        to_other = np.linalg.norm(joints_m[:, own] - truth_m[:, other], axis=1)
        seen = np.isfinite(to_own)
        wrong.append(to_other[seen] < to_own[seen])
    return np.concatenate(wrong).astype(float)
