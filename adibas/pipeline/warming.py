"""Compiles the hot loops before somebody waits for them: once after an installation.

Compiling takes a minute and holds Python's lock all the while, so the window leaves it to a
process of its own; the machine code comes to everybody through numba's cache.
"""

import gc
import importlib.metadata
import logging
import os
import tempfile
import zlib
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from multiprocessing.process import BaseProcess
from pathlib import Path

import numpy as np
import platformdirs

import adibas
from adibas.arrays import read_only
from adibas.data.frames import depth_in_metres
from adibas.errors import FileError
from adibas.files import written_whole
from adibas.shipped_kernels import shipped_folder

logger = logging.getLogger(__name__)

N_FRAMES = 2
N_BOARDS, N_SHAPES = 8, 8
COLOR_SIZE = (480, 640)
SPACE, N_SECONDS, RATE_HZ = 3, 4, 30
GARBAGE_EVERY = 1_000_000
"""New objects: compiling keeps most of what it makes, and a tenth of its time went into looking
through all of that again and again."""

NICENESS = 10
"""Of the process: whoever waits for the computer goes first."""


def start_warming(folder: Path | None = None) -> BaseProcess | None:
    """Compile in a process of its own; None where that was done before, or by who built this.

    Parameters
    ----------
    folder : Path or None
        For the note that it was done; None: the user's cache folder.
    """
    note = _note(folder or platformdirs.user_cache_path("adibas"))
    if shipped_folder() is not None or note.exists():
        return None
    process = get_context("spawn").Process(target=warm_kernels, args=(note,), daemon=True)
    process.start()
    return process


def warm_kernels(note: Path) -> None:
    """Do a little of every work that has hot loops, and note that it was done."""
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    _collect_seldom()
    for work in WORKS:
        work()
    _write(note)


def warm_at_once(folder: Path | None = None) -> None:
    """Do what `start_warming` does with every core, and wait for its end."""
    note = _note(folder or platformdirs.user_cache_path("adibas"))
    if note.exists():
        return
    spawn = get_context("spawn")
    with ProcessPoolExecutor(mp_context=spawn, initializer=_collect_seldom) as processes:
        for done in [processes.submit(work) for work in WORKS]:
            done.result()
    _write(note)


def take_session() -> None:
    """Take a tiny demo session."""
    from adibas.pipeline.demo import run_demo

    with tempfile.TemporaryDirectory() as name:
        run_demo(Path(name), _say_nothing, n_frames=N_FRAMES)


def calibrate_a_camera() -> None:
    """Find a board in some pictures, and fit their camera."""
    from adibas.data.board import Board
    from adibas.pipeline.calibrating import NamedImage, calibrate_camera
    from adibas.simulation.boards import render_board
    from adibas.simulation.boards_device import uncalibrated_device
    from adibas.simulation.boards_poses import random_board_poses

    rng = np.random.default_rng(0)
    device = uncalibrated_device(0, COLOR_SIZE)
    color = device.calibration.color
    if color is None:
        raise ValueError("the simulated device has no colour camera")
    board = Board(9, 6, 0.025)
    poses = random_board_poses(rng, board, color, N_BOARDS)
    pictures = (render_board(board, pose, color, rng).image for pose in poses)
    calibrate_camera([NamedImage(str(i), image) for i, image in enumerate(pictures)], board)


def compare_depth_with_color() -> None:
    """Look on a grid for where edges lie best."""
    from adibas.calibration.registration_check_kernels import rough_scores

    few, sums = np.zeros(SPACE), np.ones((SPACE, SPACE))
    rough_scores((few, few), np.ones((SPACE, 2)), sums, 1.0, np.empty((SPACE,) * 3))


def name_joints() -> None:
    """Name the points of a standing body, and compare and fit shapes."""
    from adibas.pipeline.skeleton_labelling import shipped_namer
    from adibas.shapes.point_distribution import learn_distribution
    from adibas.shapes.shape_context import match_shapes
    from adibas.shapes.shape_fitting import fit_shape
    from adibas.skeleton.seen_space import SeenSpace

    namer = shipped_namer()
    shapes_m = np.random.default_rng(0).normal(0.0, 0.5, (N_SHAPES, len(namer.names), SPACE))
    fit_shape(learn_distribution(namer.names, shapes_m), shapes_m[0], 1.0)
    points_m = np.random.default_rng(0).normal(0.0, 0.5, (len(namer.names), SPACE))
    namer.label(points_m, seen=SeenSpace(np.eye(SPACE), np.zeros(SPACE)))
    namer.label(points_m[:, :2], "front")
    match_shapes(points_m[:, :2], points_m[:, :2])


def find_limbs() -> None:
    """Find the limbs of a disc, and cut labels that borders are everywhere between."""
    from adibas.graphcut.boundary import boundary_weights
    from adibas.graphcut.energy import equal_penalties, label_energy
    from adibas.graphcut.minimising import minimise
    from adibas.graphcut.neighbors import connect_pixels
    from adibas.limbs.segmentation import segment
    from adibas.pipeline.shipped_limbs import shipped_model

    rows, columns = np.indices((48, 48))
    mask = np.hypot(rows - 24, columns - 24) < 10.0  # noqa: PLR2004  (pixels)
    depth_m = np.full(mask.shape, 2.0, np.float32)
    segment(depth_m, mask, 100.0, shipped_model())
    graph = connect_pixels(mask)
    probabilities = np.random.default_rng(0).random((graph.n_pixels, SPACE))
    boundary = boundary_weights(graph, depth_m)
    minimise(label_energy(graph, probabilities, boundary, equal_penalties(SPACE)))


def find_joints() -> None:
    """Find the joints of a simulated person without markers."""
    from adibas.pipeline.person_judge import person_judge
    from adibas.pipeline.pose_following import PoseEstimator, forest_segmenter
    from adibas.pipeline.shipped_limbs import shipped_model
    from adibas.simulation.scenes import open_scene

    scene = open_scene("standing", has_color=False)
    calibration = scene.info.calibration
    raw = scene.frame(0).sensor_frame.depth_raw
    if calibration is None or calibration.depth is None or raw is None:
        raise ValueError("a simulated scene has depth and a calibration of its camera")
    model, camera = shipped_model(), calibration.depth
    segmenter, judge = forest_segmenter(model, camera), person_judge(model, camera)
    estimator = PoseEstimator(camera, segmenter, calibration.floor, judge=judge)
    depth_m = depth_in_metres(raw, scene.info.depth_unit_m)
    estimator.look(depth_m, 0.0)
    read_only(depth_m)  # as who labels limbs has it; numba compiles for each
    estimator.look(depth_m, 1.0 / RATE_HZ)


def look_near_a_marker() -> None:
    """Ask for the depth at a point of a picture that is nobody's yet."""
    from adibas.markers.blobs import depth_near

    depth_near(np.ones((SPACE, SPACE), np.float32), 1.0, 1.0, 1.0)


def simulate_light_and_boards() -> None:
    """See what the simulated sensor shows on other screens: LEDs, and a board to calibrate with."""
    from adibas.calibration.corners import as_gray
    from adibas.simulation.scenes import open_scene

    open_scene("anterior_led").frame(0)
    open_scene("board").frame(0)
    color_rgb = np.zeros((SPACE, SPACE, SPACE), np.uint8)
    as_gray(color_rgb)
    read_only(color_rgb)  # as a sensor's
    as_gray(color_rgb)


def find_gestures() -> None:
    """Look for the gestures of the program in joints that are nowhere twice."""
    from adibas.data.joints import JOINT_NAMES
    from adibas.data.skeleton_track import track_of
    from adibas.gestures.described_track import describe
    from adibas.gestures.model_file import read_model, shipped_gestures

    model = read_model(shipped_gestures())
    places_m = np.random.default_rng(0).normal(0.0, 0.3, (len(JOINT_NAMES), SPACE))
    times_s = np.arange(model.descriptor.rate_hz * N_SECONDS) / model.descriptor.rate_hz
    joints_m = places_m + 0.1 * np.sin(times_s)[:, None, None]
    model.detect(describe(track_of(times_s, joints_m), model.descriptor))
    model.classify(model.examples[0])


def follow_an_exercise() -> None:
    """Align a stream with examples and with mixtures, as the methods of the thesis do."""
    from adibas.timeseries.mixture_stream import MixtureModel, MixtureStream
    from adibas.timeseries.stream import StreamAligner

    frames = np.random.default_rng(0).normal(size=(N_FRAMES, SPACE))
    StreamAligner([frames], steps="free").feed(frames)
    means = frames[:, None]
    mixtures = MixtureModel(np.ones((N_FRAMES, 1)), means, np.ones_like(means))
    MixtureStream([mixtures]).feed(frames)


def map_a_room() -> None:
    """Put two pictures of one place together, where to is not asked, and look at the place."""
    from adibas.alignment.features import FeatureParams
    from adibas.alignment.key_frames import Tracker
    from adibas.alignment.pairing import Moment
    from adibas.alignment.sights import see
    from adibas.alignment.surfels import SurfelMap
    from adibas.alignment.turn import seen_after
    from adibas.alignment.views import prepare_view
    from adibas.geometry.disc_kernels import draw_discs
    from adibas.geometry.rigid import IDENTITY
    from adibas.simulation.scenes import open_scene

    scene = open_scene("standing", has_color=False)
    calibration = scene.info.calibration
    raw = scene.frame(0).sensor_frame.depth_raw
    if calibration is None or calibration.depth is None or calibration.color is None or raw is None:
        raise ValueError("a simulated scene has depth and a calibration of both cameras")
    depth_m = depth_in_metres(raw, scene.info.depth_unit_m)
    size = (calibration.color.height // 8, calibration.color.width // 8, 3)
    coarse = np.random.default_rng(0).integers(0, 255, size, np.uint8)
    color_rgb = np.ascontiguousarray(coarse.repeat(8, 0).repeat(8, 1))
    moment = Moment(see(depth_m, color_rgb, calibration), FeatureParams())
    tracker = Tracker(lambda _number: moment)
    for _ in range(2):
        tracker.add(moment)
    view = prepare_view(depth_m, calibration.depth)
    surfels = SurfelMap()
    for _ in range(2):
        surfels.add(view, color_rgb, calibration, IDENTITY)
    seen_after(view, IDENTITY)
    found = surfels.surface()
    places, normals, radii = found.points_m.copy(), found.normals.copy(), found.radii_m.copy()
    draw_discs(places, normals, radii, found.colors_rgb, (8, 8))


def pack_depth() -> None:
    """Pack a depth image as .oni files do, and unpack it."""
    from adibas.recordings.oni_codec import decode_16zt, encode_16zt

    depth = np.arange(64, dtype=np.uint16).reshape(8, 8) * 40
    packed = encode_16zt(depth)
    if packed is not None:
        decode_16zt(packed, depth.shape)


WORKS: tuple[Callable[[], None], ...] = (
    take_session,
    calibrate_a_camera,
    compare_depth_with_color,
    name_joints,
    find_limbs,
    find_joints,
    look_near_a_marker,
    simulate_light_and_boards,
    find_gestures,
    follow_an_exercise,
    map_a_room,
    pack_depth,
)


def _collect_seldom() -> None:
    """Leave garbage alone for longer than Python would."""
    gc.set_threshold(GARBAGE_EVERY)


def _write(note: Path) -> None:
    try:
        with written_whole(note) as unfinished:
            unfinished.touch()
    except FileError:
        logger.info("the note of the compiled kernels cannot be written; next time once more")


def _note(folder: Path) -> Path:
    """Return the note's place: other sources, another version or compiler need another one."""
    compiler = importlib.metadata.version("numba")
    package = Path(adibas.__file__).resolve().parent
    marks = [f"{source} {_age(source)}" for source in sorted(package.rglob("*kernels.py"))]
    sources = zlib.crc32("\n".join(marks).encode())
    return folder / f"compiled-{adibas.__version__}-{sources:08x}-numba-{compiler}"


def _age(source: Path) -> tuple[int, int]:
    """Return what numba, too, knows a source by."""
    facts = source.stat()
    return facts.st_mtime_ns, facts.st_size


def _say_nothing(_done: int, _total: int) -> None:
    """Report to nobody."""


if __name__ == "__main__":
    warm_at_once()
