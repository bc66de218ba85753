"""What the namer of points knows: several shape models of one set of names."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import FloatArray, IntArray, check_shape, read_only
from adibas.data.joints import SIDES, mirror_order
from adibas.skeleton.parts import PartsModel


@dataclass(frozen=True, slots=True, eq=False)
class Prototype:
    """A point distribution model of shapes alike: ``mean + modes' z + noise``.

    Its frame: centred, x to the patient's left (where names have sides), y down, of root mean
    square radius 1.

    Attributes
    ----------
    kind : str
        What most of its shapes were called in training; may be empty.
    weight : float
        Share of the training's shapes.
    mean : (N, D) array
    modes : (t, N, D) array
        Each of the length of one standard deviation.
    noise : (N,) array
        Variance of one coordinate beside the modes.
    log_size, log_size_sd : float
        Of the root mean square radius in metres: mean and standard deviation of its logarithm.
    """

    kind: str
    weight: float
    mean: FloatArray
    modes: FloatArray
    noise: FloatArray
    log_size: float
    log_size_sd: float

    def __post_init__(self) -> None:
        check_shape("mean", self.mean, (None, None))
        check_shape("modes", self.modes, (None, *self.mean.shape))
        check_shape("noise", self.noise, (len(self.mean),))
        if not (self.noise > 0).all() or not self.weight > 0 or not self.log_size_sd > 0:
            raise ValueError("noise, weight and log_size_sd must be positive")
        for array in (self.mean, self.modes, self.noise):
            read_only(array)


@dataclass(frozen=True, slots=True, eq=False)
class NeighbourTree:
    """How neighbours among N points lie to one another, in the frame of `Prototype`.

    Attributes
    ----------
    edges : (E, 2) int array
        (parent, child), parents first.
    log_lengths, log_length_sds : (E,) arrays
        In root mean square radii of the shape.
    directions : (E, n_bands, n_sectors) array
        Minus the log density of directions.
    """

    edges: IntArray
    log_lengths: FloatArray
    log_length_sds: FloatArray
    directions: FloatArray

    def __post_init__(self) -> None:
        n_edges = len(self.edges)
        check_shape("edges", self.edges, (None, 2))
        check_shape("log_lengths", self.log_lengths, (n_edges,))
        check_shape("log_length_sds", self.log_length_sds, (n_edges,))
        check_shape("directions", self.directions, (n_edges, None, None))
        for array in (self.edges, self.log_lengths, self.log_length_sds, self.directions):
            read_only(array)


@dataclass(frozen=True, slots=True, eq=False)
class PointModel:
    """Shapes of D dimensions, of which each prototype holds some.

    Attributes
    ----------
    names : tuple of str
        Of the N points.
    prototypes : tuple of Prototype
        At least one.
    tree : NeighbourTree
        How neighbours lie to one another.
    is_upright : bool
        Whether y was down in all shapes that it was learned from: then a shape is looked for
        upright, else in any turn.
    """

    names: tuple[str, ...]
    prototypes: tuple[Prototype, ...]
    tree: NeighbourTree
    is_upright: bool

    def __post_init__(self) -> None:
        if not self.prototypes or not self.names:
            raise ValueError("a model needs names and prototypes")
        shape = (len(self.names), self.n_dimensions)
        for prototype in self.prototypes:
            check_shape("mean", prototype.mean, shape)

    @property
    def n_dimensions(self) -> int:
        """Return D."""
        return int(self.prototypes[0].mean.shape[1])


@dataclass(frozen=True, slots=True, eq=False)
class SkeletonModel:
    """A model for points in space, and where it has them, ones for points in the plane.

    Attributes
    ----------
    space : PointModel or None
        Of points in 3-D.
    planes : Mapping
        By view (one of `adibas.data.posture.VIEWS`, or empty for any), of points in 2-D.
    temperature : float
        By how much differences of energy are divided before they count as log odds: found from
        the training's own mistakes.
    provenance : Mapping
        What it was learned from.
    parts : PartsModel or None
        Core and limbs, where the points are the 15 joints in space; needs `space`.
    """

    space: PointModel | None
    planes: Mapping[str, PointModel]
    temperature: float
    provenance: Mapping[str, object] = field(default_factory=dict)
    parts: PartsModel | None = None

    def __post_init__(self) -> None:
        if self.space is None and not self.planes:
            raise ValueError("a skeleton model needs points in space or in the plane")
        if not self.temperature > 0:
            raise ValueError("temperature must be positive")
        if len({model.names for model in self.models()}) != 1:
            raise ValueError("all parts of a skeleton model must have the same names")
        if self.parts is not None and (self.space is None or self.parts.names != self.names):
            raise ValueError("core and limbs need points in space of the same names")

    def models(self) -> tuple[PointModel, ...]:
        """Return all parts."""
        in_space = () if self.space is None else (self.space,)
        return (*in_space, *self.planes.values())

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the points."""
        return self.models()[0].names


def left_of(shapes: FloatArray, names: tuple[str, ...]) -> FloatArray:
    """Return the (..., D) mean way from the right to the left of (..., N, D) shapes; 0 if none."""
    mirror = mirror_order(names)
    lefts = [i for i, name in enumerate(names) if name.startswith(SIDES[0]) and mirror[i] != i]
    if not lefts:
        return np.zeros_like(shapes[..., 0, :])
    rights = [mirror[i] for i in lefts]
    return np.asarray((shapes[..., lefts, :] - shapes[..., rights, :]).mean(axis=-2))
