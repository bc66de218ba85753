"""The part of space that all cameras in use see."""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only


@dataclass(frozen=True, slots=True, eq=False)
class SeenSpace:
    """Where K planes have their inner sides: a point p is seen where `normals` @ p >= `offsets_m`.

    Attributes
    ----------
    normals : (K, 3) array
        Unit vectors, inwards, in the axes of the points that are named.
    offsets_m : (K,) array
    """

    normals: FloatArray
    offsets_m: FloatArray

    def __post_init__(self) -> None:
        check_shape("normals", self.normals, (None, 3))
        check_shape("offsets_m", self.offsets_m, (len(self.normals),))
        for name in ("normals", "offsets_m"):
            values = np.array(getattr(self, name), float)
            read_only(values)
            object.__setattr__(self, name, values)

    def about(self, origin_m: FloatArray) -> "SeenSpace":
        """Return the same space with another origin (3,)."""
        return SeenSpace(self.normals, self.offsets_m - self.normals @ origin_m)

    def turned(self, rotation: FloatArray) -> "SeenSpace":
        """Return the space of points that are turned by a (3, 3) rotation."""
        return SeenSpace(self.normals @ rotation.T, self.offsets_m)


EVERYWHERE = SeenSpace(np.empty((0, 3)), np.empty(0))
"""Nothing is known of what the cameras see."""
