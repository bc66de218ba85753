"""Limbs of a simulated patient proposed by the command, and corrected on the desk."""

import json

import numpy as np
import pytest

from adibas.cli import main
from adibas.data.limbs import FULL_BODY, UPPER_BODY
from adibas.errors import LimbError
from adibas.limbs.training_set import LimbFolder, read_header, write_header
from adibas.pipeline.limb_label_files import LabellingProgress
from adibas.pipeline.limb_labelling import DeskSetup, LabellingDesk
from adibas.pipeline.limb_names import limb_text, painting_colors
from adibas.recordings import create_recording, open_recording
from adibas.simulation.scenes import open_scene


@pytest.fixture(scope="module")
def scene():
    return open_scene("clap", seed=3, color_size=(480, 640), distance_m=2.7)


@pytest.fixture(scope="module")
def video(scene, tmp_path_factory):
    path = tmp_path_factory.mktemp("video") / "clap.mcap"
    with create_recording(path, scene.info) as writer:
        for index in (40, 42):
            writer.write(scene.frame(index).sensor_frame)
    return path


def share_right(labels, frame, truth):
    known = frame.mask & np.isfinite(frame.depth_m) & (truth > 0)
    return np.mean(labels[known] == truth[known])


def test_proposals_are_nearly_right_and_wait_for_somebody_to_look(video, scene, tmp_path, capsys):
    out = tmp_path / "limbs"
    command = ["limbs", "propose", str(video), "--out", str(out), "--json"]
    assert main([*command, "--frames", "0:1"]) == 0
    assert json.loads(capsys.readouterr().out)["n_proposed"] == 1
    with pytest.raises(LimbError, match=r"no NNNN\.labels\.png"):
        LimbFolder(out)
    with open_recording(video) as recording:
        desk = LabellingDesk(recording, video.name, out)
        assert desk.files.progress == LabellingProgress(2, frozenset(), frozenset({0}))
        frame, after = desk.frame(0), desk.frame(1)
        labels = desk.files.kept(0)
        truths = [scene.frame(index).truth.labels for index in (40, 42)]
        assert share_right(labels, frame, truths[0]) > 0.9
        carried = desk.carried(frame, labels, after)
        assert share_right(carried, after, truths[1]) > share_right(labels, after, truths[1])
        desk.files.keep(0, frame.depth_raw, labels, is_done=True)
        assert desk.files.progress.done == {0}
        assert desk.files.progress.next_open(0) == 1
    assert main([*command, "--done"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["n_labelled_before"], told["n_proposed"]) == (1, 1)
    images = LimbFolder(out)
    assert (len(images), images.labels) == (2, FULL_BODY.names)
    np.testing.assert_array_equal(images.read(0)[1], labels)


def test_the_seven_labels_are_the_fifteen_merged_and_others_cannot_be_proposed(video, tmp_path):
    with open_recording(video) as recording:
        desks = [
            LabellingDesk(recording, video.name, tmp_path / labels.name, DeskSetup(labels=labels))
            for labels in (FULL_BODY, UPPER_BODY)
        ]
        frame = desks[0].frame(0)
        full, upper = (desk.proposed(frame) for desk in desks)
        arms = [name for name in UPPER_BODY.names if name != "torso"]
        for name in arms:
            same = (full == 1 + FULL_BODY.names.index(name)) == (
                upper == 1 + UPPER_BODY.names.index(name)
            )
            assert same.all()
        assert ((full > 0) == (upper > 0)).all()
        desks[0].files.keep(0, frame.depth_raw, full, is_done=False)
        header = read_header(desks[0].files.folder)
        write_header(desks[0].files.folder, type(header)(("paw", "tail"), *_optics(header)))
        desk = LabellingDesk(recording, video.name, desks[0].files.folder)
        assert desk.files.labels.names == ("paw", "tail")
        with pytest.raises(LimbError, match="not those of a body"):
            desk.proposed(frame)
        write_header(desks[0].files.folder, type(header)(header.labels, 0.001, 1.0, 1.0, 0.0, 0.0))
        with pytest.raises(LimbError, match="another camera"):
            LabellingDesk(recording, video.name, desks[0].files.folder)


def _optics(header):
    return header.depth_unit_m, header.fx, header.fy, header.cx, header.cy


def test_neighbouring_limbs_and_the_two_sides_are_painted_differently():
    colors = painting_colors(FULL_BODY.names).astype(int)
    assert len(np.unique(colors, axis=0)) == 16
    for name in FULL_BODY.names:
        if name.startswith("left_"):
            sides = [1 + FULL_BODY.names.index(one) for one in (name, f"right_{name[5:]}")]
            light, dark = colors[sides].sum(axis=1)
            assert light > 1.5 * dark
    assert limb_text("left_hand") == "Left hand"
    assert limb_text("paw") == "paw"
