"""Where the joints may be, out of the parts of the body: modes, pushed back from the surface.

A joint lies within one part (head, hand) or where two meet (elbow). The modes of the density of
the parts' pixels lie on the surface; the joint is behind them by a depth that was learned for
each joint, and beside them by shares of the ways to the middles of neighbouring parts, learned
too (see `adibas.limbs.joint_offsets`).

Source: Shotton et al., Real-time human pose recognition in parts from single depth images, CVPR
2011, section 3.3 (weighted mean shift, weights by probability and squared depth, push back by a
learned depth); Shotton et al., Efficient human pose estimation from single depth images, PAMI 35
(2013), section 4.1. The density of a pair of parts and the shares of the ways are ours.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from adibas.arrays import Float32Array, FloatArray, IntArray, check_shape
from adibas.data.joint_proposals import JointProposals
from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES
from adibas.data.limbs import LimbParts
from adibas.data.part_cloud import PartCloud
from adibas.errors import LimbError
from adibas.limbs.joint_offsets import JointOffsets
from adibas.limbs.joint_places import PLACES
from adibas.limbs.mean_shift_kernels import (
    find_middles,
    find_modes_of_joints,
    gather_cells,
    list_points,
    over_labels,
)

N_PROPOSALS = 3


@dataclass(frozen=True, slots=True)
class ProposalParams:
    """Settings of the search for joints.

    Attributes
    ----------
    cell_m : float
        Pixels are taken together in squares of this width, metres: 0.022, a quarter of the
        narrowest density.
    cut_share : float
        How much the label after the cut counts beside the forest's probabilities: 0.5.
    least_probability : float
        A square counts for a part from this mean probability on: 0.14, as Shotton et al. have it
        for pixels (2011, 3.3).
    least_density_m2 : float
        A mode needs this much surface about it: 0.0006, a quarter of a child's hand.
    least_share : float
        Modes with less than this share of the highest one are left out: 0.1.
    """

    cell_m: float = 0.022
    cut_share: float = 0.5
    least_probability: float = 0.14
    least_density_m2: float = 0.0006
    least_share: float = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class PartPoints:
    """The surface of each part in squares of some pixels.

    Attributes
    ----------
    names : tuple of str
    points : (M, 4) array
        x, y, z (metres, camera axes) and weight (probable square metres), part after part.
    starts : (L + 1,) array
        Where the points of each part begin.
    cells : (C, L, 4) array
        Of each square and label: weighted x, y, z, and the weight.
    """

    names: tuple[str, ...]
    points: FloatArray
    starts: IntArray
    cells: FloatArray

    def of(self, name: str) -> FloatArray:
        """Return the (m, 4) points of a part."""
        k = self.names.index(name)
        return self.points[self.starts[k] : self.starts[k + 1]]

    def cloud(self) -> PartCloud:
        """Return the squares with the weight of every part of the body.

        Raises
        ------
        ValueError
            The labels are not those of the whole body.
        """
        columns = [self.names.index(name) for name in BODY_PART_NAMES]
        of_all = over_labels(self.cells)
        is_used = of_all[:, 3] > 0
        used = of_all[is_used]
        weights_m2 = np.take(self.cells[..., 3], columns, axis=1)
        return PartCloud(used[:, :3] / used[:, 3:], weights_m2[is_used])

    def middles_m(self) -> dict[str, FloatArray]:
        """Return the middle of each part that is seen."""
        middles_m = find_middles(self.points, self.starts)
        seen = np.flatnonzero(np.diff(self.starts))
        return {self.names[label]: middles_m[label] for label in seen.tolist()}


def part_points(
    depth_m: Float32Array,
    parts: LimbParts,
    rays: Float32Array,
    params: ProposalParams | None = None,
) -> PartPoints:
    """Return the surface of each part.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Metres; NaN where not measured.
    parts : LimbParts
        Of the same image.
    rays : (H, W, 3) float32 array
        What each pixel sees at one metre of depth.
    """
    params = params or ProposalParams()
    check_shape("rays", rays, (*depth_m.shape, 3))
    index = np.flatnonzero(parts.pixels)
    here_m = depth_m.ravel()[index]
    here_m = here_m[here_m > 0]
    nearness_m = float(np.median(here_m)) if len(here_m) else 1.0
    pixel_m = nearness_m * float(rays[0, 1, 0] - rays[0, 0, 0])
    n_known = np.count_nonzero(parts.chosen.ravel()[index] >= 0)
    each = np.count_nonzero(parts.chosen >= 0) / n_known if n_known else 1.0
    cell_px = max(1.0, round(params.cell_m / pixel_m))
    cells = gather_cells(
        depth_m,
        index,
        rays,
        np.ascontiguousarray(parts.probabilities, np.float32),
        np.ascontiguousarray(parts.chosen),
        np.array([cell_px, params.cut_share, each]),
    )
    points, starts = list_points(cells, params.least_probability)
    return PartPoints(parts.labels.names, points, starts, cells)


def propose_joints(
    points: PartPoints, offsets: JointOffsets, params: ProposalParams | None = None
) -> JointProposals:
    """Return where each joint may be.

    Raises
    ------
    LimbError
        The labels are not those of the whole body.
    """
    params = params or ProposalParams()
    missing = {part for place in PLACES for part in place.parts} - set(points.names)
    if missing:
        raise LimbError(
            "The model of limbs has no label {label}: joints need the 15 labels of the full body. "
            "Choose a model for the full body.",
            label=min(missing),
        )
    middles_m = points.middles_m()
    positions_m = np.full((len(JOINT_NAMES), N_PROPOSALS, 3), np.nan)
    weights_m2 = np.zeros((len(JOINT_NAMES), N_PROPOSALS))
    modes = modes_of_places(points)
    least_m2 = np.maximum(params.least_density_m2, params.least_share * modes[:, :1, 3])
    is_kept = modes[:, :, 3] >= least_m2
    for place, of_place, kept in zip(PLACES, modes, is_kept, strict=True):
        found = of_place[kept]
        at = JOINT_NAMES.index(place.joint)
        positions_m[at, : len(found)] = offsets.joints_m(place, found[:, :3], middles_m)
        weights_m2[at, : len(found)] = found[:, 3]
    return JointProposals(positions_m, weights_m2)


def modes_of_places(points: PartPoints) -> FloatArray:
    """Return (15, 3, 4): x, y, z and density (m^2) of the modes of each of `PLACES`.

    The highest first; NaN and 0 where there are fewer.
    """
    pairs = _pairs_of(points.names)
    return find_modes_of_joints(points.points, points.starts, pairs, _WIDTHS_M, N_PROPOSALS)


_WIDTHS_M = np.array([place.width_m for place in PLACES])


@cache
def _pairs_of(names: tuple[str, ...]) -> IntArray:
    """Return (15, 2) which parts each of `PLACES` lies between; the second -1 if within one."""
    numbers = [[names.index(part) for part in place.parts] for place in PLACES]
    return np.array([[*pair, -1][:2] for pair in numbers])
