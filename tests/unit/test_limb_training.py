"""Folders of labelled images, training that broke off, and the command line."""

import json

import cv2
import numpy as np
import pytest

from adibas.cli import main
from adibas.cli.limbs_evaluation import evaluation_lines
from adibas.data.limbs import FULL_BODY, UPPER_BODY
from adibas.errors import LimbError
from adibas.forests.params import ForestParams
from adibas.limbs.evaluation import Confusion
from adibas.limbs.model import CLUTTER, load_model, save_model
from adibas.limbs.training_folders import LimbFolders
from adibas.limbs.training_set import (
    DEPTH,
    HEADER,
    LABELS,
    Chosen,
    FolderHeader,
    LimbFolder,
    Mirrored,
    write_header,
    write_image,
)
from adibas.pipeline import limb_training
from adibas.pipeline.limb_evaluation import EvaluationParams, LimbEvaluation, groups_of
from adibas.pipeline.limb_pictures import limb_colors, limb_picture
from adibas.pipeline.limb_simulator import simulate_folder
from adibas.pipeline.limb_training import TrainingRequest, train_model
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.simulation.limb_frames import LimbFrames
from tests.unit.limb_folders import NAMES, fill

PARAMS = ForestParams(n_trees=2, max_depth=4, n_images=None, n_pixels=40, n_candidates=12)


@pytest.fixture
def folder(tmp_path):
    return fill(tmp_path / "set")


def test_images_come_back_in_metres(folder):
    images = LimbFolder(folder)
    depth_m, labels, focal_px = images.read(3)
    assert (len(images), images.labels, focal_px) == (10, NAMES, 100.0)
    assert images.people[:3] == ("p0", "p1", "p0")
    assert np.isnan(depth_m[labels == 0]).all()
    assert abs(float(depth_m[labels == 1].mean()) - 2.0) < 0.001
    chosen = Chosen(images, [3])
    assert len(chosen) == 1
    np.testing.assert_array_equal(chosen.read(0)[1], labels)


def test_a_mirror_shows_the_other_side(folder):
    images = LimbFolder(fill(folder.with_name("sided"), 2, ("left_hand", "right_hand")))
    both = Mirrored(images)
    assert (len(both), both.labels) == (4, images.labels)
    depth_m, labels, focal_px = images.read(1)
    np.testing.assert_array_equal(both.read(1)[1], labels)
    other_m, other, other_px = both.read(3)
    assert other_px == focal_px
    np.testing.assert_array_equal(other_m, depth_m[:, ::-1])
    np.testing.assert_array_equal(other[:, ::-1] == 1, labels == 2)
    np.testing.assert_array_equal(other[:, ::-1] == 2, labels == 1)


def test_a_folder_that_is_none_is_told_so(tmp_path):
    with pytest.raises(LimbError, match=r"no labels\.json"):
        LimbFolder(tmp_path)
    for content in ("[]", "{", '{"labels": []}', '{"labels": ["a"], "fx": "b"}'):
        (tmp_path / HEADER).write_text(content, "utf-8")
        with pytest.raises(LimbError, match="cannot be used"):
            LimbFolder(tmp_path)
    write_header(tmp_path, FolderHeader((), 0.001, 1.0, 1.0, 0.0, 0.0))
    with pytest.raises(LimbError, match="no labels, or fx"):
        LimbFolder(tmp_path)
    write_header(tmp_path, FolderHeader(NAMES, 0.001, 1.0, 1.0, 0.0, 0.0))
    with pytest.raises(LimbError, match="holds no"):
        LimbFolder(tmp_path)


def test_images_that_do_not_fit_are_named(folder):
    images = LimbFolder(folder)
    (folder / f"0000{DEPTH}").unlink()
    (folder / f"0001{DEPTH}").write_bytes(b"no picture")
    cv2.imwrite(str(folder / f"0002{DEPTH}"), np.zeros((60, 80), np.uint8))
    cv2.imwrite(str(folder / f"0003{LABELS}"), np.full((60, 80), 7, np.uint8))
    wanted = ("0000.depth.png is missing", "damaged", "Image 0002.*does not fit", "has label 7")
    for index, sentence in enumerate(wanted):
        with pytest.raises(LimbError, match=sentence):
            images.read(index)


def test_training_that_broke_off_goes_on_to_the_same_model(folder, tmp_path, monkeypatch):
    whole = TrainingRequest(tmp_path / "whole.npz", (folder,), seed=4, params=PARAMS)
    wanted = train_model(whole, lambda *_told: None)
    broken = TrainingRequest(tmp_path / "broken.npz", (folder,), seed=4, params=PARAMS)

    def stop(_step, done, _total):
        if done > PARAMS.max_depth:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train_model(broken, stop)
    assert not broken.out.exists()
    grown = []
    grow = limb_training.train_tree

    def counted(images, params, seed, *others):
        grown.append(seed[1])
        return grow(images, params, seed, *others)

    monkeypatch.setattr(limb_training, "train_tree", counted)
    found = train_model(broken, lambda *_told: None)
    assert grown == [1]
    np.testing.assert_array_equal(found.forest.nodes, wanted.forest.nodes)
    np.testing.assert_array_equal(found.forest.leaves, wanted.forest.leaves)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["broken.npz", "set", "whole.npz"]


def test_other_settings_do_not_go_on_with_a_training_that_broke_off(folder, tmp_path):
    def stop(_step, done, _total):
        if done > 0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train_model(TrainingRequest(tmp_path / "m.npz", (folder,), seed=1, params=PARAMS), stop)
    with pytest.raises(LimbError, match="other settings"):
        train_model(TrainingRequest(tmp_path / "m.npz", (folder,), seed=2, params=PARAMS), stop)


def test_a_training_that_broke_off_goes_on_with_no_other_folder_of_the_same_name(folder, tmp_path):
    def stop(_step, done, _total):
        if done > 0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train_model(TrainingRequest(tmp_path / "m.npz", (folder,), params=PARAMS), stop)
    other = fill(tmp_path / "elsewhere" / folder.name, first=100)
    with pytest.raises(LimbError, match="other settings or images"):
        train_model(
            TrainingRequest(tmp_path / "m.npz", (other,), params=PARAMS), lambda *_told: None
        )


def test_other_settings_do_not_go_on_with_images_of_another_seed(tmp_path):
    def stop(*_told):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train_model(TrainingRequest(tmp_path / "m.npz", n_frames=2, seed=1, params=PARAMS), stop)
    with pytest.raises(LimbError, match="other settings"):
        train_model(TrainingRequest(tmp_path / "m.npz", n_frames=2, seed=2, params=PARAMS), stop)


@pytest.mark.parametrize("is_simulated", [True, False])
def test_labels_that_the_images_do_not_have_are_refused_at_once(folder, tmp_path, is_simulated):
    told = []
    images = () if is_simulated else (folder,)
    request = TrainingRequest(tmp_path / "m.npz", images, "hand-6", params=PARAMS)
    with pytest.raises(LimbError, match="hand-6"):
        train_model(request, lambda *step: told.append(step))
    assert not told
    assert not list(tmp_path.glob("m.npz*"))


def test_simulating_that_broke_off_makes_what_is_missing(tmp_path):
    told = []
    made = LimbFrames(5).frame(1)
    write_image(tmp_path, "00000", made.depth_mm, made.labels)  # any: it must stay
    before = (tmp_path / f"00000{DEPTH}").read_bytes()
    simulate_folder(tmp_path, 2, 5, lambda *step: told.append(step))
    assert told == [(1, 2), (2, 2)]
    for name in ("00000", "00001"):
        assert (tmp_path / f"{name}{DEPTH}").read_bytes() == before
    images = LimbFolder(tmp_path)
    assert images.people == ("p000", "p000")
    np.testing.assert_array_equal(images.read(1)[1], made.labels)


@pytest.mark.parametrize("command", ["train", "evaluate", "evaluate a model"])
def test_images_of_nobody_with_depth_are_told_and_leave_nothing(folder, tmp_path, capsys, command):
    bare = fill(tmp_path / "bare", 6)
    for path in bare.glob(f"*{DEPTH}"):
        cv2.imwrite(str(path), np.zeros((60, 80), np.uint16))
    model = tmp_path / "model.npz"
    options = ["--trees", "1", "--depth", "3"]
    if command == "train":
        options += ["--out", str(tmp_path / "m.npz")]
    elif command == "evaluate a model":
        train_model(TrainingRequest(model, (folder,), params=PARAMS), lambda *_told: None)
        options += ["--model", str(model)]
    assert main(["limbs", command.split()[0], str(bare), *options]) == 1
    assert "Nobody with depth is in the images." in capsys.readouterr().err
    assert not list(tmp_path.glob("m.npz*"))


def test_groups_are_folds_or_people(folder):
    images = LimbFolders([folder])
    folds = groups_of(images, EvaluationParams("folds"))
    assert sorted(np.bincount(folds)) == [2, 2, 2, 2, 2]
    np.testing.assert_array_equal(groups_of(images, EvaluationParams("people")), [0, 1] * 5)


def test_the_command_trains_and_evaluates(folder, tmp_path, capsys):
    model = tmp_path / "model.npz"
    forest = ["--trees", "1", "--depth", "4", "--pixels", "40"]
    assert main(["limbs", "train", str(folder), "--out", str(model), "--json", *forest]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["labels"] == list(NAMES)
    assert document["provenance"]["n_images"] == 10
    assert load_model(model).forest.n_trees == 1
    pictures = tmp_path / "pictures"
    told = ["--model", str(model), "--pictures", str(pictures), "--json", "--smoothness", "2"]
    assert main(["limbs", "evaluate", str(folder), *told]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["protocol"] == "model"
    assert document["cut"]["mean_per_class"] > 0.9
    assert np.sum(document["cut"]["confusion"]) == 10 * (40 * 14 + 8 * 8)
    assert len(list(pictures.iterdir())) == 10


def test_the_command_leaves_people_out(folder, capsys):
    forest = ["--trees", "1", "--depth", "4", "--pixels", "40"]
    assert main(["limbs", "evaluate", str(folder), "--leave-out", "people", *forest]) == 0
    told = capsys.readouterr().out
    assert "leave-one-person-out, 2 groups, 10 images" in told
    assert "left_hand" in told


def test_people_who_are_not_named_cannot_be_left_out(folder, capsys):
    header = json.loads((folder / HEADER).read_text())
    del header["people"]["0004"]
    (folder / HEADER).write_text(json.dumps(header))
    assert main(["limbs", "evaluate", str(folder), "--leave-out", "people"]) == 1
    told = capsys.readouterr().err
    assert "does not say who is in image 0004" in told
    assert "under people" in told


def test_the_confusion_is_printed_label_by_label():
    counts = np.array([[998, 2, 0], [25, 70, 5], [0, 0, 0]])
    cut = Confusion(("torso", "left_hand", "clutter"), counts)
    lines = evaluation_lines(LimbEvaluation("model", 1, 3, cut, None, cut))
    assert lines[0] == "One model, 3 images"
    assert lines[2:5] == [
        "torso        99.8 %    99.8 %",
        "left_hand    70.0 %    70.0 %",
        "clutter         -         -",
    ]
    assert lines[-4:] == [
        "                1   2   3",
        " 1  torso     100",
        " 2  left_hand  25  70   5",
        " 3  clutter",
    ]


@pytest.mark.parametrize(
    "options",
    [
        ["--simulator", "--context", "a.npz", "--cluster", "tcp://127.0.0.1:1"],
        ["--merge", "a.npz", "--context", "b.npz"],
        ["--merge", "a.npz", "--cluster", "tcp://127.0.0.1:1"],
    ],
)
def test_options_that_would_go_unheard_are_wrong_usage(tmp_path, capsys, options):
    out = tmp_path / "model.npz"
    with pytest.raises(SystemExit) as ended:
        main(["limbs", "train", *options, "--out", str(out)])
    assert ended.value.code == 2
    assert options[-2] in capsys.readouterr().err
    assert not out.exists()


def test_a_model_of_other_labels_is_not_merged_nor_evaluated(folder, tmp_path, capsys):
    model = tmp_path / "model.npz"
    train_model(TrainingRequest(model, (folder,), params=PARAMS), lambda *_told: None)
    merge = ["limbs", "train", "--merge", str(model), "--out", str(tmp_path / "7.npz")]
    assert main(merge) == 1
    assert "full-body-15" in capsys.readouterr().err
    other = fill(tmp_path / "other", 2, ("torso", "right_hand"))
    assert main(["limbs", "evaluate", str(other), "--model", str(model)]) == 1
    assert "other labels" in capsys.readouterr().err


def test_a_model_that_knows_furniture_is_evaluated_on_images_of_limbs_alone(
    folder, tmp_path, capsys
):
    model = tmp_path / "model.npz"
    cluttered = fill(tmp_path / "cluttered", names=(*NAMES, CLUTTER))
    train_model(TrainingRequest(model, (cluttered,), params=PARAMS), lambda *_told: None)
    assert load_model(model).names == (*NAMES, CLUTTER)
    figures = []
    for images in (cluttered, folder):
        assert main(["limbs", "evaluate", str(images), "--model", str(model), "--json"]) == 0
        figures.append(json.loads(capsys.readouterr().out))
    # The same pixels, which show no furniture: the folder's labels alone differ.
    assert figures[1] == figures[0]
    assert figures[1]["labels"] == [*NAMES, CLUTTER]
    assert figures[1]["cut"]["per_class"][CLUTTER] is None
    assert figures[1]["cut"]["mean_per_class"] > 0.9


@pytest.mark.parametrize("labels", [FULL_BODY, UPPER_BODY], ids=lambda labels: labels.name)
def test_the_model_that_comes_with_the_program_is_evaluated_on_images_of_its_labels(
    tmp_path, capsys, labels
):
    images, model = fill(tmp_path / "set", 2, labels.names), tmp_path / "model.npz"
    save_model(shipped_model(labels.name), model)
    figures = []
    for which in (["--shipped"], ["--model", str(model)]):
        assert main(["limbs", "evaluate", str(images), *which, "--json"]) == 0
        figures.append(json.loads(capsys.readouterr().out))
    assert figures[0] == figures[1]
    assert figures[0]["labels"] == [*labels.names, CLUTTER]
    assert np.sum(figures[0]["cut"]["confusion"]) == 2 * (40 * 14 + 8 * 8)


def test_no_model_for_such_labels_comes_with_the_program(folder, capsys):
    assert main(["limbs", "evaluate", str(folder), "--shipped"]) == 1
    assert "other labels than the images (torso, left_hand)" in capsys.readouterr().err


def test_limbs_are_drawn_in_colours_that_differ():
    colors = limb_colors(16)
    assert len({tuple(color) for color in colors}) == 17
    depth = np.array([[np.nan, 1.0], [2.0, 3.0]])
    picture = limb_picture(depth, np.array([[0, 0], [0, 2]], np.uint8))
    assert picture.shape == (2, 2, 3)
    assert not picture[0, 0].any()
    assert picture[0, 1, 0] > picture[1, 0, 0]
    assert len(set(picture[1, 1])) > 1
    assert not limb_picture(np.full((2, 2), np.nan), np.zeros((2, 2), np.uint8)).any()
