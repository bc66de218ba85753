"""Time of the markerless chain on simulated frames of 640x480, stage by stage.

Processor time of all threads, and the clock's, which is the goal's and means little on a machine
that does other work.
"""

import os
import time
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np

from adibas.body.people import find_people
from adibas.body.rays import viewing_rays
from adibas.clock import NS_PER_S
from adibas.data.frames import depth_in_metres
from adibas.limbs.facing import front_evidence
from adibas.limbs.model import load_model
from adibas.limbs.proposals import part_points, propose_joints
from adibas.pipeline.facing_file import shipped_facing
from adibas.pipeline.pose_following import forest_segmenter
from adibas.pipeline.pose_model import shipped_joint_model
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.simulation.scenes import open_scene
from adibas.skeleton.following import PersonFollower
from benchmarks.pose_real import MODEL
from benchmarks.table import Row

Result = TypeVar("Result")

SCENES = ("greet", "clap", "bend", "idle")
N_FRAMES = 60
WARM_UP = 2
FRAME_MS = 33.0
OWN = ("points", "modes", "facing", "cloud", "choice")


class _Watch:
    """Notes how long each stage took."""

    def __init__(self) -> None:
        self.spent_ms: dict[str, list[float]] = {}
        self.clock_ms: dict[str, list[float]] = {}

    def timed(self, stage: str, work: Callable[[], Result]) -> Result:
        """Do the work and note its time."""
        begin, clock = time.process_time(), time.perf_counter()
        result = work()
        self.spent_ms.setdefault(stage, []).append(1e3 * (time.process_time() - begin))
        self.clock_ms.setdefault(stage, []).append(1e3 * (time.perf_counter() - clock))
        return result


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` ten frames of one scene."""
    watch = _Watch()
    n_frames = 10 if quick else N_FRAMES
    for name in SCENES[:1] if quick else SCENES:
        _follow(name, n_frames, watch)
    whole = np.sum([times[WARM_UP:] for times in watch.spent_ms.values()], axis=0)
    told = f"640x480, one person, {len(whole)} frames"
    for stage, times in watch.spent_ms.items():
        yield Row(f"{told}: {stage}, median", float(np.median(times[WARM_UP:])), "ms")
    own = np.sum([watch.spent_ms[stage][WARM_UP:] for stage in OWN], axis=0)
    yield Row("proposals and choice, median", float(np.median(own)), "ms", 5.0, "goal <=")
    yield Row("whole chain, median", float(np.median(whole)), "ms", FRAME_MS, "goal <=")
    name = "whole chain, 99 % of frames within"
    yield Row(name, float(np.percentile(whole, 99)), "ms", FRAME_MS, "goal <=")
    clock = np.sum([times[WARM_UP:] for times in watch.clock_ms.values()], axis=0)
    yield Row("whole chain, median", float(np.median(clock)), "ms clock", FRAME_MS, "goal <=")
    yield Row(name, float(np.percentile(clock, 99)), "ms clock", FRAME_MS, "goal <=")


def _follow(name: str, n_frames: int, watch: _Watch) -> None:
    scene = open_scene(name, seed=3, has_color=False)
    calibration = scene.info.calibration
    if calibration is None or calibration.depth is None:
        raise ValueError("a simulated scene has a calibrated depth camera")
    camera, floor = calibration.depth, calibration.floor
    chosen = os.environ.get(MODEL)
    model = shipped_model() if chosen is None else load_model(Path(chosen))
    segmented = forest_segmenter(model, camera)
    joints, rays = shipped_joint_model(), viewing_rays(camera)
    follower = PersonFollower(joints.proportions)
    for index in range(n_frames):
        frame = scene.frame(index).sensor_frame
        if frame.depth_raw is None:
            raise ValueError("a simulated frame has depth")
        depth_m = calibration.corrected_depth(depth_in_metres(frame.depth_raw, 0.001))
        depth_m = np.ascontiguousarray(depth_m, np.float32)
        people = watch.timed("people", partial(find_people, depth_m, camera, floor))
        parts = watch.timed("limbs", partial(segmented, depth_m, people[0].pixels))
        points = watch.timed("points", partial(part_points, depth_m, parts, rays))
        proposals = watch.timed("modes", partial(propose_joints, points, joints.offsets))
        time_s = frame.timestamp_ns / NS_PER_S
        facing = watch.timed("facing", partial(front_evidence, points, shipped_facing()))
        cloud = watch.timed("cloud", points.cloud)
        watch.timed("choice", partial(follower.follow, proposals, time_s, facing, cloud))
