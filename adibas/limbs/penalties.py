"""Omega_2: which limbs hardly ever lie side by side."""

from adibas.arrays import Int32Array
from adibas.graphcut.energy import penalty_table

SAME_LIMB, NEXT_LIMB = 10, 5
_NEXT = {"hand": "lower_arm", "foot": "lower_leg"}
_LIMBS = ("upper_arm", "lower_arm", "hand", "upper_leg", "lower_leg", "foot")
THESIS = ("upper_arm", "hand")


def omega_2(names: tuple[str, ...]) -> Int32Array:
    """Return the table of equation 6.25 for any labels; 1 for all pairs that it does not name.

    A limb beside the other side's costs 10, a hand beside the other lower arm 5. The thesis has
    no price for the two lower arms of its seven labels; the full body continues its idea: any limb
    beside its like, a foot beside the other lower leg.
    """
    is_full = any(name.endswith("_leg") for name in names)
    prices: dict[tuple[int, int], int] = {}
    for limb in _LIMBS if is_full else THESIS:
        _put(prices, names, limb, limb, SAME_LIMB)
    for limb, next_limb in _NEXT.items():
        _put(prices, names, limb, next_limb, NEXT_LIMB)
    return penalty_table(len(names), prices)


def _put(
    prices: dict[tuple[int, int], int], names: tuple[str, ...], limb: str, other: str, price: int
) -> None:
    for pair in ((f"left_{limb}", f"right_{other}"), (f"right_{limb}", f"left_{other}")):
        if set(pair) <= set(names):
            prices[names.index(pair[0]), names.index(pair[1])] = price
