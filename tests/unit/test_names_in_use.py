"""Which corrected sessions could teach the names, and what has been learned from them."""

import json

import pytest

from adibas.errors import FileError
from adibas.measures.protocol_store import find_protocol
from adibas.pipeline.namers import forget_own_model, namer_of, own_model_path, own_models
from adibas.pipeline.names_in_use import learn_own_names, names_in_use
from adibas.pipeline.skeleton_examples import LandmarkSet
from adibas.pipeline.skeleton_labelling import shipped_namer
from tests.unit.name_samples import PLACES, add_examples
from tests.unit.store_samples import open_sample

FREE = LandmarkSet()
FRONT = LandmarkSet("sapo-1", "anterior")
TRUNK = {
    "left_acromion": (0.2, -0.4, 2.0),
    "right_acromion": (-0.2, -0.4, 2.0),
    "left_asis": (0.14, 0.1, 1.95),
    "right_asis": (-0.14, 0.1, 1.95),
}


@pytest.fixture(autouse=True)
def no_own_models(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))


@pytest.fixture
def store(tmp_path):
    with open_sample(tmp_path / "store") as opened:
        yield opened


def quiet(_done, _all):
    pass


def test_sessions_are_counted_by_what_they_mark(store):
    assert names_in_use(store) == ()
    add_examples(store, 2)
    add_examples(store, 1)
    add_examples(store, 1, protocol="joints-15")
    free, joints = names_in_use(store)
    assert (free.which, free.n_captures, free.n_sessions, free.n_patients) == (FREE, 3, 2, 2)
    assert free.n_sessions_since == 2
    assert free.learned is None
    assert not free.is_shipped_known
    assert joints.which == LandmarkSet("joints-15")
    assert joints.is_shipped_known


def test_nobody_is_looked_at_where_sessions_are_counted(store):
    add_examples(store, 1)
    n_lines = len(store.audit.entries())
    names_in_use(store)
    assert len(store.audit.entries()) == n_lines


def test_what_was_learned_is_used_and_told_and_what_is_corrected_later_is_new(store):
    add_examples(store, 10)
    held_out = learn_own_names(store, FREE, quiet)
    (row,) = names_in_use(store)
    assert row.learned["held_out"]["right"] == held_out.right
    assert row.learned["n_patients"] == 1
    assert row.n_sessions == 1


def test_only_sessions_corrected_after_the_model_was_learned_are_new(store):
    add_examples(store, 10)
    learn_own_names(store, FREE, quiet)
    path = own_model_path()
    document = json.loads(path.read_text())
    newest = max(one.corrected_utc for one in store.captures.corrected())
    document["provenance"]["created_utc"] = newest.isoformat()
    path.write_text(json.dumps(document))
    assert names_in_use(store)[0].n_sessions_since == 1
    document["provenance"]["created_utc"] = store.audit.now()
    path.write_text(json.dumps(document))
    assert names_in_use(store)[0].n_sessions_since == 0
    add_examples(store, 1)
    assert names_in_use(store)[0].n_sessions_since == 1
    for unknown in ("", "2026-01-01T00:00:00"):
        document["provenance"]["created_utc"] = unknown
        path.write_text(json.dumps(document))
        (row,) = names_in_use(store)
        assert row.learned_utc is None
        assert row.n_sessions_since == 2


def test_a_model_of_one_view_names_that_view_alone_until_it_is_forgotten(store):
    protocol = find_protocol("sapo-1")
    add_examples(store, 10, places=TRUNK, protocol="sapo-1")
    learn_own_names(store, FRONT, quiet)
    assert own_model_path(FRONT).is_file()
    assert set(namer_of(protocol, "anterior").names) == set(TRUNK)
    assert namer_of(protocol, "posterior") is None
    assert namer_of(protocol) is None
    forget_own_model(FRONT)
    forget_own_model(FRONT)
    assert namer_of(protocol, "anterior") is None
    assert own_models() == ()


def test_of_two_models_that_fit_the_one_that_knows_more_names_the_markers(store):
    protocol = find_protocol("sapo-1")
    fewer = dict(list(TRUNK.items())[:3])
    add_examples(store, 10, places=fewer)
    add_examples(store, 10, places=TRUNK, protocol="sapo-1")
    learn_own_names(store, FREE, quiet)
    assert set(namer_of(protocol, "anterior").names) == set(fewer)
    learn_own_names(store, FRONT, quiet)
    assert set(namer_of(protocol, "anterior").names) == set(TRUNK)


def test_a_model_of_some_joints_does_not_take_the_place_of_the_shipped_one(store):
    places = dict(zip(("head", "left_hand", "right_hand", "torso"), PLACES.values(), strict=True))
    add_examples(store, 10, places=places)
    learn_own_names(store, FREE, quiet)
    assert len(own_models()) == 1
    assert namer_of(find_protocol("joints-15")) is shipped_namer()


def test_a_model_that_cannot_be_removed_is_told():
    own_model_path().mkdir(parents=True)
    with pytest.raises(FileError, match=r"names\.json cannot be removed"):
        forget_own_model(FREE)


def test_where_there_are_too_few_captures_nothing_changes(store):
    add_examples(store, 9)
    with pytest.raises(FileError, match="There are 9 captures"):
        learn_own_names(store, FREE, quiet)
    assert own_models() == ()
