"""How fast the simulator makes frames, on one core."""

import time
from collections.abc import Callable, Iterable, Iterator

import cv2
import numpy as np

from adibas.simulation.raster import draw, lens_vector
from adibas.simulation.scenes import SimulatedScene, open_scene
from adibas.simulation.studio import mesh_in
from benchmarks.table import Row

GOAL_DEPTH_HZ = 30.0
GOAL_COLOR_HZ = 10.0


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure CPU time, so that what else runs on the machine counts little."""
    n_frames = 5 if quick else 40
    n_threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield from _rows(n_frames)
    finally:
        cv2.setNumThreads(n_threads)


def _rows(n_frames: int) -> Iterator[Row]:
    depth_s = _seconds_a_frame(open_scene("standing", 1, has_color=False), n_frames)
    yield Row("640x480 depth with labels", 1 / depth_s, "frames/s", GOAL_DEPTH_HZ, "goal >=")
    for size, goal in (((1024, 1280), GOAL_COLOR_HZ), ((480, 640), None)):
        scene = open_scene("standing", 1, color_size=size)
        whole_s = _seconds_a_frame(scene, n_frames)
        name = f"{size[1]}x{size[0]}"
        goal_name = "" if goal is None else "goal >="
        yield Row(f"{name} colour alone", 1 / (whole_s - depth_s), "frames/s", goal, goal_name)
        yield Row(f"{name} colour + 640x480 depth", 1 / whole_s, "frames/s")
    yield _raster_row(scene, n_frames)


def _raster_row(scene: SimulatedScene, n_frames: int) -> Row:
    patient, posed = scene.person(0)
    mesh = mesh_in(scene.depth_from_world, patient, posed)
    lens = lens_vector(scene.device.depth.intrinsics, ())

    def work() -> None:
        draw(mesh.vertices, mesh.triangles, lens, (480, 640), hides_back_faces=True)

    name = f"rasterise {len(mesh.triangles):,} triangles at 640x480"
    return Row(name, 1e3 * _median_s(work, n_frames), "ms", 1.1, "prototype")


def _seconds_a_frame(scene: SimulatedScene, n_frames: int) -> float:
    numbers = iter(range(n_frames + 1))
    return _median_s(lambda: scene.frame(next(numbers)), n_frames)


def _median_s(work: Callable[[], object], n_rounds: int) -> float:
    work()
    times_s = []
    for _ in range(n_rounds):
        start_s = time.process_time()
        work()
        times_s.append(time.process_time() - start_s)
    return float(np.median(times_s))
