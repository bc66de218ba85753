"""Forests in files: arrays and a JSON header in one ``.npz``, nothing that could run."""

import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from adibas.arrays import AnyArray
from adibas.errors import FileError
from adibas.files import cannot_read, written_whole
from adibas.forests.forest import Forest

FORMAT, VERSION = "adibas-forest", 1
_ARRAYS = ("roots", "child", "nodes", "leaves")


def save_forest(forest: Forest, path: Path) -> None:
    """Write a forest to `path`, whole or not at all.

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
    arrays = {name: getattr(forest, name) for name in _ARRAYS}
    with written_whole(path) as unfinished, unfinished.open("wb") as file:
        np.savez_compressed(file, header=text, **arrays)


def load_forest(path: Path) -> Forest:
    """Read a forest.

    Raises
    ------
    FileError
        The file is missing, damaged, of another format or of a later version.
    """
    try:
        # NumPy leaves a damaged file open.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return _forest_of(arrays, path)
    except OSError as error:
        raise cannot_read(path, error) from error
    except (ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise FileError(
            "{file} is no forest of ADiBAS, or it is damaged. Choose a file that "
            "adibas limbs train wrote.",
            file=path.name,
        ) from error


def _forest_of(arrays: Mapping[str, AnyArray], path: Path) -> Forest:
    header = json.loads(arrays["header"].tobytes())
    _check_header(header, path)
    return Forest(
        tuple(map(str, header["labels"])),
        arrays["roots"].astype(np.int32),
        arrays["child"].astype(np.int32),
        arrays["nodes"].astype(np.float32),
        arrays["leaves"].astype(np.float32),
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
