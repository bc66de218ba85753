"""Simulated actors who perform the thesis' gestures in long streams, as a sensor's skeletons.

Noise as the markerless chain has it: white 12 mm, slowly wandering 20 mm a joint (hands and feet
twice that), hands lost in 2 % of the time for a third of a second, and in 1 % of the frames a hand
30 cm away.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.events import TimedEvent
from adibas.data.joints import JOINT_NAMES
from adibas.data.skeleton_track import SkeletonTrack, track_of
from adibas.simulation.arm_room import with_arm_room
from adibas.simulation.body import PosedBody, ShapedBody, load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.gestures import gesture_names, perform
from adibas.simulation.skeleton import bone_turns

RATE_HZ = 15.0
WHITE_M, WANDERING_M, WANDERING_S = 0.012, 0.020, 1.0
FAR_JOINTS = [k for k, name in enumerate(JOINT_NAMES) if name.endswith(("hand", "foot"))]
HANDS = [k for k, name in enumerate(JOINT_NAMES) if name.endswith("hand")]
LOST_SHARE, LOST_FRAMES = 0.02, 5
WRONG_SHARE, WRONG_M = 0.01, 0.3
GESTURES = tuple(name for name in gesture_names() if name != "idle")
NO_SKIN = np.empty((0, 3))
PLACE_M = np.array([0.0, 0.3, 2.7])


def streams(
    n_actors: int, n_each: int, seed: int
) -> tuple[dict[tuple[str, int], SkeletonTrack], tuple[TimedEvent, ...]]:
    """Return one stream an actor, each gesture `n_each` times in mixed order between idling."""
    tracks: dict[tuple[str, int], SkeletonTrack] = {}
    events: list[TimedEvent] = []
    for actor in range(n_actors):
        rng = np.random.default_rng([seed, actor])
        name = f"actor{actor:02d}"
        joints_m, done = _performance(_actor(actor, rng), n_each, rng)
        facing = rng.normal(0.0, 0.2)
        sensed_m = _sensed(_turned(joints_m, facing) + PLACE_M, rng)
        tracks[name, 1] = track_of(np.arange(len(sensed_m)) / RATE_HZ, sensed_m)
        events += [
            TimedEvent(name, label, begin / RATE_HZ, end / RATE_HZ, name)
            for label, begin, end in done
        ]
    return tracks, tuple(events)


def _actor(number: int, rng: np.random.Generator) -> ShapedBody:
    stature_m = float(rng.uniform(1.5, 1.9))
    sex = ("female", "male")[number % 2]
    weight_kg = float(rng.uniform(20.5, 27.0)) * stature_m**2
    return load_body_model().shaped(
        BodyShape("female" if sex == "female" else "male", 30, stature_m, weight_kg)
    )


def _performance(
    actor: ShapedBody, n_each: int, rng: np.random.Generator
) -> tuple[FloatArray, list[tuple[str, int, int]]]:
    plan = rng.permutation(np.repeat(GESTURES, n_each))
    frames: list[FloatArray] = []
    done = []
    for label in plan:
        frames += list(_frames(actor, "idle", rng))
        begin = len(frames)
        frames += list(_frames(actor, str(label), rng))
        done.append((str(label), begin, len(frames) - 1))
    frames += list(_frames(actor, "idle", rng))
    return np.array(frames), done


def _frames(actor: ShapedBody, name: str, rng: np.random.Generator) -> Iterator[FloatArray]:
    gesture = perform(name, int(rng.integers(2**31)))
    for time_s in np.arange(0.0, gesture.duration_s, 1.0 / RATE_HZ):
        pose = with_arm_room(gesture.pose(float(time_s)), actor.arm_room_rad)
        # Without skin: joints are measured from the neck, and the floor does not matter.
        yield PosedBody(actor, pose, NO_SKIN, bone_turns(actor.skeleton, pose)).joints_m


def _turned(joints_m: FloatArray, angle_rad: float) -> FloatArray:
    cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
    turn = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
    return np.asarray(joints_m @ turn.T)


def _sensed(joints_m: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Add the noise of the chain."""
    keep = np.exp(-1.0 / (WANDERING_S * RATE_HZ))
    scale = np.ones((len(JOINT_NAMES), 1))
    scale[FAR_JOINTS] = 2.0
    steps = rng.normal(0.0, WANDERING_M * np.sqrt(1 - keep**2), joints_m.shape)
    wandering = np.zeros_like(joints_m)
    for before, now in pairwise(range(len(joints_m))):
        wandering[now] = keep * wandering[before] + steps[now]
    sensed = joints_m + scale * (wandering + rng.normal(0.0, WHITE_M, joints_m.shape))
    for hand in HANDS:
        wrong = rng.random(len(sensed)) < WRONG_SHARE
        sensed[wrong, hand] += rng.normal(0.0, WRONG_M / np.sqrt(3), (int(wrong.sum()), 3))
        lost = np.flatnonzero(rng.random(len(sensed)) < LOST_SHARE / LOST_FRAMES)
        for begin in lost:
            sensed[begin : begin + LOST_FRAMES, hand] = np.nan
    return np.asarray(sensed)
