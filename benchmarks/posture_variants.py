"""What is changed in the thesis' analyses: markers, distance, light, skin, clothes, dithering."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from adibas.simulation.depth_noise import DepthNoise
from adibas.simulation.light import Illumination
from adibas.simulation.looks import CLOTH_SRGB, SKIN_TONES_SRGB, Look, draw_look
from adibas.simulation.scenes import SceneSettings
from benchmarks.posture_trial import Analysis

Change: TypeAlias = Callable[[SceneSettings], SceneSettings]

NUMBERS_APART = 1000
"""Between the numbers of the analyses of two variants in a file of results."""
PLAIN = Illumination()
ILLUMINATIONS = {
    "plain light": PLAIN,
    "dim light (0.5)": replace(PLAIN, level=0.5),
    "light bulbs (2900 K)": replace(PLAIN, temperature_k=2900.0),
    "daylight from the side, hard shadows": replace(
        PLAIN, temperature_k=6500.0, azimuth_rad=1.2, ambient=0.25
    ),
    "wrong white balance (8 %)": replace(PLAIN, white_balance_error=(0.08, -0.08)),
}
SKINS = {"light": 0, "brown": 3, "dark": 5}
GARMENTS = {"white T-shirt": CLOTH_SRGB[1], "black T-shirt": CLOTH_SRGB[0]}
MARKERS: Mapping[str, Mapping[str, object]] = {
    "LED of 5 mm": {"kind": "led", "diameter_m": 0.005},
    "stickers of 12 mm": {"diameter_m": 0.012},
}
WHOLE_PATIENT_M = (2.6, 3.5)
"""From where on the depth camera sees the feet."""
WEAK_DITHER = DepthNoise(disparity_sd=0.1)
"""Noise so weak that steps of the disparity do not average out."""


@dataclass(frozen=True, slots=True)
class Variant:
    """A change of the analyses, and what it is called."""

    name: str
    change: Change


def variants() -> tuple[Variant, ...]:
    """Return all changes, the unchanged analyses not among them."""
    return (
        *(Variant(name, _marked(changes)) for name, changes in MARKERS.items()),
        *(Variant(f"{far_m:g} m", _at(far_m)) for far_m in (1.2, 2.6, 3.5)),
        *(Variant(name, _lit(light)) for name, light in ILLUMINATIONS.items()),
        *(Variant(f"{name} skin", _dressed(skin=index)) for name, index in SKINS.items()),
        *(Variant(name, _dressed(top=color)) for name, color in GARMENTS.items()),
        Variant("weak dithering", lambda one: replace(one, depth_noise=WEAK_DITHER)),
        *(
            Variant(f"{name} at {far_m:g} m", _both(_at(far_m), _marked(changes)))
            for name, changes in MARKERS.items()
            for far_m in WHOLE_PATIENT_M
        ),
    )


def changed(wanted: tuple[Analysis, ...], variant: Variant, place: int) -> tuple[Analysis, ...]:
    """Return the analyses with the change; `place` of the variant among all, from 1."""
    return tuple(
        replace(
            one,
            number=NUMBERS_APART * place + one.number,
            settings=variant.change(one.settings),
        )
        for one in wanted
    )


def _marked(changes: Mapping[str, object]) -> Change:
    return lambda one: replace(one, markers=replace(one.markers, **changes))  # type: ignore[arg-type]


def _both(first: Change, second: Change) -> Change:
    return lambda one: second(first(one))


def _at(distance_m: float) -> Change:
    return lambda one: replace(one, distance_m=distance_m)


def _lit(illumination: Illumination) -> Change:
    return lambda one: replace(one, illumination=illumination)


def _dressed(*, skin: int | None = None, top: tuple[int, int, int] | None = None) -> Change:
    """Return the change to a skin, or to a T-shirt of a colour; the rest follows the seed."""

    def change(one: SceneSettings) -> SceneSettings:
        sex = one.shape.sex if one.shape is not None else "female"
        look: Look = draw_look(np.random.default_rng([one.seed, 0x10]), sex)
        if skin is not None:
            look = replace(look, skin=SKIN_TONES_SRGB[skin])
        if top is not None:
            look = replace(look, outfit="t_shirt_and_trousers", top=top)
        return replace(one, look=look)

    return change
