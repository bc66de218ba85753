"""A patient who bends the elbows as is known, seen at 30 frames a second."""

import numpy as np

from adibas.data.joints import JOINT_NAMES
from adibas.data.posture import Provenance
from adibas.data.skeleton_track import track_of
from adibas.movement.measuring import MovementSource
from tests.unit.test_joint_angles import RIGHT, standing, turned

RATE_HZ = 30.0
PERIOD_S = 2.5
LEFT_DEG, RIGHT_DEG = (10.0, 130.0), (20.0, 110.0)
PROVENANCE = Provenance("ab" * 32, "sha256:" + "cd" * 32, "1.2", "2026-11-21T10:00:00", {"a": 1})


def elbow_deg(times_s, limits_deg):
    """Return flexion that goes to and fro between the limits."""
    low, high = limits_deg
    return low + (high - low) * (1 - np.cos(2 * np.pi * times_s / PERIOD_S)) / 2


def bending(n_frames=150, noise_m=0.0, seed=0):
    """Return the track of a patient who bends both elbows, each in its own range."""
    times_s = np.arange(n_frames) / RATE_HZ
    joints_m = np.stack(
        [
            turned(
                turned(standing(), ["left_hand"], "left_elbow", RIGHT, left_deg),
                ["right_hand"],
                "right_elbow",
                RIGHT,
                right_deg,
            )
            for left_deg, right_deg in zip(
                elbow_deg(times_s, LEFT_DEG), elbow_deg(times_s, RIGHT_DEG), strict=True
            )
        ]
    )
    rng = np.random.default_rng(seed)
    noise = rng.normal(scale=noise_m, size=(n_frames, len(JOINT_NAMES), 3)) if noise_m else 0.0
    return track_of(times_s + 5.0, joints_m + noise)


def source(**changes):
    """Return where these joints come from."""
    return MovementSource(**{"origin": "markers", "provenance": PROVENANCE, **changes})
