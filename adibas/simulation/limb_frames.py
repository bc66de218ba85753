"""Labelled depth images of people, as bad as real ones: what models of limbs are trained on.

Each image depends on the seed and its number alone: a person of any size in any pose, dressed
(cloth has thickness and folds here), near or far, turned, perhaps partly out of the picture,
before, on or behind furniture; measured by a simulated sensor; in a
mask that is too large, too small, torn, or holds furniture. The image is every second row and
column of the sensor's, or all of them.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from adibas.arrays import (
    AnyArray,
    BoolArray,
    Float32Array,
    FloatArray,
    Int32Array,
    UInt8Array,
    UInt16Array,
    read_only,
)
from adibas.data.calibration import CameraCalibration
from adibas.data.joints import BODY_PART_NAMES
from adibas.geometry.distortion import pixel_rays
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.body import PosedBody, ShapedBody, load_body_model
from adibas.simulation.color_kernels import Mesh
from adibas.simulation.depth_noise import DepthNoise, DepthSensor
from adibas.simulation.device import Device, draw_device
from adibas.simulation.label_kernels import label_person
from adibas.simulation.limb_clutter import Thing, random_things
from adibas.simulation.limb_masks import damaged_mask
from adibas.simulation.limb_people import (
    random_kind,
    random_look,
    random_outfit,
    random_shape,
    wide_pose,
)
from adibas.simulation.looks import MATERIALS, Materials, materials, surface_fields
from adibas.simulation.poses import Pose
from adibas.simulation.raster import draw, lens_vector
from adibas.simulation.rotations import about

STEP = 2
CLUTTER = len(BODY_PART_NAMES) + 1
"""Value of furniture in images of labels."""
FRAMES_A_PERSON = 12
_TURNED_RAD = math.radians(75.0)
_FAR_TURNED_RAD = math.radians(110.0)
_BODY_BAND_M = 0.12
NOISES = (
    DepthNoise(),
    DepthNoise(disparity_sd=0.25, edge_jitter_px=0.4, edge_dropout=0.1),
    DepthNoise(disparity_sd=0.9, edge_jitter_px=1.3, edge_dropout=0.5, dim_echo=0.02),
)
"""Of the sensors, from mild to bad."""


@dataclass(frozen=True, slots=True)
class FrameSettings:
    """What is asked of the images.

    Attributes
    ----------
    has_clutter, has_damage : bool
        Furniture; masks that are not right.
    farthest_turn_rad : float
        Of the heading from facing the camera; nine of ten are within 75 degrees of it.
    distance_m : (nearest, farthest)
        Of the person from the camera.
    step : int
        Rows and columns of the sensor for one of the image: 1, or 2 as models are trained.
    turned_rad : float
        Added to every heading: half a turn shows backs.
    """

    has_clutter: bool = True
    has_damage: bool = True
    farthest_turn_rad: float = _FAR_TURNED_RAD
    distance_m: tuple[float, float] = (1.1, 4.2)
    step: int = STEP
    turned_rad: float = 0.0


@dataclass(frozen=True, slots=True)
class Film:
    """Which film an image belongs to.

    Attributes
    ----------
    number : int
    aim : Pose or None
        The camera looks at, and furniture stands about, somebody in this pose; None: each image's
        own, which the camera follows.
    """

    number: int
    aim: Pose | None = None


@dataclass(frozen=True, slots=True, eq=False)
class LimbFrame:
    """One image and what it shows; (H, W) is (240, 320), or (480, 640) with a step of 1.

    Attributes
    ----------
    depth_mm : (H, W) uint16 array
        As measured; 0 = no reading.
    labels : (H, W) uint8 array
        Of the mask: index in `BODY_PART_NAMES` + 1, `CLUTTER`, or 0.
    color_rgb : (H, W, 3) uint8 array
        Of skin, hair and cloth, without light and shade; black elsewhere.
    joints_m : (15, 3) array
        In camera axes.
    person : int
    kind : str
        Of pose.
    posed : PosedBody
        Whom it shows, without clothes.
    camera_from_body : RigidTransform
    """

    depth_mm: UInt16Array
    labels: UInt8Array
    color_rgb: UInt8Array
    joints_m: FloatArray
    person: int
    kind: str
    posed: PosedBody
    camera_from_body: RigidTransform

    def __post_init__(self) -> None:
        for array in (self.depth_mm, self.labels, self.color_rgb, self.joints_m):
            read_only(array)


@dataclass(frozen=True, slots=True, eq=False)
class Dressed:
    """One person with the thickness of what is worn.

    Attributes
    ----------
    body : ShapedBody
    covers : (V, 6) float32 array
        See `looks.surface_fields`.
    looks : Materials
        Colours and reflectances of what is seen.
    thickness_m : (V,) array
        Of hair, cloth and shoes on the skin, folds and all.
    """

    body: ShapedBody
    covers: Float32Array
    looks: Materials
    thickness_m: FloatArray

    def surface_m(self, posed: PosedBody) -> FloatArray:
        """Return (V, 3) vertices of skin and cloth, body axes."""
        return np.asarray(posed.vertices_m + self.thickness_m[:, None] * posed.vertex_normals)


class LimbFrames:
    """Any number of images of any number of people.

    Parameters
    ----------
    seed : int
        Others give other people, poses and sensors.
    settings : FrameSettings or None
    """

    def __init__(self, seed: int, settings: FrameSettings | None = None) -> None:
        self._seed = seed
        self._settings = settings or FrameSettings()
        self._device = draw_device(seed)
        self._sensors = [
            DepthSensor(self._device, noise, seed + number) for number, noise in enumerate(NOISES)
        ]
        depth = self._device.depth
        self._rays = pixel_rays((depth.height, depth.width), depth.intrinsics, ()).astype(
            np.float32
        )

    @property
    def camera(self) -> CameraCalibration:
        """Return that of the images."""
        return thinned(self._device, self._settings.step)

    def frame(self, index: int) -> LimbFrame:
        """Return image `index`, from 0, of person ``index // FRAMES_A_PERSON``."""
        rng = np.random.default_rng([self._seed, 0x11, index])
        person = index // FRAMES_A_PERSON
        kind = random_kind(rng)
        dressed = dressed_person(self._seed, person)
        return self.seen(dressed, wide_pose(rng, kind), (person, kind), index)

    def seen(
        self,
        dressed: Dressed,
        pose: Pose,
        what: tuple[int, str],
        index: int,
        film: Film | None = None,
    ) -> LimbFrame:
        """Return image `index` of somebody in a given pose; `what` are person and kind.

        Images of one `film` share heading and sensor; only the noise is each one's own.
        """
        number = index if film is None else film.number
        rng = np.random.default_rng([self._seed, 0x22, number])
        settings, step = self._settings, self._settings.step
        is_far_turned = rng.random() < 0.1  # noqa: PLR2004  (a share, ours)
        most = settings.farthest_turn_rad if is_far_turned else _TURNED_RAD
        heading = rng.uniform(-1.0, 1.0) * min(most, settings.farthest_turn_rad)
        turned_rad = settings.turned_rad + heading
        posed = dressed.body.posed(_turned(pose, turned_rad))
        aim = posed
        if film is not None and film.aim is not None:
            aim = dressed.body.posed(_turned(film.aim, turned_rad))
        from_world = _camera_pose(rng, aim, settings.distance_m)
        things = random_things(rng, aim, what[1]) if settings.has_clutter else ()
        scene = self._drawn(dressed, posed, from_world, things, rng)
        sensor = self._sensors[int(rng.integers(len(self._sensors)))]
        depth_mm = sensor.measure(scene.inverse_depth, scene.reflectance, index)[::step, ::step]
        true_mm = 1000.0 / scene.inverse_depth[::step, ::step]
        labels = _believed(depth_mm, true_mm, scene.labels[::step, ::step])
        if settings.has_damage:
            labels = damaged_mask(rng, labels, depth_mm, CLUTTER)
        return LimbFrame(
            np.ascontiguousarray(depth_mm),
            np.ascontiguousarray(labels),
            _painted(dressed.looks, scene.material[::step, ::step]),
            from_world.apply(posed.joints_m),
            *what,
            posed,
            from_world,
        )

    def _drawn(
        self,
        dressed: Dressed,
        posed: PosedBody,
        from_world: RigidTransform,
        things: tuple[Thing, ...],
        rng: np.random.Generator,
    ) -> "_Scene":
        """Return what is there, as large as the sensor's image."""
        camera = self._device.depth
        size, lens = (camera.height, camera.width), lens_vector(camera.intrinsics, ())
        vertices = np.ascontiguousarray(from_world.apply(dressed.surface_m(posed)))
        triangles = dressed.body.model.triangles
        inverse_depth, seen = draw(vertices, triangles, lens, size, hides_back_faces=True)
        labels = np.zeros(size, np.uint8)
        reflectance = np.full(size, rng.uniform(0.3, 0.8), np.float32)
        material = np.zeros(size, np.float32)
        for thing in things:
            _cover(thing, from_world, lens, (inverse_depth, seen, labels, reflectance))
        mesh = Mesh(
            vertices=vertices,
            normals=np.zeros_like(vertices),
            rest=dressed.body.rest_vertices_m.astype(np.float32),
            covers=dressed.covers,
            triangles=triangles,
        )
        label_person(
            mesh,
            dressed.body.model.part_weights,
            np.arange(1, len(MATERIALS) + 1, dtype=np.float32),
            (seen, self._rays),
            (labels, material),
        )
        numbers = material.astype(np.uint8)
        is_person = numbers > 0
        reflectance[is_person] = dressed.looks.infrared[numbers[is_person] - 1]
        wall_m = float(vertices[:, 2].max()) + rng.uniform(0.2, 2.0)
        behind = np.maximum(inverse_depth, np.float32(1.0 / wall_m))
        return _Scene(behind, labels, reflectance, numbers)


class _Scene(NamedTuple):
    """True 1/z, label, reflectance, and material (`MATERIALS` + 1) of each pixel, all (H, W)."""

    inverse_depth: Float32Array
    labels: UInt8Array
    reflectance: Float32Array
    material: UInt8Array


def thinned(device: Device, step: int) -> CameraCalibration:
    """Return the camera of every `step`-th row and column of a device's depth image."""
    depth = device.depth
    k = depth.intrinsics
    return CameraCalibration(
        depth.width // step,
        depth.height // step,
        Intrinsics(k.fx / step, k.fy / step, k.cx / step, k.cy / step),
    )


@lru_cache(maxsize=4)
def dressed_person(seed: int, number: int) -> Dressed:
    """Return person `number` of those of `seed`."""
    rng = np.random.default_rng([seed, 0x33, number])
    body = _shaped(rng)
    covers = surface_fields(body, random_outfit(rng))
    return Dressed(body, covers, materials(random_look(rng)), _thickness_m(body, covers, rng))


def _shaped(rng: np.random.Generator) -> ShapedBody:
    """Return a body, trying again where the model has no such stature."""
    while True:
        try:
            return load_body_model().shaped(random_shape(rng))
        except ValueError:
            continue


def _thickness_m(body: ShapedBody, covers: Float32Array, rng: np.random.Generator) -> FloatArray:
    """Return (V,) how far hair, top, bottom and shoes stand off, with folds 8 to 30 cm long."""
    most = rng.uniform((0.004, 0.0, 0.0, 0.004), (0.05, 0.035, 0.03, 0.018))
    fold_m = np.array([0.15, 0.3, 0.3, 0.0]) * most
    worn = np.clip(covers[:, :4] / 0.03, 0.0, 1.0)
    waves = rng.normal(size=(3, 6))
    waves *= 2 * math.pi / (rng.uniform(0.08, 0.3, 6) * np.linalg.norm(waves, axis=0))
    folds = np.sin(body.rest_vertices_m @ waves + rng.uniform(0, 2 * math.pi, 6)).mean(axis=1)
    return np.asarray((worn * most).max(axis=1) + (worn * fold_m).max(axis=1) * 2.0 * folds)


def _turned(pose: Pose, heading_rad: float) -> Pose:
    return replace(pose, heading_rad=pose.heading_rad + heading_rad)


def _camera_pose(
    rng: np.random.Generator, posed: PosedBody, distance_m: tuple[float, float]
) -> RigidTransform:
    """Return a camera that looks at the body or, from near, at a part of it."""
    low, high = posed.vertices_m.min(axis=0), posed.vertices_m.max(axis=0)
    middle = 0.5 * (low + high)
    nearest, farthest = distance_m
    distance = math.exp(rng.uniform(math.log(nearest), math.log(farthest)))
    height_m = rng.uniform(0.6, 2.1)
    is_upper = distance < 1.9 and rng.random() < 0.7  # noqa: PLR2004  (m and a share, ours)
    aim = middle + rng.normal(scale=0.05 * distance, size=3) * (1.0, 0.6, 0.0)
    if is_upper:
        aim[1] = low[1] + rng.uniform(0.25, 0.55) * (high[1] - low[1])
    eye = np.array([aim[0] + rng.normal(scale=0.1), -height_m, middle[2] - distance])
    tilt = math.atan2(aim[1] - eye[1], aim[2] - eye[2])
    pan = math.atan2(aim[0] - eye[0], aim[2] - eye[2])
    roll = rng.normal(scale=math.radians(2.0))
    z = np.array([0.0, 0.0, 1.0])
    rotation = (
        about(z, roll)
        @ about(np.array([1.0, 0.0, 0.0]), tilt)
        @ about(np.array([0.0, 1.0, 0.0]), -pan)
    )
    return RigidTransform(rotation, -rotation @ eye)


def _cover(
    thing: Thing,
    from_world: RigidTransform,
    lens: FloatArray,
    images: tuple[Float32Array, Int32Array, UInt8Array, Float32Array],
) -> None:
    """Draw furniture over the person where it is nearer."""
    inverse_depth, seen, labels, reflectance = images
    vertices = np.ascontiguousarray(from_world.apply(thing.vertices_m))
    other, _ = draw(
        vertices, thing.triangles, lens, (seen.shape[0], seen.shape[1]), hides_back_faces=False
    )
    is_nearer = other > inverse_depth
    inverse_depth[is_nearer] = other[is_nearer]
    seen[is_nearer] = -1
    labels[is_nearer] = CLUTTER if thing.is_in_mask else 0
    reflectance[is_nearer] = thing.infrared


def _painted(looks: Materials, material: AnyArray) -> UInt8Array:
    """Return (H, W, 3) colours; the square root is near sRGB."""
    colors = np.concatenate([np.zeros((1, 3)), 255.0 * np.sqrt(looks.albedo)])
    painted: UInt8Array = colors.astype(np.uint8)[material]
    return painted


def _believed(depth_mm: AnyArray, true_mm: AnyArray, labels: AnyArray) -> UInt8Array:
    """Return the labels but where the sensor saw something far from what is there."""
    is_other: BoolArray = (depth_mm > 0) & (np.abs(depth_mm - true_mm) > 1000.0 * _BODY_BAND_M)
    return np.where(is_other, 0, labels).astype(np.uint8)
