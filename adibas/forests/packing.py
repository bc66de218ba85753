"""Arrays of a forest as small integers, byte by byte, which a file compresses to half the space.

Nothing is lost: what does not come back to the last bit stays as it is.
"""

from collections.abc import Mapping

import numpy as np

from adibas.arrays import AnyArray, Float32Array, Int32Array, UInt8Array

OFFSET_STEPS_PER_M, THRESHOLD_STEPS, LEAF_STEPS = 1024, 8192, 128
"""To which numbers of a forest are rounded; powers of two, so that a float holds each step."""

NODE_STEPS = np.array([1, *[OFFSET_STEPS_PER_M] * 4, THRESHOLD_STEPS], np.float32)
"""Of the columns of `Forest.nodes`."""


def pack_child(child: Int32Array) -> dict[str, AnyArray]:
    """Return (M,) links as what each adds to the one before it of its kind, split or leaf."""
    is_leaf = child < 0
    return {
        "is_leaf": np.packbits(is_leaf),
        "split_links": np.diff(child[~is_leaf], prepend=np.int32(0)),
        "leaf_links": np.diff(child[is_leaf], prepend=np.int32(0)),
    }


def unpack_child(arrays: Mapping[str, AnyArray]) -> Int32Array:
    """Return (M,) links as they were before `pack_child`."""
    splits, leaves = arrays["split_links"], arrays["leaf_links"]
    is_leaf = np.unpackbits(arrays["is_leaf"], count=len(splits) + len(leaves)) > 0
    child = np.empty(len(is_leaf), np.int32)
    child[~is_leaf] = np.cumsum(splits, dtype=np.int32)
    child[is_leaf] = np.cumsum(leaves, dtype=np.int32)
    return child


def pack_nodes(nodes: Float32Array, is_leaf: AnyArray) -> UInt8Array | None:
    """Return (M, 6) nodes as (bytes, 6, splits) steps; None where they are no whole steps."""
    steps = np.asarray(np.rint(nodes[~is_leaf] * NODE_STEPS).T, np.int64)
    packed = _split(steps)
    same = packed is not None and np.array_equal(unpack_nodes(packed, is_leaf), nodes)
    return packed if same else None


def unpack_nodes(packed: UInt8Array, is_leaf: AnyArray) -> Float32Array:
    """Return (M, 6) nodes; leaves have zeros."""
    nodes = np.zeros((len(is_leaf), len(NODE_STEPS)), np.float32)
    nodes[~is_leaf] = _joined(packed).T / NODE_STEPS
    return nodes


def pack_leaves(leaves: Float32Array) -> UInt8Array | None:
    """Return (F, L) probabilities as (bytes, L, F) counts; None where they are no shares of such.

    Rounding makes the counts of a leaf add up to something near `LEAF_STEPS`: half a count a label.
    """
    counts = np.zeros(leaves.shape, np.int64)
    is_open = np.ones(len(leaves), np.bool_)
    off = leaves.shape[1] // 2 + 1
    for total in sorted(range(LEAF_STEPS - off, LEAF_STEPS + off + 1), key=_from_steps):
        counts[is_open] = np.rint(leaves[is_open] * np.float32(total))
        is_open[is_open] = (_shares(counts[is_open]) != leaves[is_open]).any(axis=1)
    return None if is_open.any() else _split(counts.T)


def unpack_leaves(packed: UInt8Array) -> Float32Array:
    """Return (F, L) probabilities."""
    return _shares(np.ascontiguousarray(_joined(packed).T))


def _from_steps(total: int) -> int:
    return abs(total - LEAF_STEPS)


def _shares(counts: AnyArray) -> Float32Array:
    totals = np.maximum(counts.sum(axis=1, keepdims=True), 1)
    return np.asarray(counts.astype(np.float32) / totals.astype(np.float32))


def _split(values: AnyArray) -> UInt8Array | None:
    """Return the two bytes of each number apart; None where one does not fit."""
    limits = np.iinfo(np.int16)
    if values.size and not (limits.min <= values.min() and values.max() <= limits.max):
        return None
    small = np.ascontiguousarray(values, np.dtype("<i2"))
    return np.stack([small & 0xFF, small >> 8 & 0xFF]).astype(np.uint8)


def _joined(packed: UInt8Array) -> AnyArray:
    low, high = packed
    return np.asarray(low.astype(np.int16) | high.astype(np.int16) << 8)
