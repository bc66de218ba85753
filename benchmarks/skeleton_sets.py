"""Skeletons of real people, recorded by others, in our joints and axes.

They stay where `ADIBAS_REAL_DATA` says. All three sets have the 20 joints of the Kinect SDK, y up.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.io import loadmat

from adibas.arrays import FloatArray
from adibas.data.events import TimedEvent
from adibas.data.skeleton_track import SkeletonTrack, track_of

KINECT_NAMES = (
    "hip_center",
    "spine",
    "neck",
    "head",
    "left_shoulder",
    "left_elbow",
    "left_wrist",
    "left_palm",
    "right_shoulder",
    "right_elbow",
    "right_wrist",
    "right_palm",
    "left_hip",
    "left_knee",
    "left_ankle",
    "left_foot",
    "right_hip",
    "right_knee",
    "right_ankle",
    "right_foot",
)
UTD_NAMES = (
    "head",
    "neck",
    "spine",
    "hip_center",
    "left_shoulder",
    "left_elbow",
    "left_wrist",
    "left_palm",
    "right_shoulder",
    "right_elbow",
    "right_wrist",
    "right_palm",
    "left_hip",
    "left_knee",
    "left_ankle",
    "left_foot",
    "right_hip",
    "right_knee",
    "right_ankle",
    "right_foot",
)
MSR_NAMES = (
    "left_shoulder",
    "right_shoulder",
    "neck",
    "spine",
    "left_hip",
    "right_hip",
    "hip_center",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
    "left_palm",
    "right_palm",
    "left_knee",
    "right_knee",
    "left_ankle",
    "right_ankle",
    "left_foot",
    "right_foot",
    "head",
)
"""Which of the two sides is the left one is not documented."""

SOURCE_OF_JOINT = (
    "head",
    "neck",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_palm",
    "right_palm",
    "spine",
    "left_hip",
    "right_hip",
    "left_knee",
    "right_knee",
    "left_ankle",
    "right_ankle",
)
MSR_RATE_HZ, UTD_RATE_HZ, UTKINECT_INDEX_HZ = 15.0, 30.0, 60.0
MOST_ZEROS = 0.7
"""Share of unseen frames above which a sequence is no sample."""


@dataclass(frozen=True, slots=True, eq=False)
class SkeletonSet:
    """Recordings by name, and what happens in them."""

    name: str
    tracks: dict[str, SkeletonTrack]
    events: tuple[TimedEvent, ...]


def msr_action3d(folder: Path) -> SkeletonSet:
    """Return the isolated actions of MSR-Action3D."""
    tracks: dict[str, SkeletonTrack] = {}
    events: list[TimedEvent] = []
    for path in sorted((folder / "skeletons" / "msr_action3d").glob("*_skeleton3D.txt")):
        action, subject, _ = path.name.split("_")[:3]
        joints = np.loadtxt(path)[:, :3].reshape(-1, 20, 3)
        joints[(joints == 0).all(axis=2)] = np.nan
        seen = np.isfinite(joints).any(axis=(1, 2))
        if seen.mean() < 1.0 - MOST_ZEROS:
            continue
        times_s = np.arange(len(joints))[seen] / MSR_RATE_HZ
        _add(path.name.removesuffix("_skeleton3D.txt"), times_s,
             _ours(joints[seen], MSR_NAMES), action, subject, tracks, events)  # fmt: skip
    return SkeletonSet("MSR-Action3D", tracks, tuple(events))


def utd_mhad(folder: Path) -> SkeletonSet:
    """Return the isolated actions of UTD-MHAD."""
    tracks: dict[str, SkeletonTrack] = {}
    events: list[TimedEvent] = []
    for path in sorted((folder / "utd_mhad" / "Skeleton").glob("*_skeleton.mat")):
        action, subject, _ = path.name.split("_")[:3]
        joints = np.moveaxis(loadmat(path)["d_skel"], 2, 0)
        times_s = np.arange(len(joints)) / UTD_RATE_HZ
        _add(path.name.removesuffix("_skeleton.mat"), times_s, _ours(joints, UTD_NAMES),
             f"a{int(action[1:]):02d}", subject, tracks, events)  # fmt: skip
    return SkeletonSet("UTD-MHAD", tracks, tuple(events))


def utkinect(folder: Path) -> SkeletonSet:
    """Return the continuous recordings of UTKinect-Action3D."""
    place = folder / "skeletons" / "utkinect"
    tracks = {}
    for path in sorted(place.glob("joints_*.txt")):
        rows = np.loadtxt(path)
        _, first = np.unique(rows[:, 0], return_index=True)
        rows = rows[first]
        joints = rows[:, 1:].reshape(-1, 20, 3)
        joints[(joints == 0).all(axis=2)] = np.nan
        name = path.stem.removeprefix("joints_")
        tracks[name] = track_of(rows[:, 0] / UTKINECT_INDEX_HZ, _ours(joints, KINECT_NAMES))
    labels = (place / "action_labels.txt").read_text("utf-8")
    return SkeletonSet("UTKinect", tracks, tuple(_labelled(labels, tracks)))


def _labelled(text: str, tracks: dict[str, SkeletonTrack]) -> Iterator[TimedEvent]:
    name = ""
    for line in text.splitlines():
        if re.fullmatch(r"s\d\d_e\d\d\s*", line):
            name = line.strip()
        elif (found := re.match(r"(\w+):\s*(\d+)\s+(\d+)", line)) and name in tracks:
            begin, end = (int(number) / UTKINECT_INDEX_HZ for number in found.groups()[1:])
            yield TimedEvent(name, found[1], begin, end, subject=name[:3])


def _ours(joints: FloatArray, names: tuple[str, ...]) -> FloatArray:
    """Pick the 15 joints, and turn the axes: the SDK mirrors its images and counts y upwards."""
    picked = joints[:, [names.index(name) for name in SOURCE_OF_JOINT]]
    return np.asarray(picked * np.array([-1.0, -1.0, 1.0]))


def _add(  # noqa: PLR0913, PLR0917
    name: str,
    times_s: FloatArray,
    joints_m: FloatArray,
    label: str,
    subject: str,
    tracks: dict[str, SkeletonTrack],
    events: list[TimedEvent],
) -> None:
    tracks[name] = track_of(times_s, joints_m)
    events.append(TimedEvent(name, label, float(times_s[0]), float(times_s[-1]), subject))
