"""The surface of a person in small squares, and which part of the body each of them may be."""

from dataclasses import dataclass

from adibas.arrays import FloatArray, check_shape, read_only
from adibas.data.joints import BODY_PART_NAMES, mirror_order


@dataclass(frozen=True, slots=True, eq=False)
class PartCloud:
    """Points of the surface of one person in one frame.

    Attributes
    ----------
    points_m : (N, 3) array
        Axes of the depth camera, metres.
    weights_m2 : (N, 15) array
        Area that faces the camera times the probability of each of `BODY_PART_NAMES`.
    """

    points_m: FloatArray
    weights_m2: FloatArray

    def __post_init__(self) -> None:
        check_shape("points_m", self.points_m, (None, 3))
        check_shape("weights_m2", self.weights_m2, (len(self.points_m), len(BODY_PART_NAMES)))
        read_only(self.points_m)
        read_only(self.weights_m2)

    def with_sides_swapped(self) -> "PartCloud":
        """Return the cloud of which every left part is a right one, and the other way round."""
        swapped = mirror_order(BODY_PART_NAMES)
        return PartCloud(self.points_m, self.weights_m2[:, swapped].copy())
