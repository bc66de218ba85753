"""Limbs in recordings of the simulated clinic, with the shipped models."""

import json
from dataclasses import asdict
from pathlib import Path

import cv2
import numpy as np
import pytest

from adibas.cli import limbs, main
from adibas.cli.command_line import build_parser
from adibas.context.training import ContextTraining
from adibas.data.limbs import FULL_BODY, UPPER_BODY
from adibas.limbs.segmentation import LimbParams
from adibas.limbs.training_set import LimbFolder
from adibas.pipeline.limb_segmenting import PICTURE, shipped_model
from adibas.pipeline.limb_training import SHIPPED, SHIPPED_FRAMES
from adibas.recordings import create_recording
from adibas.simulation.scenes import open_scene

ROOT = Path(__file__).parents[2]


def record(path, scene):
    opened = open_scene(scene, seed=3, color_size=(480, 640), distance_m=2.7)
    with create_recording(path, opened.info) as writer:
        for index in (0, 20):
            writer.write(opened.frame(index).sensor_frame)
    return opened


@pytest.mark.parametrize("labels", [FULL_BODY, UPPER_BODY])
def test_the_shipped_models_have_the_labels_of_their_names(labels):
    model = shipped_model(labels.name)
    assert model.labels is labels
    assert model.has_clutter
    assert model.forest.provenance["images"] == "simulator"


@pytest.mark.parametrize("labels", [FULL_BODY, UPPER_BODY])
def test_the_command_makes_the_shipped_models_again_if_nothing_is_said(labels):
    provenance = shipped_model(labels.name).forest.provenance
    assert provenance["params"] == asdict(SHIPPED)
    assert (provenance["n_images"], provenance["mirrored"]) == (SHIPPED_FRAMES, True)
    forest = (SHIPPED.n_trees, SHIPPED.max_depth, SHIPPED.n_pixels)
    assert (SHIPPED_FRAMES, forest) == (limbs.N_FRAMES, limbs.SHIPPED_FOREST)


@pytest.mark.parametrize("labels", [FULL_BODY, UPPER_BODY])
def test_make_train_gives_the_network_of_the_shipped_models(labels):
    model = shipped_model(labels.name)
    learned = model.forest.provenance["context"]
    params = json.loads(json.dumps(asdict(ContextTraining())))
    assert (learned["params"], learned["images"]) == (params, "simulator")
    assert model.context.shape.widths == tuple(params["widths"])
    told = f"--seed {learned['seed']} --frames {learned['n_images']}"
    assert told in (ROOT / "Makefile").read_text("utf-8")
    assert learned["seed"] != model.forest.provenance["seed"], "images that the forest has not seen"


@pytest.mark.parametrize("action", ["segment", "evaluate"])
def test_the_command_cuts_as_the_live_picture_does_if_nothing_is_said(action):
    arguments = ["limbs", action, "some", *["--out", "folder"] * (action == "segment")]
    told = build_parser().parse_args(arguments)
    assert (told.cut, told.smoothness) == (LimbParams().cut, LimbParams().smoothness)


def test_the_limbs_of_a_patient_are_written_as_pictures_and_as_images_to_train_on(tmp_path, capsys):
    scene = record(tmp_path / "one.mcap", "standing")
    out = tmp_path / "limbs"
    assert main(["limbs", "segment", str(tmp_path / "one.mcap"), "--out", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["n_with_person"] == 2
    images = LimbFolder(out)
    assert images.labels == FULL_BODY.names
    assert len(images) == 2
    depth_m, labels, _ = images.read(0)
    frame = scene.frame(0)
    assert depth_m.shape == labels.shape == frame.truth.labels.shape
    truth = frame.truth.labels
    both = (truth > 0) & (labels > 0)
    assert both.sum() > 0.8 * np.count_nonzero(truth)
    assert (truth[both] == labels[both]).mean() > 0.7
    picture = cv2.imread(str(out / f"00000{PICTURE}"))
    assert picture.shape == (480, 640, 3)
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 50


def test_an_empty_room_gives_no_limbs_and_a_word(tmp_path, capsys):
    record(tmp_path / "none.mcap", "empty")
    out = tmp_path / "limbs"
    assert main(["limbs", "segment", str(tmp_path / "none.mcap"), "--out", str(out)]) == 0
    told = capsys.readouterr()
    assert "limbs in 0 of 2 frames" in told.out
    assert "Nobody is seen" in told.err
    wrong = ["limbs", "segment", str(tmp_path / "none.mcap"), "--frames", "7:9"]
    assert main([*wrong, "--out", str(out)]) == 1
    assert "no such frames" in capsys.readouterr().err
