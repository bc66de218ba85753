"""Three actors who move their arms before the camera: the thesis' 500 frames in shape.

Section 6.2.4: 3 actors, 3 sessions, frames of 640x480 with colour, the upper body. Two sets:
frames of film, whose neighbours show nearly the same, as the thesis' do; and frames each in a pose
of its own, which is much harder.
"""

import math

import numpy as np

from adibas.arrays import Float32Array, UInt8Array
from adibas.data.joints import BODY_PART_NAMES
from adibas.data.limbs import UPPER_BODY
from adibas.limbs.training_set import TO_TORSO
from adibas.simulation.figures import Figure
from adibas.simulation.limb_frames import (
    Film,
    FrameSettings,
    LimbFrame,
    LimbFrames,
    dressed_person,
)
from adibas.simulation.limb_people import wide_pose
from adibas.simulation.poses import Pose
from adibas.simulation.random_poses import random_figure
from benchmarks.limb_sets import Read, metres

ACTORS, SESSIONS, ACTOR_SEED = 3, 9, 500
FRAMES_A_POSE = 10
"""From one pose to the next: a third of a second at the sensor's rate, a second of every third."""
DRAWN_KINDS = ("gesture", "standing", "overhead", "at_body")
UPPER = np.array(
    [0, *(UPPER_BODY.names.index(TO_TORSO.get(name, name)) + 1 for name in BODY_PART_NAMES)],
    np.uint8,
)
"""The thesis' label of each of the fifteen."""
NEAR = FrameSettings(
    has_clutter=False,
    has_damage=False,
    farthest_turn_rad=math.radians(25),
    distance_m=(1.4, 1.85),
    step=1,
)


class ThesisFrames:
    """Frames of 640x480; colour is that of skin, hair and cloth with noise.

    Parameters
    ----------
    n_frames : int
    is_film : bool
        Else each frame has a pose, a heading and a camera of its own.
    """

    labels = UPPER_BODY.names

    def __init__(self, n_frames: int, *, is_film: bool) -> None:
        self._n_frames, self._is_film = n_frames, is_film
        self._frames = LimbFrames(ACTOR_SEED, NEAR)
        self._kept: dict[int, LimbFrame] = {}

    def __len__(self) -> int:
        return self._n_frames

    def read(self, index: int) -> Read:
        """Return metres, labels and focal_px of frame `index`."""
        frame = self._frame(index)
        return metres(frame.depth_mm), UPPER[frame.labels], self._frames.camera.intrinsics.fx

    def color(self, index: int) -> UInt8Array:
        """Return the (480, 640, 3) picture in colour."""
        frame = self._frame(index)
        rng = np.random.default_rng([ACTOR_SEED, index, 3])
        noisy = frame.color_rgb.astype(float) + rng.normal(0, 5, frame.color_rgb.shape)
        return np.clip(noisy, 0, 255).astype(np.uint8)

    def _frame(self, index: int) -> LimbFrame:
        if index not in self._kept:
            self._kept[index] = self._filmed(index) if self._is_film else self._drawn(index)
        return self._kept[index]

    def _drawn(self, index: int) -> LimbFrame:
        rng = np.random.default_rng([ACTOR_SEED, index])
        actor = index * ACTORS // self._n_frames
        kind = str(rng.choice(DRAWN_KINDS))
        dressed = dressed_person(ACTOR_SEED, actor)
        return self._frames.seen(dressed, wide_pose(rng, kind), (actor, kind), index)

    def _filmed(self, index: int) -> LimbFrame:
        session = index * SESSIONS // self._n_frames
        first = -(-session * self._n_frames // SESSIONS)
        actor = session * ACTORS // SESSIONS
        dressed = dressed_person(ACTOR_SEED, actor)
        pose = film_pose(session, (index - first) / FRAMES_A_POSE)
        return self._frames.seen(dressed, pose, (actor, "film"), index, Film(session))


def film_pose(session: int, time: float) -> Pose:
    """Return somebody on the way from one pose to the next; `time` counts poses, from 0."""
    before = math.floor(time)
    share = 0.5 - 0.5 * math.cos(math.pi * (time - before))
    here, there = (_figure(session, number).vector() for number in (before, before + 1))
    return Figure.from_vector((1.0 - share) * here + share * there).pose()


def _figure(session: int, number: int) -> Figure:
    """Return pose `number` of a session: the feet stay, the arms are anywhere."""
    legs = random_figure(np.random.default_rng([ACTOR_SEED, session]), "standing")
    rng = np.random.default_rng([ACTOR_SEED, session, number])
    trunk, arms = random_figure(rng, "standing").trunk, random_figure(rng, "moving")
    return Figure(arms.left_arm, arms.right_arm, legs.left_leg, legs.right_leg, trunk)


def depth_of_body(depth_m: Float32Array, labels: UInt8Array) -> Float32Array:
    """Return the depth of the labelled pixels, NaN elsewhere."""
    seen_m: Float32Array = np.where(labels > 0, depth_m, np.float32(np.nan))
    return seen_m
