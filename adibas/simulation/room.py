"""The room around the patient: floor, walls, and a chair if wanted.

World axes are the body's: x to the image's right, y down with the floor at y = 0, z away from
the camera, metres; the patient stands at the origin.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import Float32Array, FloatArray, Int32Array
from adibas.data.calibration import CameraCalibration
from adibas.geometry.distortion import pixel_rays
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.looks import linear_from_srgb
from adibas.simulation.raster import draw, lens_vector

SKIRTING_M = 0.08
PLANK_M = (0.14, 1.1)


@dataclass(frozen=True, slots=True)
class Room:
    """A plain clinic room.

    Attributes
    ----------
    back_m : float
        From the patient to the wall behind.
    left_m, right_m, height_m : float
        From the patient to the side walls (as the camera sees them), and to the ceiling.
    wall, floor, skirting : (r, g, b)
        sRGB.
    chair : (x, z) or None
        Where one stands on the floor, metres.
    """

    back_m: float = 1.1
    left_m: float = 2.1
    right_m: float = 2.6
    height_m: float = 2.7
    wall: tuple[int, int, int] = (216, 212, 200)
    floor: tuple[int, int, int] = (168, 132, 98)
    skirting: tuple[int, int, int] = (236, 234, 228)
    chair: tuple[float, float] | None = None


WALLS_SRGB = ((216, 212, 200), (198, 208, 216), (206, 214, 198), (224, 220, 218), (186, 186, 190))
FLOORS_SRGB = ((168, 132, 98), (128, 124, 118), (104, 84, 66), (178, 172, 160))


def draw_room(rng: np.random.Generator) -> Room:
    """Return one of the clinic's rooms."""
    chair = None
    if rng.random() < 0.3:  # noqa: PLR2004  (assumed)
        chair = (float(rng.choice((-1.0, 1.0)) * rng.uniform(0.8, 1.1)), float(rng.uniform(0, 0.5)))
    return Room(
        back_m=float(rng.uniform(0.8, 1.5)),
        left_m=float(rng.uniform(1.6, 2.6)),
        right_m=float(rng.uniform(1.6, 2.6)),
        wall=WALLS_SRGB[int(rng.integers(len(WALLS_SRGB)))],
        floor=FLOORS_SRGB[int(rng.integers(len(FLOORS_SRGB)))],
        chair=chair,
    )


@dataclass(frozen=True, slots=True, eq=False)
class Backdrop:
    """The room as one camera sees it, without the patient; all (H, W[, 3]) float32.

    Attributes
    ----------
    inverse_depth : (H, W) array
        1/z, 1/metres.
    normals : (H, W, 3) array
        In camera axes.
    albedo : (H, W, 3) array
        Linear RGB.
    infrared : (H, W) array
        Reflectance for the depth camera.
    rays : (H, W, 2) array
        (x/z, y/z) of every pixel.
    """

    inverse_depth: Float32Array
    normals: Float32Array
    albedo: Float32Array
    infrared: Float32Array
    rays: Float32Array

    def places_m(self) -> Float32Array:
        """Return the (H, W, 3) points that are seen, in camera axes, metres."""
        z_m = 1.0 / self.inverse_depth
        places: Float32Array = np.dstack([self.rays * z_m[..., None], z_m])
        return np.ascontiguousarray(places, np.float32)


def see_room(room: Room, camera_from_world: RigidTransform, camera: CameraCalibration) -> Backdrop:
    """Return the room as `camera` sees it from inside."""
    size = (camera.height, camera.width)
    rays = pixel_rays(size, camera.intrinsics, camera.distortion)
    walls = _walls(room)
    directions = np.dstack([rays, np.ones(size)]) @ camera_from_world.rotation
    eye_m = camera_from_world.inverse().translation_m
    # The room is convex and the camera inside: the wall met first has the largest 1/z.
    by_wall = np.stack([-(directions @ n) / (n @ eye_m + offset) for n, offset in walls])
    nearest = by_wall.argmax(axis=0)
    inverse_z = np.take_along_axis(by_wall, nearest[None], axis=0)[0]
    places_m = eye_m + directions / inverse_z[..., None]
    normals = np.stack([n for n, _ in walls])[nearest] @ camera_from_world.rotation.T
    albedo = _paint(room, places_m, nearest)
    backdrop = Backdrop(
        inverse_depth=inverse_z.astype(np.float32),
        normals=normals.astype(np.float32),
        albedo=albedo.astype(np.float32),
        infrared=np.sqrt(albedo.mean(axis=2)).astype(np.float32),
        rays=rays.astype(np.float32),
    )
    if room.chair is not None:
        _add_chair(backdrop, room.chair, camera_from_world, camera)
    return backdrop


def chair_mesh(x_m: float, z_m: float) -> tuple[FloatArray, Int32Array]:
    """Return (V, 3) vertices in world axes and (T, 3) triangles of a chair at (x, z)."""
    boxes = [
        ((-0.22, -0.47, -0.22), (0.22, -0.43, 0.22)),
        ((-0.22, -0.92, 0.18), (0.22, -0.55, 0.21)),
    ]
    for x in (-0.21, 0.18):
        boxes.append(((x, -0.43, -0.21), (x + 0.03, 0.0, -0.18)))
        boxes.append(((x, -0.92, 0.18), (x + 0.03, 0.0, 0.21)))
    meshes = [_box(np.array(low), np.array(high)) for low, high in boxes]
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    vertices = np.concatenate([vertices for vertices, _ in meshes]) + np.array([x_m, 0.0, z_m])
    triangles = [faces + start for (_, faces), start in zip(meshes, starts, strict=False)]
    return vertices, np.concatenate(triangles).astype(np.int32)


def _walls(room: Room) -> list[tuple[FloatArray, float]]:
    """Return floor, ceiling, back, front, left and right as inward normal and offset."""
    x, y, z = np.eye(3)
    return [
        (-y, 0.0),
        (y, room.height_m),
        (-z, room.back_m),
        (z, 8.0),
        (x, room.left_m),
        (-x, room.right_m),
    ]


def _paint(room: Room, places_m: FloatArray, wall: FloatArray) -> FloatArray:
    """Return (H, W, 3) linear albedo: plain walls, skirting boards, planks on the floor."""
    colors = linear_from_srgb(np.array([room.wall, room.floor, room.skirting], float))
    x, y, z = np.moveaxis(places_m, -1, 0)
    is_floor = wall == 0
    albedo = np.where(is_floor[..., None], colors[1], colors[0])
    is_skirting = (wall > 1) & (y > -SKIRTING_M)
    albedo = np.where(is_skirting[..., None], colors[2], albedo)
    row = np.floor(x / PLANK_M[0])
    along = z / PLANK_M[1] + 0.37 * row
    tone = np.sin(12.9898 * row + 78.233 * np.floor(along)) * 43758.5453
    planks = 0.88 + 0.2 * (tone - np.floor(tone))
    gap = np.abs(x / PLANK_M[0] - row - 0.5) > 0.5 - 0.002 / PLANK_M[0]
    planks *= np.where(gap, 0.6, 1.0)
    # Plaster is never quite even.
    plaster = 1.0 + 0.015 * np.sin(2.1 * x + 1.3 * y) * np.sin(1.7 * z - 2.3 * y)
    return np.asarray(albedo * np.where(is_floor, planks, plaster)[..., None])


def _add_chair(
    backdrop: Backdrop,
    chair: tuple[float, float],
    camera_from_world: RigidTransform,
    camera: CameraCalibration,
) -> None:
    vertices_m, triangles = chair_mesh(*chair)
    vertices_m = np.ascontiguousarray(camera_from_world.apply(vertices_m))
    lens = lens_vector(camera.intrinsics, camera.distortion)
    size = (camera.height, camera.width)
    inverse_depth, seen = draw(vertices_m, triangles, lens, size, hides_back_faces=True)
    is_nearer = inverse_depth > backdrop.inverse_depth
    a, b, c = (vertices_m[triangles[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    backdrop.inverse_depth[is_nearer] = inverse_depth[is_nearer]
    backdrop.normals[is_nearer] = normals[seen[is_nearer]]
    backdrop.albedo[is_nearer] = linear_from_srgb(np.array((92.0, 104.0, 120.0)))
    backdrop.infrared[is_nearer] = 0.4


def _box(low: FloatArray, high: FloatArray, n_parts: int = 6) -> tuple[FloatArray, Int32Array]:
    """Return a box of small triangles, so that its edges bend with the lens."""
    side = np.linspace(0.0, 1.0, n_parts + 1)
    row, column = (grid.ravel() for grid in np.indices((n_parts, n_parts)))
    corner = row * (n_parts + 1) + column
    down = corner + n_parts + 1
    quad = np.concatenate(
        [np.stack([corner, corner + 1, down + 1], 1), np.stack([corner, down + 1, down], 1)]
    )
    faces = []
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        for level in (0.0, 1.0):
            points = np.zeros((len(side) ** 2, 3))
            points[:, axis] = level
            points[:, first] = np.repeat(side, len(side))
            points[:, second] = np.tile(side, len(side))
            # Rows run along `second`: the normal of `quad` is then minus the axis.
            faces.append((low + points * (high - low), quad if level == 0.0 else quad[:, ::-1]))
    starts = np.cumsum([0, *(len(points) for points, _ in faces)])
    triangles = [quad + start for (_, quad), start in zip(faces, starts, strict=False)]
    return np.concatenate([points for points, _ in faces]), np.concatenate(triangles)
