"""Labelled images of several folders are one set, for training and for evaluation."""

import json
import shutil

import numpy as np
import pytest

from adibas.cli.command_line import main
from adibas.errors import LimbError
from adibas.forests.params import ForestParams
from adibas.limbs.model import load_model
from adibas.limbs.training_folders import LimbFolders, folders_of
from adibas.limbs.training_set import LimbFolder
from adibas.pipeline.context_training import ContextRequest, train_context_of
from adibas.pipeline.limb_training import TrainingRequest, train_model
from tests.unit.limb_folders import NAMES, fill

PARAMS = ForestParams(n_trees=2, max_depth=4, n_images=None, n_pixels=40, n_candidates=12)
FOREST = ["--trees", "1", "--depth", "4", "--pixels", "40"]


@pytest.fixture
def folders(tmp_path):
    """Two folders of the same name: ten images, and four others."""
    return fill(tmp_path / "one" / "limbs"), fill(tmp_path / "two" / "limbs", 4, first=100)


def quiet(*_told):
    pass


def test_the_images_of_folders_stand_one_behind_the_other(folders):
    parts = [LimbFolder(one) for one in folders]
    images = LimbFolders(folders)
    assert len(images) == 14
    assert images.labels == NAMES
    assert images.people == parts[0].people + parts[1].people
    assert len(set(images.names)) == 14
    assert images.names[9:11] == ("1-limbs-0009", f"2-limbs-{parts[1].names[0]}")
    for index, (part, place) in ((0, (0, 0)), (9, (0, 9)), (10, (1, 0)), (13, (1, 3))):
        for found, wanted in zip(images.read(index), parts[part].read(place), strict=True):
            np.testing.assert_array_equal(found, wanted)
    assert LimbFolders(folders[:1]).names == parts[0].names
    assert folders_of(()) is None


def test_a_folder_with_other_labels_is_told(folders, tmp_path):
    other = fill(tmp_path / "sided", 2, ("left_hand", "right_hand"))
    with pytest.raises(LimbError, match="sided has other labels than limbs"):
        LimbFolders([folders[0], other])


def test_a_folder_that_is_named_twice_is_told(folders):
    again = folders[0].parent / ".." / "one" / "limbs"
    with pytest.raises(LimbError, match="limbs is named twice"):
        LimbFolders([*folders, again])


def test_two_folders_teach_what_one_with_all_their_images_does(folders, tmp_path):
    whole = shutil.copytree(folders[0], tmp_path / "whole")
    for i, name in enumerate(LimbFolder(folders[1]).names, 10):
        for ending in (".depth.png", ".labels.png"):
            shutil.copy(folders[1] / f"{name}{ending}", whole / f"{i:04d}{ending}")
    models = [
        train_model(TrainingRequest(tmp_path / f"{i}.npz", these, params=PARAMS), quiet)
        for i, these in enumerate([folders, (whole,)])
    ]
    ours, theirs = (one.forest for one in models)
    np.testing.assert_array_equal(ours.nodes, theirs.nodes)
    np.testing.assert_array_equal(ours.leaves, theirs.leaves)
    told = ours.provenance
    assert (told["images"], told["n_images"]) == (["limbs", "limbs"], 14)
    assert told["images_sha256"] == [LimbFolder(one).sha256() for one in folders]


def test_one_folder_of_the_forest_s_own_among_others_is_refused(folders, tmp_path):
    forest = tmp_path / "forest.npz"
    train_model(TrainingRequest(forest, folders, params=PARAMS), quiet)
    new = fill(tmp_path / "new", 4, first=200)
    request = ContextRequest(forest, tmp_path / "model.npz", (new, folders[1]))
    with pytest.raises(LimbError, match="trained on these images"):
        train_context_of(request, quiet)


def test_the_commands_take_several_folders(folders, tmp_path, capsys):
    model = tmp_path / "model.npz"
    both = [str(one) for one in folders]
    assert main(["limbs", "train", *both, "--out", str(model), *FOREST]) == 0
    assert load_model(model).forest.provenance["n_images"] == 14
    pictures = tmp_path / "pictures"
    wanted = ["--model", str(model), "--pictures", str(pictures), "--json"]
    capsys.readouterr()
    assert main(["limbs", "evaluate", *both, *wanted]) == 0
    assert json.loads(capsys.readouterr().out)["n_images"] == 14
    assert len(list(pictures.iterdir())) == 14
    assert main(["limbs", "evaluate", *both, "--leave-out", "people", *FOREST]) == 0
    assert "2 groups, 14 images" in capsys.readouterr().out


def test_without_images_the_usage_is_told(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["limbs", "train", "--out", str(tmp_path / "model.npz")])
    assert ended.value.code == 2
    assert "FOLDER" in capsys.readouterr().err


def test_folders_and_the_simulator_are_not_learned_from_together(folders, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["limbs", "train", str(folders[0]), "--simulator", "--out", str(tmp_path / "m.npz")])
    assert ended.value.code == 2
    assert "--simulator" in capsys.readouterr().err
