"""`colours.json`, and a picture of what was taken."""

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from adibas.arrays import BoolArray, UInt8Array
from adibas.errors import MarkerError
from adibas.files import written_whole
from adibas.markers.color_model import ColorModel

FORMAT = "adibas-colours"
VERSION = 1
MAX_BYTES = 1 << 20
"""More is not read; a cut document is no colour model."""
LEAST_LAB, GREATEST_LAB = (-1.0, -128.0, -128.0), (101.0, 128.0, 128.0)
"""No colour of a screen lies outside; lightness is 0 to 100, and rounding may exceed it."""
GREATEST_THRESHOLD = 400
"""More than the distance of any two colours."""
DIMMED = 0.35
"""Brightness of what was not taken, in the preview."""


def write_colors(path: Path, model: ColorModel) -> None:
    """Write `colours.json`, whole or not at all.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    text = json.dumps(colors_to_json(model), indent=1, allow_nan=False)
    with written_whole(path) as unfinished:
        unfinished.write_text(text + "\n", "utf-8")


def colors_to_json(model: ColorModel) -> dict[str, object]:
    """Return the document that `colours.json` holds."""
    document: dict[str, object] = {
        "format": FORMAT,
        "version": VERSION,
        "centroids_lab": model.centroids_lab.tolist(),
        "threshold": model.threshold,
        "source": dict(model.source),
    }
    if model.surround_lab is not None:
        document["surround_lab"] = model.surround_lab.tolist()
    return document


def read_colors(path: Path) -> ColorModel:
    """Read `colours.json`.

    Raises
    ------
    MarkerError
        The file is missing, is no colour model, or holds numbers that are no colours.
    """
    try:
        with path.open("rb") as file:
            model = colors_from_json(json.loads(file.read(MAX_BYTES)))
    except OSError as error:
        raise MarkerError(
            "{file} cannot be read: {reason}. Check the name, or learn the colours with "
            "`adibas markers learn`.",
            file=path.name,
            reason=error.strerror or str(error),
        ) from error
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError) as error:
        raise MarkerError(
            "{file} holds no learned colours. Learn them with `adibas markers learn`.",
            file=path.name,
        ) from error
    if not _is_possible(model):
        raise MarkerError(
            "{file} holds numbers that are no colours: lightness must be 0 to 100, a and b -128 to "
            "128, and the threshold at most {most}. Learn them again with `adibas markers learn`.",
            file=path.name,
            most=GREATEST_THRESHOLD,
        )
    return model


def _is_possible(model: ColorModel) -> bool:
    known = [values for values in (model.centroids_lab, model.surround_lab) if values is not None]
    colors_lab = np.concatenate(known)
    are_colors = (colors_lab >= LEAST_LAB) & (colors_lab <= GREATEST_LAB)
    return bool(are_colors.all()) and model.threshold <= GREATEST_THRESHOLD


def colors_from_json(document: object) -> ColorModel:
    """Return the colour model in the document of a `colours.json`.

    Raises
    ------
    ValueError, TypeError, KeyError, OverflowError
        It is no such document.
    """
    if not isinstance(document, Mapping) or document.get("format") != FORMAT:
        raise ValueError("another format")
    if document.get("version") != VERSION:
        raise ValueError("another version")
    source = document.get("source", {})
    surround = document.get("surround_lab")
    return ColorModel(
        np.array(document["centroids_lab"], dtype=np.float64).reshape(-1, 3),
        float(document["threshold"]),
        source if isinstance(source, Mapping) else {},
        None if surround is None else np.array(surround, dtype=np.float64).reshape(-1, 3),
    )


def preview(color_rgb: UInt8Array, taken: BoolArray) -> UInt8Array:
    """Return the picture with everything dimmed that was not taken, (H, W, 3) RGB."""
    picture = (color_rgb * np.float32(DIMMED)).astype(np.uint8)
    picture[taken] = color_rgb[taken]
    return picture
