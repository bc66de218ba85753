"""What the window does where two operators changed the same: it asks, and loses nothing."""

import weakref
from dataclasses import replace
from functools import partial
from unittest.mock import create_autospec

import pytest
from PySide6.QtWidgets import QLabel, QPushButton, QRadioButton

from adibas.data.corrections import MarkerCorrection
from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import ServerAwayError, StoreError
from adibas.sessions.conflicts import Conflict
from tests.ui.review_scene import DOTS, entered_review, saved_session
from tests.unit.recorded_frames import INFO
from tests.unit.store_samples import add_capture
from ui.disputes import Dispute, undecided
from ui.patients.content import PatientEntry
from ui.patients.form_presenter import FormPresenter, FormView
from ui.review.notes_panel import NotesPanel
from ui.review.presenter import ReviewView
from ui.widgets.dispute_dialog import DisputeDialog
from ui.widgets.message_bar import MessageBar
from ui.workspace import Workspace

LABEL = next(iter(DOTS))


@pytest.fixture
def saved(store):
    return saved_session(store)


@pytest.fixture
def disputes(workspace):
    found = []
    workspace.dispute_found.subscribe(found.append)
    return found


@pytest.fixture
def view():
    return create_autospec(ReviewView, instance=True)


@pytest.fixture
def review(view, workspace, saved):
    with entered_review(view, workspace, saved) as presenter:
        yield presenter


@pytest.fixture
def notes(qtbot, review, view):
    """The real field of the notes, as the screen wires it."""
    panel = NotesPanel()
    qtbot.addWidget(panel)
    view.show_notes.side_effect = panel.show_notes
    view.keep_notes.side_effect = panel.keep
    panel.written.connect(review.change_notes)
    review.entered()
    return panel


def type_notes(panel, text):
    panel._text.setPlainText(text)
    panel.save()


def by_somebody_else(store, session_id, **change):
    store.operator = "Ana"
    changed = store.sessions.change(session_id, **change)
    store.operator = "Bea"
    return changed


def moved_by_somebody_else(store, capture, u):
    store.operator = "Ana"
    marker = next(one for one in capture.markers() if one.label == LABEL)
    history = capture.history.after(MarkerCorrection(marker, replace(marker, u=u)))
    store.captures.correct(capture.capture_id, history)
    store.operator = "Bea"


@pytest.mark.parametrize(
    ("choice", "expected"), [("theirs", "left"), ("mine", "right"), ("both", "left\nright")]
)
def test_notes_that_two_typed_are_asked_about(notes, store, saved, disputes, choice, expected):
    session_id = saved[1].session_id
    by_somebody_else(store, session_id, notes="left")
    type_notes(notes, "right")
    (dispute,) = disputes
    (row,) = dispute.rows
    assert (row.field, row.theirs, row.mine, row.operator) == ("Notes", "left", "right", "Ana")
    assert store.sessions.get(session_id).notes == "left"
    assert notes._text.toPlainText() == "right"
    dispute.decide((choice,))
    assert store.sessions.get(session_id).notes == expected
    assert notes._text.toPlainText() == expected
    assert len(disputes) == 1


def test_notes_that_nobody_decided_on_stay_and_are_asked_about_again(
    notes, store, saved, disputes, workspace
):
    session_id = saved[1].session_id
    theirs = by_somebody_else(store, session_id, notes="left")
    type_notes(notes, "right")
    disputes[0].put_off()
    workspace.choose_session(theirs)  # something else of the session was changed meanwhile
    assert notes._text.toPlainText() == "right"
    assert len(disputes) == 2
    assert store.sessions.get(session_id).notes == "left"


def test_notes_are_kept_while_the_server_is_away_and_saved_when_asked_again(
    notes, store, saved, workspace, monkeypatch
):
    offered = []
    workspace.retry_offered.subscribe(lambda *offer: offered.append(offer))

    def away(*_ids, **_fields):
        raise ServerAwayError("The server does not answer.")

    monkeypatch.setattr(store.sessions, "change", away)
    type_notes(notes, "limps")
    monkeypatch.undo()
    ((sentence, again),) = offered
    assert sentence == "The server does not answer."
    assert notes._text.toPlainText() == "limps"
    again()
    assert store.sessions.get(saved[1].session_id).notes == "limps"
    type_notes(notes, "limps")
    assert len(offered) == 1


@pytest.mark.parametrize("choice", ["theirs", "mine"])
def test_a_marker_that_two_moved_is_asked_about(review, store, saved, disputes, choice, view):
    capture = saved[2][0]
    moved_by_somebody_else(store, capture, 31.0)
    review.points.drag(LABEL, 12.0, 13.0)
    review.points.drop(LABEL, 12.0, 13.0, is_free=True)
    (dispute,) = disputes
    (row,) = dispute.rows
    assert row.theirs.endswith(f"at 31.0, {DOTS[LABEL][1]:.1f} px")
    assert row.mine.endswith("at 12.0, 13.0 px")
    dispute.decide((choice,))
    expected = 31.0 if choice == "theirs" else 12.0
    for markers in (
        store.captures.get(capture.capture_id).markers(),
        view.show_points.call_args.args[0].markers,
    ):
        assert next(one.u for one in markers if one.label == LABEL) == expected


def test_a_marker_that_nobody_decided_on_is_as_saved_and_the_other_place_is_on_record(
    review, store, saved, disputes
):
    capture = saved[2][0]
    moved_by_somebody_else(store, capture, 31.0)
    review.points.drag(LABEL, 12.0, 13.0)
    review.points.drop(LABEL, 12.0, 13.0, is_free=True)
    disputes[0].put_off()
    markers = store.captures.get(capture.capture_id).markers()
    assert next(one.u for one in markers if one.label == LABEL) == 31.0
    kinds = [line.detail.get("correction") for line in store.audit.entries(3)]
    assert "set aside" in kinds


@pytest.fixture
def hidden(store, saved):
    """Hides the session, or its patient, as somebody else does at another workstation."""

    def hide(what):
        patient, session, _captures = saved
        if what == "session":
            store.sessions.delete(session.session_id)
        else:
            store.patients.delete(patient.pseudonym)

    return hide


@pytest.mark.parametrize("what", ["session", "patient"])
def test_who_goes_on_in_what_somebody_hid_meanwhile_is_told_once_and_loses_nothing(
    notes, store, saved, told, hidden, what
):
    hidden(what)
    type_notes(notes, "the left knee")
    assert store.sessions.get(saved[1].session_id).notes == "the left knee"
    ((kind, sentence),) = told
    assert kind == "warning"
    assert "deleted this patient or session meanwhile" in sentence
    type_notes(notes, "the left knee hurts")
    assert len(told) == 1


@pytest.mark.parametrize("what", ["session", "patient"])
def test_nothing_is_recorded_into_what_somebody_hid_meanwhile(store, saved, hidden, what):
    hidden(what)
    with pytest.raises(StoreError, match="deleted meanwhile and is hidden"):
        store.recordings.create(saved[1].session_id, INFO)
    assert store.recordings.of_session(saved[1].session_id) == ()
    before = [one.capture_id for one in store.captures.of_session(saved[1].session_id)]
    with pytest.raises(StoreError, match="deleted meanwhile and is hidden"):
        add_capture(store, saved[1])
    after = [one.capture_id for one in store.captures.of_session(saved[1].session_id)]
    assert after == before
    if what == "patient":
        with pytest.raises(StoreError, match="deleted meanwhile and is hidden"):
            store.sessions.start(saved[0].pseudonym, SessionSetup())


def test_other_corrections_of_somebody_else_come_along_with_a_word(review, store, saved, told):
    capture = saved[2][0]
    moved_by_somebody_else(store, capture, 31.0)
    other = next(label for label in DOTS if label != LABEL)
    review.points.select(other)
    review.points.delete()
    kept = {one.label: one.u for one in store.captures.get(capture.capture_id).markers()}
    assert kept[LABEL] == 31.0
    assert other not in kept
    assert [kind for kind, _ in told] == ["warning"]
    review.points.undo()
    assert len(store.captures.get(capture.capture_id).markers()) == len(DOTS)


def test_a_form_of_a_patient_stays_open_until_it_is_decided(workspace, store, saved, disputes):
    patient = saved[0]
    workspace.choose_patient(patient)
    view = create_autospec(FormView, instance=True)
    forms = FormPresenter(view, workspace, lambda: None)
    forms.edit()
    store.operator = "Ana"
    store.patients.change(patient.pseudonym, identity=Identity("Ana Maria"), notes="left knee")
    store.operator = "Bea"
    forms.save(PatientEntry("Anna", "27/03/2014", "", "female", ""))
    view.close_form.assert_not_called()
    (dispute,) = disputes
    assert [(row.field, row.theirs, row.mine) for row in dispute.rows] == [
        ("Name", "Ana Maria", "Anna")
    ]
    dispute.decide(("theirs",))
    view.close_form.assert_called_once_with()
    kept = store.patients.get(patient.pseudonym)
    assert (kept.identity.name, kept.sex, kept.notes) == ("Ana Maria", "female", "left knee")
    assert kept.identity.birth_date is not None


def conflict(field, theirs, mine, now):
    return Conflict(field, theirs, mine, "Ana", now)


@pytest.fixture
def now(store):
    return store.audit.now_utc()


@pytest.mark.parametrize(
    ("field", "theirs", "mine", "words"),
    [
        ("sex", "female", "", ("Sex", "female", "not told")),
        ("setup.rotation_deg", "90", "180", ("Rotation of the picture", "90", "180")),
        ("setup.color_size", "[640,480]", "[1280,1024]", None),
        ("setup.is_repeat", "true", "false", ("Repeats the session before it", "yes", "no")),
        ("setup.protocol", '"sapo-1"', '""', ("Protocol", "sapo-1", "none")),
        ("setup.markers", '{"a":1}', "null", None),
        ("birth_date", "2014-03-27", "", ("Birth date", "2014-03-27", "nothing")),
        ("C7", None, None, ("Marker C7", "deleted", "deleted")),
    ],
)
def test_every_field_has_words(field, theirs, mine, words, now):
    (row,) = Dispute((conflict(field, theirs, mine, now),), lambda _: None, lambda: None).rows
    assert row.theirs != row.mine or theirs is None
    assert words is None or (row.field, row.theirs, row.mine) == words


def test_what_is_not_decided_loses_no_text(now):
    conflicts = (conflict("notes", "a", "b", now), conflict("C7", None, None, now))
    assert [one.takes for one in undecided(conflicts)] == ["both", "theirs"]


@pytest.fixture
def dialog(qtbot, now, theme):
    assert theme
    answers = []
    conflicts = (conflict("notes", "left", "right", now), conflict("sex", "female", "male", now))

    def decide(decisions):
        answers.append([one.takes for one in decisions])

    bar = MessageBar()
    qtbot.addWidget(bar)
    made = DisputeDialog(Dispute(conflicts, decide, lambda: answers.append("later")), bar)
    made.answers, made.window_behind = answers, bar
    return made


def test_the_dialog_shows_both_versions_and_saves_once_all_is_chosen(dialog):
    texts = {label.text() for label in dialog.findChildren(QLabel)}
    assert texts >= {"left", "right", "female", "male"}
    assert not dialog.save.isEnabled()
    for group, number in zip(dialog.groups, (2, 0), strict=True):
        group.choices.button(number).click()
    answers = dialog.answers
    dialog.save.click()
    assert answers == [["both", "theirs"]]


def test_a_dialog_that_is_closed_puts_the_question_off(dialog):
    answers = dialog.answers
    buttons = dialog.findChildren(QPushButton)
    next(one for one in buttons if one.text() == "&Later").click()
    assert answers == ["later"]


def test_every_choice_is_read_out_with_its_field_and_value(dialog):
    names = [one.accessibleName() for one in dialog.groups[1].findChildren(QRadioButton)]
    assert names[1] == "Sex: Yours: male"
    assert "Ana" in names[0]
    assert names[0].endswith("female")
    dialog.close()


def test_the_message_offers_to_try_again_once(qtbot):
    bar = MessageBar()
    qtbot.addWidget(bar)
    tried = []
    bar.offer_again("The server does not answer.", lambda: tried.append(1))
    button = next(one for one in bar.findChildren(QPushButton) if one.text() == "&Try again")
    button.click()
    assert tried == [1]
    assert bar.text == ""
    bar.tell("bad", "Something else.")
    assert button.isHidden()


def test_an_offer_that_is_withdrawn_goes_with_all_it_held_and_other_messages_stay(qtbot):
    bar = MessageBar()
    qtbot.addWidget(bar)
    typed = Identity("Ana")
    held = weakref.ref(again := partial(print, typed))
    bar.offer_again("The server does not answer.", again)
    del again
    bar.withdraw_retry()
    assert (bar.text, held()) == ("", None)
    bar.tell("bad", "Something else.")
    bar.withdraw_retry()
    assert bar.text == "Something else."


def test_a_second_window_that_only_reads_is_no_dispute(read_only_store, inline_jobs, preferences):
    workspace = Workspace(read_only_store, inline_jobs, preferences, None)
    found, told = [], []
    workspace.dispute_found.subscribe(found.append)
    workspace.noticed.subscribe(lambda *notice: told.append(notice))
    patients = read_only_store.patients
    assert not workspace.save_shared(lambda _: patients.add(Identity("Ana")) and None)
    assert (found, len(told)) == ([], 1)


def test_a_form_that_was_locked_meanwhile_still_knows_what_was_seen(
    workspace, store, saved, disputes
):
    patient = saved[0]
    workspace.choose_patient(patient)
    view = create_autospec(FormView, instance=True)
    forms = FormPresenter(view, workspace, lambda: None)
    forms.edit()
    view.typed.return_value = (PatientEntry("Somebody", "", "", "", "right knee"), None)
    draft = forms.draft()
    store.patients.change(patient.pseudonym, notes="left knee")
    again = FormPresenter(view, workspace, lambda: None)
    again.take_back(draft)
    again.save(PatientEntry("Somebody", "", "", "", "right knee"))
    assert [(row.theirs, row.mine) for row in disputes[0].rows] == [("left knee", "right knee")]
