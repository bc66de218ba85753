"""Depth images of things and animals with nobody near: what must not be taken for a person.

World axes: y down, floor at y = 0. Each image depends on the seed and its number alone.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray, Int32Array, UInt16Array, read_only
from adibas.data.calibration import CameraCalibration
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.depth_noise import DepthSensor
from adibas.simulation.device import draw_device
from adibas.simulation.limb_frames import CLUTTER, NOISES, STEP, thinned
from adibas.simulation.limb_masks import damaged_mask
from adibas.simulation.poses import DOWN
from adibas.simulation.raster import draw, lens_vector
from adibas.simulation.room import chair_mesh
from adibas.simulation.rotations import about, onto, unit

N_AROUND, N_ALONG = 12, 5
_BOX_FACES = np.array(
    [
        *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)),
        *((2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
    ],
    np.int32,
)
Solid = tuple[FloatArray, Int32Array]
"""(V, 3) vertices and (T, 3) triangles."""
Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class ThingFrame:
    """One image of a thing.

    Attributes
    ----------
    depth_mm : (240, 320) uint16 array
        0 = no reading; the wall behind is measured, too.
    mask : (240, 320) bool array
        The thing.
    kind : str
        One of `KINDS`.
    """

    depth_mm: UInt16Array
    mask: BoolArray
    kind: str

    def __post_init__(self) -> None:
        read_only(self.depth_mm)
        read_only(self.mask)


class ThingFrames:
    """Any number of images of any number of things.

    Parameters
    ----------
    seed : int
        Others give other things.
    has_damage : bool
        Masks that are as wrong as those of people in `limb_frames`.
    """

    def __init__(self, seed: int, *, has_damage: bool = True) -> None:
        self._seed, self._has_damage = seed, has_damage
        self._device = draw_device(seed)
        self._sensors = [
            DepthSensor(self._device, noise, seed + number) for number, noise in enumerate(NOISES)
        ]

    @property
    def camera(self) -> CameraCalibration:
        """Return that of the images."""
        return thinned(self._device, STEP)

    def frame(self, index: int) -> ThingFrame:
        """Return image `index`, of each kind in turn."""
        rng = np.random.default_rng([self._seed, 0x44, index])
        kind = KINDS[index % len(KINDS)]
        vertices, triangles = draw_thing(rng, kind)
        from_world = _camera_before(rng, vertices)
        seen_from = np.ascontiguousarray(from_world.apply(vertices))
        depth = self._device.depth
        size, lens = (depth.height, depth.width), lens_vector(depth.intrinsics, ())
        inverse_depth, seen = draw(seen_from, triangles, lens, size, hides_back_faces=False)
        wall_m = float(seen_from[:, 2].max()) + rng.uniform(0.2, 2.0)
        reflectance = np.full(size, rng.uniform(0.2, 0.7), np.float32)
        behind = np.maximum(inverse_depth, np.float32(1.0 / wall_m))
        sensor = self._sensors[int(rng.integers(len(self._sensors)))]
        depth_mm = sensor.measure(behind, reflectance, index)[::STEP, ::STEP]
        shown = np.ascontiguousarray((seen >= 0)[::STEP, ::STEP].astype(np.uint8))
        if self._has_damage:
            shown = damaged_mask(rng, shown, depth_mm, CLUTTER)
        return ThingFrame(np.ascontiguousarray(depth_mm), np.asarray(shown > 0), kind)


def draw_thing(rng: np.random.Generator, kind: str) -> Solid:
    """Return a thing of one of `KINDS` on the floor at the origin, turned any way."""
    return _turned(_PLANS[kind](rng), rng.uniform(-math.pi, math.pi))


def _camera_before(rng: np.random.Generator, vertices: FloatArray) -> RigidTransform:
    """Return a camera at the height of a table or a tripod that looks at the thing."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    aim = 0.5 * (low + high)
    distance_m = math.exp(rng.uniform(math.log(1.1), math.log(4.2)))
    distance_m = max(distance_m, 0.9 * float((high - low).max()))
    height_m = rng.uniform(0.6, 2.1)
    eye = np.array([aim[0], -height_m, aim[2] - distance_m])
    tilt = math.atan2(aim[1] - eye[1], distance_m)
    rotation = about(np.array([1.0, 0.0, 0.0]), tilt)
    return RigidTransform(rotation, -rotation @ eye)


def _turned(solid: Solid, turn_rad: float) -> Solid:
    return solid[0] @ about(DOWN, turn_rad).T, solid[1]


def _joined(solids: list[Solid]) -> Solid:
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in solids)])
    triangles = [faces + start for (_, faces), start in zip(solids, starts, strict=False)]
    vertices = np.concatenate([vertices for vertices, _ in solids])
    return vertices, np.concatenate(triangles).astype(np.int32)


def _box(low: Point, high: Point) -> Solid:
    ends = (np.array(low), np.array(high))
    corners = [[ends[(k >> axis) & 1][axis] for axis in range(3)] for k in range(8)]
    return np.array(corners, float), _BOX_FACES


def _capsule(a: Point, b: Point, radius_a_m: float, radius_b_m: float | None = None) -> Solid:
    """Return a rod with round ends, as thick at either end as asked."""
    radius_b_m = radius_a_m if radius_b_m is None else radius_b_m
    begin, end = np.array(a, float), np.array(b, float)
    way = end - begin
    axis = unit(way) if np.linalg.norm(way) > 0 else DOWN
    turn = onto(DOWN, axis)
    rings = []
    for middle, radius_m, first, last in (
        (begin, radius_a_m, -0.5 * math.pi, 0.0),
        (end, radius_b_m, 0.0, 0.5 * math.pi),
    ):
        for angle in np.linspace(first, last, N_ALONG):
            around = np.linspace(0, 2 * math.pi, N_AROUND, endpoint=False)
            wide = radius_m * math.cos(angle)
            ring = np.stack(
                [wide * np.cos(around), np.full(N_AROUND, radius_m * math.sin(angle)),
                 wide * np.sin(around)], axis=1,
            )  # fmt: skip
            rings.append(middle + ring @ turn.T)
    faces = []
    for row in range(len(rings) - 1):
        for column in range(N_AROUND):
            here, beside = row * N_AROUND + column, row * N_AROUND + (column + 1) % N_AROUND
            faces += [(here, beside, here + N_AROUND), (beside, beside + N_AROUND, here + N_AROUND)]
    return np.concatenate(rings), np.array(faces, np.int32)


def _chair(rng: np.random.Generator) -> Solid:
    vertices, triangles = chair_mesh(0.0, 0.0)
    return vertices * rng.uniform((0.8, 0.75, 0.8), (1.3, 1.3, 1.3)), triangles


def _armchair(rng: np.random.Generator) -> Solid:
    wide, deep = rng.uniform(0.3, 0.9), rng.uniform(0.3, 0.45)
    seat, back, rest = rng.uniform(0.35, 0.5), rng.uniform(0.75, 1.1), rng.uniform(0.5, 0.7)
    return _joined(
        [
            _box((-wide, -seat, -deep), (wide, -0.08, deep)),
            _box((-wide, -back, deep - 0.15), (wide, -0.08, deep)),
            _box((-wide - 0.12, -rest, -deep), (-wide, -0.08, deep)),
            _box((wide, -rest, -deep), (wide + 0.12, -0.08, deep)),
        ]
    )


def _office_chair(rng: np.random.Generator) -> Solid:
    seat, back = rng.uniform(0.4, 0.55), rng.uniform(0.85, 1.25)
    solids = [
        _capsule((0, -seat, 0), (0, -0.1, 0), 0.03),
        _box((-0.24, -seat - 0.05, -0.24), (0.24, -seat, 0.24)),
        _box((-0.22, -back, 0.2), (0.22, -seat - 0.12, 0.26)),
        _capsule((0, -seat - 0.2, 0.25), (0, -seat, 0.2), 0.03),
    ]
    for number in range(5):
        angle = 2 * math.pi * number / 5
        foot = (0.3 * math.cos(angle), -0.05, 0.3 * math.sin(angle))
        solids.append(_capsule((0, -0.1, 0), foot, 0.025))
    if rng.random() < 0.6:  # noqa: PLR2004  (a share, ours)
        for x in (-0.28, 0.28):
            arm = -seat - rng.uniform(0.15, 0.25)
            solids.append(_capsule((x, arm, -0.12), (x, arm, 0.15), 0.03))
            solids.append(_capsule((x, arm, 0.0), (x, -seat, 0.0), 0.02))
    return _joined(solids)


def _table(rng: np.random.Generator) -> Solid:
    top, wide, deep = rng.uniform(0.45, 1.05), rng.uniform(0.2, 0.8), rng.uniform(0.2, 0.4)
    solids = [_box((-wide, -top, -deep), (wide, -top + 0.04, deep))]
    corners = [(x, z) for x in (-wide, wide - 0.05) for z in (-deep, deep - 0.05)]
    solids += [_box((x, -top + 0.04, z), (x + 0.05, 0, z + 0.05)) for x, z in corners]
    if rng.random() < 0.5:  # noqa: PLR2004  (a share, ours)
        solids.append(_box((-0.2, -top - 0.4, -0.05), (0.2, -top, 0.05)))
    return _joined(solids)


def _cupboard(rng: np.random.Generator) -> Solid:
    wide, tall, deep = rng.uniform((0.15, 0.5, 0.12), (0.6, 2.0, 0.35))
    solids = [_box((-wide, -tall, -deep), (wide, 0, deep))]
    if rng.random() < 0.5:  # noqa: PLR2004  (a share, ours)
        solids.append(_box((-0.12, -tall - 0.35, -0.12), (0.12, -tall, 0.12)))
    return _joined(solids)


def _lamp(rng: np.random.Generator) -> Solid:
    tall = rng.uniform(1.1, 1.8)
    shade = rng.uniform(0.1, 0.25)
    return _joined(
        [
            _capsule((0, -tall, 0), (0, -0.03, 0), rng.uniform(0.012, 0.04)),
            _capsule((0, -tall - 0.25, 0), (0, -tall, 0), 0.6 * shade, shade),
            _box((-0.18, -0.04, -0.18), (0.18, 0, 0.18)),
        ]
    )


def _coat_stand(rng: np.random.Generator) -> Solid:
    tall = rng.uniform(1.4, 1.9)
    solids = [_capsule((0, -tall, 0), (0, 0, 0), 0.025)]
    for number in range(int(rng.integers(1, 4))):
        angle = rng.uniform(0, 2 * math.pi)
        x, z = 0.2 * math.cos(angle), 0.2 * math.sin(angle)
        high = tall - rng.uniform(0.02, 0.2)
        solids.append(_capsule((0, -high, 0), (x, -high - 0.05, z), 0.015))
        low = high - rng.uniform(0.6, 1.1)
        solids.append(_capsule((x, -high + 0.15, z), (x, -low, z), 0.09 + 0.02 * number, 0.2))
    return _joined(solids)


def _plant(rng: np.random.Generator) -> Solid:
    pot, tall = rng.uniform(0.2, 0.5), rng.uniform(0.8, 1.7)
    solids = [
        _capsule((0, -pot, 0), (0, -0.1, 0), 0.2, 0.14),
        _capsule((0, -tall, 0), (0, -pot, 0), 0.03),
    ]
    for _ in range(int(rng.integers(8, 20))):
        ways = rng.uniform((-0.4, -0.4, -0.4), (0.4, 0.25, 0.4))
        begin = (0.0, -tall + rng.uniform(0.0, 0.4), 0.0)
        end = (float(ways[0]), begin[1] + float(ways[1]), float(ways[2]))
        solids.append(_capsule(begin, end, 0.02, rng.uniform(0.03, 0.09)))
    return _joined(solids)


def _ball(rng: np.random.Generator) -> Solid:
    radius = rng.uniform(0.2, 0.45)
    solids = [_capsule((0, -radius, 0), (0, -radius, 0), radius)]
    if rng.random() < 0.5:  # noqa: PLR2004  (a share, ours)
        other = rng.uniform(0.1, 0.2)
        top = -2 * radius - other
        solids.append(_capsule((0, top, 0), (0, top, 0), other))
    return _joined(solids)


def _quadruped(rng: np.random.Generator) -> Solid:
    """Return a dog, a cat or a sheep, standing or walking, the head up or down."""
    tall = rng.uniform(0.3, 0.95)
    long, thick = tall * rng.uniform(0.45, 0.75), tall * rng.uniform(0.13, 0.24)
    back = -tall + thick
    leg = tall * rng.uniform(0.035, 0.07)
    solids = [_capsule((0, back, -long), (0, back + 0.1 * tall, long), thick, 0.85 * thick)]
    for x in (-0.6 * thick, 0.6 * thick):
        for z in (-long, long):
            swing = rng.uniform(-0.25, 0.25) * tall
            knee = (x, 0.5 * back, z + 0.5 * swing - 0.08 * tall)
            foot = (x, -leg, z + swing)
            solids += [_capsule((x, back, z), knee, 2 * leg, 1.2 * leg), _capsule(knee, foot, leg)]
    rise, reach = rng.uniform(-0.15, 0.45) * tall, rng.uniform(0.15, 0.4) * tall
    head = (rng.uniform(-0.1, 0.1), back - rise, -long - reach)
    solids.append(_capsule((0, back, -long), head, 0.6 * thick, 0.45 * thick))
    solids.append(
        _capsule(head, (head[0], head[1] + 0.05, head[2] - 0.25 * tall), 0.5 * thick, 0.2 * thick)
    )
    for x in (-0.4, 0.4):
        ear = (head[0] + x * thick, head[1] - 0.7 * thick, head[2])
        solids.append(_capsule(head, ear, 0.15 * thick))
    tail = (rng.uniform(-0.2, 0.2), back - rng.uniform(-0.3, 0.4) * tall, long + 0.35 * tall)
    solids.append(_capsule((0, back, long), tail, 0.02 + 0.1 * thick, 0.02))
    return _joined(solids)


def _sitting_dog(rng: np.random.Generator) -> Solid:
    tall = rng.uniform(0.4, 0.9)
    thick = tall * rng.uniform(0.14, 0.22)
    head = (0.0, -tall, -0.25 * tall)
    solids = [
        _capsule((0, -0.75 * tall, -0.2 * tall), (0, -thick, 0.2 * tall), 0.9 * thick, 1.2 * thick),
        _capsule((0, -0.75 * tall, -0.2 * tall), head, 0.6 * thick, 0.55 * thick),
        _capsule(head, (0.0, -0.95 * tall, -0.5 * tall), 0.5 * thick, 0.25 * thick),
        _capsule((0, -0.05, 0.3 * tall), (rng.uniform(-0.3, 0.3), -0.04, 0.7 * tall), 0.03),
    ]
    for x in (-0.6 * thick, 0.6 * thick):
        solids.append(
            _capsule((x, -0.6 * tall, -0.25 * tall), (x, -0.03, -0.3 * tall), 0.05 * tall)
        )
        solids.append(
            _capsule((2 * x, -0.2 * tall, 0.1 * tall), (2 * x, -0.04, -0.2 * tall), 0.07 * tall)
        )
    return _joined(solids)


_PLANS: Mapping[str, Callable[[np.random.Generator], Solid]] = {
    "chair": _chair,
    "quadruped": _quadruped,
    "armchair": _armchair,
    "sitting_dog": _sitting_dog,
    "office_chair": _office_chair,
    "table": _table,
    "cupboard": _cupboard,
    "lamp": _lamp,
    "coat_stand": _coat_stand,
    "plant": _plant,
    "ball": _ball,
}
KINDS = tuple(_PLANS)
