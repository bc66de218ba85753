"""Names of unordered markers: simulated people whom the training did not see, and real ones.

Sets are shuffled and turned to one of the four views, within 20 degrees (`marker_sets`). "Entirely
right": every point has its name, surely, and points that are none have none. "Capture": the namer
is told that the patient holds still, as in every posture session; else it may be any frame of a
movement. Real: markers of Plug-in-Gait files, and joints of motion capture, and skeletons as the
software of a first Kinect saw people, whose bones are nowhere equally long. All of the real ones
were looked at while settings were chosen (docs/skeleton.md). They need ADIBAS_REAL_DATA.
"""

import operator
import os
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.stats import beta

from adibas.arrays import FloatArray
from adibas.data.joints import JOINT_NAMES, mirror_order, other_side
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_simulator import simulate_shapes
from adibas.skeleton.starts import turn_back
from adibas.skeleton.tracking import MovingPoints, name_movement
from benchmarks.labelling_bands import band_rows
from benchmarks.labelling_sets import marker_sets
from benchmarks.mocap_files import c3d_rate_hz, read_c3d_joints, read_mocap_joints
from benchmarks.skeleton_sets import msr_action3d, utd_mhad, utkinect
from benchmarks.table import Row

SEED = 1000 + int(os.environ.get("ADIBAS_BENCHMARK_SEED", "0"))
N_BODIES, N_POSES = 40, 40
N_SWAP_SETS = 10_000
STEP_MOCAP, STEP_MARKERS = 24, 10
MOCAP_HZ, TRACKED_HZ = 120.0, 30.0
N_KINECT = 400
MOVING = "Movement_trial"
"""Of the marker files the one of somebody who does not hold still."""


@dataclass(frozen=True, slots=True)
class Told:
    """What the namer is told of each set: the view, the sizes, that the patient holds still."""

    view: bool = True
    sizes: bool = False
    still: bool = False


@dataclass(slots=True)
class Count:
    """What became of some sets."""

    n: int = 0
    right: int = 0
    wrong: int = 0
    swapped: int = 0
    seconds: float = 0.0

    def add(self, names: tuple[str | None, ...], truth: tuple[str | None, ...]) -> None:
        """Count one set."""
        self.n += 1
        self.right += names == truth
        pairs = [(a, b) for a, b in zip(names, truth, strict=True) if a is not None and a != b]
        self.wrong += bool(pairs)
        self.swapped += any(b is not None and other_side(b) == a for a, b in pairs)

    def __add__(self, other: "Count") -> "Count":
        """Return what became of both."""
        own, more = (
            (one.n, one.right, one.wrong, one.swapped, one.seconds) for one in (self, other)
        )
        return Count(*map(operator.add, own, more))


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` on a twentieth of the sets."""
    share = 20 if quick else 1
    n_bodies = max(N_BODIES // share, 3)
    people = simulate_shapes(n_bodies, N_POSES, SEED, lambda _done, _all: None)
    kinds = np.array(people.kinds)
    told = f"{n_bodies} unseen people, seed {SEED}"
    label_all(people.shapes_m[:1], 1, Told())
    for kind, how, goal in (
        ("standing", "capture", 99.5),
        ("seated", "capture", 99.5),
        ("gesture", "frame", None),
        ("moving", "frame", None),
    ):
        of_kind = people.shapes_m[kinds == kind]
        count = label_all(of_kind, len(of_kind), Told(still=how == "capture"))
        yield from _rows(f"{kind}, {how}, all 15, {told}", count, goal)
    standing = people.shapes_m[kinds == "standing"]
    for how in ("capture", "frame"):
        for sizes, known in ((False, "by places alone"), (True, "sizes measured")):
            count = label_all(standing, len(standing), Told(sizes=sizes, still=how == "capture"), 2)
            called = f"standing, {how}, 2 missing and 2 spurious, {known}, {told}"
            yield from _rows(called, count, 98.0)
    count = label_all(standing, len(standing), Told(view=False))
    yield from _rows(f"standing, all 15, view not told, {told}", count, None)
    for kind in ("standing", "gesture"):
        yield from band_rows(people.shapes_m[kinds == kind], f"{kind}, {told}", SEED, share)
    of_clinic = people.shapes_m[np.isin(kinds, ("standing", "seated"))]
    count = label_all(of_clinic, N_SWAP_SETS // share, Told(still=True))
    yield Row(f"silent left-right swaps in {count.n} sets", count.swapped, "sets", 0, "goal")
    bound = 100 * float(beta.ppf(0.95, count.swapped + 1, count.n - count.swapped))
    yield Row("share of silent swaps: upper 95 % bound", bound, "%")
    folder = os.environ.get("ADIBAS_REAL_DATA")
    if folder:
        yield from _real_rows(Path(folder), share)


def label_all(
    shapes_m: FloatArray, n_sets: int, told: Told, n_changed: int = 0, seed: int = SEED
) -> Count:
    """Name sets of shapes that face the camera; see `marker_sets`."""
    count = Count()
    namer = shipped_namer().holding_still() if told.still else shipped_namer()
    for one in marker_sets(shapes_m, n_sets, n_changed, seed):
        sizes_m = one.sizes_m if told.sizes else None
        begin = time.thread_time()
        labelling = namer.label(one.points_m, one.view if told.view else "", sizes_m)
        count.seconds += time.thread_time() - begin
        count.add(labelling.names, one.truth)
    return count


def _rows(told: str, count: Count, goal: float | None) -> Iterator[Row]:
    right = 100 * count.right / max(count.n, 1)
    whose = "" if goal is None else "goal >="
    yield Row(f"{told}: entirely right of {count.n}", right, "%", goal, whose)
    yield Row(f"{told}: with a wrong name", 100 * count.wrong / max(count.n, 1), "%")
    yield Row(f"{told}: time", 1000 * count.seconds / max(count.n, 1), "ms", 300, "thesis")


def facing(shapes_m: FloatArray) -> FloatArray:
    """Turn each of (S, 15, 3) people about the vertical to face the camera."""
    lefts = [i for i, name in enumerate(JOINT_NAMES) if name in ("left_shoulder", "left_hip")]
    rights = [mirror_order(JOINT_NAMES)[i] for i in lefts]
    across = (shapes_m[:, lefts] - shapes_m[:, rights]).mean(axis=1)
    headings = -np.arctan2(across[:, 2], across[:, 0])
    turned = [one @ turn_back(angle).T for one, angle in zip(shapes_m, headings, strict=True)]
    return np.stack(turned)


def _real_rows(folder: Path, share: int) -> Iterator[Row]:
    alone = Count()
    for name in ("Static_trial", "RoboStatic", MOVING):
        path = folder / "markers_c3d" / f"{name}.c3d"
        joints_m = read_c3d_joints(path)
        whole = joints_m[~np.isnan(joints_m).any(axis=(1, 2))]
        few = facing(whole[:: STEP_MARKERS * share])
        count = label_all(few, len(few), Told())
        alone += count
        yield from _rows(f"{name}.c3d", count, 97.0)
        yield from _rows(
            f"{name}.c3d, view not told", label_all(few, len(few), Told(view=False)), None
        )
        changed = label_all(few, len(few), Told(), 1)
        yield from _rows(f"{name}.c3d, 1 missing and 1 spurious", changed, None)
        if name != MOVING:
            held = label_all(few, len(few), Told(still=True))
            yield from _rows(f"{name}.c3d, capture", held, 97.0)
            changed = label_all(few, len(few), Told(still=True), 1)
            yield from _rows(f"{name}.c3d, capture, 1 missing and 1 spurious", changed, None)
        yield from _rows(f"{name}.c3d, followed", _followed([whole], c3d_rate_hz(path)), 97.0)
    for subject in ("01", "02"):
        files = sorted((folder / "mocap" / subject).glob("*.amc"))
        movements = [read_mocap_joints(files[0].parent / f"{subject}.asf", one) for one in files]
        frames = np.concatenate([one[:: STEP_MOCAP * share] for one in movements])
        count = label_all(facing(frames), len(frames), Told())
        alone += count
        yield from _rows(f"mocap {subject}, each frame alone, view told", count, 97.0)
        followed = _followed(movements[::share], MOCAP_HZ)
        yield from _rows(f"mocap {subject}, followed", followed, 97.0)
    yield from _rows("all frames of files and mocap, each alone, view told", alone, 97.0)
    yield from _kinect_rows(folder, share)


def _kinect_rows(folder: Path, share: int) -> Iterator[Row]:
    """Name skeletons that a Kinect saw, each frame alone."""
    rng = np.random.default_rng(SEED)
    for read in (utd_mhad, msr_action3d, utkinect):
        of_people = read(folder)
        joints_m = np.concatenate([track.joints_m for track in of_people.tracks.values()])
        whole = joints_m[~np.isnan(joints_m).any(axis=(1, 2))]
        chosen = facing(whole[rng.choice(len(whole), N_KINECT // share, replace=False)])
        for n_changed, told in ((0, "all 15"), (1, "1 missing and 1 spurious")):
            count = label_all(chosen, len(chosen), Told(), n_changed)
            yield from _rows(f"{of_people.name}, {told}", count, None)


def _followed(movements: list[FloatArray], rate_hz: float) -> Count:
    """Name each movement as a whole; the view is told of none."""
    count = Count()
    rng = np.random.default_rng(SEED)
    for movement in movements:
        frames_m = movement[:: round(rate_hz / TRACKED_HZ)]
        orders = [rng.permutation(len(joints_m)) for joints_m in frames_m]
        shuffled_m = [joints_m[order] for joints_m, order in zip(frames_m, orders, strict=True)]
        frames = [
            MovingPoints(points_m, number / TRACKED_HZ)
            for number, points_m in enumerate(shuffled_m)
        ]
        begin = time.thread_time()
        tracked = name_movement(shipped_namer(), frames)
        count.seconds += time.thread_time() - begin
        for one, order in zip(tracked, orders, strict=True):
            count.add(one.names, tuple(JOINT_NAMES[i] for i in order))
    return count
