"""What was learned about joints: how far behind the surface they lie, and how long bones are.

``resources/models/joints.json`` is made by `adibas.pipeline.pose_training`.
"""

import functools
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from adibas.errors import FileError
from adibas.files import DAMAGED_JSON, check_document, written_whole
from adibas.limbs.facing import Facing
from adibas.limbs.joint_offsets import JointOffsets, offsets_from_json, offsets_to_json
from adibas.limbs.model import LimbModel
from adibas.pipeline.facing_file import shipped_facing
from adibas.pipeline.reliability_file import shipped_reliability
from adibas.resources import resource_path
from adibas.skeleton.proportions import (
    Proportions,
    proportions_from_json,
    proportions_to_json,
)
from adibas.skeleton.reliability import Reliability

FORMAT, VERSION = "adibas-joints", 1


@dataclass(frozen=True, slots=True)
class JointModel:
    """What is needed beside a model of limbs to find joints.

    Attributes
    ----------
    offsets : JointOffsets
    proportions : Proportions
    reliability : Reliability or None
        Makes shares of right joints out of confidences; None: they stay as they are.
    facing : Facing or None
        Tells front from back; None: labels and places alone do.
    """

    offsets: JointOffsets
    proportions: Proportions
    reliability: Reliability | None = None
    facing: Facing | None = None


def write_joint_model(path: Path, model: JointModel, provenance: Mapping[str, object]) -> None:
    """Write the model and what it was learned from.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    document = {
        "format": FORMAT,
        "version": VERSION,
        "offsets": offsets_to_json(model.offsets),
        "proportions": proportions_to_json(model.proportions),
        "provenance": dict(provenance),
    }
    with written_whole(path) as unfinished:
        unfinished.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def read_joint_model(path: Path) -> JointModel:
    """Read a model.

    Raises
    ------
    FileError
        It is missing or broken.
    """
    try:
        return _model_of(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, KeyError, TypeError, AttributeError, *DAMAGED_JSON) as error:
        raise FileError(
            "{file} is no model of joints, or is broken. Install the program again.",
            file=path.name,
        ) from error


def _model_of(document: Mapping[str, Any]) -> JointModel:
    check_document(document, FORMAT, VERSION)
    return JointModel(
        offsets_from_json(document["offsets"]), proportions_from_json(document["proportions"])
    )


@functools.cache
def shipped_joint_model() -> JointModel:
    """Return the model that is part of the program; it is read once."""
    model = read_joint_model(resource_path("models", "joints.json"))
    return replace(model, facing=shipped_facing())


def joint_model_for(model: LimbModel) -> JointModel:
    """Return what finds joints with a model of limbs.

    How reliable joints are was counted for the shipped model of limbs alone; with another one
    confidences stay as they are.
    """
    reliability = shipped_reliability()
    is_counted = model.is_made(reliability.provenance.get("limbs_created_utc"))
    return replace(shipped_joint_model(), reliability=reliability if is_counted else None)
