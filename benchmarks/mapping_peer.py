"""The path of a camera beside Open3D's own, of the same frames.

Open3D does what its reconstruction system does: its RGB-D odometry (colour and depth together)
from frame to frame, the same between every fifth frame where these see alike, and its global
optimisation of the pose graph, which doubts loops. It takes part where it is installed.
"""

import importlib
import importlib.util
from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np

from adibas.alignment.registration import register_depth
from adibas.arrays import FloatArray, UInt8Array, UInt16Array
from adibas.clock import NS_PER_S
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import depth_in_metres
from adibas.pipeline.mapping import MapRequest, map_recording
from adibas.recordings import open_recording
from adibas.recordings.decoding import decode_color
from benchmarks.mapping_walk import PERIOD_NS, Walk, walk
from benchmarks.table import Row

N_FRAMES = 200
"""Of a turn by 380 degrees, 1.9 degrees apart."""
KEY_EVERY = 5
LOOP_RAD, LOOP_M = np.radians(25.0), 0.5
FARTHEST_STEP_M = 0.07
"""Of its system's settings: depths that differ by more are no pair."""


def peer_rows() -> Iterator[Row]:
    """Print the root mean square error of both paths, the first frame given."""
    walked = walk(N_FRAMES, N_FRAMES)
    mapped = map_recording(MapRequest(walked.path), lambda _done, _total: None)
    numbers = np.rint((mapped.timestamps_ns - NS_PER_S) / PERIOD_NS).astype(int)
    first = walked.camera_from_world[0]
    truth_m = np.array(
        [(first @ pose.inverse()).translation_m for pose in walked.camera_from_world]
    )
    found_m = np.array([pose.translation_m for pose in mapped.world_from_camera])
    ours_mm = _rms_mm(found_m - truth_m[numbers])
    told = f"walk by 380 deg, {N_FRAMES} frames: path after loop closure, rms error"
    yield Row(
        f"{told}, {mapped.n_loops} loops, {len(found_m)} placed", ours_mm, "mm", *_peer(walked)
    )


def _peer(walked: Walk) -> tuple[float, str] | tuple[None, str]:
    if importlib.util.find_spec("open3d") is None:
        return None, "Open3D is not installed"
    calibration, depths, colors = _frames(walked)
    first = calibration.color_from_depth @ walked.camera_from_world[0]
    truth_m = np.array(
        [
            (first @ (calibration.color_from_depth @ pose).inverse()).translation_m
            for pose in walked.camera_from_world
        ]
    )
    return _rms_mm(_open3d_path_m(_color_camera(calibration), depths, colors) - truth_m), "Open3D"


def _frames(walked: Walk) -> tuple[RgbdCalibration, list[UInt16Array], list[UInt8Array]]:
    """Return pictures without distortion, and depth in them in millimetres."""
    depths, colors = [], []
    with open_recording(walked.path) as recording:
        calibration = recording.info.calibration
        if calibration is None:
            raise ValueError("a simulated walk has a calibration")
        camera = _color_camera(calibration)
        lens = camera.intrinsics
        matrix = np.array([[lens.fx, 0.0, lens.cx], [0.0, lens.fy, lens.cy], [0.0, 0.0, 1.0]])
        size = camera.width, camera.height
        maps = cv2.initUndistortRectifyMap(
            matrix, np.array(camera.distortion), np.eye(3), matrix, size, cv2.CV_32FC1
        )
        for number in range(len(recording)):
            frame = recording.read(number)
            if frame.depth_raw is None or frame.color is None:
                raise ValueError("a simulated walk has depth and colour")
            depth_m = depth_in_metres(frame.depth_raw, recording.info.depth_unit_m)
            corrected_m = np.ascontiguousarray(calibration.corrected_depth(depth_m), np.float32)
            seen_m = np.nan_to_num(register_depth(corrected_m, calibration))
            flat_m = cv2.remap(seen_m, *maps, cv2.INTER_NEAREST)
            depths.append(np.rint(1e3 * flat_m).astype(np.uint16))
            picture = decode_color(frame.color, number)
            colors.append(np.asarray(cv2.remap(picture, *maps, cv2.INTER_LINEAR), np.uint8))
    return calibration, depths, colors


def _color_camera(calibration: RgbdCalibration) -> CameraCalibration:
    if calibration.color is None:
        raise ValueError("a simulated walk has a colour camera")
    return calibration.color


def _open3d_path_m(
    camera: CameraCalibration, depths: list[UInt16Array], colors: list[UInt8Array]
) -> FloatArray:
    """Return the (N, 3) places of the camera, in the axes of the first frame."""
    o3d: Any = importlib.import_module("open3d")
    registration, odometry = o3d.pipelines.registration, o3d.pipelines.odometry
    lens = camera.intrinsics
    pinhole = o3d.camera.PinholeCameraIntrinsic(
        camera.width, camera.height, lens.fx, lens.fy, lens.cx, lens.cy
    )
    images = [
        o3d.geometry.RGBDImage.create_from_color_and_depth(
            o3d.geometry.Image(color), o3d.geometry.Image(depth), 1000.0, 5.0
        )
        for color, depth in zip(colors, depths, strict=True)
    ]
    option = odometry.OdometryOption(depth_diff_max=FARTHEST_STEP_M)

    def aligned(source: int, target: int, guess: FloatArray) -> tuple[bool, FloatArray, FloatArray]:
        found: tuple[bool, FloatArray, FloatArray] = odometry.compute_rgbd_odometry(
            images[source],
            images[target],
            pinhole,
            guess,
            odometry.RGBDOdometryJacobianFromHybridTerm(),
            option,
        )
        return found

    graph = registration.PoseGraph()
    target_from_first = np.eye(4)
    graph.nodes.append(registration.PoseGraphNode(target_from_first))
    for source in range(len(images) - 1):
        _, motion, information = aligned(source, source + 1, np.eye(4))
        target_from_first = motion @ target_from_first
        graph.nodes.append(registration.PoseGraphNode(np.linalg.inv(target_from_first)))
        graph.edges.append(
            registration.PoseGraphEdge(source, source + 1, motion, information, uncertain=False)
        )
    for source in range(0, len(images), KEY_EVERY):
        for target in range(source + KEY_EVERY, len(images), KEY_EVERY):
            guess = np.linalg.inv(graph.nodes[target].pose) @ graph.nodes[source].pose
            if not _is_near(guess):
                continue
            is_found, motion, information = aligned(source, target, guess)
            if is_found:
                graph.edges.append(
                    registration.PoseGraphEdge(source, target, motion, information, uncertain=True)
                )
    registration.global_optimization(
        graph,
        registration.GlobalOptimizationLevenbergMarquardt(),
        registration.GlobalOptimizationConvergenceCriteria(),
        registration.GlobalOptimizationOption(FARTHEST_STEP_M, 0.25, 0.1, 0),
    )
    poses = np.array([node.pose for node in graph.nodes])
    return np.asarray((np.linalg.inv(poses[0]) @ poses)[:, :3, 3], float)


def _is_near(motion: FloatArray) -> bool:
    """Say whether two places see alike."""
    turn_rad = np.arccos(np.clip((np.trace(motion[:3, :3]) - 1.0) / 2.0, -1.0, 1.0))
    return bool(turn_rad <= LOOP_RAD and np.linalg.norm(motion[:3, 3]) <= LOOP_M)


def _rms_mm(off_m: FloatArray) -> float:
    return 1e3 * float(np.sqrt((off_m**2).sum(axis=1).mean()))
