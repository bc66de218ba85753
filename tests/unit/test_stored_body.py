"""The back and the body out of a store: what the same depth gives that never was in one."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.data.patients import Identity
from adibas.errors import BodyError
from adibas.pipeline.back import measure_back
from adibas.pipeline.body_views import ViewRequest, person_in
from adibas.pipeline.stored_body import FROM_TURN, stored_back, stored_body
from adibas.pipeline.turning import see_turn
from adibas.pipeline.whole_body import join_body
from tests.unit.standing_bodies import add_body_session, scene, surface, unheard
from tests.unit.store_samples import add_patient, open_sample
from tests.unit.turning_bodies import add_turn, turn_images, turning_scene, write

AROUND = ("posterior", "anterior", "right_lateral", "left_lateral")


@pytest.fixture
def store(tmp_path):
    with open_sample(tmp_path / "store") as store:
        yield store


@pytest.fixture
def patient(store):
    return add_patient(store, Identity("Rosa Ibarra")).pseudonym


def seen(view):
    return person_in(view, surface(view), scene().calibration)


def test_the_back_of_a_stored_capture_is_that_of_its_burst(store, patient):
    session = add_body_session(store, patient, ("anterior", "posterior"))
    wanted = measure_back(seen("posterior"))
    found = stored_back(store, session, unheard)
    assert [one.value for one in found.measures] == [one.value for one in wanted.measures]
    assert any(one.value is not None for one in found.measures)
    np.testing.assert_array_equal(found.grid.back_m, wanted.grid.back_m)


def test_the_body_is_looked_for_as_the_pictures_of_the_session_were_turned(
    store, patient, monkeypatch
):
    asked = []

    def look(*told, rotation_deg, **more):
        asked.append(rotation_deg)
        return person_in(*told, **more)

    monkeypatch.setattr("adibas.pipeline.stored_body.person_in", look)
    session = add_body_session(store, patient)
    turned = replace(session, setup=replace(session.setup, rotation_deg=270))
    stored_back(store, turned, unheard)
    stored_body(store, turned, unheard)
    assert asked == [270, 270]


def test_the_last_capture_of_a_view_counts(store, patient):
    session = add_body_session(store, patient, ("posterior",), without_depth=("posterior",))
    with pytest.raises(BodyError, match="No depth was kept with the posterior view"):
        stored_back(store, session, unheard)


def test_all_stored_views_are_joined_and_those_without_depth_left_out(store, patient):
    session = add_body_session(
        store, patient, ("anterior", "left_lateral", "posterior"), without_depth=("right_lateral",)
    )
    wanted = join_body([seen(view) for view in ("posterior", "anterior", "left_lateral")])
    found = stored_body(store, session, unheard)
    assert tuple(found.n_frames) == ("posterior", "anterior", "left_lateral")
    np.testing.assert_allclose(found.whole.surface.points_m, wanted.surface.points_m)
    assert found.patient == patient
    assert found.back is not None
    assert {one.definition.measure_id for one in found.girths} >= {"VOLUME.TRUNK"}


def test_colours_come_from_the_picture(store, patient):
    surface_found = stored_body(store, add_body_session(store, patient), unheard).whole.surface
    known = surface_found.colors[np.isfinite(surface_found.colors).all(axis=1)]
    assert len(known) > 1000
    np.testing.assert_allclose(known, 120, atol=2)  # as JPEG keeps it


@pytest.mark.parametrize(
    ("views", "without_depth", "told"),
    [
        ((), (), "no posterior view"),
        (("anterior",), (), "no posterior view"),
        ((), ("posterior",), "No depth was kept"),
    ],
)
def test_a_session_without_a_back_says_why(store, patient, views, without_depth, told):
    session = add_body_session(store, patient, views, without_depth=without_depth)
    with pytest.raises(BodyError, match=told):
        stored_back(store, session, unheard)


def test_a_session_without_depth_has_no_body(store, patient):
    session = add_body_session(store, patient, (), without_depth=AROUND)
    with pytest.raises(BodyError, match="no view with depth"):
        stored_body(store, session, unheard)


def test_a_turn_gives_the_body_where_the_views_do_not_show_it_all_around(store, patient, tmp_path):
    images = turn_images()
    path = write(tmp_path / "turn.mcap", images, turning_scene())
    wanted = see_turn(ViewRequest("posterior", path), unheard)
    session = add_turn(store, add_body_session(store, patient, ("anterior", "posterior")), images)
    told = []
    found = stored_body(store, session, lambda done, total: told.append((done, total)))
    assert dict(found.n_frames) == {view.view: view.n_frames for view in wanted.views}
    np.testing.assert_allclose(
        found.whole.surface.points_m, join_body(wanted.views).surface.points_m, atol=1e-9
    )
    assert found.notices[0].message == FROM_TURN
    assert found.back is not None
    assert len(found.girths) > 0
    facts = store.recordings.facts(session.setup.turn)
    assert {one.recording_sha256 for one in found.provenances.values()} == {facts.sha256}
    assert told[0][0] < told[-1][0] == told[-1][1]


def test_without_a_posterior_view_the_back_is_that_of_the_turn(store, patient):
    session = add_turn(store, add_body_session(store, patient, ("anterior",)), turn_images())
    found = stored_back(store, session, unheard)
    wanted = stored_body(store, session, unheard).back
    assert [one.value for one in found.measures] == [one.value for one in wanted.measures]
    assert found.shape is not None


def test_views_all_around_count_more_than_a_turn(store, patient):
    session = add_body_session(store, patient, ("anterior", "left_lateral", "posterior"))
    session = add_turn(store, session, turn_images()[:2])
    assert set(stored_body(store, session, unheard).n_frames) == {
        "anterior",
        "left_lateral",
        "posterior",
    }


def test_a_turn_that_cannot_be_followed_says_why(store, patient):
    session = add_turn(store, add_body_session(store, patient, ()), turn_images()[:8])
    with pytest.raises(BodyError, match="degrees of a turn can be followed in turn"):
        stored_body(store, session, unheard)


def test_the_turn_of_a_session_is_not_that_of_the_next(store, patient):
    session = add_turn(store, add_body_session(store, patient, ()), turn_images()[:2])
    assert store.sessions.get(session.session_id).setup.turn == session.setup.turn
    assert store.sessions.start(patient, session.setup).setup.turn == ""
