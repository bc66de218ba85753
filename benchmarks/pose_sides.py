"""Left and right of people of whom nobody said which side they show.

The simulator's scenes `anterior` and `posterior`: somebody stands 2 m away, the feet out of the
picture. Live is what each frame says when it comes; in a recording the first frames are told again
once the view is sure (`adibas.skeleton.settled_sides`). Seeds have no part in what was learned.
"""

from collections.abc import Iterator

import numpy as np

from adibas.arrays import FloatArray
from adibas.clock import NS_PER_S
from adibas.data.frames import depth_in_metres
from adibas.data.joints import JOINT_NAMES
from adibas.pipeline.limb_segmenting import shipped_model
from adibas.pipeline.pose_following import PoseEstimator, forest_segmenter
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


def rows(*, quick: bool) -> Iterator[Row]:
    """Measure; with `quick` two people."""
    seeds = SEEDS[:2] if quick else SEEDS
    for scene, told in SCENES.items():
        live, recorded = zip(*(_exchanged(scene, seed) for seed in seeds), strict=True)
        name = f"{len(seeds)} people {told}, feet not seen, view not told, {N_FRAMES} frames"
        yield Row(f"{name}: shoulders exchanged, live", 100 * _share(live), "%", 0, "goal")
        yield Row(f"{name}: shoulders exchanged, recording", 100 * _share(recorded), "%", 0, "goal")


def _share(found: tuple[FloatArray, ...]) -> float:
    return float(np.concatenate(found).mean())


def _exchanged(name: str, seed: int) -> tuple[FloatArray, FloatArray]:
    """Return of each shoulder that was seen whether it lies at the other one: live, recorded."""
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
        return np.empty(0), np.empty(0)
    truth_m = np.stack(truths_m)
    return _at_other(found, truth_m), _at_other(settled(found, SideParams()), truth_m)


def _at_other(found: list[ChosenJoints], truth_m: FloatArray) -> FloatArray:
    joints_m = np.stack([one.joints_m for one in found])
    wrong = []
    for own, other in PAIRS:
        to_own = np.linalg.norm(joints_m[:, own] - truth_m[:, own], axis=1)
        to_other = np.linalg.norm(joints_m[:, own] - truth_m[:, other], axis=1)
        seen = np.isfinite(to_own)
        wrong.append(to_other[seen] < to_own[seen])
    return np.concatenate(wrong).astype(float)
