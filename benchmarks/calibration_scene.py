"""The whole way of a clinic: a board before an uncalibrated sensor, recorded and calibrated.

Runs the command line's own `adibas calibrate --depth` on a recording of the scene
``simulator:board``, and holds what it writes beside the truth of that sensor.
"""

import tempfile
from collections.abc import Iterable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

import numpy as np

from adibas.calibration.files import read_calibration
from adibas.cli import main as run_command
from adibas.data.calibration import RgbdCalibration
from adibas.recordings import create_recording
from adibas.simulation.boards_scenes import BoardScene, BoardSceneSettings
from adibas.simulation.device import Device
from adibas.simulation.frame_times import FRAME_RATE_HZ
from benchmarks.calibration_depth import GOAL_MM, TEST_DISTANCES_M, wall_errors_m
from benchmarks.table import Row

SEEDS = (3, 4, 5)
COLOR_SIZE = (480, 640)


def rows(*, quick: bool) -> Iterable[Row]:
    """Calibrate one simulated sensor after the other; `quick`: the first."""
    for seed in SEEDS[:1] if quick else SEEDS:
        scene = BoardScene(BoardSceneSettings(seed=seed, color_size=COLOR_SIZE))
        with tempfile.TemporaryDirectory() as name:
            yield from _beside_truth(scene.device, calibrated(scene, Path(name)), seed)


def calibrated(scene: BoardScene, folder: Path) -> RgbdCalibration:
    """Return what the command line makes of one walk with the board.

    Raises
    ------
    ValueError
        It refused.
    """
    recording, out = folder / "board.mcap", folder / "calibration.json"
    with create_recording(recording, scene.info) as writer:
        for index in range(round(scene.walk.duration_s * FRAME_RATE_HZ)):
            writer.write(scene.frame(index).sensor_frame)
    board = scene.settings.board
    command = ["calibrate", str(recording), "--depth", "--out", str(out), "--json"]
    command += ["--board", f"{board.columns}x{board.rows}"]
    command += ["--square-mm", f"{1e3 * board.square_m:g}"]
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        run_command(command)
    if not out.is_file():
        raise ValueError("the sensor could not be calibrated")
    return read_calibration(out)


def _beside_truth(device: Device, found: RgbdCalibration, seed: int) -> Iterator[Row]:
    true = device.calibration
    if found.depth is None:
        raise ValueError("the depth camera was not calibrated")
    name = f"simulator:board, seed {seed}, colour {COLOR_SIZE[1]}x{COLOR_SIZE[0]}"
    error = found.color_from_depth @ true.color_from_depth.inverse()
    turned_rad = np.arccos(np.clip((np.trace(error.rotation) - 1.0) / 2.0, -1.0, 1.0))
    moved_m = np.linalg.norm(
        found.color_from_depth.translation_m - true.color_from_depth.translation_m
    )
    yield Row(f"{name}: turn of depth to colour", 1e3 * float(turned_rad), "mrad")
    yield Row(f"{name}: place of depth to colour", 1e3 * float(moved_m), "mm")
    errors_mm = 1e3 * wall_errors_m(device, found.depth_bias, found.depth)
    for distance_m, (plane, image, before) in zip(TEST_DISTANCES_M, errors_mm, strict=True):
        told = f"{name}, wall at {distance_m:g} m"
        yield Row(f"{told}: depth before, rms over the image", float(before), "mm")
        yield Row(f"{told}: plane", abs(float(plane)), "mm", GOAL_MM, "goal <=")
        yield Row(f"{told}: rms over the image", float(image), "mm", GOAL_MM, "goal <=")
