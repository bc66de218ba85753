"""A trained forest, and the label probabilities it gives.

Source: thesis, section 6.2.2; Shotton et al., Real-time human pose recognition in parts from
single depth images, CVPR 2011.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from adibas.arrays import BoolArray, Float32Array, Int32Array, IntArray, check_shape, read_only
from adibas.forests.feature_kernels import KIND
from adibas.forests.images import ForestImage, join_images, prepare_image
from adibas.forests.packing import LEAF_STEPS, OFFSET_STEPS_PER_M, THRESHOLD_STEPS
from adibas.forests.params import GRADIENT
from adibas.forests.prediction_kernels import LINK, N_COLUMNS, predict

N_NODE_VALUES = 6
LEAF = -1
LINE_BYTES = 64
"""What memory gives at once."""


@dataclass(frozen=True, slots=True, eq=False)
class Forest:
    """Trees one after the other in the same arrays.

    Attributes
    ----------
    labels : tuple of str
        The L labels.
    roots : (T,) int32 array
        The first node of each tree.
    child : (M,) int32 array
        The left child of each node, the right one follows it; -1 - l for leaf l.
    nodes : (M, 6) float32 array
        Feature (kind, u_row, u_column, v_row, v_column; metres on the body) and threshold.
    leaves : (F, L) float32 array
        Probabilities; each row sums to 1.
    far_m, smoothing_px : float
        As in training.
    provenance : mapping
        What it was trained from and how; plain JSON values.
    uses_gradients : bool
        A node asks for the angle of gradients.
    """

    labels: tuple[str, ...]
    roots: Int32Array
    child: Int32Array
    nodes: Float32Array
    leaves: Float32Array
    far_m: float
    smoothing_px: float
    provenance: Mapping[str, object] = field(default_factory=dict)
    uses_gradients: bool = field(init=False)
    _steps: Float32Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        check_shape("roots", self.roots, (None,))
        check_shape("child", self.child, (None,))
        check_shape("nodes", self.nodes, (len(self.child), N_NODE_VALUES))
        check_shape("leaves", self.leaves, (None, len(self.labels)))
        self._check_links()
        steps = _in_lines(len(self.child))
        steps[:, :N_NODE_VALUES] = self.nodes
        steps.view(np.int32)[:, LINK] = self.child
        object.__setattr__(self, "_steps", steps)
        gradients = self.nodes[self.child >= 0, KIND] == GRADIENT
        object.__setattr__(self, "uses_gradients", bool(gradients.any()))
        for array in (self.roots, self.child, self.nodes, self.leaves):
            read_only(array)

    def _check_links(self) -> None:
        """Raise ValueError where a walk down would leave the tables or never end."""
        n_nodes, n_leaves = len(self.child), len(self.leaves)
        is_split = self.child >= 0
        below = self.child[is_split]
        goes_down = (below > np.flatnonzero(is_split)).all() and (below + 1 < n_nodes).all()
        has_leaves = (-1 - self.child[~is_split] < n_leaves).all()
        has_roots = ((self.roots >= 0) & (self.roots < n_nodes)).all() and len(self.roots) > 0
        if not (goes_down and has_leaves and has_roots):
            raise ValueError("the nodes of the forest do not fit together")

    @property
    def n_trees(self) -> int:
        """Return T."""
        return len(self.roots)

    def prepare(self, depth_m: Float32Array, mask: BoolArray, focal_px: float) -> ForestImage:
        """Cut the body out of an (H, W) depth image as this forest reads it."""
        smoothing_px = self.smoothing_px if self.uses_gradients else None
        return prepare_image(depth_m, mask, focal_px, self.far_m, smoothing_px)

    def rounded(self) -> "Forest":
        """Return the forest with numbers of fewer digits, which a file keeps in little space.

        Offsets to 1 mm, thresholds to 0.1 mm or 0.1 mrad, probabilities to 1 / 128.
        """
        nodes = self.nodes.copy()
        nodes[:, KIND + 1 : -1] = _rounded(nodes[:, KIND + 1 : -1], OFFSET_STEPS_PER_M)
        nodes[:, -1] = _rounded(nodes[:, -1], THRESHOLD_STEPS)
        leaves = np.rint(self.leaves * LEAF_STEPS) / np.float32(LEAF_STEPS)
        leaves /= np.maximum(leaves.sum(axis=1, keepdims=True), np.finfo(np.float32).tiny)
        return replace(self, nodes=nodes, leaves=leaves.astype(np.float32))

    def probabilities(
        self,
        depth_m: Float32Array,
        mask: BoolArray,
        focal_px: float,
        pixels: BoolArray | None = None,
    ) -> Float32Array:
        """Return the probability of each label at the pixels of a mask (equation 6.18).

        Parameters
        ----------
        depth_m : (H, W) float32 array
            Metres; NaN where not measured.
        mask : (H, W) bool array
            The body.
        focal_px : float
            Of the camera, pixels.
        pixels : (H, W) bool array or None
            The N pixels of the mask that are asked for; None: all.

        Returns
        -------
        probabilities : (N, L) float32 array
            In the order of ``np.flatnonzero(pixels)``; rows sum to 1, and are even where a pixel
            of the mask has no depth.
        """
        asked = mask if pixels is None else pixels
        return self.probabilities_at(depth_m, mask, focal_px, np.flatnonzero(asked))

    def probabilities_at(
        self, depth_m: Float32Array, mask: BoolArray, focal_px: float, index: IntArray
    ) -> Float32Array:
        """Do as `probabilities` at (N,) pixels of the flat image, in their order."""
        image = self.prepare(depth_m, mask, focal_px)
        rows, columns = np.divmod(index, mask.shape[1])
        at = np.empty((len(index), 2), np.int32)
        at[:, 0], at[:, 1] = rows - image.top, columns - image.left
        batch = join_images([image], self.far_m)
        return predict(
            batch.depth_m,
            batch.slope_x,
            batch.slope_y,
            batch.places,
            at,
            np.array([focal_px, self.far_m, self.uses_gradients]),
            self.roots,
            self._steps,
            self._steps.view(np.int32),
            self.leaves,
        )


def _in_lines(n_nodes: int) -> Float32Array:
    """Return an empty table of steps, none of which lies across two lines of the cache.

    Where numpy puts it, every other one does, and a walk down takes a seventh longer.
    """
    n_bytes = n_nodes * N_COLUMNS * np.dtype(np.float32).itemsize
    space = np.zeros(n_bytes + LINE_BYTES, np.uint8)
    begin = -space.ctypes.data % LINE_BYTES
    return space[begin : begin + n_bytes].view(np.float32).reshape(n_nodes, N_COLUMNS)


def _rounded(values: Float32Array, steps: int) -> Float32Array:
    nearest: Float32Array = (np.rint(values * steps) / steps).astype(np.float32)
    return nearest
