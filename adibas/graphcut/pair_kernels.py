"""The tables that the loops of a cut work on, and what a binary choice costs pairs of pixels.

Compiled functions take these arrays one by one: a tuple of arrays costs a counted reference at
every use. N pixels, K arcs each, L labels:

- ``arcs``: (2, N, K) int32; planes `TO` (the neighbour, -1 where there is none; its arc ``k ^ 1``
  leads back) and `WEIGHT` (of the pair).
- ``left``: (N, K) int32; what more each arc can carry.
- ``nodes``: (5, N) int32; `EXCESS` (what the arc from the source, or negative to the sink, can
  still carry), `DISTANCE` (arcs to the sink) and `SEEN_AT` (when that was known), `ACTIVE` and
  `ORPHANS` (rings of pixels that wait).
- ``marks``: (5, N) int8; `PARENT` (the arc towards the sink, or `TERMINAL`, `FREE`, `ORPHAN`),
  `IS_ACTIVE`, `IS_LAID` (whether `left` is worked out), `STAY` and `CHANGE` (the pixel's label on
  the source's side of the cut and on the sink's).
- ``counters``: (5,) int64.
- ``penalties``: (L, L) int32, symmetric, 0 on the diagonal.
"""

from adibas.arrays import AnyArray, Int32Array
from adibas.kernels import compiled

TO, WEIGHT = range(2)
EXCESS, DISTANCE, SEEN_AT, ACTIVE, ORPHANS = range(5)
PARENT, IS_ACTIVE, IS_LAID, STAY, CHANGE = range(5)
CLOCK, FIRST_ACTIVE, N_ACTIVE, FIRST_ORPHAN, N_ORPHANS = range(5)
TERMINAL = -1
FREE = -2
ORPHAN = -3


@compiled
def pair_terms(
    penalties: Int32Array, stay_1: int, change_1: int, stay_2: int, change_2: int
) -> tuple[int, int, int, int]:
    """Return how a pair's penalty is shared out, each for a weight of 1.

    With E00, E01, E10, E11 for (first, second) = (stay, stay), (stay, change), ... the penalty is
    E00 + a x1 + (E11 - E00 - a) x2 + (E01 - E11 + a) (1 - x1) x2 + (E10 - E00 - a) x1 (1 - x2).
    This a makes the last two, which arcs carry, as equal as can be: neither is negative where
    E00 + E11 <= E01 + E10.

    Returns
    -------
    first, second : int
        What each pixel pays for a change.
    forth, back : int
        What the arcs from the first pixel to the second, and back, can carry.
    """
    stay, change = penalties[stay_1, stay_2], penalties[change_1, change_2]
    second_changes, first_changes = penalties[stay_1, change_2], penalties[change_1, stay_2]
    first = (change - second_changes + first_changes - stay) >> 1
    forth, back = second_changes - change + first, first_changes - stay - first
    return first, change - stay - first, forth, back


@compiled
def terms_at(
    arcs: Int32Array, marks: AnyArray, penalties: Int32Array, p: int, k: int
) -> tuple[int, int, int, int]:
    """Return `pair_terms` of pixel `p`, which comes first, and its neighbour at arc `k`."""
    q = arcs[TO, p, k]
    stay_p, change_p = marks[STAY, p], marks[CHANGE, p]
    stay_q, change_q = marks[STAY, q], marks[CHANGE, q]
    if k & 1 == 0:
        return pair_terms(penalties, stay_p, change_p, stay_q, change_q)
    # Halves are rounded the same way from either end.
    of_q, of_p, back, forth = pair_terms(penalties, stay_q, change_q, stay_p, change_p)
    return of_p, of_q, forth, back


@compiled
def lay_arcs(
    arcs: Int32Array, left: Int32Array, marks: AnyArray, penalties: Int32Array, p: int
) -> None:
    """Work out what the arcs of pixel `p` can carry."""
    marks[IS_LAID, p] = 1
    for k in range(arcs.shape[2]):
        carries = terms_at(arcs, marks, penalties, p, k)[2] if arcs[TO, p, k] >= 0 else 0
        left[p, k] = arcs[WEIGHT, p, k] * carries


@compiled
def price_of_change(arcs: Int32Array, marks: AnyArray, penalties: Int32Array, p: int) -> int:
    """Return what the pairs of pixel `p` add to its arc from the source."""
    total = 0
    for k in range(arcs.shape[2]):
        if arcs[TO, p, k] >= 0:
            total += arcs[WEIGHT, p, k] * terms_at(arcs, marks, penalties, p, k)[0]
    return total
