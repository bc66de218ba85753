"""Which parts of the skin are covered by hair, cloth and shoes.

A covering is a field over the rest shape: positive inside, about the distance to the border in
metres. Interpolated over a triangle and compared with 0 pixel by pixel it gives a smooth border.
Cloth and hair have no thickness and do not hang: they are colours on the body's surface.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.data.joints import BODY_PART_NAMES
from adibas.simulation.body import ShapedBody
from adibas.simulation.poses import DOWN, FORWARD
from adibas.simulation.rotations import unit

COVERINGS = ("hair", "top", "bottom", "shoes")
"""Columns of `covering_fields`; where several are positive the last one is seen."""

_FAR_M = 0.1
"""What a field says where a garment cannot be."""


@dataclass(frozen=True, slots=True)
class Outfit:
    """What a person wears. Lengths are shares of the limb; None is without.

    Attributes
    ----------
    hair : bool
    sleeve : float or None
        Of a top: 0 ends at the shoulder, 1 at the elbow, 2 at the wrist; None is bare above.
    leg : float or None
        Of the bottom: 0 ends at the groin, 1 at the knee, 2 at the ankle.
    hem : float
        End of the top: 0 at the hips, 1 at the neck's root; 0.7 is a bra top.
    waist : float
        Upper border of the bottom, on the same scale.
    shoes : bool
    """

    hair: bool = True
    sleeve: float | None = None
    leg: float | None = 0.25
    hem: float = 0.1
    waist: float = 0.2
    shoes: bool = False


OUTFITS: dict[str, Outfit] = {
    "briefs": Outfit(leg=0.0, waist=0.12),
    "shorts": Outfit(leg=0.4),
    "shorts_and_bra_top": Outfit(leg=0.4, sleeve=0.0, hem=0.56),
    "t_shirt_and_trousers": Outfit(leg=1.95, sleeve=0.6, shoes=True),
    "long_sleeves_and_trousers": Outfit(leg=1.95, sleeve=1.9, shoes=True),
    "bare": Outfit(hair=False, leg=None),
}
"""From what patients are measured in to street clothes."""


def covering_fields(body: ShapedBody, outfit: Outfit) -> Float32Array:
    """Return (V, 4) fields in the order of `COVERINGS`, metres."""
    absent = np.full(body.model.n_vertices, -_FAR_M)
    fields = [
        _hair_m(body) if outfit.hair else absent,
        absent if outfit.sleeve is None else _top_m(body, outfit.sleeve, outfit.hem),
        absent if outfit.leg is None else _bottom_m(body, outfit.leg, outfit.waist),
        _shoes_m(body) if outfit.shoes else absent,
    ]
    return np.stack(fields, axis=1).astype(np.float32)


def _share(body: ShapedBody, *parts: str) -> FloatArray:
    """Return (V,) how much each vertex belongs to the named parts."""
    columns = [BODY_PART_NAMES.index(part) for part in parts]
    return np.asarray(body.model.part_weights[:, columns].sum(1), float)


def _sides(*parts: str) -> tuple[str, ...]:
    return tuple(f"{side}_{part}" for side in ("left", "right") for part in parts)


def _trunk_y(body: ShapedBody, share: float) -> float:
    """Return y at a share of the way from the hips to the neck's root."""
    hips = float(body.skeleton.head("upperleg01.L") @ DOWN)
    neck = float(body.skeleton.head("neck01") @ DOWN)
    return hips + share * (neck - hips)


def _left_of_limb_m(
    body: ShapedBody, bones: tuple[str, str, str], share: float
) -> dict[str, FloatArray]:
    """Return by suffix how far each vertex is from a cut across a limb, positive before it.

    `share` counts 0 ... 1 along the first segment and 1 ... 2 along the second.
    """
    fields = {}
    for suffix in (".L", ".R"):
        start, middle, end = (body.skeleton.head(bone + suffix) for bone in bones)
        a, b = (start, middle) if share <= 1 else (middle, end)
        cut = a + (share if share <= 1 else share - 1) * (b - a)
        before_m = (cut - body.rest_vertices_m) @ unit(b - a)
        # Far values would move the borders where limb and trunk blend.
        fields[suffix] = np.clip(before_m, -_FAR_M, _FAR_M)
    return fields


def _nearer_side(body: ShapedBody, fields: dict[str, FloatArray]) -> FloatArray:
    return np.where(body.rest_vertices_m[:, 0] >= 0, fields[".L"], fields[".R"])


def _top_m(body: ShapedBody, sleeve: float, hem: float) -> FloatArray:
    """Return the field of a top: above the hem, below the neckline, up to the sleeve's end."""
    vertices_m = body.rest_vertices_m
    neck = body.skeleton.head("neck01")
    neckline = unit(DOWN - 0.55 * FORWARD)
    below_neckline = (vertices_m - neck - 0.02 * DOWN) @ neckline
    above_hem = np.clip(_trunk_y(body, hem) - vertices_m[:, 1], -_FAR_M, _FAR_M)
    trunk = np.minimum(above_hem, np.clip(below_neckline, -_FAR_M, _FAR_M))
    arm_bones = ("upperarm01", "lowerarm01", "wrist")
    arm = _nearer_side(body, _left_of_limb_m(body, arm_bones, sleeve))
    on_arm = _share(body, *_sides("upper_arm", "lower_arm", "hand"))
    return (1 - on_arm) * trunk + on_arm * arm


def _bottom_m(body: ShapedBody, leg: float, waist: float) -> FloatArray:
    """Return the field of shorts or trousers: below the waist, up to the leg's end."""
    below_waist = np.clip(body.rest_vertices_m[:, 1] - _trunk_y(body, waist), -_FAR_M, _FAR_M)
    leg_bones = ("upperleg02", "lowerleg01", "foot")
    before_end = _nearer_side(body, _left_of_limb_m(body, leg_bones, leg))
    on_leg = _share(body, *_sides("upper_leg", "lower_leg", "foot"))
    on_arm = _share(body, *_sides("upper_arm", "lower_arm", "hand"))
    on_trunk = 1 - on_leg - on_arm
    return on_trunk * below_waist + on_leg * before_end - on_arm * _FAR_M


def _shoes_m(body: ShapedBody) -> FloatArray:
    """Return the field of low shoes: all that lies under the ankle bones."""
    ankle = float(body.skeleton.head("foot.L") @ DOWN)
    floor = float(body.rest_vertices_m[:, 1].max())
    below_m: FloatArray = body.rest_vertices_m[:, 1] - (ankle + 0.1 * (floor - ankle))
    return below_m


def _hair_m(body: ShapedBody) -> FloatArray:
    """Return the field of short hair: above the hairline, and behind the ears down to the nape."""
    vertices_m = body.rest_vertices_m
    eye = body.skeleton.head("eye.L")
    skull = vertices_m[body.model.head_vertices]
    forehead_m = float(eye[1] - skull[:, 1].min())
    ear_z = 0.5 * float(skull[:, 2].min() + skull[:, 2].max()) + 0.1 * forehead_m
    hairline = unit(DOWN + 0.75 * FORWARD)
    front = np.array([0.0, eye[1] - 0.55 * forehead_m, eye[2] + 0.1 * forehead_m])
    above_eyes = eye[1] + 0.05 * forehead_m - vertices_m[:, 1]
    above = np.minimum((front - vertices_m) @ hairline, above_eyes)
    behind = np.minimum(
        vertices_m[:, 2] - ear_z - 0.25 * forehead_m, eye[1] + 0.75 * forehead_m - vertices_m[:, 1]
    )
    on_trunk = 1 - _share(body, "head", "neck")
    return np.asarray(np.maximum(above, behind) - on_trunk * _FAR_M)
