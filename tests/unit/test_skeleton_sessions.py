"""The clinic's own corrected captures become a model, held against what it replaces."""

import json

import numpy as np
import pytest

from adibas.cli.command_line import main
from adibas.data.corrections import CorrectionHistory, MarkerCorrection
from adibas.data.protocols import Landmark, Protocol, Wording
from adibas.data.views import VIEWS
from adibas.errors import FileError
from adibas.measures.protocol_store import find_protocol
from adibas.pipeline.namers import namer_of, own_model_path
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_sessions import HeldOut, corrected_examples, train_from_sessions
from tests.unit.store_samples import (
    IDENTITY,
    PASSPHRASE,
    add_capture,
    add_session,
    marker,
    open_sample,
)

PLACES = {
    "chin": (0.0, -0.6, 2.0),
    "left_side": (0.3, -0.1, 2.1),
    "right_side": (-0.3, -0.1, 2.1),
    "navel": (0.0, 0.2, 1.9),
}


def add_example(store, session, rng, *, is_corrected=True):
    found = tuple(
        marker(f"m{i:02d}", 30.0 * i, np.array(place) + rng.normal(scale=0.01, size=3))
        for i, place in enumerate(PLACES.values(), 1)
    )
    capture = add_capture(store, session, detected=found)
    renames = tuple(
        MarkerCorrection(one, marker(name, one.u, one.position_m))
        for one, name in zip(found, PLACES, strict=True)
    )
    if is_corrected:
        store.captures.correct(capture.capture_id, CorrectionHistory(renames, len(renames)))


@pytest.fixture
def folder(tmp_path):
    rng = np.random.default_rng(0)
    with open_sample(tmp_path / "store") as store:
        session = add_session(store)
        for number in range(13):
            add_example(store, session, rng, is_corrected=number > 0)
    return tmp_path / "store"


def quiet(_done, _all):
    pass


def test_only_captures_that_were_corrected_are_examples(folder):
    with open_sample(folder) as store:
        examples = corrected_examples(store, quiet)
    assert len(examples) == 12
    for example in examples:
        assert set(example.points.labels) == set(PLACES)
        assert example.points.view == "anterior"


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
