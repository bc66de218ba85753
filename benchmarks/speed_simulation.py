"""How fast the simulator makes frames, on one core."""

from collections.abc import Iterable, Iterator

import cv2

from adibas.simulation.raster import draw, lens_vector
from adibas.simulation.scenes import SimulatedScene, open_scene
from adibas.simulation.studio import mesh_in
from benchmarks.table import Row
from benchmarks.works import median_ms

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
    depth_ms = _ms_a_frame(open_scene("standing", 1, has_color=False), n_frames)
    yield Row("640x480 depth with labels", 1e3 / depth_ms, "frames/s", GOAL_DEPTH_HZ, "goal >=")
    for size, goal in (((1024, 1280), GOAL_COLOR_HZ), ((480, 640), None)):
        scene = open_scene("standing", 1, color_size=size)
        whole_ms = _ms_a_frame(scene, n_frames)
        name = f"{size[1]}x{size[0]}"
        goal_name = "" if goal is None else "goal >="
        yield Row(f"{name} colour alone", 1e3 / (whole_ms - depth_ms), "frames/s", goal, goal_name)
        yield Row(f"{name} colour + 640x480 depth", 1e3 / whole_ms, "frames/s")
    yield _raster_row(scene, n_frames)


def _raster_row(scene: SimulatedScene, n_frames: int) -> Row:
    patient, posed = scene.person(0)
    mesh = mesh_in(scene.depth_from_world, patient, posed)
    lens = lens_vector(scene.device.depth.intrinsics, ())

    def work() -> None:
        draw(mesh.vertices, mesh.triangles, lens, (480, 640), hides_back_faces=True)

    name = f"rasterise {len(mesh.triangles):,} triangles at 640x480"
    return Row(name, median_ms(work, n_frames), "ms", 1.1, "prototype")


def _ms_a_frame(scene: SimulatedScene, n_frames: int) -> float:
    numbers = iter(range(n_frames + 1))
    return median_ms(lambda: scene.frame(next(numbers)), n_frames)
