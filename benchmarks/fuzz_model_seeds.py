"""Whole files of models and protocols, small enough for `benchmarks.fuzz_importers`."""

import json
import zipfile
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from adibas.forests.files import save_forest
from adibas.forests.forest import Forest
from adibas.gestures.model_file import read_model, shipped_gestures
from adibas.gestures.model_file import write_model as write_gestures
from adibas.limbs.training_set import FolderHeader
from adibas.markers.color_files import write_colors
from adibas.markers.color_model import ColorModel
from adibas.pipeline.limb_label_files import LabelFiles
from adibas.resources import resource_path
from benchmarks.fuzz_seeds import in_one


def protocol(path: Path, _variant: str) -> None:
    """Write a protocol that the program comes with."""
    path.write_bytes(resource_path("protocols", "joints-15.json").read_bytes())


def gesture_model(path: Path, _variant: str) -> None:
    """Write a tenth of a second of two examples, with all else that the shipped model has."""
    model = read_model(shipped_gestures())
    examples = tuple(one[:3] for one in model.examples[:2])
    owners = model.owners[:2]
    write_gestures(path, replace(model, method="dtw", judge=None, examples=examples, owners=owners))


LIMB_HEADER = FolderHeader(("left arm", "right arm"), 0.001, 500.0, 500.0, 7.5, 5.5, {"00000": "a"})
LIMB_SIZE = (12, 16)


def limb_folder(path: Path, _variant: str) -> None:
    """Write a folder of limbs on one depth image."""
    path.mkdir(exist_ok=True)
    labels = np.zeros(LIMB_SIZE, np.uint8)
    labels[3:9, 4:8], labels[3:9, 8:12] = 1, 2
    files = LabelFiles(path, "a.mcap", 2, LIMB_SIZE, LIMB_HEADER)
    files.keep(0, np.full(LIMB_SIZE, 2000, np.uint16), labels, is_done=True)


def names_of_markers(path: Path, _variant: str) -> None:
    """Write a table of names for markers."""
    path.write_text("marker,label\nm01,c7\nm02,t12\n", encoding="utf-8")


def forest(path: Path, _variant: str) -> None:
    """Write a tree with two leaves."""
    save_forest(
        Forest(
            ("left", "right"),
            np.array([0], np.int32),
            np.array([1, -1, -2], np.int32),
            np.zeros((3, 6), np.float32),
            np.array([[0.9, 0.1], [0.2, 0.8]], np.float32),
            10.0,
            1.0,
        ),
        path,
    )


def forest_parts(path: Path, _variant: str) -> None:
    """Write the arrays of such a forest, unpacked."""
    archive = path.with_suffix(".npz")
    forest(archive, "")
    with zipfile.ZipFile(archive) as parts:
        path.write_bytes(in_one({name: parts.read(name) for name in parts.namelist()}))


def skeleton_model(path: Path, _variant: str) -> None:
    """Write the shipped model with one prototype, without core and limbs."""
    path.write_text(json.dumps({**_small_skeleton(), "parts": None}), encoding="utf-8")


def core_and_limbs(path: Path, _variant: str) -> None:
    """Write those of the shipped model with one kind of posture, and one component of each mixture.

    See `in_a_skeleton`.
    """
    parts = _small_skeleton()["parts"]
    parts["kinds"] = parts["kinds"][:1]
    parts["core"]["kinds"] = [0]
    for part, fields in SINGLE.items():
        for field in fields:
            parts[part][field] = parts[part][field][:1]
    limbs = parts["limbs"]
    limbs["kinds"] = [[0]] * len(limbs["roots"])
    for field in SINGLE_OF_LIMBS:
        limbs[field] = [of_limb[:1] for of_limb in limbs[field]]
    path.write_text(json.dumps(parts), encoding="utf-8")


SINGLE = {
    "core": ("log_weights", "means", "covariances", "factors"),
    "stance": ("weights", "means", "covariances"),
}
SINGLE_OF_LIMBS = (
    "log_weights", "core_means", "core_factors", "means", "slopes", "factors", "outer_factors",
    "bone_means", "bone_covariances", "side_covariances", "drawn_means", "drawn_covariances",
)  # fmt: skip


def in_a_skeleton(parts: bytes) -> bytes:
    """Return a file of a skeleton model with these core and limbs, whatever they are."""
    before, after = _around_parts()
    return before + parts + after


@cache
def _around_parts() -> tuple[bytes, bytes]:
    text = json.dumps({**_small_skeleton(), "parts": "here"})
    before, _, after = text.encode().partition(b'"here"')
    return before, after


def _small_skeleton() -> dict[str, Any]:
    """Return the document of the shipped model with one prototype of each kind of points."""
    text = resource_path("models", "skeleton.json").read_text("utf-8")
    document: dict[str, Any] = json.loads(text)
    document["planes"] = dict(list(document["planes"].items())[:1])
    for model in (document["space"], *document["planes"].values()):
        model["prototypes"] = model["prototypes"][:1]
    return document


def joint_model(path: Path, _variant: str) -> None:
    """Write the shipped one."""
    path.write_bytes(resource_path("models", "joints.json").read_bytes())


def colors(path: Path, _variant: str) -> None:
    """Write colours of markers."""
    lab = np.array([[60.0, -40.0, 30.0], [55.0, -35.0, 25.0]])
    write_colors(path, ColorModel(lab, 12.0, {"clicks": 2}, lab + 10))
