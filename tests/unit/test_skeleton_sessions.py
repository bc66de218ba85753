"""The clinic's own corrected captures become a model, held against what it replaces."""

import json
from dataclasses import replace

import numpy as np
import pytest

from adibas.cli.command_line import main
from adibas.data.corrections import (
    CorrectionHistory,
    FreeMeasure,
    MarkerCorrection,
    MeasureCorrection,
)
from adibas.data.markers import AutomaticName
from adibas.data.protocols import Landmark, Protocol, Wording
from adibas.data.views import VIEWS
from adibas.errors import FileError, ProtocolError
from adibas.measures.protocol_store import find_protocol
from adibas.pipeline.namers import namer_of, own_model_path
from adibas.pipeline.skeleton_examples import LandmarkSet, corrected_sets, examples_of, landmark_set
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_sessions import HeldOut, train_from_sessions
from tests.unit.name_samples import PLACES, add_example, add_examples
from tests.unit.store_samples import IDENTITY, PASSPHRASE, add_session, open_sample


@pytest.fixture
def folder(tmp_path):
    with open_sample(tmp_path / "store") as store:
        add_examples(store, 12)
    return tmp_path / "store"


def quiet(_done, _all):
    pass


def test_only_captures_that_were_corrected_are_examples(folder):
    with open_sample(folder) as store:
        ((which, captures),) = corrected_sets(store).items()
        examples = examples_of(store, which, captures, quiet)
    assert which == LandmarkSet()
    assert len(examples) == 12
    for example in examples:
        assert set(example.points.labels) == set(PLACES)
        assert example.points.view == "anterior"


def test_a_measure_that_was_asked_for_is_no_correction_of_names(tmp_path):
    measure = MeasureCorrection(None, FreeMeasure(("m01", "m02")))
    with open_sample(tmp_path) as store:
        rng = np.random.default_rng(0)
        capture = add_example(store, add_session(store), rng, is_corrected=False)
        store.captures.correct(capture.capture_id, CorrectionHistory((measure,), 1))
        assert store.captures.corrected() == ()


def test_names_that_a_model_gave_are_no_examples_until_a_hand_corrects_one(tmp_path):
    with open_sample(tmp_path) as store:
        rng = np.random.default_rng(0)
        capture = add_example(store, add_session(store), rng, is_corrected=False)
        one, other = capture.detected[:2]
        named = replace(one, label="neck", named_by=AutomaticName("shipped, 2024-01-01", 0.98))
        by_model = CorrectionHistory().after(MarkerCorrection(one, named))
        store.captures.correct(capture.capture_id, by_model)
        assert store.captures.corrected() == ()
        by_hand = by_model.after(MarkerCorrection(other, replace(other, label="head")))
        store.captures.correct(capture.capture_id, by_hand)
        assert len(store.captures.corrected()) == 1


def test_what_was_undone_or_is_hidden_is_no_example(tmp_path):
    with open_sample(tmp_path) as store:
        session = add_examples(store, 3)
        first, second, _third = store.captures.corrected()
        history = store.captures.get(first.capture_id).history
        store.captures.correct(first.capture_id, CorrectionHistory(history.corrections, 0))
        store.captures.delete(second.capture_id)
        (left,) = store.captures.corrected()
        assert (left.session_id, left.patient) == (session.session_id, session.patient)
        store.patients.delete(session.patient)
        assert store.captures.corrected() == ()


SIDE = {
    "shoulder": (0.18, -0.4, 2.0),
    "elbow": (0.24, -0.1, 2.02),
    "hand": (0.26, 0.15, 1.95),
    "hip": (0.1, 0.1, 2.0),
    "knee": (0.11, 0.5, 1.98),
    "foot": (0.12, 0.9, 2.03),
}
JOINTS = {
    "head": (0.0, -0.7, 1.98),
    "neck": (0.0, -0.48, 2.0),
    "torso": (0.0, -0.15, 2.0),
    **{f"left_{name}": place for name, place in SIDE.items()},
    **{f"right_{name}": (-x, y, z) for name, (x, y, z) in SIDE.items()},
}
TRUNK = {
    "right_acromion": (-0.2, -0.4, 2.0),
    "sternal_notch": (0.0, -0.35, 1.9),
    "LEFT ASIS": (0.14, 0.1, 1.95),
    "right asis": (-0.14, 0.1, 1.95),
    "somewhere": (0.0, 0.4, 2.0),
}


def test_each_view_that_marks_other_places_is_learned_by_itself(tmp_path):
    with open_sample(tmp_path) as store:
        add_examples(store, 10, places=TRUNK, protocol="sapo-1")
        add_examples(store, 2, places=TRUNK, protocol="sapo-1", view="posterior")
        add_examples(store, 1, places=TRUNK, protocol="sapo-1", view="")
        add_examples(store, 1, places=TRUNK, protocol="lost")
        found = {which: len(captures) for which, captures in corrected_sets(store).items()}
        front = LandmarkSet("sapo-1", "anterior")
        assert found == {LandmarkSet("lost"): 1, front: 10, LandmarkSet("sapo-1", "posterior"): 2}
        model, held_out = train_from_sessions(store, quiet, front)
        assert held_out.wrong == 0
        assert held_out.shipped_right is None
        ids = {"right_acromion", "sternal_notch", "left_asis", "right_asis"}
        assert set(model.names) == ids
        assert train_from_sessions(store, quiet)[0].names == model.names  # the one with enough
        with pytest.raises(FileError, match="There are 2 captures"):
            train_from_sessions(store, quiet, LandmarkSet("sapo-1", "posterior"))


def test_of_several_sets_with_enough_captures_one_must_be_chosen(tmp_path):
    with open_sample(tmp_path) as store:
        add_examples(store, 10)
        add_examples(store, 10, places=JOINTS, protocol="joints-15")
        with pytest.raises(FileError, match=r"joints-15\. Choose one with --protocol"):
            train_from_sessions(store, quiet)
    secret, out = tmp_path / "secret.txt", tmp_path / "model.json"
    secret.write_text(PASSPHRASE + "\n")
    command = ["skeleton", "train", "--sessions", "--protocol", "joints-15", "--view", "anterior"]
    command += ["--store", str(tmp_path), "--passphrase-file", str(secret), "--out", str(out)]
    assert main(command) == 0
    assert json.loads(out.read_text())["provenance"]["protocol"] == "joints-15"


def test_captures_that_show_a_part_of_the_joints_make_no_model_of_joints(tmp_path):
    with open_sample(tmp_path) as store:
        places = {name: place for name, place in JOINTS.items() if "foot" not in name}
        add_examples(store, 10, places=places, protocol="joints-15")
        with pytest.raises(FileError, match="0 show all of these 15 landmarks"):
            train_from_sessions(store, quiet)


def test_a_view_is_asked_for_where_it_makes_a_difference():
    assert landmark_set("joints-15", "anterior") == LandmarkSet("joints-15")
    assert landmark_set("sapo-1", "anterior") == LandmarkSet("sapo-1", "anterior")
    with pytest.raises(ProtocolError, match="Choose one with --view"):
        landmark_set("sapo-1", "")


def test_a_model_of_sessions_says_what_it_knows_and_how_well(folder):
    with open_sample(folder) as store:
        model, held_out = train_from_sessions(store, quiet)
    assert model.names == tuple(sorted(PLACES))
    assert held_out.n_examples == 12
    assert held_out.wrong == 0
    assert not held_out.is_worse
    assert model.provenance["n_captures"] == 12
    assert model.provenance["n_patients"] == 1
    assert IDENTITY.name not in json.dumps(dict(model.provenance))


def test_too_few_corrected_captures_make_no_model(tmp_path):
    with open_sample(tmp_path) as store:
        add_example(store, add_session(store), np.random.default_rng(0))
        with pytest.raises(FileError, match="1 captures with corrected names"):
            train_from_sessions(store, quiet)


@pytest.mark.parametrize(
    ("right", "wrong", "is_worse"), [(9, 1, False), (8, 0, True), (10, 2, True), (10, 0, False)]
)
def test_fewer_right_or_more_wrong_than_the_shipped_model_is_worse(right, wrong, is_worse):
    assert HeldOut(12, right, wrong, 9, 1).is_worse is is_worse


def test_where_nobody_else_names_them_more_wrong_than_right_is_refused():
    HeldOut(10, 4, 4, None, None).check()
    with pytest.raises(FileError, match="3 right and 4 with a mistake"):
        HeldOut(10, 3, 4, None, None).check()
    with pytest.raises(FileError, match="shipped model names these captures better: 9 of 10"):
        HeldOut(10, 8, 0, 9, 0).check()


def test_the_command_learns_from_the_store(folder, tmp_path, capsys):
    secret, out = tmp_path / "secret.txt", tmp_path / "model.json"
    secret.write_text(PASSPHRASE + "\n")
    command = ["skeleton", "train", "--sessions", "--store", str(folder)]
    command += ["--passphrase-file", str(secret), "--out", str(out), "--json"]
    assert main(command) == 0
    assert json.loads(capsys.readouterr().out)["provenance"]["held_out"]["n_examples"] == 12
    assert out.exists()


def protocol_of(*names):
    landmarks = tuple(Landmark(name, Wording({"en": name.title()}), VIEWS) for name in names)
    return Protocol("own", Wording({"en": "Own"}), "made up", "1", landmarks, (), ())


def test_a_model_that_is_to_be_used_names_markers_where_the_protocol_has_its_landmarks(
    folder, tmp_path, monkeypatch
):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    secret, out = tmp_path / "secret.txt", tmp_path / "model.json"
    secret.write_text(PASSPHRASE + "\n")
    assert namer_of(protocol_of(*PLACES)) is None
    command = ["skeleton", "train", "--sessions", "--store", str(folder), "--use"]
    assert main([*command, "--passphrase-file", str(secret), "--out", str(out)]) == 0
    namer = namer_of(protocol_of(*PLACES, "another"))
    assert namer.names == tuple(sorted(PLACES))
    places_m = np.array(list(PLACES.values()))
    assert namer.label(places_m, "anterior").names == tuple(PLACES)
    assert namer_of(protocol_of("chin", "navel")) is None  # would name places that it lacks
    assert namer_of(find_protocol("joints-15")) is shipped_namer()


def test_an_own_model_that_is_damaged_is_left_aside(tmp_path, monkeypatch, caplog):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    own_model_path().parent.mkdir(parents=True)
    own_model_path().write_text("{")
    assert namer_of(find_protocol("joints-15")) is shipped_namer()
    assert "left aside" in caplog.text


def test_one_source_must_be_given(tmp_path, capsys):
    out = str(tmp_path / "model.json")
    assert main(["skeleton", "train", "--sessions", "--simulator", "--out", out]) == 1
    assert "one of them" in capsys.readouterr().err
    assert main(["skeleton", "train", "--simulator", "--view", "anterior", "--out", out]) == 1
    assert "Give --sessions" in capsys.readouterr().err
