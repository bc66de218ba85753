"""A device before a room with a patient in it: draws both images of one moment."""

from dataclasses import dataclass

import cv2
import numpy as np

from adibas.arrays import Float32Array, FloatArray, Int32Array, UInt8Array
from adibas.data.calibration import CameraCalibration
from adibas.data.markers import pixels_uv
from adibas.geometry.distortion import project_distorted
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.body import PosedBody
from adibas.simulation.color_kernels import Lamp, Mesh, light_room, shade_person, shade_room
from adibas.simulation.label_kernels import label_person
from adibas.simulation.light import Illumination, lamp_position_m, shadow_camera
from adibas.simulation.marker_kernels import BALL, DISC, add_glow, paint_markers, place_balls
from adibas.simulation.patient import MarkerSettings, Patient
from adibas.simulation.raster import draw, lens_vector
from adibas.simulation.room import Room, chair_mesh, see_room
from adibas.simulation.truth import MarkerTruth

TARGET_M = np.array([0.0, -0.95, 0.0])
TARGET_RADIUS_M = 1.35
SHADOW_TOLERANCE_M = 0.012
FILL = 0.12
LED_DARKNESS = 0.02
"""Share of the room's light behind the infrared filter of LED mode."""
LED_POWER = 30.0
_GLOSS = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class DepthView:
    """The ideal depth image: 1/z (0 = nothing), part labels, infrared reflectance, all (H, W)."""

    inverse_depth: Float32Array
    labels: UInt8Array
    reflectance: Float32Array


class DepthStudio:
    """What the depth camera has before it."""

    def __init__(self, room: Room, from_world: RigidTransform, camera: CameraCalibration) -> None:
        self._from_world = from_world
        self._camera = camera
        self._lens = lens_vector(camera.intrinsics, camera.distortion)
        self._backdrop = see_room(room, from_world, camera)

    def view(
        self, patient: Patient | None, posed: PosedBody | None, markers: MarkerSettings
    ) -> DepthView:
        """Return the noise-free image of one moment; stickers are flat, balls stand out."""
        back = self._backdrop
        size = (self._camera.height, self._camera.width)
        labels = np.zeros(size, np.uint8)
        if patient is None or posed is None:
            return DepthView(back.inverse_depth, labels, back.infrared)
        mesh = mesh_in(self._from_world, patient, posed)
        inverse_depth, seen = draw(
            mesh.vertices, mesh.triangles, self._lens, size, hides_back_faces=True
        )
        seen[inverse_depth < back.inverse_depth] = -1
        reflectance = back.infrared.copy()
        label_person(
            mesh,
            patient.body.model.part_weights,
            patient.materials.infrared,
            (seen, back.rays),
            (labels, reflectance),
        )
        inverse_depth = np.maximum(inverse_depth, back.inverse_depth)
        if markers.kind == "ball" and markers.names:
            centers_m = self._from_world.apply(patient.places(posed, markers)[0])
            place_balls(centers_m, markers.radius_m, back.rays, inverse_depth)
        return DepthView(inverse_depth, labels, reflectance)


class ColorStudio:
    """What the colour camera has before it, and the light that falls on it."""

    def __init__(
        self,
        room: Room,
        from_world: RigidTransform,
        camera: CameraCalibration,
        illumination: Illumination,
    ) -> None:
        self._from_world = from_world
        self._camera = camera
        self._lens = lens_vector(camera.intrinsics, camera.distortion)
        self._backdrop = see_room(room, from_world, camera)
        self._places = self._backdrop.places_m()
        self._illumination = illumination
        lamp_m = from_world.apply(lamp_position_m(illumination, TARGET_M))
        self._lamp_m = lamp_m
        self._lamp_from_camera, self._lamp_camera = shadow_camera(
            lamp_m, from_world.apply(TARGET_M), TARGET_RADIUS_M
        )
        furniture = (
            (np.zeros((0, 3)), np.zeros((0, 3), np.int32))
            if room.chair is None
            else chair_mesh(*room.chair)
        )
        lamp = self._lamp(from_world.apply(furniture[0]), furniture[1])
        self._empty = np.empty_like(self._places)
        self._direct = np.empty_like(self._places)
        self._cells = np.full(self._places.shape[:2], -1, np.int32)
        light_room(
            self._places,
            self._backdrop.normals,
            self._backdrop.albedo,
            lamp,
            (self._empty, self._direct, self._cells),
        )

    def view(
        self, patient: Patient | None, posed: PosedBody | None, markers: MarkerSettings
    ) -> tuple[Float32Array, tuple[MarkerTruth, ...]]:
        """Return (H, W, 3) linear light of one moment, and the markers in it."""
        linear = self._empty.copy()
        darkness = LED_DARKNESS if markers.kind == "led" else 1.0
        if patient is None or posed is None:
            return linear * np.float32(darkness), ()
        mesh = mesh_in(self._from_world, patient, posed)
        lamp = self._lamp(mesh.vertices, mesh.triangles)
        grown = np.asarray(cv2.dilate(lamp.nearest, np.ones((7, 7), np.uint8)), np.float32)
        shade_room((self._places, self._direct, self._cells), grown, lamp, linear)
        inverse_depth = self._draw_person(mesh, patient, lamp, linear)
        truths = self._paint_markers(patient, posed, markers, (inverse_depth, lamp, linear))
        if markers.kind == "led":
            linear *= np.float32(LED_DARKNESS)
            self._light_leds(truths, linear)
        return linear, truths

    def _draw_person(
        self, mesh: Mesh, patient: Patient, lamp: Lamp, linear: Float32Array
    ) -> Float32Array:
        back = self._backdrop
        size = (self._camera.height, self._camera.width)
        inverse_depth, seen = draw(
            mesh.vertices, mesh.triangles, self._lens, size, hides_back_faces=True
        )
        seen[inverse_depth < back.inverse_depth] = -1
        looks = np.column_stack([patient.materials.albedo, patient.materials.finish])
        pixel_rad = 1.0 / self._camera.intrinsics.fx
        shade_person(mesh, (inverse_depth, seen, back.rays), (looks, pixel_rad), lamp, linear)
        return np.maximum(inverse_depth, back.inverse_depth)

    def _lamp(self, vertices_m: FloatArray, triangles: Int32Array) -> Lamp:
        """Return the lamp with the shadow of a mesh in camera axes."""
        camera = self._lamp_camera
        vertices = np.ascontiguousarray(self._lamp_from_camera.apply(vertices_m))
        nearest, _ = draw(
            vertices,
            triangles,
            lens_vector(camera.intrinsics, ()),
            (camera.height, camera.width),
            hides_back_faces=True,
        )
        light = self._illumination
        pose = self._lamp_from_camera
        return Lamp(
            position=self._lamp_m,
            pose=np.column_stack([pose.rotation, pose.translation_m]),
            lens=np.array([camera.intrinsics.fx, camera.intrinsics.cx]),
            nearest=nearest,
            strength=np.array(
                [
                    (1.0 - light.ambient) * light.lamp_m**2,
                    light.ambient,
                    FILL,
                    SHADOW_TOLERANCE_M,
                ]
            ),
            up=np.ascontiguousarray(-self._from_world.rotation[:, 1]),
        )

    def _paint_markers(
        self,
        patient: Patient,
        posed: PosedBody,
        markers: MarkerSettings,
        scene: tuple[Float32Array, Lamp, Float32Array],
    ) -> tuple[MarkerTruth, ...]:
        points, normals = patient.places(posed, markers)
        points = self._from_world.apply(points)
        normals = normals @ self._from_world.rotation.T
        inverse_depth, lamp, linear = scene
        pixels = project_distorted(points, self._camera.intrinsics, self._camera.distortion)
        reach = 1.3 * self._camera.intrinsics.fx * markers.radius_m / points[:, 2:] + 2.0
        low, high = np.floor(pixels - reach), np.ceil(pixels + reach) + 1
        # What the lens cannot show has no pixels.
        boxes = np.nan_to_num(np.stack([low[:, 0], high[:, 0], low[:, 1], high[:, 1]], axis=1))
        shapes = np.column_stack([points, normals, np.full(len(points), markers.radius_m)])
        looks = np.array([*markers.albedo, _GLOSS, 0.003 + 0.25 * markers.radius_m])
        fractions = paint_markers(
            (
                np.ascontiguousarray(shapes),
                np.ascontiguousarray(boxes.astype(np.int64)),
                BALL if markers.kind == "ball" else DISC,
            ),
            (inverse_depth, self._backdrop.rays),
            looks,
            lamp,
            linear,
        )
        cosines = -np.einsum("ij,ij->i", normals, points) / np.linalg.norm(points, axis=1)
        angles_rad = np.arccos(np.clip(cosines, -1.0, 1.0))
        return tuple(
            MarkerTruth(
                name=name,
                position_m=points[i].copy(),
                normal=normals[i].copy(),
                radius_m=markers.radius_m,
                u=float(pixels[i, 0]),
                v=float(pixels[i, 1]),
                view_angle_rad=float(angles_rad[i]),
                visible_fraction=float(fractions[i]),
            )
            for i, name in enumerate(markers.names)
        )

    def _light_leds(self, truths: tuple[MarkerTruth, ...], linear: Float32Array) -> None:
        centers = pixels_uv(truths)
        # An LED shines less to the side.
        power = LED_POWER * np.array(
            [truth.visible_fraction * max(np.cos(truth.view_angle_rad), 0.0) for truth in truths]
        )
        scale = self._camera.width / 1280
        spread = np.array([1.3, 5.0, 0.02]) * np.array([scale, scale, 1.0])
        add_glow(centers, power, spread, linear)


def mesh_in(camera_from_world: RigidTransform, patient: Patient, posed: PosedBody) -> Mesh:
    """Return the person's surface in a camera's axes."""
    return Mesh(
        vertices=np.ascontiguousarray(camera_from_world.apply(posed.vertices_m)),
        normals=np.ascontiguousarray(posed.vertex_normals @ camera_from_world.rotation.T),
        rest=patient.rest,
        covers=patient.covers,
        triangles=patient.body.model.triangles,
    )
