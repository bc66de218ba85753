"""The tables that the loops of a cut work on, and what a binary choice costs pairs of pixels.

Compiled functions take these arrays one by one: a tuple of arrays costs a counted reference at
every use. N pixels, K arcs each, L labels:

- ``arcs``: (3, N, K) int32; planes `TO` (the neighbour, -1 where there is none; its arc ``k ^ 1``
  leads back), `WEIGHT` (of the pair) and `LEFT` (what more the arc can carry).
- ``nodes``: (5, N) int32; `EXCESS` (what the arc from the source, or negative to the sink, can
  still carry), `DISTANCE` (arcs to the sink) and `SEEN_AT` (when that was known), `ACTIVE` and
  `ORPHANS` (rings of pixels that wait).
- ``marks``: (5, N) int8; `PARENT` (the arc towards the sink, or `TERMINAL`, `FREE`, `ORPHAN`),
  `IS_ACTIVE`, `IS_LAID` (whether `LEFT` is worked out), `STAY` and `CHANGE` (the pixel's label on
  the source's side of the cut and on the sink's).
- ``counters``: (5,) int64.
- ``penalties``: (L, L) int32, symmetric, 0 on the diagonal.
"""

from adibas.arrays import AnyArray, Int32Array
from adibas.kernels import compiled

TO, WEIGHT, LEFT = range(3)
EXCESS, DISTANCE, SEEN_AT, ACTIVE, ORPHANS = range(5)
PARENT, IS_ACTIVE, IS_LAID, STAY, CHANGE = range(5)
CLOCK, FIRST_ACTIVE, N_ACTIVE, FIRST_ORPHAN, N_ORPHANS = range(5)
TERMINAL = -1
FREE = -2
ORPHAN = -3


@compiled
def share_penalty(marks: AnyArray, penalties: Int32Array, first: int, second: int) -> int:
    """Return what of a pair's penalty its first pixel pays for a change.

    With E00, E01, E10, E11 for (first, second) = (stay, stay), (stay, change), ... the penalty is
    E00 + a x1 + (E11 - E00 - a) x2 + (E01 - E11 + a) (1 - x1) x2 + (E10 - E00 - a) x1 (1 - x2).
    This a makes the last two, which arcs carry, as equal as can be: neither is negative where
    E00 + E11 <= E01 + E10.
    """
    stay_1, change_1 = marks[STAY, first], marks[CHANGE, first]
    stay_2, change_2 = marks[STAY, second], marks[CHANGE, second]
    sum_second = penalties[change_1, change_2] - penalties[stay_1, change_2]
    sum_first = penalties[change_1, stay_2] - penalties[stay_1, stay_2]
    return int(sum_second + sum_first) >> 1


@compiled
def lay_arcs(arcs: Int32Array, marks: AnyArray, penalties: Int32Array, p: int) -> None:
    """Work out what the arcs of pixel `p` can carry."""
    marks[IS_LAID, p] = 1
    for k in range(arcs.shape[2]):
        q = arcs[TO, p, k]
        carries = 0
        if q >= 0 and k & 1 == 0:
            share = share_penalty(marks, penalties, p, q)
            stay = penalties[marks[STAY, p], marks[CHANGE, q]]
            carries = stay - penalties[marks[CHANGE, p], marks[CHANGE, q]] + share
        elif q >= 0:
            share = share_penalty(marks, penalties, q, p)
            stay = penalties[marks[STAY, q], marks[STAY, p]]
            carries = penalties[marks[CHANGE, q], marks[STAY, p]] - stay - share
        arcs[LEFT, p, k] = arcs[WEIGHT, p, k] * carries


@compiled
def price_of_change(arcs: Int32Array, marks: AnyArray, penalties: Int32Array, p: int) -> int:
    """Return what the pairs of pixel `p` add to its arc from the source."""
    total = 0
    for k in range(arcs.shape[2]):
        q = arcs[TO, p, k]
        if q >= 0 and k & 1 == 0:
            total += arcs[WEIGHT, p, k] * share_penalty(marks, penalties, p, q)
        elif q >= 0:
            both = (
                penalties[marks[CHANGE, p], marks[CHANGE, q]]
                - penalties[marks[STAY, p], marks[STAY, q]]
            )
            total += arcs[WEIGHT, p, k] * (both - share_penalty(marks, penalties, q, p))
    return total
