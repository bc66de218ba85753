"""A simulated person in shorts who turns as a statue does, before a noisy device that stands still.

The room is seen, too; the program is told nothing but the recording, and maps the person alone.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from adibas.clock import NS_PER_S
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.data.joints import JOINT_NAMES
from adibas.geometry.rigid import RigidTransform, fit_rigid
from adibas.pipeline.mapping import MapRequest, map_recording
from adibas.recordings import RecordingOptions, create_recording
from adibas.simulation.body import PosedBody
from adibas.simulation.color_noise import ColorNoise, ColorSensor
from adibas.simulation.depth_noise import DepthNoise, DepthSensor
from adibas.simulation.device import DEPTH_UNIT_M, draw_device
from adibas.simulation.light import draw_illumination
from adibas.simulation.looks import draw_look
from adibas.simulation.patient import SHAPES, MarkerSettings, Patient
from adibas.simulation.poses import standing
from adibas.simulation.room import draw_room
from adibas.simulation.studio import ColorStudio, DepthStudio
from benchmarks.mapping_rooms import COLOR_SIZE
from benchmarks.table import Row

FOLDER = Path(__file__).parents[1] / "build" / "benchmarks"
SEED = 41
WORN = {
    "without stickers": MarkerSettings(),
    "with 15 stickers of 20 mm": MarkerSettings(JOINT_NAMES, diameter_m=0.02),
}
STEP_RAD = np.radians(3.0)
N_FRAMES = 130
EYE_M = np.array([0.0, -1.0, -2.4])
MIDDLE_M = np.array([0.0, -0.95, 0.0])
"""Of the body, in the world: y is down, the floor at 0."""
PERIOD_NS = NS_PER_S // 10


@dataclass(frozen=True, slots=True)
class Turn:
    """A recording and the truth.

    Attributes
    ----------
    path : Path
    camera_from_body : tuple of RigidTransform
        Of every frame; the body is as it stands in the first one.
    """

    path: Path
    camera_from_body: tuple[RigidTransform, ...]


def turn_rows() -> Iterator[Row]:
    """Map the person without and with stickers, and look where the middle of the body comes to."""
    for worn, markers in WORN.items():
        yield from _rows(worn, markers)


def _rows(worn: str, markers: MarkerSettings) -> Iterator[Row]:
    turned = _turn(worn, markers)
    request = MapRequest(turned.path, is_body=True)
    mapped = map_recording(request, lambda _done, _total: None)
    numbers = np.rint((mapped.timestamps_ns - NS_PER_S) / PERIOD_NS).astype(int).tolist()
    truths = turned.camera_from_body
    home_m = truths[numbers[0]].apply(MIDDLE_M)
    off_mm = [
        1e3 * float(np.linalg.norm(pose.apply(truths[number].apply(MIDDLE_M)) - home_m))
        for number, pose in zip(numbers, mapped.world_from_camera, strict=True)
    ]
    told = f"person in shorts {worn}, who turns by 3 deg a frame, {N_FRAMES} frames, alone"
    yield Row(f"{told}: placed", 100.0 * len(numbers) / N_FRAMES, "%")
    yield Row("same: loops closed, wrong ones left out", float(mapped.n_loops), "")
    yield Row("same: middle of the body amiss, root mean square", _rms(off_mm), "mm")
    yield Row("same: at the end", off_mm[-1], "mm")
    if mapped.motion is not None:
        yield Row("same: frames from the joined surface", mapped.motion.residual_mm, "mm")


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _turn(worn: str, markers: MarkerSettings) -> Turn:
    """Return the recording, drawn where it is not kept yet."""
    rng = np.random.default_rng([SEED, 0x7A])
    shape = SHAPES[SEED % len(SHAPES)]
    patient = Patient.dressed(shape, draw_look(rng, shape.sex))
    poses = [replace(standing(), heading_rad=number * STEP_RAD) for number in range(N_FRAMES)]
    bodies = [patient.body.posed(pose) for pose in poses]
    camera_from_world = RigidTransform(np.eye(3), -EYE_M)
    path = FOLDER / f"turn-{SEED}-{N_FRAMES}-{worn.replace(' ', '-')}.mcap"
    if not path.exists():
        _draw(path, (patient, markers), bodies, camera_from_world)
    first_m = bodies[0].joints_m
    moved = (camera_from_world @ fit_rigid(body.joints_m, first_m) for body in bodies)
    return Turn(path, tuple(moved))


def _draw(
    path: Path,
    dressed: tuple[Patient, MarkerSettings],
    bodies: Sequence[PosedBody],
    camera_from_world: RigidTransform,
) -> None:
    patient, markers = dressed
    device, room = draw_device(SEED, COLOR_SIZE), draw_room(np.random.default_rng([SEED, 1]))
    light = draw_illumination(np.random.default_rng([SEED, 2]))
    color_from_world = device.calibration.color_from_depth @ camera_from_world
    depth_studio = DepthStudio(room, camera_from_world, device.depth)
    color_studio = ColorStudio(room, color_from_world, device.color, light)
    depth_sensor = DepthSensor(device, DepthNoise(), SEED)
    color_sensor = ColorSensor(device.color, ColorNoise(), light, SEED)
    info = SourceInfo(calibration=device.calibration, depth_unit_m=DEPTH_UNIT_M)
    path.parent.mkdir(parents=True, exist_ok=True)
    with create_recording(path, info, RecordingOptions(is_live=False)) as recording:
        for number, body in enumerate(bodies):
            view = depth_studio.view(patient, body, markers)
            raw = depth_sensor.measure(view.inverse_depth, view.reflectance, number)
            linear, _ = color_studio.view(patient, body, markers)
            time_ns = NS_PER_S + number * PERIOD_NS
            color_rgb = color_sensor.take(linear, number)
            recording.write(SensorFrame(number, time_ns, raw, color_rgb, time_ns))
