"""Scenes with several people and furniture, in depth alone, with the truth for each person.

The thesis' hard case (section 8.2): children who sit at tables, furniture before them, people who
pass by and cross. World axes as in `adibas.simulation.scenes`: x to the image's right, y down with
the floor at y = 0, z away from the sensor.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from adibas.arrays import (
    BoolArray,
    Float32Array,
    FloatArray,
    Int32Array,
    UInt8Array,
    read_only,
)
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.body import PosedBody
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.crowd_plans import PLANS, Actor, CrowdPlan, Solid
from adibas.simulation.crowd_sensors import CrowdSensor
from adibas.simulation.depth_noise import DepthNoise, DepthSensor
from adibas.simulation.frame_times import FRAME_RATE_HZ, frame_time_ns
from adibas.simulation.label_kernels import label_person
from adibas.simulation.looks import draw_look
from adibas.simulation.patient import Patient
from adibas.simulation.raster import draw, lens_vector
from adibas.simulation.room import Room, see_room
from adibas.simulation.rotations import about
from adibas.simulation.studio import mesh_in

FURNITURE_ECHO = 0.4
SKIN_M = 0.18
"""A joint lies at most so deep under the skin before it: the torso's of a heavy adult."""


@dataclass(frozen=True, slots=True, eq=False)
class PersonTruth:
    """What is so of one person in one frame.

    Attributes
    ----------
    person : int
        1, 2, ..., the same in every frame.
    joints_m : (15, 3) array
        Depth camera's axes, metres.
    visible_share : float
        Of the person's surface that the sensor would see if nothing stood in the way and the
        image were larger.
    in_view : (15,) bool array
        Whether the sensor sees the person's own skin before the joint: where the joint is in the
        image, nearer by `SKIN_M` at most. The far shoulder of somebody seen from the side is not.
    """

    person: int
    joints_m: FloatArray
    visible_share: float
    in_view: BoolArray

    def __post_init__(self) -> None:
        read_only(self.joints_m)
        read_only(self.in_view)


@dataclass(frozen=True, slots=True, eq=False)
class CrowdFrame:
    """What the sensor gives, and the truth behind it.

    Attributes
    ----------
    sensor_frame : SensorFrame
        Depth alone.
    people : tuple of PersonTruth
    owners : (H, W) uint8 array
        Number of the person that each pixel shows; 0: none.
    labels : (H, W) uint8 array
        Index in `BODY_PART_NAMES` + 1; 0: no person.
    """

    sensor_frame: SensorFrame
    people: tuple[PersonTruth, ...]
    owners: UInt8Array
    labels: UInt8Array


class CrowdScene:
    """A source of frames.

    Attributes
    ----------
    info : SourceInfo
        As a real sensor's, with calibration and floor.
    n_frames : int
    """

    def __init__(self, plan: CrowdPlan, seed: int, sensor: CrowdSensor | None = None) -> None:
        rng = np.random.default_rng([seed, 0xC0])
        self._plan = plan
        self._seed = seed
        self._people = plan.cast(rng)
        self._patients = tuple(_dressed(person.shape, seed + k) for k, person in self._numbered())
        self._solids = (*(_box(*box) for box in plan.furniture(rng)), *plan.things(rng))
        self._given = CrowdSensor() if sensor is None else sensor
        self.n_frames = plan.n_frames
        device = self._given.device(seed)
        rotation = about(np.array([1.0, 0.0, 0.0]), plan.tilt_rad)
        eye_m = np.array([0.0, -plan.camera_height_m, -plan.distance_m])
        self.depth_from_world = RigidTransform(rotation, -rotation @ eye_m)
        self._camera = device.depth
        room = Room(back_m=1.6, left_m=2.3, right_m=2.3)
        self._backdrop = see_room(room, self.depth_from_world, device.depth)
        self._sensor = DepthSensor(device, DepthNoise(), seed)
        self._lens = lens_vector(device.depth.intrinsics, device.depth.distortion)
        normal = self.depth_from_world.rotation @ np.array([0.0, -1.0, 0.0])
        floor = Plane(normal, -float(normal @ self.depth_from_world.translation_m))
        calibration = device.calibration
        self.info = SourceInfo(
            depth_unit_m=calibration.depth_unit_m,
            frame_rate_hz=FRAME_RATE_HZ,
            sensor_name="ADiBAS simulator",
            sensor_serial=calibration.sensor_serial,
            calibration=RgbdCalibration(
                color=calibration.color,
                depth=calibration.depth,
                color_from_depth=calibration.color_from_depth,
                depth_unit_m=calibration.depth_unit_m,
                depth_bias=calibration.depth_bias,
                sensor_serial=calibration.sensor_serial,
                gravity=-normal,
                floor=floor,
            ),
        )

    def _numbered(self) -> list[tuple[int, Actor]]:
        return list(enumerate(self._people, 1))

    def frame(self, index: int) -> CrowdFrame:
        """Return frame number `index`, from 0.

        Raises
        ------
        IndexError
            The scene has no such frame.
        """
        if not 0 <= index < self.n_frames:
            raise IndexError(f"frame {index} of {self.n_frames}")
        timestamp_ns = frame_time_ns(self._seed, index)
        time_s = index / FRAME_RATE_HZ
        posed = [
            patient.body.posed(person.pose(time_s))
            for person, patient in zip(self._people, self._patients, strict=True)
        ]
        picture = _Picture(self._backdrop.inverse_depth, self._backdrop.infrared)
        for solid in self._solids:
            self._add_solid(picture, solid)
        alone = [
            self._add_person(picture, number, patient, one)
            for number, (patient, one) in enumerate(zip(self._patients, posed, strict=True), 1)
        ]
        depth_raw = self._sensor.measure(picture.inverse_depth, picture.reflectance, index)
        self._given.punch(depth_raw, self._seed, index)
        people = tuple(
            self._truth(number, one, mine, picture.owners == number)
            for number, (one, mine) in enumerate(zip(posed, alone, strict=True), 1)
        )
        frame = SensorFrame(sequence=index, timestamp_ns=timestamp_ns, depth_raw=depth_raw)
        return CrowdFrame(frame, people, picture.owners, picture.labels)

    def _add_solid(self, picture: "_Picture", solid: Solid) -> None:
        vertices_m = np.ascontiguousarray(self.depth_from_world.apply(solid[0]))
        size = picture.inverse_depth.shape
        near, _ = draw(vertices_m, solid[1], self._lens, size, hides_back_faces=False)
        wins = near > picture.inverse_depth
        picture.inverse_depth[wins] = near[wins]
        picture.reflectance[wins] = FURNITURE_ECHO

    def _add_person(
        self, picture: "_Picture", number: int, patient: Patient, posed: PosedBody
    ) -> Float32Array:
        """Draw a person; return (H, W) 1/z of the person alone, 0 elsewhere."""
        mesh = mesh_in(self.depth_from_world, patient, posed)
        size = picture.inverse_depth.shape
        alone, seen = draw(mesh.vertices, mesh.triangles, self._lens, size, hides_back_faces=True)
        wins = alone > picture.inverse_depth
        seen[~wins] = -1
        labels = np.zeros(size, np.uint8)
        label_person(
            mesh,
            patient.body.model.part_weights,
            patient.materials.infrared,
            (seen, self._backdrop.rays),
            (labels, picture.reflectance),
        )
        picture.inverse_depth[wins] = alone[wins]
        picture.labels[wins] = labels[wins]
        picture.owners[wins] = number
        return alone

    def _truth(
        self, number: int, posed: PosedBody, alone: Float32Array, shown: BoolArray
    ) -> PersonTruth:
        joints_m = self.depth_from_world.apply(posed.joints_m)
        whole = _whole_share(self.depth_from_world.apply(posed.vertices_m), self._lens, alone.shape)
        areas = np.square(1.0 / alone[alone > 0])
        seen_share = float(areas[shown[alone > 0]].sum() / max(areas.sum(), 1e-9))
        return PersonTruth(
            number, joints_m, seen_share * whole, self._in_view(joints_m, alone, shown)
        )

    def _in_view(self, joints_m: FloatArray, alone: Float32Array, shown: BoolArray) -> BoolArray:
        k = self._camera.intrinsics
        z_m = joints_m[:, 2]
        columns = np.rint(k.fx * joints_m[:, 0] / z_m + k.cx).astype(np.int64)
        rows = np.rint(k.fy * joints_m[:, 1] / z_m + k.cy).astype(np.int64)
        inside = (rows >= 0) & (columns >= 0) & (rows < shown.shape[0]) & (columns < shown.shape[1])
        inside &= z_m > 0
        seen = np.zeros(len(joints_m), np.bool_)
        rows, columns = rows[inside], columns[inside]
        near_skin = alone[rows, columns] < 1.0 / (z_m[inside] - SKIN_M)
        seen[inside] = shown[rows, columns] & near_skin
        return seen


class _Picture:
    """The images of one moment while they are drawn."""

    def __init__(self, inverse_depth: Float32Array, reflectance: Float32Array) -> None:
        self.inverse_depth = inverse_depth.copy()
        self.reflectance = reflectance.copy()
        self.labels = np.zeros(inverse_depth.shape, np.uint8)
        self.owners = np.zeros(inverse_depth.shape, np.uint8)


def _whole_share(vertices_m: FloatArray, lens: FloatArray, size: tuple[int, ...]) -> float:
    """Return the share of a person's vertices that lie within the image."""
    z_m = vertices_m[:, 2]
    u = lens[0] * vertices_m[:, 0] / z_m + lens[2]
    v = lens[1] * vertices_m[:, 1] / z_m + lens[3]
    inside = (z_m > 0) & (u >= 0) & (u < size[1]) & (v >= 0) & (v < size[0])
    return float(inside.mean())


def _box(low_m: FloatArray, high_m: FloatArray) -> tuple[FloatArray, Int32Array]:
    """Return a closed box; seen from outside its triangles run counter-clockwise."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    vertices_m = low_m + corners * (high_m - low_m)
    middle_m = vertices_m.mean(axis=0)
    quads = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
    triangles = []
    for a, b, c, d in quads:
        for one in ((a, b, c), (a, c, d)):
            p, q, r = vertices_m[list(one)]
            outward = np.cross(q - p, r - p) @ (p - middle_m) > 0
            triangles.append(one if outward else one[::-1])
    return vertices_m, np.array(triangles, np.int32)


@lru_cache(maxsize=16)
def _dressed(shape: BodyShape, seed: int) -> Patient:
    rng = np.random.default_rng([seed, 0x10])
    return Patient.dressed(shape, draw_look(rng, shape.sex))


def crowd_names() -> tuple[str, ...]:
    """Return the names that `open_crowd` knows."""
    return tuple(PLANS)


def open_crowd(name: str, seed: int = 0) -> CrowdScene:
    """Return a scene; people, room and sensor follow the seed.

    Raises
    ------
    KeyError
        There is no such scene.
    """
    return CrowdScene(PLANS[name], seed)
