"""Alignment of moments: real frames with given poses, and simulated rooms with exact ones.

The re-projection error of a pair is the median distance along z between the source's pixels,
moved, and what the target measured there.
"""

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from adibas.alignment.joint_fit import JointFit
from adibas.alignment.key_frames import Tracker
from adibas.alignment.pairing import ByShape, Moment, align, align_anywhere
from adibas.alignment.sights import see
from adibas.alignment.turn import TurnParams
from adibas.arrays import BoolArray, Float32Array, UInt8Array
from adibas.clock import NS_PER_S
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import depth_in_metres
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import IDENTITY, RigidTransform
from adibas.pipeline.mapping import MapRequest, map_recording
from benchmarks.mapping_far import SEEDS as FAR_SEEDS
from benchmarks.mapping_far import WRONG_M, far_rows, motion_error
from benchmarks.mapping_peer import peer_rows
from benchmarks.mapping_rooms import room_pair
from benchmarks.mapping_turn import turn_rows
from benchmarks.mapping_walk import PERIOD_NS, walk
from benchmarks.table import Row

REAL_DATA = "ADIBAS_REAL_DATA"
NEAR_SEEDS = range(1000, 1040)
NEAR_TURN_RAD, NEAR_SHIFT_M = np.radians(1.5), 0.03
FAST_FRAMES = 60
MIDDLE_M = np.array([0.0, 0.0, 2.0])


@dataclass(frozen=True, slots=True, eq=False)
class _Frame:
    depth_m: Float32Array
    mask: BoolArray
    moment: Moment
    world_from_camera: RigidTransform


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` a few pairs of each."""
    folder = os.environ.get(REAL_DATA)
    if folder is not None:
        yield from _turntable(Path(folder) / "person_turntable", quick=quick)
        yield from _open3d(Path(folder) / "open3d_rgbd")
    yield from _near(NEAR_SEEDS[:6] if quick else NEAR_SEEDS)
    yield from _fast_walk()
    yield from turn_rows()
    if not quick:
        yield from peer_rows()
    yield from far_rows(FAR_SEEDS[:10] if quick else FAR_SEEDS, keeps=not quick)


def _turntable(folder: Path, *, quick: bool) -> Iterator[Row]:
    """Neighbours, then the whole turn without and with loops."""
    camera = CameraCalibration(640, 480, Intrinsics(525.0, 525.0, 320.0, 240.0))
    numbers = range(8 if quick else 50)
    frames = [_turntable_frame(folder, number, camera) for number in numbers]
    told = f"turning person, {len(frames)} frames"
    ours, given, chain, n_refused = [], [], [IDENTITY], 0
    for source, target in zip(frames[1:], frames, strict=False):
        true = target.world_from_camera.inverse() @ source.world_from_camera
        fit = align(target.moment, source.moment, IDENTITY)
        if not isinstance(fit, JointFit):
            n_refused += 1
            continue
        ours.append(_reprojection_mm(target, source, fit.target_from_source, camera))
        given.append(_reprojection_mm(target, source, true, camera))
        chain.append(chain[-1] @ fit.target_from_source)
    yield Row(f"{told}: neighbours re-projected, median", np.median(ours), "mm", 2.0, "goal <=")
    yield Row("same, by the given poses", float(np.median(given)), "mm")
    yield Row("same, refused", float(n_refused), "pairs")
    # As `adibas map --body` follows a person; no floor is seen here, the camera stands upright.
    upright = Plane(np.array([0.0, -1.0, 0.0]), 0.0)
    tracker = Tracker(lambda number: frames[number].moment, aligner=ByShape(upright, TurnParams()))
    for frame in frames:
        tracker.add(frame.moment)
    track = tracker.track()
    first = frames[0].world_from_camera.inverse()
    truths = [first @ frame.world_from_camera for frame in frames]
    if not n_refused:
        yield Row(f"{told}: drift at the end, chained", _apart_mm(chain[-1], truths[-1]), "mm")
    placed = [
        _apart_mm(pose, truth)
        for pose, truth in zip(track.world_from, truths, strict=True)
        if pose is not None
    ]
    yield Row("same, by the shape, key-frames and loops", placed[-1], "mm")
    yield Row(
        "same, root mean square of all frames", float(np.sqrt(np.mean(np.square(placed)))), "mm"
    )
    yield Row("same, loops closed", float(track.n_loops), "")


def _turntable_frame(folder: Path, number: int, camera: CameraCalibration) -> _Frame:
    stem = str(folder / f"{number:010d}")
    depth_m = _depth(Path(f"{stem}_depth.png"))
    mask: BoolArray = np.asarray(cv2.imread(f"{stem}_mask.jpg", cv2.IMREAD_GRAYSCALE)) > 127
    store = cv2.FileStorage(f"{stem}_camera.xml", cv2.FILE_STORAGE_READ)
    left, _, right = np.linalg.svd(store.getNode("R").mat().astype(float))
    shift_m = store.getNode("t").mat().astype(float).ravel()
    color_rgb = np.asarray(cv2.imread(f"{stem}.jpg"))[..., ::-1].astype(np.uint8)
    return _Frame(
        depth_m,
        mask,
        _moment(depth_m, color_rgb, camera, mask),
        RigidTransform(left @ right, shift_m),
    )


def _depth(path: Path) -> Float32Array:
    """Return metres of a 16-bit picture of millimetres."""
    raw = np.asarray(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), np.uint16)
    return depth_in_metres(raw, 0.001)


def _open3d(folder: Path) -> Iterator[Row]:
    camera = CameraCalibration(640, 480, Intrinsics(525.0, 525.0, 319.5, 239.5))
    frames = []
    poses = np.loadtxt(
        line for k, line in enumerate((folder / "trajectory.log").open()) if k % 5
    ).reshape(-1, 4, 4)
    for number, pose in enumerate(poses):
        depth_m = _depth(folder / "depth" / f"{number:05d}.png")
        color = np.asarray(cv2.imread(str(folder / "color" / f"{number:05d}.jpg")))[
            ..., ::-1
        ].astype(np.uint8)
        left, _, right = np.linalg.svd(pose[:3, :3])
        world_from = RigidTransform(left @ right, pose[:3, 3])
        everything = np.ones(depth_m.shape, np.bool_)
        frames.append(
            _Frame(depth_m, everything, _moment(depth_m, color, camera, None), world_from)
        )
    ours, given = [], []
    for source, target in zip(frames[1:], frames, strict=False):
        true = target.world_from_camera.inverse() @ source.world_from_camera
        fit = align(target.moment, source.moment, IDENTITY)
        if not isinstance(fit, JointFit):
            fit = align_anywhere(target.moment, source.moment)
        if isinstance(fit, JointFit):
            ours.append(_reprojection_mm(target, source, fit.target_from_source, camera))
        given.append(_reprojection_mm(target, source, true, camera))
    told = f"Open3D's room, {len(ours)} of {len(given)} pairs aligned"
    yield Row(f"{told}: re-projected, median", float(np.median(ours)), "mm", 6.0, "goal <=")
    yield Row("same, by the true poses", float(np.median(given)), "mm")


def _near(seeds: range) -> Iterator[Row]:
    shifts, turns, ratios, n_refused = [], [], [], 0
    for seed in seeds:
        pair = room_pair(seed, NEAR_TURN_RAD, NEAR_SHIFT_M)
        if pair is None:
            continue
        fit = align(pair.target, pair.source, IDENTITY)
        if not isinstance(fit, JointFit):
            n_refused += 1
            continue
        shift_m, turn_rad = motion_error(fit.target_from_source, pair.target_from_source)
        shifts.append(1e3 * shift_m)
        turns.append(np.degrees(turn_rad))
        sd_m = np.sqrt(np.trace(np.linalg.inv(fit.information)[3:, 3:]))
        ratios.append(shift_m / sd_m)
    told = f"noisy rooms 1.5 deg and 3 cm apart, seeds {seeds[0]}-{seeds[-1]}"
    yield Row(f"{told}: shift, median error", float(np.median(shifts)), "mm", 0.5, "goal <=")
    yield Row("same: turn, median error", float(np.median(turns)), "deg", 0.015, "goal <=")
    yield Row("same: shift, root mean square", float(np.sqrt(np.mean(np.square(shifts)))), "mm")
    yield Row(
        "same: error of the shift over its stated deviation, median", float(np.median(ratios)), ""
    )
    yield Row("same: refused", float(n_refused), "pairs")


def _fast_walk() -> Iterator[Row]:
    """Follow a camera that turns by 6 degrees from frame to frame, past walls and corners."""
    walked = walk(FAST_FRAMES, FAST_FRAMES)
    mapped = map_recording(MapRequest(walked.path), lambda _done, _total: None)
    first = walked.camera_from_world[0]
    truths = {NS_PER_S + k * PERIOD_NS: first @ pose.inverse()
              for k, pose in enumerate(walked.camera_from_world)}  # fmt: skip
    placed = zip(mapped.timestamps_ns.tolist(), mapped.world_from_camera, strict=True)
    off_mm = [1e3 * motion_error(pose, truths[time_ns])[0] for time_ns, pose in placed]
    told = f"fast walk, {FAST_FRAMES} frames 6 deg apart"
    yield Row(f"{told}: placed", 100.0 * len(off_mm) / FAST_FRAMES, "%")
    yield Row(
        "same: path, root mean square error", float(np.sqrt(np.mean(np.square(off_mm)))), "mm"
    )
    n_wrong = sum(one > 1e3 * WRONG_M for one in off_mm)
    yield Row("same: placed wrong by more than 2 cm", n_wrong, "frames", 0.0, "goal")
    yield Row("same: loops closed", float(mapped.n_loops), "")
    yield Row("same: loops that count nothing", float(mapped.n_wrong_loops), "")


def _moment(
    depth_m: Float32Array, color_rgb: UInt8Array, camera: CameraCalibration, mask: BoolArray | None
) -> Moment:
    """Return a moment of a sensor that registered its depth itself."""
    calibration = RgbdCalibration(depth=camera, color=camera, color_from_depth=IDENTITY)
    return Moment(see(depth_m, np.ascontiguousarray(color_rgb, np.uint8), calibration, mask))


def _reprojection_mm(
    target: _Frame, source: _Frame, motion: RigidTransform, camera: CameraCalibration
) -> float:
    v, u = np.nonzero(source.mask & np.isfinite(source.depth_m))
    z = source.depth_m[v, u].astype(float)
    lens = camera.intrinsics
    points = np.stack([(u - lens.cx) / lens.fx * z, (v - lens.cy) / lens.fy * z, z], axis=1)
    points = motion.apply(points)
    columns = np.rint(points[:, 0] / points[:, 2] * lens.fx + lens.cx).astype(int)
    rows_v = np.rint(points[:, 1] / points[:, 2] * lens.fy + lens.cy).astype(int)
    inside = (columns >= 0) & (columns < camera.width) & (rows_v >= 0) & (rows_v < camera.height)
    off_m = np.abs(target.depth_m[rows_v[inside], columns[inside]] - points[inside, 2])
    return 1e3 * float(np.nanmedian(off_m))


def _apart_mm(pose: RigidTransform, truth: RigidTransform) -> float:
    """Return how far what lies 2 m before the camera is put wrong."""
    return 1e3 * float(np.linalg.norm(pose.apply(MIDDLE_M) - truth.apply(MIDDLE_M)))
