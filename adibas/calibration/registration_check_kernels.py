"""How well the outlines of the depth lie on edges of the colour image, for a grid of shifts."""

from adibas.arrays import FloatArray
from adibas.kernels import compiled


@compiled
def rough_scores(
    axes: tuple[FloatArray, FloatArray],
    normals: FloatArray,
    sums: FloatArray,
    samples_per_px: float,
    scores: FloatArray,
) -> None:
    """Fill `scores` (S, S, G) with the total strength, by straight lines between the samples.

    `axes` are the S shifts, to the right and down alike, and the G growths, pixels; `normals`
    (D, 2) and `sums` (D, K) belong to the directions. Beyond the samples there is no strength.
    """
    shifts, growths = axes
    last = sums.shape[1] - 1
    for i in range(len(shifts)):
        for j in range(len(shifts)):
            for k in range(len(growths)):
                total = 0.0
                for d in range(sums.shape[0]):
                    along = shifts[i] * normals[d, 0] + shifts[j] * normals[d, 1] + growths[k]
                    place = 0.5 * last + along * samples_per_px
                    if place < 0.0 or place > last:
                        continue
                    n = min(int(place), last - 1)
                    total += sums[d, n] + (place - n) * (sums[d, n + 1] - sums[d, n])
                scores[i, j, k] = total
