"""What was typed of one patient is never saved over another, however late it is saved."""

from dataclasses import replace
from unittest.mock import create_autospec

import pytest

from adibas.data.corrections import MarkerCorrection
from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import ServerAwayError
from adibas.markers.led import LedParams
from adibas.pipeline.targets import target_to_document
from tests.ui.review_scene import DOTS, entered_review, saved_session
from tests.unit.store_samples import add_patient
from ui.capture.ports import CaptureView
from ui.capture.presenter import CapturePresenter
from ui.capture.sources import usual_sources
from ui.markers.ports import LearnerView
from ui.markers.presenter import LearnerPresenter
from ui.patients.content import PatientEntry
from ui.patients.form_presenter import FormPresenter, FormView
from ui.patients.history_presenter import HistoryPresenter, HistoryView
from ui.patients.undo import Undo, UndoView
from ui.review.presenter import ReviewView

TYPED = PatientEntry("Ana Ruiz Gil", "", "", "female", "knee, left")


class Desk:
    """Ana is looked at, in the second session of her day; Bernat is the next one."""

    def __init__(self, workspace, store):
        self.workspace, self.store = workspace, store
        self.ana, self.bernat = (
            add_patient(store, Identity(name)) for name in ("Ana Ruiz", "Bernat Puig")
        )
        _first, self.session = (
            store.sessions.start(self.ana.pseudonym, SessionSetup()) for _number in range(2)
        )
        self.view = create_autospec(FormView, instance=True)
        self.forms = FormPresenter(self.view, workspace, lambda: None)
        self.offers, self.disputes = [], []
        workspace.retry_offered.subscribe(lambda _sentence, again: self.offers.append(again))
        workspace.retry_withdrawn.subscribe(self.offers.clear)
        workspace.dispute_found.subscribe(self.disputes.append)
        workspace.choose_patient(self.ana)
        workspace.choose_session(self.session)

    def go_on_to_bernat(self):
        """Give Ana's form up, and open his."""
        self.forms.cancel()
        self.workspace.choose_patient(self.bernat)
        self.forms.edit()
        self.view.reset_mock()

    def set_up_elsewhere(self, **changes):
        """Let somebody else change the set-up of Ana's session."""
        setup = replace(self.session.setup, **changes)
        self.store.sessions.change(self.session.session_id, setup=setup)

    def saved(self, patient):
        return self.store.patients.get(patient.pseudonym)

    def saved_setup(self):
        return self.store.sessions.get(self.session.session_id).setup


@pytest.fixture
def desk(workspace, store):
    return Desk(workspace, store)


@pytest.fixture
def away(store, monkeypatch):
    """Let the server of the store not answer, until this is called."""

    def fail(*_ids, **_fields):
        raise ServerAwayError("The server does not answer.")

    with monkeypatch.context() as patch:
        patch.setattr(store.patients, "change", fail)
        patch.setattr(store.sessions, "change", fail)
        yield patch.undo


@pytest.fixture
def again(desk, away):
    """What tries to save Ana's form again; the server is back."""
    desk.forms.edit()
    desk.forms.save(TYPED)
    away()
    (again,) = desk.offers
    return again


def test_a_form_that_could_not_be_saved_is_tried_again_as_it_was_typed(desk, again):
    again()
    assert desk.saved(desk.ana).identity.name == "Ana Ruiz Gil"
    assert desk.workspace.patient.notes == "knee, left"
    desk.view.close_form.assert_called_once_with()
    assert desk.offers == []


def test_what_was_typed_of_one_patient_is_not_tried_again_on_another(desk, again):
    desk.go_on_to_bernat()
    again()
    assert desk.saved(desk.bernat) == desk.workspace.patient == desk.bernat
    assert desk.saved(desk.ana) == desk.ana, "it was given up"
    desk.view.close_form.assert_not_called()


@pytest.mark.usefixtures("again")
@pytest.mark.parametrize("how", ["cancelled", "saved", "patient", "session"])
def test_what_is_given_up_or_saved_or_of_somebody_else_is_not_offered_again(desk, how):
    if how == "cancelled":
        desk.forms.cancel()
    elif how == "saved":
        desk.forms.save(replace(TYPED, notes="knee, right"))
    elif how == "patient":
        desk.workspace.choose_patient(desk.bernat)
    else:
        desk.workspace.choose_session(None)
    assert desk.offers == []


def test_what_fails_because_another_patient_is_chosen_stays_on_offer(desk):
    def fail(_decisions):
        raise ServerAwayError("The server does not answer.")

    desk.workspace.patient_changed.subscribe(lambda: desk.workspace.save_shared(fail))
    desk.workspace.choose_patient(desk.bernat)
    assert len(desk.offers) == 1


def test_a_late_decision_is_saved_where_it_was_typed_and_closes_no_other_form(desk):
    desk.forms.edit()
    desk.store.patients.change(desk.ana.pseudonym, identity=Identity("Ana Maria"))
    desk.forms.save(TYPED)
    desk.go_on_to_bernat()
    desk.disputes[0].decide(("mine",))
    assert desk.saved(desk.ana).identity.name == "Ana Ruiz Gil"
    assert desk.saved(desk.bernat) == desk.workspace.patient == desk.bernat
    desk.view.close_form.assert_not_called()


def test_a_repeat_that_could_not_be_noted_opens_no_session_of_another_patient(desk, away):
    undo = Undo(create_autospec(UndoView, instance=True), desk.workspace)
    history = HistoryPresenter(create_autospec(HistoryView, instance=True), desk.workspace, undo)
    history.enter()
    history.call_repeat(desk.session.session_id, is_repeat=True)
    away()
    (again,) = desk.offers
    desk.workspace.choose_patient(desk.bernat)
    again()
    assert (desk.workspace.patient, desk.workspace.session) == (desk.bernat, None)
    assert not desk.saved_setup().is_repeat


def test_a_set_up_that_is_decided_on_late_opens_no_session_of_another_patient(desk):
    view = create_autospec(CaptureView, instance=True)
    capture = CapturePresenter(view, desk.workspace, look=usual_sources)
    desk.set_up_elsewhere(rotation_deg=180)
    capture.sources.turn()
    desk.workspace.choose_patient(desk.bernat)
    desk.disputes[0].decide(("mine",))
    assert desk.workspace.session is None
    assert desk.saved_setup().rotation_deg == 90


def test_markers_that_are_decided_on_late_open_no_session_of_another_patient(desk):
    learner = LearnerPresenter(create_autospec(LearnerView, instance=True), desk.workspace)
    desk.set_up_elsewhere(markers={"kind": "another"})
    learner.set_mode("led")
    learner.use()
    desk.workspace.choose_patient(desk.bernat)
    desk.disputes[0].decide(("mine",))
    assert desk.workspace.session is None
    assert desk.saved_setup().markers == target_to_document(LedParams())


def test_a_correction_that_is_decided_on_late_shows_no_capture_of_another_session(desk):
    view = create_autospec(ReviewView, instance=True)
    saved = saved_session(desk.store)
    (capture,) = saved[2]
    label = next(iter(DOTS))
    marker = next(one for one in capture.markers() if one.label == label)
    moved = MarkerCorrection(marker, replace(marker, u=31.0))
    with entered_review(view, desk.workspace, saved) as review:
        desk.store.captures.correct(capture.capture_id, capture.history.after(moved))
        review.points.drag(label, 12.0, 13.0)
        review.points.drop(label, 12.0, 13.0, is_free=True)
        desk.workspace.choose_session(desk.session)
        view.reset_mock()
        desk.disputes[0].decide(("mine",))
        view.show_captures.assert_not_called()
    kept = desk.store.captures.get(capture.capture_id).markers()
    assert next(one.u for one in kept if one.label == label) == 12.0
