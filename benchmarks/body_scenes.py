"""Simulated people with bent spines before a depth camera, and the truth of their backs.

Arms hang; the spine's parts are turned one by one, so that every back has another curve. The truth
is the skin over the spinous processes: the points of the resting body's midline, moved with it.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import depth_in_metres
from adibas.data.joints import BODY_PART_NAMES
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.body import PosedBody, ShapedBody
from adibas.simulation.depth_noise import DepthNoise, DepthSensor
from adibas.simulation.device import Device, draw_device
from adibas.simulation.landmarks import SPINE_LEVELS
from adibas.simulation.looks import draw_look
from adibas.simulation.patient import SHAPES, MarkerSettings, Patient
from adibas.simulation.poses import DOWN, FORWARD, LEFT, Pose, View, standing
from adibas.simulation.room import draw_room
from adibas.simulation.rotations import about
from adibas.simulation.studio import DepthStudio
from adibas.simulation.surface import Ray, SurfaceAnchors, anchor_rays

CAMERA_HEIGHT_M = 1.0
N_LEVELS = 90
PARTS = ("torso", "neck", "head", "left_upper_leg", "right_upper_leg")
FIRST_LEVEL, LAST_LEVEL = -0.25, 1.35
"""Shares of the way from C7 to L5, see `SPINE_LEVELS`: from the neck to the sacrum."""


@dataclass(frozen=True, slots=True, eq=False)
class BackScene:
    """One person in one pose, and the device that looks.

    Attributes
    ----------
    patient : Patient
    pose : Pose
        Facing the camera; turned by `burst`.
    device : Device
    depth_from_world : RigidTransform
    """

    patient: Patient
    pose: Pose
    device: Device
    depth_from_world: RigidTransform

    @property
    def calibration(self) -> RgbdCalibration:
        """What a sensor would bring: its own error known, floor and vertical too."""
        up = -self.depth_from_world.rotation[:, 1]
        floor = Plane(up, CAMERA_HEIGHT_M)
        return replace(self.device.calibration, gravity=-up, floor=floor)

    def posed(self, view: View) -> PosedBody:
        """Return the body with that side to the camera, world axes."""
        return self.patient.body.posed(self.pose.facing(view))


def draw_back_scene(seed: int, distance_m: float = 2.0, *, is_portrait: bool = False) -> BackScene:
    """Return the scene of a seed; an upright picture shows all of the patient at 2 m."""
    rng = np.random.default_rng([seed, 0xBAC])
    shape = SHAPES[seed % len(SHAPES)]
    patient = Patient.dressed(shape, draw_look(rng, shape.sex))
    eye_m = np.array([0.0, -CAMERA_HEIGHT_M, -distance_m])
    upright = about(np.array([0.0, 0.0, 1.0]), -np.pi / 2) if is_portrait else np.eye(3)
    sensor = RigidTransform(upright, -upright @ eye_m)
    return BackScene(patient, bent_pose(rng), draw_device(seed), sensor)


def bent_pose(rng: np.random.Generator) -> Pose:
    """Return a standing pose with a spine bent forward, aside and turned, a few degrees a part."""
    forward = np.radians(rng.normal((2.0, 0.0, -2.0, -2.0, 2.0), (4.0, 4.0, 4.0, 4.0, 4.0)))
    aside = np.radians(rng.normal(0.0, 2.5, 5))
    turned = np.radians(rng.normal(0.0, 2.0, 5))
    pelvis, *spine, chest = (
        about(LEFT, f) @ about(FORWARD, -a) @ about(DOWN, -t)
        for f, a, t in zip(forward, aside, turned, strict=True)
    )
    return replace(standing(), pelvis=pelvis, chest=chest, head=chest, spine=np.stack(spine))


def midline(body: ShapedBody) -> SurfaceAnchors:
    """Return the skin over the spinous processes, from above C7 down over the sacrum."""
    landmarks = body.landmark_anchors.chosen(("c7", "l5"))
    mesh = body.model.triangles
    c7_m, l5_m = landmarks.on(body.rest_vertices_m, mesh)
    parts = np.isin(body.model.triangle_parts, [BODY_PART_NAMES.index(part) for part in PARTS])
    rays = {}
    for number, level in enumerate(np.linspace(FIRST_LEVEL, LAST_LEVEL, N_LEVELS)):
        y_m = c7_m[1] + (l5_m[1] - c7_m[1]) * level / SPINE_LEVELS["l5"]
        rays[str(number)] = Ray(np.array([0.0, y_m, -0.02]), -FORWARD, parts)
    return anchor_rays(rays, body.rest_vertices_m, mesh)


def burst(
    scene: BackScene, posed: PosedBody, n_frames: int, seed: int, noise: DepthNoise | None = None
) -> Iterator[Float32Array]:
    """Yield (H, W) depth images in metres as the device measures them, not yet corrected."""
    room = draw_room(np.random.default_rng([seed, 0x5C]))
    studio = DepthStudio(room, scene.depth_from_world, scene.device.depth)
    sensor = DepthSensor(scene.device, noise or DepthNoise(), seed)
    view = studio.view(scene.patient, posed, MarkerSettings())
    for index in range(n_frames):
        raw = sensor.measure(view.inverse_depth, view.reflectance, index, None)
        yield depth_in_metres(raw, scene.device.calibration.depth_unit_m)


def true_midline_m(scene: BackScene, posed: PosedBody) -> FloatArray:
    """Return (N, 3) points of the midline, world axes (y down), from the neck down."""
    anchors = midline(scene.patient.body)
    return anchors.on(posed.vertices_m, scene.patient.body.model.triangles)
