"""How skin, hair, cloth and stickers look, in visible light and in infrared."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.data.joints import BODY_PART_NAMES
from adibas.simulation.body import ShapedBody
from adibas.simulation.clothing import COVERINGS, OUTFITS, Outfit, covering_fields

SURFACES = (*COVERINGS, "eyes", "lips")
"""Columns of `surface_fields`; where several are positive the last one is seen."""
MATERIALS = ("skin", *SURFACES)

Srgb = tuple[int, int, int]

SKIN_TONES_SRGB: tuple[Srgb, ...] = (
    (238, 204, 182),
    (226, 182, 152),
    (204, 154, 122),
    (172, 120, 88),
    (126, 84, 62),
    (90, 60, 46),
)
"""From light to dark, near the six types of Fitzpatrick (chosen by eye)."""
HAIR_SRGB: tuple[Srgb, ...] = (
    (30, 25, 23),
    (54, 39, 30),
    (98, 68, 43),
    (172, 137, 90),
    (154, 152, 150),
)
CLOTH_SRGB: tuple[Srgb, ...] = (
    (34, 36, 40),
    (236, 236, 234),
    (42, 54, 98),
    (122, 126, 130),
    (150, 38, 44),
    (196, 178, 144),
    (96, 66, 114),
)
_CLINIC_OUTFITS = ("briefs", "shorts", "shorts", "t_shirt_and_trousers")
_CLINIC_OUTFITS_FEMALE = ("shorts_and_bra_top", "shorts_and_bra_top", "t_shirt_and_trousers")


@dataclass(frozen=True, slots=True)
class Look:
    """Cut and colours (sRGB) of what a person wears, and of the person.

    Attributes
    ----------
    outfit : str
        One of `adibas.simulation.clothing.OUTFITS`.
    skin, hair, top, bottom, shoes : (r, g, b)
    """

    outfit: str = "shorts"
    skin: Srgb = SKIN_TONES_SRGB[1]
    hair: Srgb = HAIR_SRGB[1]
    top: Srgb = CLOTH_SRGB[1]
    bottom: Srgb = CLOTH_SRGB[2]
    shoes: Srgb = CLOTH_SRGB[0]

    @property
    def cut(self) -> Outfit:
        """The garments."""
        return OUTFITS[self.outfit]


@dataclass(frozen=True, slots=True, eq=False)
class Materials:
    """Looks of `MATERIALS`, in that order.

    Attributes
    ----------
    albedo : (7, 3) array
        Linear RGB, 0 to 1.
    infrared : (7,) array
        Reflectance at 830 nm; skin of every tone is bright there.
    finish : (7, 3) array
        Strength of highlights, relative amplitude of the grain, and its size in metres.
    """

    albedo: Float32Array
    infrared: Float32Array
    finish: Float32Array


def draw_look(rng: np.random.Generator, sex: str) -> Look:
    """Return what a patient may wear at a posture clinic: mostly little, so that skin is seen."""

    def pick(colors: tuple[Srgb, ...]) -> Srgb:
        return colors[int(rng.integers(len(colors)))]

    outfits = _CLINIC_OUTFITS_FEMALE if sex == "female" else _CLINIC_OUTFITS
    return Look(
        outfit=outfits[int(rng.integers(len(outfits)))],
        skin=pick(SKIN_TONES_SRGB),
        hair=pick(HAIR_SRGB),
        top=pick(CLOTH_SRGB),
        bottom=pick(CLOTH_SRGB),
        shoes=pick(CLOTH_SRGB),
    )


def materials(look: Look) -> Materials:
    """Return the looks of everything on a person."""
    skin = np.array(look.skin, float)
    albedo = {
        "skin": skin,
        "hair": np.array(look.hair, float),
        "top": np.array(look.top, float),
        "bottom": np.array(look.bottom, float),
        "shoes": np.array(look.shoes, float),
        "eyes": skin * 0.42,
        "lips": skin * (0.9, 0.7, 0.7),
    }
    linear = {name: linear_from_srgb(color) for name, color in albedo.items()}
    infrared = {
        "skin": 0.55,
        "hair": 0.05 + 0.5 * float(linear["hair"].mean()),
        **{name: _cloth_infrared(linear[name]) for name in ("top", "bottom", "shoes")},
        "eyes": 0.3,
        "lips": 0.5,
    }
    finish = {
        "skin": (0.04, 0.06, 0.012),
        "hair": (0.03, 0.45, 0.005),
        "top": (0.0, 0.05, 0.004),
        "bottom": (0.0, 0.05, 0.004),
        "shoes": (0.03, 0.05, 0.01),
        "eyes": (0.1, 0.2, 0.004),
        "lips": (0.05, 0.05, 0.01),
    }
    return Materials(
        albedo=np.array([linear[name] for name in MATERIALS], np.float32),
        infrared=np.array([infrared[name] for name in MATERIALS], np.float32),
        finish=np.array([finish[name] for name in MATERIALS], np.float32),
    )


def surface_fields(body: ShapedBody, outfit: Outfit) -> Float32Array:
    """Return (V, 6) fields in the order of `SURFACES`, metres, positive where one is seen."""
    fields = np.column_stack([covering_fields(body, outfit), _eyes_m(body), _lips_m(body)])
    return np.ascontiguousarray(fields, np.float32)


def linear_from_srgb(srgb: FloatArray | Srgb) -> FloatArray:
    """Turn sRGB 0-255 into linear light 0-1.

    Source: IEC 61966-2-1.
    """
    value = np.asarray(srgb, float) / 255.0
    is_dark = value <= 0.04045  # noqa: PLR2004  (the standard's)
    return np.where(is_dark, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def _cloth_infrared(albedo: FloatArray) -> float:
    """Return the reflectance of cloth at 830 nm: dark cloth is taken as dark there too."""
    return 0.05 + 0.65 * float(np.sqrt(albedo.mean()))


def _eyes_m(body: ShapedBody) -> FloatArray:
    """Return where the eyes are, roughly: the mesh has no names for them."""
    eye = body.skeleton.head("eye.L")
    mirrored = body.rest_vertices_m.copy()
    mirrored[:, 0] = np.abs(mirrored[:, 0])
    stretched = (mirrored - eye) * (0.8, 1.6, 0.6)
    return np.asarray(0.012 - np.linalg.norm(stretched, axis=1))


def _lips_m(body: ShapedBody) -> FloatArray:
    """Return where the lips are, roughly."""
    eye = body.skeleton.head("eye.L")
    vertices_m = body.rest_vertices_m
    on_head = body.model.part_weights[:, BODY_PART_NAMES.index("head")] > 0.5  # noqa: PLR2004
    is_middle = np.abs(vertices_m[:, 0]) < 0.01  # noqa: PLR2004
    front_m = float(vertices_m[on_head & is_middle, 2].min())
    mouth = np.array([0.0, eye[1] + 2.33 * eye[0], front_m + 0.02])
    stretched = (vertices_m - mouth) * (1.0, 2.6, 0.6)
    return np.asarray(0.8 * eye[0] - np.linalg.norm(stretched, axis=1))
