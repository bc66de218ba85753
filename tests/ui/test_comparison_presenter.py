"""What the comparison screen chooses, reads and refuses, without Qt, over a real store."""

from unittest.mock import create_autospec

import pytest

from adibas.data.reliability import Verdict
from adibas.errors import NotAllowedError
from adibas.pipeline.picture_overlay import OverlayWay
from adibas.sessions import open_store, people
from adibas.sessions.roles import Role
from tests.ui.comparison_scene import StepClock, add_patient, add_session, fill_clinic
from tests.ui.conftest import CHEAP, PASSPHRASE, NoSensor
from ui.comparison.presenter import (
    NO_PATIENT,
    NO_SESSIONS,
    ONE_SESSION,
    ComparisonPresenter,
    ComparisonView,
)
from ui.workspace import Workspace

ACROMIA = ("anterior", "ANT.ACR.H")


@pytest.fixture
def clock():
    return StepClock()


@pytest.fixture
def store(tmp_path, clock):
    """An empty store in which days pass."""
    folder = tmp_path / "store"
    with open_store(folder, PASSPHRASE, operator="tester", key_params=CHEAP, clock=clock) as store:
        yield store


@pytest.fixture
def view():
    return create_autospec(ComparisonView, instance=True)


@pytest.fixture
def presenter(view, workspace):
    presenter = ComparisonPresenter(view, workspace)
    yield presenter
    presenter.close()


@pytest.fixture
def patient(store, workspace):
    patient = add_patient(store)
    workspace.choose_patient(patient)
    return patient.pseudonym


@pytest.fixture
def visit(store, clock, patient):
    """Add a session of the patient a week after the one before; return it."""

    def add(height_m, **options):
        clock.days_pass(7)
        return add_session(store, patient, height_m, **options)

    return add


def choices(view):
    return view.show_choices.call_args.args[0]


def differences(view):
    return view.show_differences.call_args.args[0]


def change(view, key=ACROMIA):
    found = differences(view).comparison.changes
    return next(one for one in found if (one.view, one.measure_id) == key)


def compared(view):
    return choices(view).earlier.session_id, choices(view).later.session_id


def test_it_says_what_to_do_first(presenter, view, workspace, store):
    presenter.enter()
    assert view.show_nothing.call_args.args == (NO_PATIENT, "patients")
    patient = add_patient(store)
    workspace.choose_patient(patient)
    assert view.show_nothing.call_args.args == (NO_SESSIONS, "capture")
    session = add_session(store, patient.pseudonym, 0.0)
    workspace.choose_session(session)
    assert view.show_nothing.call_args.args == (ONE_SESSION, "capture")
    assert choices(view).later == session
    assert choices(view).earlier is None
    assert differences(view).comparison is None
    assert len(view.show_trends.call_args.args[0].trends[0].points) == 1


def test_the_last_two_sessions_of_one_protocol_are_compared(presenter, view, visit):
    first = visit(0.0)
    second = visit(0.01)
    visit(0.0, protocol="upper-quadrant")
    presenter.enter()
    assert view.show_nothing.call_args.args == ("", "")
    assert compared(view) == (first.session_id, second.session_id)
    assert choices(view).protocol == "sapo-1"
    assert change(view).difference == pytest.approx(1.59, abs=0.02)
    assert change(view).verdict is Verdict.UNKNOWN


def test_a_session_that_is_opened_is_the_later_one(presenter, view, visit, workspace):
    sessions = [visit(0.01 * number) for number in range(3)]
    workspace.choose_session(sessions[1])
    presenter.enter()
    assert compared(view) == (sessions[0].session_id, sessions[1].session_id)
    workspace.choose_session(sessions[0])
    assert compared(view) == (sessions[1].session_id, sessions[2].session_id)


def test_what_was_chosen_stays_where_the_screen_is_seen_again(presenter, view, visit, store):
    sessions = [visit(0.01 * number) for number in range(3)]
    presenter.enter()
    presenter.choose_sessions(sessions[0].session_id, sessions[2].session_id)
    presenter.choose_protocol("upper-quadrant")
    presenter.leave()
    presenter.enter()
    assert compared(view) == (sessions[0].session_id, sessions[2].session_id)
    assert choices(view).protocol == "upper-quadrant"
    store.sessions.delete(sessions[0].session_id)
    presenter.enter()
    assert compared(view) == (sessions[1].session_id, sessions[2].session_id)


def test_only_what_was_before_is_compared_with_a_session(presenter, view, visit):
    first, second, third = (visit(0.01 * number) for number in range(3))
    presenter.enter()
    assert choices(view).nows == (third, second), "nothing was before the first"
    assert choices(view).befores == (second, first)
    presenter.choose_sessions(second.session_id, second.session_id)
    assert compared(view) == (first.session_id, second.session_id)
    assert choices(view).befores == (first,)
    assert differences(view).refusal == ""


def test_another_patient_begins_anew(presenter, view, visit, store, workspace):
    for height_m in (0.0, 0.01):
        visit(height_m)
    presenter.enter()
    presenter.choose_protocol("upper-quadrant")
    other = add_patient(store, "Another")
    workspace.choose_patient(other)
    assert choices(view).sessions == ()
    assert choices(view).protocol == "sapo-1"


def test_sessions_of_different_protocols_get_a_sentence_and_no_number(presenter, view, visit):
    first = visit(0.0)
    second = visit(0.0, protocol="joints-15")
    presenter.enter()
    presenter.choose_sessions(first.session_id, second.session_id)
    assert differences(view).comparison is None
    assert "different protocols, sapo-1 and joints-15" in differences(view).refusal
    assert choices(view).protocol == "joints-15"


def test_trends_leave_other_protocols_out_and_say_so(presenter, view, visit):
    for height_m in (0.0, 0.01, 0.02):
        visit(height_m)
    visit(0.0, protocol="joints-15")
    visit(0.0, views=("left_lateral",))
    presenter.enter()
    presenter.choose_sessions(*(one.session_id for one in reversed(choices(view).sessions[2:4])))
    trends = view.show_trends.call_args.args[0]
    acromia = next(one for one in trends.trends if one.key == ACROMIA)
    assert len(acromia.points) == 3
    assert trends.notes == ("1 session follows another protocol and is left out.",)


def test_a_session_without_measures_is_told(presenter, view, visit):
    visit(0.0)
    visit(0.0, views=("",))
    presenter.enter()
    assert "without measures" in differences(view).refusal
    notes = view.show_trends.call_args.args[0].notes
    assert notes == ("1 session has no measure of this protocol.",)


def test_repeats_of_the_clinic_mark_the_changes(presenter, view, visit, store, clock):
    fill_clinic(store, clock)
    visit(0.0)
    clock.days_pass(30)
    visit(0.03)
    presenter.enter()
    assert change(view).verdict is Verdict.BEYOND
    assert not differences(view).is_looking
    assert differences(view).comparison.n_judged > 5
    repeats = dict(view.show_repeats.call_args.args[0].by_measure)
    assert repeats[ACROMIA].n_patients == 10
    assert repeats[ACROMIA].mdc95 == pytest.approx(change(view).mdc95)
    trends = view.show_trends.call_args.args[0].trends
    assert next(one for one in trends if one.key == ACROMIA).band is not None


def test_the_repeats_are_looked_through_once_until_a_session_changes(
    presenter, view, visit, workspace
):
    first = visit(0.0)
    visit(0.01)
    presenter.enter()
    presenter.enter()
    looked = "Looking through the clinic's repeats"
    assert workspace.jobs.labels.count(looked) == 1
    workspace.session_changed.emit()
    assert workspace.jobs.labels.count(looked) == 2
    presenter.choose_operator("somebody else")
    assert workspace.jobs.labels.count(looked) == 3
    assert "No session of this operator" in view.show_repeats.call_args.args[0].sentence
    assert first.operator == "tester"


def test_repeats_are_those_of_the_later_session_s_operator_until_another_is_chosen(
    presenter, view, visit, store
):
    store.operator = ""
    visit(0.0)
    store.operator = "Ada"
    visit(0.01)
    presenter.enter()
    assert (choices(view).operators, choices(view).operator) == (("", "Ada"), "Ada")
    presenter.choose_operator("")
    presenter.enter()
    assert choices(view).operator == ""


def test_a_stopped_look_through_is_told_and_can_be_begun_again(presenter, view, visit, workspace):
    visit(0.0)
    visit(0.01)
    workspace.jobs.is_stopped = True
    presenter.enter()
    assert "were not looked through" in view.show_repeats.call_args.args[0].sentence
    workspace.jobs.is_stopped = False
    presenter.choose_operator("tester")
    assert view.show_repeats.call_args.args[0].sentence == ""
    assert not differences(view).is_looking


def test_the_pictures_of_one_view_lie_over_one_another(presenter, view, visit):
    visit(0.0, views=("anterior", "posterior"))
    visit(0.02, views=("anterior", "left_lateral"))
    presenter.enter()
    views, pair = view.show_pair.call_args.args
    assert views == ("anterior", "posterior", "left_lateral")
    assert pair.view == "anterior"
    assert pair.overlay.way is OverlayWay.FLOOR
    assert pair.laid_rgb.shape == pair.later.picture_rgb.shape
    presenter.pictures.choose_view("posterior")
    _views, pair = view.show_pair.call_args.args
    assert (pair.later, pair.overlay) == (None, None)
    assert pair.earlier is not None
    n_calls = view.show_pair.call_count
    presenter.pictures.choose_view("posterior")
    assert view.show_pair.call_count == n_calls


def test_nothing_is_read_while_nobody_looks(presenter, view, visit, workspace):
    presenter.enter()
    presenter.leave()
    n_calls = view.show_choices.call_count
    workspace.choose_session(visit(0.0))
    presenter.refresh()
    assert view.show_choices.call_count == n_calls


def test_a_plot_that_is_saved_is_noted_in_the_audit_log(
    presenter, view, visit, store, workspace, tmp_path
):
    told = []
    workspace.noticed.subscribe(lambda *notice: told.append(notice))
    visit(0.0)
    presenter.enter()
    presenter.save_picture(tmp_path / "plot.png", b"PNG")
    assert (tmp_path / "plot.png").read_bytes() == b"PNG"
    (entry,) = store.audit.entries(1)
    assert (entry.action, entry.subject) == ("export", choices(view).later.session_id)
    assert told == [("good", "Written: plot.png")]


def test_a_plot_that_was_saved_when_stop_was_pressed_is_told(
    presenter, visit, workspace, tmp_path, inline_jobs
):
    told = []
    workspace.noticed.subscribe(lambda *notice: told.append(notice))
    visit(0.0)
    presenter.enter()
    inline_jobs.is_stopped_late = True
    presenter.save_picture(tmp_path / "plot.png", b"PNG")
    assert told == [("good", "Written: plot.png")]


def save_plot(view, workspace, patient, path):
    """Save a plot of a patient's last session."""
    workspace.choose_patient(patient)
    presenter = ComparisonPresenter(view, workspace)
    presenter.enter()
    presenter.save_picture(path, b"PNG")
    presenter.close()


def test_a_plot_that_a_second_window_saves_is_noted_too(view, second_window, store, tmp_path):
    patient = add_patient(store)
    session = add_session(store, patient.pseudonym, 0.0)
    save_plot(view, second_window, patient, tmp_path / "plot.png")
    assert (tmp_path / "plot.png").exists()
    (line,) = [entry for entry in store.audit.entries() if entry.action == "export"]
    assert (line.operator, line.subject) == ("second", session.session_id)


def test_a_second_window_saves_no_plot_where_the_role_may_not_export(
    view, store, preferences, inline_jobs, tmp_path, monkeypatch
):
    monkeypatch.setattr(people, "Argon2Params", lambda: CHEAP)
    patient = add_patient(store)
    add_session(store, patient.pseudonym, 0.0)
    store.people.add("Anna", Role.ADMINISTRATOR, "anna has a long one")
    store.people.add("Carla", Role.OPERATOR, "carla, still another")
    with open_store(store.folder, "carla, still another") as second:
        workspace = Workspace(second, inline_jobs, preferences, NoSensor())
        save_plot(view, workspace, patient, tmp_path / "plot.png")
    assert isinstance(inline_jobs.problems[-1], NotAllowedError)
    assert not (tmp_path / "plot.png").exists()


def test_a_protocol_that_is_gone_is_told(presenter, visit, workspace):
    told = []
    workspace.noticed.subscribe(lambda *notice: told.append(notice))
    visit(0.0)
    presenter.enter()
    presenter.choose_protocol("gone")
    assert told[-1][0] == "bad"
    assert "No protocol is named gone" in told[-1][1]


def test_another_screen_can_be_asked_for(presenter, workspace):
    wanted = []
    workspace.screen_wanted.subscribe(wanted.append)
    presenter.go_to("patients")
    assert wanted == ["patients"]
