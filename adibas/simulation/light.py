"""One lamp that casts shadows, light from all around, and how the camera takes them."""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.calibration import CameraCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform

SHADOW_MAP_PX = 640


@dataclass(frozen=True, slots=True)
class Illumination:
    """The light of a scene and the camera's answer to it.

    Attributes
    ----------
    level : float
        Exposure: 1 shows white paper just below full scale.
    temperature_k : float
        Of lamp and surroundings.
    white_balance_error : (float, float)
        Relative error of the red and blue gain after the camera's white balance.
    azimuth_rad, elevation_rad : float
        From where the lamp shines on the patient: azimuth 0 from the camera's side, positive from
        the image's right.
    lamp_m : float
        Distance of the lamp from the patient.
    ambient : float
        Share of the light that comes from all around.
    """

    level: float = 1.0
    temperature_k: float = 4500.0
    white_balance_error: tuple[float, float] = (0.0, 0.0)
    azimuth_rad: float = math.radians(35)
    elevation_rad: float = math.radians(48)
    lamp_m: float = 3.0
    ambient: float = 0.45


def draw_illumination(rng: np.random.Generator) -> Illumination:
    """Return the light of some clinic room: lamp, level, colour and white balance all vary."""
    red, blue = rng.normal(0.0, 0.05, 2)
    return Illumination(
        level=float(rng.uniform(0.75, 1.25)),
        temperature_k=float(rng.uniform(2900.0, 6500.0)),
        white_balance_error=(float(red), float(blue)),
        azimuth_rad=float(rng.uniform(-1.1, 1.1)),
        elevation_rad=float(rng.uniform(0.6, 1.1)),
        lamp_m=float(rng.uniform(2.4, 4.0)),
        ambient=float(rng.uniform(0.35, 0.65)),
    )


def lamp_position_m(illumination: Illumination, target_m: FloatArray) -> FloatArray:
    """Return the lamp's (3,) place in world axes (x right, y down, camera looks along z)."""
    level_m = illumination.lamp_m * math.cos(illumination.elevation_rad)
    offset = np.array(
        [
            level_m * math.sin(illumination.azimuth_rad),
            -illumination.lamp_m * math.sin(illumination.elevation_rad),
            -level_m * math.cos(illumination.azimuth_rad),
        ]
    )
    return np.asarray(target_m + offset)


def shadow_camera(
    lamp_m: FloatArray, target_m: FloatArray, radius_m: float, size_px: int = SHADOW_MAP_PX
) -> tuple[RigidTransform, CameraCalibration]:
    """Return a camera in the lamp that sees all within `radius_m` of `target_m`.

    Both points are (3,) in one frame; the transform leads from that frame into the lamp's.
    """
    forward = target_m - lamp_m
    distance_m = float(np.linalg.norm(forward))
    forward = forward / distance_m
    right = np.cross(np.array([0.0, 1.0, 0.0]), forward)
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    widest = radius_m / math.sqrt(distance_m**2 - radius_m**2)
    focal_px = 0.5 * size_px / widest
    middle = 0.5 * (size_px - 1)
    camera = CameraCalibration(size_px, size_px, Intrinsics(focal_px, focal_px, middle, middle))
    return RigidTransform(rotation, -rotation @ lamp_m), camera


def black_body_rgb(temperature_k: float) -> FloatArray:
    """Return linear sRGB of a black body, green 1.

    Source: Kim et al. 2002 (US patent 7024034), cubic fit of the Planckian locus in CIE xy.
    """
    t = 1000.0 / temperature_k
    if temperature_k < 4000.0:  # noqa: PLR2004  (where the two fits meet)
        x = -0.2661239 * t**3 - 0.2343589 * t**2 + 0.8776956 * t + 0.179910
        y = -0.9549476 * x**3 - 1.37418593 * x**2 + 2.09137015 * x - 0.16748867
    else:
        x = -3.0258469 * t**3 + 2.1070379 * t**2 + 0.2226347 * t + 0.240390
        y = 3.0817580 * x**3 - 5.87338670 * x**2 + 3.75112997 * x - 0.37001483
    xyz = np.array([x / y, 1.0, (1.0 - x - y) / y])
    rgb = (
        np.array(
            [
                [3.2406, -1.5372, -0.4986],
                [-0.9689, 1.8758, 0.0415],
                [0.0557, -0.2040, 1.0570],
            ]
        )
        @ xyz
    )
    return np.asarray(np.maximum(rgb, 0.02) / rgb[1])
