"""Which of the surfaces in a depth image is a person."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import Float32Array, FloatArray, Int32Array, IntArray
from adibas.body.component_kernels import gaps_to_body

TOP_PERCENTILE = 98.0
BOTTOM_ROWS = 8
"""Above the lowest row with depth: dips of an outline that the image cuts off."""


@dataclass(frozen=True, slots=True)
class BodyParams:
    """Settings of the body mask.

    Attributes
    ----------
    range_m : tuple
        Depths where a person is looked for: what the sensor measures (thesis 6.1.1.1: 1.2-3.5 m;
        PrimeSense from 0.5 m).
    step_per_m : float
        Step of inverse depth (1/m) that parts two surfaces. 0.012: 48 mm at 2 m, over four steps of
        disparity of a PrimeSense.
    step_m : float
        Smallest step in depth that parts two surfaces, 0.025: at close range a slanted surface
        falls by more than the noise from one pixel to the next.
    floor_band_m, floor_band_per_m : float
        Height over the floor under which all is floor: 8 mm and 1.2 mm times depth squared (three
        standard deviations of the noise seen at the usual slant).
    min_area_m2, max_area_m2 : float
        Of the body's front: a child's trunk 0.05; a large adult with arms spread 1.6.
    min_length_m, max_length_m : float
        Of the part in view, 0.35; and 2.6: ceiling and side walls of a room, of whose far end the
        sensor sees nothing, are longer.
    standing_length_m, standing_top_m : float
        A person in view down to the floor is longer or reaches higher than that, unlike a chair:
        0.95 and 1.0 (children from 6 years on).
    min_cut_m : float
        Width at the image's lower edge of someone seen from the waist up, 0.1.
    min_relief : float
        Depth of the shape as a share of its width (standard deviations along the shortest and the
        middle principal axis) once the sensor's noise is taken off: a trunk from the front has
        0.13. 0.07.
    noise_per_m : float
        Standard deviation of a far wall's depth per depth squared (1/m), 0.001: seen from 3.5 m on
        a strip of wall is as thick with it as a trunk is for its width. A first Kinect has 0.0014
        (Khoshelham and Elberink 2012), of which no wall has all after the lens is corrected.
    joint_reach_px : int
        Width of the shadow between an arm and the trunk that still counts as touching, 24.
    front_gap_m, level_gap_m : float
        How far a bordering surface of any size may be before and behind the body to belong to it:
        raised forearms part head and chest from the rest. 0.6 (an arm's length), and 0.13 (less
        than a trunk is thick).
    back_gap_m, max_part_share : float
        How far a bordering surface may be behind if it has less than that share of the body's
        area: the far leg. 0.28 and 0.3.
    in_line_m : float
        A bordering surface belongs to the body if its middle lies that near to the body's in depth
        and to one side: the legs under raised forearms. 0.2.
    bay_px : int
        Radius of the disc that closes bays of the outline without depth, 2.
    max_hole_share : float
        Of the body's area that one hole may have, 0.03.
    alone_share : float
        Of the outline along which something may be before what stands alone, with nothing measured
        behind it: noise of the floor about the feet. 0.1.
    """

    range_m: tuple[float, float] = (0.4, 4.5)
    step_per_m: float = 0.012
    step_m: float = 0.025
    floor_band_m: float = 0.008
    floor_band_per_m: float = 0.0012
    min_area_m2: float = 0.05
    max_area_m2: float = 1.6
    min_length_m: float = 0.35
    max_length_m: float = 2.6
    standing_length_m: float = 0.95
    standing_top_m: float = 1.0
    min_cut_m: float = 0.1
    min_relief: float = 0.07
    noise_per_m: float = 0.001
    joint_reach_px: int = 24
    front_gap_m: float = 0.6
    level_gap_m: float = 0.13
    back_gap_m: float = 0.28
    max_part_share: float = 0.3
    in_line_m: float = 0.2
    bay_px: int = 2
    max_hole_share: float = 0.03
    alone_share: float = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Surfaces:
    """A depth image in pieces without a step.

    Attributes
    ----------
    labels : (H, W) int32 array
        1, 2, ...; 0 where there is nothing.
    moments : (n + 1, 10) array
        Of each label; see `adibas.body.component_kernels.surface_moments`.
    inverse_depth : (H, W) float32 array
        1/m.
    heights_m : (H, W) float32 array or None
        Over the floor; None where none is known.
    pixel_rad : float
        Angle from one pixel to the next.
    """

    labels: Int32Array
    moments: FloatArray
    inverse_depth: Float32Array
    heights_m: Float32Array | None
    pixel_rad: float
    _borders: dict[tuple[int, int], FloatArray] = field(default_factory=dict, init=False)
    _pixels: dict[int, IntArray] = field(default_factory=dict, init=False)

    def pixels_of(self, label: int) -> IntArray:
        """Return where a surface is: rising numbers of pixels in the flat image."""
        known = self._pixels.get(label)
        if known is None:
            known = self._pixels[label] = np.flatnonzero(self.labels == label)
        return known

    def outline_px(self, label: int) -> int:
        """Return the length of an outline in sides of pixels, those of the image left out."""
        pixels = self.labels == label
        return sum(
            int(np.count_nonzero(one != other))
            for one, other in ((pixels[1:], pixels[:-1]), (pixels[:, 1:], pixels[:, :-1]))
        )

    def borders(self, label: int, reach_px: int) -> FloatArray:
        """Return how every surface borders on one; see `component_kernels.gaps_to_body`."""
        known = self._borders.get((label, reach_px))
        if known is None:
            n_labels = len(self.moments) - 1
            known = gaps_to_body(self.labels, n_labels, label, self.inverse_depth, reach_px)
            self._borders[label, reach_px] = known
        return known


def find_person(surfaces: Surfaces, params: BodyParams) -> int | None:
    """Return the label of the largest surface that can be a person; None where there is none."""
    return next(_candidates(surfaces, params, _nobody_else), None)


def find_persons(
    surfaces: Surfaces, params: BodyParams, is_seated: Callable[[int], bool]
) -> list[int]:
    """Return the labels of all surfaces that can be persons, the largest first.

    `is_seated` is asked about surfaces that are not tall enough.
    """
    return list(_candidates(surfaces, params, is_seated))


def could_be_of_a_person(moments: FloatArray, params: BodyParams) -> bool:
    """Say whether a surface of (10,) moments could be a person's, or a part of one."""
    if not params.min_area_m2 < moments[0] < params.max_area_m2:
        return False
    return _Shape(moments).fits_a_person(params)


def _candidates(
    surfaces: Surfaces, params: BodyParams, is_seated: Callable[[int], bool]
) -> Iterator[int]:
    area_m2 = surfaces.moments[:, 0]
    large = np.flatnonzero((area_m2 > params.min_area_m2) & (area_m2 < params.max_area_m2))
    for label in sorted(large.tolist(), key=lambda label: -area_m2[label]):
        shape = _Shape(surfaces.moments[label])
        if not shape.fits_a_person(params):
            continue
        is_person = _is_tall(surfaces, label, shape, params) or is_seated(label)
        if is_person and _stands_before(surfaces, label, params):
            yield int(label)


def _nobody_else(_label: int) -> bool:
    """Say that nobody is expected to sit."""
    return False


def _is_tall(surfaces: Surfaces, label: int, shape: "_Shape", params: BodyParams) -> bool:
    """Say whether it is as tall as a person, as far as can be seen."""
    if shape.length_m > params.standing_length_m:
        return True
    if surfaces.heights_m is not None:
        heights_m = surfaces.heights_m.ravel()[surfaces.pixels_of(label)]
        return float(np.percentile(heights_m, TOP_PERCENTILE)) > params.standing_top_m
    # Someone seen from the waist up is cut off by the lower edge of the image, across.
    last_row = int(np.flatnonzero((surfaces.labels > 0).any(axis=1))[-1])
    lowest = surfaces.labels[max(last_row - BOTTOM_ROWS, 0) : last_row + 1] == label
    cut_px = int(lowest.any(axis=0).sum())
    return bool(cut_px * surfaces.pixel_rad * shape.mean_m[2] > params.min_cut_m)


def _stands_before(surfaces: Surfaces, label: int, params: BodyParams) -> bool:
    """Say whether most of what it borders on lies behind it; of a piece of wall, nothing does.

    What is level with it, within the step that parts surfaces, is neither: far away noise tears a
    leg from its trunk. Far from all walls that the sensor sees, a person borders on nearly nothing.
    """
    length_px, gap_m = surfaces.borders(label, params.joint_reach_px).T
    before_px = length_px[gap_m < -params.step_m].sum()
    if length_px[gap_m > params.step_m].sum() >= before_px:
        return True
    return bool(before_px < params.alone_share * surfaces.outline_px(label))


class _Shape:
    """Size and form of one surface, out of its moments."""

    def __init__(self, moments: FloatArray) -> None:
        self.mean_m = moments[1:4] / moments[0]
        xx, yy, zz, xy, xz, yz = moments[4:] / moments[0]
        second = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        self._covariance = second - np.outer(self.mean_m, self.mean_m)
        self._variances = np.maximum(np.linalg.eigvalsh(self._covariance), 0.0)

    @property
    def length_m(self) -> float:
        """Length of the evenly filled bar that spreads as much along the longest axis."""
        return float(np.sqrt(12.0 * self._variances[2]))

    def fits_a_person(self, params: BodyParams) -> bool:
        """Say whether it is no plane, and neither too short nor too long."""
        noise_m = params.noise_per_m * self.mean_m[2] ** 2
        is_solid = self._variances[0] - noise_m**2 > params.min_relief**2 * self._variances[1]
        return bool(is_solid and params.min_length_m <= self.length_m <= params.max_length_m)
