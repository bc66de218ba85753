"""The thesis' experiment as scenes: 5 bodies x 4 postures x 10 marker layouts.

Source: thesis, chapter 8 (200 analyses, green stickers of 8 mm, 2 m); bodies, postures and
layouts are ours.
"""

import numpy as np

from adibas.simulation.patient import SHAPES, MarkerSettings
from adibas.simulation.postures import POSTURES
from adibas.simulation.scenes import SceneSettings

N_BODIES = 5
N_LAYOUTS = 10

_MIDLINE = (
    ("glabella", "head"),
    ("menton",),
    ("sternal_notch", "neck"),
    ("torso",),
)
_PAIRED = (
    ("acromion", "shoulder"),
    ("elbow", "lateral_epicondyle"),
    ("wrist", "hand"),
    ("asis", "hip"),
    ("patella", "knee"),
    ("tibial_tuberosity",),
    ("foot", "metatarsals", "lateral_malleolus"),
)
"""Places on the front of the body; the names of one place are near each other."""
_FEWEST, _MOST = 10, 15


def marker_layouts(n: int = N_LAYOUTS, seed: int = 0) -> tuple[tuple[str, ...], ...]:
    """Return `n` sets of 10 to 15 places over the front of head, trunk, arms and legs.

    Names are landmarks (`adibas.simulation.landmarks`) or joints of `JOINT_NAMES`, whose sticker
    stands on the skin before them.
    """
    rng = np.random.default_rng([seed, 0x1A])
    return tuple(_layout(rng) for _ in range(n))


def analysis_settings(seed: int = 0) -> tuple[SceneSettings, ...]:
    """Return the settings of the 200 analyses; light, room, clothes and sensor vary with each."""
    layouts = marker_layouts(N_LAYOUTS, seed)
    settings: list[SceneSettings] = []
    for shape in SHAPES[:N_BODIES]:
        for posture in POSTURES:
            for names in layouts:
                settings.append(
                    SceneSettings(
                        seed=1000 * (seed + 1) + len(settings),
                        posture=posture,
                        shape=shape,
                        markers=MarkerSettings(names),
                    )
                )
    return tuple(settings)


def _layout(rng: np.random.Generator) -> tuple[str, ...]:
    """Draw a layout: some of the midline, then limb places on one or both sides."""
    wanted = int(rng.integers(_FEWEST, _MOST + 1))
    places: list[tuple[str, ...]] = [*_MIDLINE]
    for names in _PAIRED:
        places += [tuple(f"{side}_{name}" for name in names) for side in ("left", "right")]
    # One place of each region first, so that every layout spreads over the whole body.
    regions = [places[:2], places[2:4], places[4:10], places[10:12], places[12:]]
    first = [region[int(rng.integers(len(region)))] for region in regions]
    rest = [place for place in places if place not in first]
    order = rng.permutation(len(rest))
    chosen = first + [rest[i] for i in order[: wanted - len(first)]]
    return tuple(place[int(rng.integers(len(place)))] for place in chosen)
