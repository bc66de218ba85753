"""Begin-end alignment with limited slope from costs that are already known.

The steps are those of `sloped_kernels`.
"""

from adibas.arrays import FloatArray, IntArray
from adibas.kernels import compiled
from adibas.timeseries.sloped_kernels import N_COSTS, advance


@compiled
def feed_costs(
    local: FloatArray,
    offsets: IntArray,
    first: int,
    memory: FloatArray,
    costs_out: FloatArray,
    starts_out: FloatArray,
) -> None:
    """Take `local` (n, M) costs of n frames, as `feed_sloped` takes frames; `memory` goes on."""
    for t in range(len(local)):
        now = first + t
        row = now % N_COSTS
        for i in range(local.shape[1]):
            memory[row, i] = local[t, i]
        advance(now, t, offsets, memory, costs_out, starts_out)
