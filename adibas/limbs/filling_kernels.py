"""Labels of the pixels between those that were looked at."""

import numpy as np

from adibas.arrays import AnyArray, BoolArray
from adibas.data.limbs import NO_LABEL
from adibas.kernels import compiled, compiled_parallel, parallel_range


@compiled_parallel
def filled_between(thin: AnyArray, mask: BoolArray, step: int) -> AnyArray:
    """Return (H, W) int16 labels of the mask: that of the nearest sample that has one.

    `NO_LABEL` is what is not in the mask, and everything where no sample has a label. Of samples
    as near the upper one counts, then the left one.

    Parameters
    ----------
    thin : (h, w) int16 array
        Of every `step`-th pixel of every `step`-th row; negative where none is known.
    mask : (H, W) bool array
        ``h = ceil(H / step)``, likewise w.
    step : int
    """
    height, width = mask.shape
    labels = np.full((height, width), NO_LABEL, np.int16)
    if not (thin >= 0).any():
        return labels
    for row in parallel_range(height):
        # Counted, not divided: a division takes longer than all the rest.
        above, left, beyond = row // step, 0, 0
        for column in range(width):
            if mask[row, column]:
                label = thin[above, left] if beyond == 0 and row == above * step else NO_LABEL
                reach = 1
                while label < 0:
                    label = _nearest_label(thin, row, column, (above, left), step, reach)
                    reach *= 2
                labels[row, column] = label
            beyond += 1
            if beyond == step:
                left, beyond = left + 1, 0
    return labels


@compiled
def _nearest_label(
    thin: AnyArray, row: int, column: int, corner: tuple[int, int], step: int, reach: int
) -> int:
    """Return the label of the nearest sample less than `reach` steps away, or `NO_LABEL`.

    `corner` is the sample above and left of the pixel, or at it.
    """
    nearest, label = (reach * step) ** 2, NO_LABEL
    for i in range(max(corner[0] - reach + 1, 0), min(corner[0] + reach + 1, thin.shape[0])):
        for j in range(max(corner[1] - reach + 1, 0), min(corner[1] + reach + 1, thin.shape[1])):
            gap = (i * step - row) ** 2 + (j * step - column) ** 2
            if thin[i, j] >= 0 and gap < nearest:
                nearest, label = gap, thin[i, j]
    return label
