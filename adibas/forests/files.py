"""Forests in files: arrays and a JSON header in one ``.npz``, nothing that could run.

Numbers that were rounded by `Forest.rounded` are kept as small integers, in half the space; others,
and all those of version 1, as they are.
"""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from adibas.arrays import AnyArray
from adibas.errors import FileError
from adibas.files import DAMAGED_ARRAYS, cannot_read, written_whole
from adibas.forests.forest import Forest
from adibas.forests.packing import (
    pack_child,
    pack_leaves,
    pack_nodes,
    unpack_child,
    unpack_leaves,
    unpack_nodes,
)

FORMAT, VERSION = "adibas-forest", 2
Beside = TypeVar("Beside")


def save_forest(forest: Forest, path: Path, beside: Mapping[str, AnyArray] | None = None) -> None:
    """Write a forest to `path`, and other arrays `beside` it, whole or not at all.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    header = {
        "format": FORMAT,
        "version": VERSION,
        "labels": forest.labels,
        "far_m": forest.far_m,
        "smoothing_px": forest.smoothing_px,
        "provenance": forest.provenance,
    }
    text = np.frombuffer(json.dumps(header, indent=1).encode(), np.uint8)
    with written_whole(path) as unfinished, unfinished.open("wb") as file:
        arrays: dict[str, Any] = {**_packed(forest), **(beside or {})}
        np.savez_compressed(file, header=text, roots=forest.roots, **arrays)


def _packed(forest: Forest) -> dict[str, Any]:
    arrays: dict[str, Any] = {**pack_child(forest.child)}
    nodes = pack_nodes(forest.nodes, forest.child < 0)
    arrays |= {"nodes": forest.nodes} if nodes is None else {"node_steps": nodes}
    leaves = pack_leaves(forest.leaves)
    arrays |= {"leaves": forest.leaves} if leaves is None else {"leaf_counts": leaves}
    return arrays


def load_forest(path: Path) -> Forest:
    """Read a forest.

    Raises
    ------
    FileError
        The file is missing, damaged, of another format or of a later version.
    """
    return load_forest_and(path, lambda _arrays: None)[0]


def load_forest_and(
    path: Path, read: Callable[[Mapping[str, AnyArray]], Beside]
) -> tuple[Forest, Beside]:
    """Read a forest, and what `read` makes of the arrays of its file.

    Raises
    ------
    FileError
        The file is missing, damaged, of another format or of a later version.
    """
    try:
        # NumPy leaves a damaged file open.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return _forest_of(arrays, path), read(arrays)
    except OSError as error:
        raise cannot_read(path, error) from error
    except (*DAMAGED_ARRAYS, RecursionError) as error:
        raise FileError(
            "{file} is no forest of ADiBAS, or it is damaged. Choose a file that "
            "adibas limbs train wrote.",
            file=path.name,
        ) from error


def _forest_of(arrays: Mapping[str, AnyArray], path: Path) -> Forest:
    header = json.loads(arrays["header"].tobytes())
    _check_header(header, path)
    child = arrays["child"].astype(np.int32) if "child" in arrays else unpack_child(arrays)
    is_packed = "node_steps" in arrays
    nodes = unpack_nodes(arrays["node_steps"], child < 0) if is_packed else arrays["nodes"]
    has_counts = "leaf_counts" in arrays
    leaves = unpack_leaves(arrays["leaf_counts"]) if has_counts else arrays["leaves"]
    return Forest(
        tuple(map(str, header["labels"])),
        arrays["roots"].astype(np.int32),
        child,
        nodes.astype(np.float32),
        leaves.astype(np.float32),
        float(header["far_m"]),
        float(header["smoothing_px"]),
        header["provenance"],
    )


def _check_header(header: Any, path: Path) -> None:
    if header["format"] != FORMAT:
        raise ValueError(header["format"])
    if header["version"] > VERSION:
        raise FileError(
            "{file} was written by a later ADiBAS. Update this one to read it.", file=path.name
        )
