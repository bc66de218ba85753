"""Limbs in recordings of the simulated clinic, with the shipped models."""

import json
from dataclasses import asdict, replace
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest

from adibas.cli import limbs, main
from adibas.cli.command_line import build_parser
from adibas.context.training import ContextTraining
from adibas.data.calibration import DepthBias
from adibas.data.frames import depth_in_metres
from adibas.data.limbs import FULL_BODY, UPPER_BODY
from adibas.limbs.segmentation import LimbParams
from adibas.limbs.training_set import LimbFolder
from adibas.pipeline.limb_labelling import LabellingDesk
from adibas.pipeline.limb_segmenting import PICTURE
from adibas.pipeline.limb_training import SHIPPED, SHIPPED_FRAMES
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.recordings import create_recording, open_recording
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
    assert "none.mcap has 2 frames, so frames 7:9 cannot be read" in capsys.readouterr().err


def segment(video, out, *options):
    return main(["limbs", "segment", str(video), "--out", str(out), *options])


def label_by_hand(video, out, *, is_done):
    """Label the first frame as no model does; return the labels."""
    with open_recording(video) as recording:
        desk = LabellingDesk(recording, video.name, out)
        frame = desk.frame(0)
        labels = np.where(frame.mask, 3, 0).astype(np.uint8)
        desk.files.keep(0, frame.depth_raw, labels, is_done=is_done)
    return labels


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def changed(out, n_frames):
    """Shares of pixels, of a person in two frames that follow, whose label is another one."""
    images = LimbFolder(out)
    labels = [images.read(index)[1] for index in range(n_frames)]
    pairs = [(a, b, (a > 0) & (b > 0)) for a, b in pairwise(labels)]
    return [(a != b)[both].mean() for a, b, both in pairs]


def test_labels_tied_over_time_change_less_from_frame_to_frame(tmp_path, capsys):
    video, n_frames = tmp_path / "still.mcap", 4
    scene = open_scene("standing", seed=3, has_color=False, is_swaying=False, distance_m=2.7)
    with create_recording(video, scene.info) as writer:
        for index in range(n_frames):
            writer.write(scene.frame(index).sensor_frame)
    assert segment(video, tmp_path / "free") == 0
    assert segment(video, tmp_path / "tied", "--over-time", "1") == 0
    free, tied = (changed(tmp_path / name, n_frames) for name in ("free", "tied"))
    assert all(after < before for before, after in zip(free, tied, strict=True))
    first = [LimbFolder(tmp_path / name).read(0)[1] for name in ("free", "tied")]
    np.testing.assert_array_equal(*first)
    with pytest.raises(SystemExit):
        segment(video, tmp_path / "none", "--over-time", "1", "--cut", "none")
    assert "leave --cut none out" in capsys.readouterr().err


@pytest.mark.parametrize("is_done", [True, False])
def test_labels_made_by_hand_outlive_segmenting(tmp_path, capsys, is_done):
    video, out = tmp_path / "one.mcap", tmp_path / "one-limbs"
    record(video, "standing")
    label_by_hand(video, out, is_done=is_done)
    before = contents(out)
    assert segment(video, out, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["n_frames"], told["n_with_person"], told["n_labelled_before"]) == (1, 1, 1)
    after = contents(out)
    assert before == {name: after[name] for name in before}
    assert not [name for name in after.keys() - before.keys() if not name.startswith("00001.")]


def test_a_folder_with_other_labels_than_the_model_is_not_touched(tmp_path, capsys):
    video, out = tmp_path / "one.mcap", tmp_path / "one-limbs"
    record(video, "standing")
    label_by_hand(video, out, is_done=True)
    before = contents(out)
    assert segment(video, out, "--labels", UPPER_BODY.name) == 1
    assert "one-limbs holds images with other labels than the model" in capsys.readouterr().err
    assert contents(out) == before


def test_segmenting_again_goes_on_in_its_own_folder_and_in_no_other_recording_s(tmp_path, capsys):
    video, out = tmp_path / "one.mcap", tmp_path / "limbs"
    record(video, "standing")
    assert segment(video, out, "--frames", "0:1") == 0
    first = contents(out)
    assert segment(video, out) == 0
    assert "1 frame was labelled before and stays as it is." in capsys.readouterr().out
    both = contents(out)
    assert first == {name: both[name] for name in first}
    assert len(LimbFolder(out)) == 2
    assert segment(video.rename(tmp_path / "two.mcap"), out) == 1
    assert "limbs holds labels of one.mcap" in capsys.readouterr().err
    assert contents(out) == both


def test_limbs_are_found_in_corrected_depth_and_depth_is_kept_as_it_came(tmp_path):
    scene = open_scene("standing", seed=3, color_size=(480, 640), distance_m=2.7)
    frame, info = scene.frame(0), scene.info
    raw = frame.sensor_frame.depth_raw
    true_m = info.calibration.corrected_depth(depth_in_metres(raw, info.depth_unit_m))
    short = np.nan_to_num(true_m / 1.02 / info.depth_unit_m).round().astype(np.uint16)
    erring = replace(info.calibration, depth_bias=DepthBias(b=1.02))
    with create_recording(tmp_path / "one.mcap", replace(info, calibration=erring)) as writer:
        writer.write(replace(frame.sensor_frame, depth_raw=short))
    assert segment(tmp_path / "one.mcap", tmp_path / "limbs") == 0
    depth_m, labels, _ = LimbFolder(tmp_path / "limbs").read(0)
    truth = frame.truth.labels
    assert np.count_nonzero(labels[truth > 0]) > 0.95 * np.count_nonzero(truth)
    assert np.count_nonzero(truth[labels > 0] == 0) < 0.02 * np.count_nonzero(labels)
    np.testing.assert_array_equal(depth_m, depth_in_metres(short, info.depth_unit_m))
