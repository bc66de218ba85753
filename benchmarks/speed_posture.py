"""How fast a burst is analysed: from the file to markers in space, whole and stage by stage."""

import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from adibas.alignment.registration import register_pixels
from adibas.arrays import UInt8Array
from adibas.body.floor import find_floor
from adibas.body.mask import find_body
from adibas.data.frames import RgbdFrame
from adibas.markers.color_model import ColorModel, grow_region
from adibas.markers.detection import find_color_markers
from adibas.markers.lab import rgb_to_lab
from adibas.markers.likeness_kernels import unlikeness
from adibas.pipeline.learning import LearningRequest, learn_from_picture
from adibas.pipeline.outline import body_in_color
from adibas.pipeline.posture import PostureParams, analyse_burst
from adibas.recordings import create_recording, open_recording
from adibas.recordings.decoding import to_rgbd
from adibas.recordings.ports import RecordingOptions, RecordingReader
from adibas.simulation.scenes import open_scene
from benchmarks.table import Row

SEED = 7
N_FRAMES = 30
N_CLICKS = 3
JPEG_QUALITY = 95
GOAL_HZ = 15.0
GOAL_SLIDER_MS = 50.0
"""A step of the sensitivity's slider: grow the region anew."""
CLICK_SENSITIVITY = 20.0
EVERYTHING = 1000.0
PLAIN_DISTANCE = (1.0, 1.0)
"""Weight of lightness, and how far the light may change: CIE76."""
Stages = dict[str, Callable[[], object]]


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` fewer frames and rounds."""
    n_frames, n_rounds = (6, 2) if quick else (N_FRAMES, 7)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "burst.mcap"
        clicks = _record(path, n_frames)
        with open_recording(path) as recording:
            first = to_rgbd(recording.read(0), recording.info)
            model, _ = learn_from_picture(first.color_rgb, LearningRequest(path, clicks))
            yield from _chain_rows(recording, model, n_rounds)
            yield from _stage_rows(recording, model, 2 * n_rounds)
    yield from _color_rows(first, clicks[0], model, 2 * n_rounds)


def _record(path: Path, n_frames: int) -> tuple[tuple[float, float], ...]:
    """Record the scene; return where a user would click on markers in its first frame."""
    scene = open_scene("anterior", seed=SEED, jpeg_quality=JPEG_QUALITY)
    with create_recording(path, scene.info, RecordingOptions(is_live=False)) as writer:
        frames = [scene.frame(index) for index in range(n_frames)]
        for frame in frames:
            writer.write(frame.sensor_frame)
    visible = [marker for marker in frames[0].truth.markers if marker.is_visible]
    frontal = sorted(visible, key=lambda marker: marker.view_angle_rad)[:N_CLICKS]
    return tuple((marker.u, marker.v) for marker in frontal)


def _chain_rows(recording: RecordingReader, model: ColorModel, n_rounds: int) -> Iterator[Row]:
    """Read, register, mask, detect and measure: wall-clock time, and CPU time of all threads."""
    calibration, params = recording.info.calibration, PostureParams()
    if calibration is None:
        raise ValueError("a simulated scene brings its calibration")

    def chain() -> object:
        frames = (to_rgbd(frame, recording.info) for frame in recording)
        return analyse_burst(frames, calibration, model, params)

    wall_s, cpu_s = _seconds(chain, n_rounds)
    name = f"whole chain, 1280x1024 + 640x480, {len(recording)} frames (seed {SEED})"
    yield Row(name, len(recording) / wall_s, "frames/s", GOAL_HZ, "goal >=")
    yield Row("whole chain, CPU time of a frame", 1e3 * cpu_s / len(recording), "ms")


def _stage_rows(recording: RecordingReader, model: ColorModel, n_rounds: int) -> Iterator[Row]:
    for name, work in _stages(recording, model).items():
        yield Row(f"{name}, CPU time", 1e3 * _seconds(work, n_rounds)[1], "ms")


def _stages(recording: RecordingReader, model: ColorModel) -> Stages:
    """Return the stages of one frame, each on what the one before it gave."""
    calibration, params = recording.info.calibration, PostureParams()
    if calibration is None or calibration.color is None or calibration.depth is None:
        raise ValueError("a simulated scene brings its calibration")
    color, depth = calibration.color, calibration.depth
    frame = to_rgbd(recording.read(0), recording.info)
    depth_m = calibration.corrected_depth(frame.depth_m)
    floor = find_floor(depth_m, depth)
    body = find_body(depth_m, depth, floor)
    if body is None:
        raise ValueError("the simulated patient is seen")
    pixels = body.pixels
    registration = register_pixels(depth_m, calibration)
    outline = body_in_color(pixels, registration, color, params.margin_m)
    focal_px = color.intrinsics.fx
    return {
        "read and decode": lambda: to_rgbd(recording.read(0), recording.info),
        "floor": lambda: find_floor(depth_m, depth),
        "mask": lambda: find_body(depth_m, depth, floor),
        "register": lambda: register_pixels(depth_m, calibration),
        "outline in colour": lambda: body_in_color(pixels, registration, color, params.margin_m),
        "detect": lambda: find_color_markers(
            frame.color_rgb, outline, registration.depth_m, focal_px, model, params.detection
        ),
    }


def _color_rows(
    frame: RgbdFrame, click_uv: tuple[float, float], model: ColorModel, n_rounds: int
) -> Iterator[Row]:
    """Colour alone, on a whole picture: the marker mask beside OpenCV's, and the slider."""
    picture_rgb = frame.color_rgb
    centroids_lab = model.centroids_lab.astype(np.float32)
    limit = np.float32(model.threshold)

    def ours() -> object:
        distance = unlikeness(rgb_to_lab(picture_rgb), centroids_lab, *PLAIN_DISTANCE)
        return _blobs_of((distance < limit).view(np.uint8))

    peers = {
        "cv2, CIELAB in 8 bit": lambda: _blobs_of(_opencv_8_bit(picture_rgb, model)),
        "cv2, CIELAB in floats": lambda: _blobs_of(_opencv_floats(picture_rgb, model)),
    }
    for peer_name, peer in peers.items():
        ours_s, peer_s = (_seconds(work, n_rounds)[1] for work in (ours, peer))
        name = "marker mask of 1280x1024 (CIELAB, threshold, opening, blobs), CPU time"
        yield Row(name, 1e3 * ours_s, "ms", 1e3 * peer_s, peer_name)
    lab = rgb_to_lab(picture_rgb)
    for extent, sensitivity in (("a marker", CLICK_SENSITIVITY), ("everything", EVERYTHING)):
        growing_s = _seconds(partial(grow_region, lab, click_uv, sensitivity), n_rounds)[1]
        name = f"slider step, the region grows over {extent} of 1280x1024, CPU time"
        yield Row(name, 1e3 * growing_s, "ms", GOAL_SLIDER_MS, "goal <")


def _blobs_of(mask: UInt8Array) -> object:
    opened = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    return cv2.connectedComponentsWithStats(opened)


def _opencv_floats(picture_rgb: UInt8Array, model: ColorModel) -> UInt8Array:
    """Threshold the same distance as ours."""
    lab = cv2.cvtColor(picture_rgb.astype(np.float32) / 255, cv2.COLOR_RGB2Lab)
    mask = np.zeros(picture_rgb.shape[:2], np.uint8)
    for centroid_lab in model.centroids_lab.astype(np.float32):
        squared = cv2.transform((lab - centroid_lab) ** 2, np.ones((1, 3), np.float32))
        mask |= (squared < model.threshold**2).view(np.uint8)
    return mask


def _opencv_8_bit(picture_rgb: UInt8Array, model: ColorModel) -> UInt8Array:
    """Threshold a box about each centroid in rounded CIELAB: cruder than a distance, and fast."""
    lab = cv2.cvtColor(picture_rgb, cv2.COLOR_RGB2Lab)
    mask = np.zeros(picture_rgb.shape[:2], np.uint8)
    to_8_bit = np.array([255 / 100, 1, 1])
    reach = model.threshold * to_8_bit
    for centroid_lab in model.centroids_lab:
        middle = centroid_lab * to_8_bit + (0, 128, 128)
        mask |= cv2.inRange(lab, middle - reach, middle + reach).astype(np.uint8)
    return np.minimum(mask, 1)


def _seconds(work: Callable[[], object], n_rounds: int) -> tuple[float, float]:
    """Return the median wall-clock and CPU time (of all threads) after a first run."""
    work()
    spent = []
    for _ in range(n_rounds):
        wall_s, cpu_s = time.perf_counter(), time.process_time()
        work()
        spent.append((time.perf_counter() - wall_s, time.process_time() - cpu_s))
    wall_s, cpu_s = (float(np.median(times_s)) for times_s in zip(*spent, strict=True))
    return wall_s, cpu_s
