"""Whether names fit the view: the left on the patient's left, the face on the side it looks to.

A name on the wrong side would turn the sign of what is measured, and with a plane that is the
patient's own, of everything. Nobody sees that in a number.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joints import other_side
from adibas.data.protocols import LENGTHWAYS, VIEW_AXES
from adibas.measures.sight_plane import axis_along

CAN_CROSS = frozenset({"elbow", "wrist", "hand", "knee", "foot"})
"""Joints of limbs that may lie on the other side of the body."""
_IN_FRONT = (
    ("menton", "c7"),
    ("sternal_notch", "c7"),
    ("asis", "psis"),
    ("canthus", "tragus"),
    ("glabella", "tragus"),
    ("metatarsals", "calcaneus"),
    ("metatarsals", "lateral_malleolus"),
)
"""Landmarks of which the first is before the second in whoever stands or sits."""


@dataclass(frozen=True, slots=True)
class SidesSeen:
    """What places say of sides.

    Attributes
    ----------
    are_exchanged : bool
        Most of what cannot lie crossed stands the other way round: the view is wrong, or all names.
    exchanged : frozenset of str
        Both names of each pair whose left stands to the right, though neither can be there.
    crossed : frozenset of str
        The same of limbs that may lie crossed.
    """

    are_exchanged: bool
    exchanged: frozenset[str]
    crossed: frozenset[str]


def see_sides(positions_m: Mapping[str, FloatArray], view: str, up: FloatArray) -> SidesSeen:
    """Compare the left with the right, and the front with the back.

    Parameters
    ----------
    positions_m : Mapping
        (3,) places of landmarks in the colour camera's axes, by id.
    view : str
        Of `VIEWS`, as declared.
    up : (3,) array
        Unit vector.
    """
    left, ahead = patient_axis("left", view, up), patient_axis("anterior", view, up)
    pairs = [
        (name, other_side(name))
        for name in positions_m
        if name.startswith("left_") and other_side(name) in positions_m
    ]
    steady = [pair for pair in pairs if pair[0].removeprefix("left_") not in CAN_CROSS]
    ways = [(positions_m[one] - positions_m[other]) @ left for one, other in steady or pairs]
    ways += [(positions_m[one] - positions_m[other]) @ ahead for one, other in _known(positions_m)]
    wrong = [pair for pair in pairs if (positions_m[pair[0]] - positions_m[pair[1]]) @ left < 0]
    return SidesSeen(
        2 * sum(bool(way < 0) for way in ways) > len(ways),
        frozenset(name for pair in wrong if pair in steady for name in pair),
        frozenset(name for pair in wrong if pair not in steady for name in pair),
    )


def patient_axis(axis: str, view: str, up: FloatArray) -> FloatArray:
    """Return a level direction of a patient who stands as the view says, (3,), unit length."""
    if axis in VIEW_AXES[view]:
        return axis_along(axis, view, up, None)
    if axis in LENGTHWAYS:
        ahead = np.cross(axis_along("left", view, up, None), up)
        return ahead if axis == "anterior" else -ahead
    left = np.cross(up, axis_along("anterior", view, up, None))
    return left if axis == "left" else -left


def _known(names: Collection[str]) -> Iterator[tuple[str, str]]:
    """Give what lies in front and what lies behind, of each side and of the middle."""
    for front, back in _IN_FRONT:
        for side in ("left_", "right_"):
            pair = (_of_side(side, front, names), _of_side(side, back, names))
            if set(pair) <= set(names) and (side == "left_" or pair != (front, back)):
                yield pair


def _of_side(side: str, name: str, names: Collection[str]) -> str:
    """Return the name, of that side unless it is in the middle."""
    return name if name in names else side + name
