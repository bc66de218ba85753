"""Whole files of models and protocols, small enough for `benchmarks.fuzz_importers`."""

import json
import zipfile
from dataclasses import replace
from pathlib import Path

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
    """Write the shipped model with one prototype, without its parts."""
    document = json.loads(resource_path("models", "skeleton.json").read_text("utf-8"))
    document["parts"] = None
    document["planes"] = dict(list(document["planes"].items())[:1])
    for model in (document["space"], *document["planes"].values()):
        model["prototypes"] = model["prototypes"][:1]
    path.write_text(json.dumps(document), encoding="utf-8")


def joint_model(path: Path, _variant: str) -> None:
    """Write the shipped one."""
    path.write_bytes(resource_path("models", "joints.json").read_bytes())


def colors(path: Path, _variant: str) -> None:
    """Write colours of markers."""
    lab = np.array([[60.0, -40.0, 30.0], [55.0, -35.0, 25.0]])
    write_colors(path, ColorModel(lab, 12.0, {"clicks": 2}, lab + 10))
