"""A simulated person with clothes, and what sticks to the skin."""

import functools
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.data.joints import JOINT_NAMES
from adibas.simulation.body import PosedBody, ShapedBody, load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.looks import Look, Materials, linear_from_srgb, materials, surface_fields

MarkerKind: TypeAlias = Literal["sticker", "ball", "led"]

GREEN = (40, 168, 72)
BLUE = (36, 84, 196)
RED = (206, 44, 48)
YELLOW = (238, 206, 40)
"""Colours of stickers, sRGB in plain light."""


@dataclass(frozen=True, slots=True)
class MarkerSettings:
    """What sticks where.

    Attributes
    ----------
    names : tuple of str
        Landmarks (see `adibas.simulation.landmarks`), or joints of `JOINT_NAMES`: then the skin
        before the joint, or behind it with ``is_on_back``.
    kind : "sticker", "ball" or "led"
        Flat disc, ball that touches the skin, or light-emitting diode.
    diameter_m : float
        8 mm in the thesis.
    color : (r, g, b)
        sRGB.
    is_on_back : bool
        For joints.
    hole_m : float or None
        Radius around the marker where the depth camera finds nothing; None: 0 for stickers and
        balls, 6 mm and its own radius for LEDs (assumed).
    """

    names: tuple[str, ...] = ()
    kind: MarkerKind = "sticker"
    diameter_m: float = 0.008
    color: tuple[int, int, int] = GREEN
    is_on_back: bool = False
    hole_m: float | None = None

    @property
    def radius_m(self) -> float:
        """Half the diameter."""
        return 0.5 * self.diameter_m

    @property
    def albedo(self) -> FloatArray:
        """Return (3,) linear RGB; an LED's own body is grey."""
        return linear_from_srgb((110, 110, 110) if self.kind == "led" else self.color)

    @property
    def hole_radius_m(self) -> float:
        """Return the radius of the hole in the depth, 0 = none."""
        if self.hole_m is not None:
            return self.hole_m
        return self.radius_m + 0.006 if self.kind == "led" else 0.0


@dataclass(frozen=True, eq=False)
class Patient:
    """One person, dressed.

    Attributes
    ----------
    body : ShapedBody
    covers : (V, 6) float32 array
        See `looks.surface_fields`.
    materials : Materials
    rest : (V, 3) float32 array
        Rest shape, metres: where the grain of skin and cloth hangs.
    """

    body: ShapedBody
    covers: Float32Array
    materials: Materials
    rest: Float32Array

    @staticmethod
    def dressed(shape: BodyShape, look: Look) -> "Patient":
        """Return the person of that shape in these clothes."""
        body = _shaped(shape)
        return Patient(
            body,
            surface_fields(body, look.cut),
            materials(look),
            body.rest_vertices_m.astype(np.float32),
        )

    def places(self, posed: PosedBody, markers: MarkerSettings) -> tuple[FloatArray, FloatArray]:
        """Return (N, 3) centres in body axes, metres, and (N, 3) outward normals."""
        if not markers.names:
            return np.zeros((0, 3)), np.zeros((0, 3))
        joints = self.body.back_joint_anchors if markers.is_on_back else None
        found = []
        for name in markers.names:
            anchors = self.body.landmark_anchors
            if name in JOINT_NAMES:
                anchors = joints or self.body.front_joint_anchors
            found.append(anchors.chosen((name,)))
        on_skin = [posed.on_skin(anchor) for anchor in found]
        points = np.concatenate([points for points, _ in on_skin])
        normals = np.concatenate([normals for _, normals in on_skin])
        if markers.kind == "ball":
            points = points + markers.radius_m * normals
        return points, normals


@functools.lru_cache(maxsize=16)
def _shaped(shape: BodyShape) -> ShapedBody:
    return load_body_model().shaped(shape)


SHAPES = (
    BodyShape("female", 28, 1.66, 60),
    BodyShape("male", 34, 1.79, 78),
    BodyShape("female", 58, 1.60, 72),
    BodyShape("male", 67, 1.72, 86),
    BodyShape("male", 19, 1.86, 70),
    BodyShape("female", 41, 1.73, 66),
    BodyShape("male", 45, 1.68, 92),
    BodyShape("female", 12, 1.50, 42),
)
"""The clinic's patients; a scene takes the one of its seed, modulo their number."""
