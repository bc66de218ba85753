"""People of sticks who wave and bend, for the tests of the recognition."""

import numpy as np

from adibas.data.events import TimedEvent
from adibas.data.joints import JOINT_NAMES
from adibas.data.skeleton_track import track_of

RATE_HZ = 30.0
STANDING_M = {
    "head": (0, -0.2, 0), "neck": (0, 0, 0), "torso": (0, 0.26, 0),
    "left_shoulder": (0.17, 0.04, 0), "right_shoulder": (-0.17, 0.04, 0),
    "left_elbow": (0.2, 0.33, 0), "right_elbow": (-0.2, 0.33, 0),
    "left_hand": (0.22, 0.61, 0), "right_hand": (-0.22, 0.61, 0),
    "left_hip": (0.1, 0.52, 0), "right_hip": (-0.1, 0.52, 0),
    "left_knee": (0.1, 0.95, 0), "right_knee": (-0.1, 0.95, 0),
    "left_foot": (0.1, 1.36, 0), "right_foot": (-0.1, 1.36, 0),
}  # fmt: skip


def body(phase_wave, phase_bend):
    """Return (15, 3): phases 0 to 1 of a wave of the left hand and of a bend."""
    joints = np.array([STANDING_M[name] for name in JOINT_NAMES], float)
    hand, elbow = JOINT_NAMES.index("left_hand"), JOINT_NAMES.index("left_elbow")
    lift = np.sin(np.pi * phase_wave) if 0 < phase_wave < 1 else 0.0
    joints[elbow] += lift * np.array([0.15, -0.25, 0])
    swing = 0.15 * np.sin(6 * np.pi * phase_wave) * lift
    joints[hand] += lift * np.array([0.2, -0.85, -0.1]) + [swing, 0, 0]
    angle = (np.sin(np.pi * phase_bend) if 0 < phase_bend < 1 else 0.0) * 1.2
    upper = [k for k, name in enumerate(JOINT_NAMES) if "knee" not in name and "foot" not in name]
    hip = np.array([0, 0.52, 0])
    sine, cosine = np.sin(angle), np.cos(angle)
    turn = np.array([[1, 0, 0], [0, cosine, sine], [0, -sine, cosine]])
    joints[upper] = (joints[upper] - hip) @ turn + hip
    return joints


def recording(seed, plan, size=1.0, place=(0.2, 0.1, 2.5)):
    """Return (track, [(label, begin_s, end_s)]): `plan` names gestures, each after standing."""
    rng = np.random.default_rng(seed)
    frames, events = [], []
    for label in plan:
        frames += [body(0, 0)] * int(rng.integers(20, 40))
        n = int(rng.integers(35, 55))
        begin = len(frames)
        for phase in np.linspace(0, 1, n):
            frames.append(body(phase if label == "wave" else 0, phase if label == "bend" else 0))
        events.append((label, begin / RATE_HZ, (len(frames) - 1) / RATE_HZ))
    frames += [body(0, 0)] * 30
    joints = np.array(frames) * size + place + rng.normal(0, 0.008, (len(frames), 15, 3))
    return track_of(np.arange(len(frames)) / RATE_HZ, joints), events


def streams(n_subjects=4, plan=("wave", "bend", "wave", "bend")):
    """Return tracks by (recording, person), and events: one recording a subject."""
    tracks, events = {}, []
    for subject in range(n_subjects):
        track, done = recording(subject, plan, size=0.85 + 0.1 * subject)
        tracks[f"r{subject}", 1] = track
        events += [
            TimedEvent(f"r{subject}", label, begin, end, f"s{subject}")
            for label, begin, end in done
        ]
    return tracks, events


def clips(n_subjects=3, n_each=2):
    """Return isolated gestures: tracks by (recording, person), and events."""
    tracks, events = {}, []
    whole, done = streams(n_subjects, ("wave", "bend") * n_each)
    for number, event in enumerate(done):
        name = f"c{number}"
        cut = whole[event.recording, 1].between(event.begin_s, event.end_s)
        tracks[name, 1] = cut
        events.append(TimedEvent(name, event.label, cut.times_s[0], cut.times_s[-1], event.subject))
    return tracks, events
