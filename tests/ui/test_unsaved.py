"""Whoever closes the window loses nothing without a question, wherever it was typed."""

import json

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QComboBox, QDialog, QLineEdit, QMessageBox, QPlainTextEdit

from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import BehaviourError, ServerAwayError
from adibas.markers.led import LedParams
from adibas.pipeline.targets import target_to_document
from adibas.sessions import open_store
from tests.ui import window_user
from tests.ui.behaviour_scene import make_recording
from tests.ui.conftest import CHEAP
from tests.ui.window_user import CTRL, SECRET, visible, visible_dialogs
from tests.unit.store_samples import add_patient
from ui.behaviour.scheme_dialog import SchemeDialog
from ui.settings.servers_page import ServersPage

open_window = window_user.open_window
Key = Qt.Key
KEEP, LOSE = "Do not close", "Close without saving"


@pytest.fixture(autouse=True)
def prepared(tmp_path):
    """A store with one patient and a session; guessing its passphrase would be cheap."""
    with open_store(tmp_path / "store", SECRET, key_params=CHEAP) as store:
        patient = add_patient(store, Identity("Rosa Ibarra", None, "HC-77"))
        store.sessions.start(patient.pseudonym, SessionSetup())


@pytest.fixture
def user(open_window):
    user = open_window()
    unlock(user)
    return user


def unlock(user):
    user.window.activateWindow()
    user.until(user.window.isActiveWindow)
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    user.settle()


def choose_session(user):
    (row,) = user.store.patients.search("ibarra")
    user.workspace.choose_patient(user.store.patients.get(row.pseudonym))
    (session,) = user.store.sessions.of_patient(row.pseudonym)
    user.workspace.choose_session(session)
    user.settle()
    return session


def asked(user):
    """Close the window, and return what the question names."""
    user.window.close()
    assert user.window.isVisible()
    (question,) = visible_dialogs(QMessageBox)
    return question.informativeText()


def answer(user, button):
    (question,) = visible_dialogs(QMessageBox)
    user.click(button, question)


def stay(user):
    answer(user, KEEP)
    user.window.activateWindow()
    user.until(user.window.isActiveWindow)


def lose(user):
    answer(user, LOSE)
    user.until(lambda: user.workspace is None and not user.window.isVisible())
    assert not visible_dialogs()


def closes_at_once(user):
    user.window.close()
    user.until(lambda: user.workspace is None and not user.window.isVisible())


def type_patient(user):
    user.key(Key.Key_N, CTRL)
    user.keys("Nuria Typed")


def test_a_form_that_is_being_filled_in_is_not_closed_without_a_question(user):
    type_patient(user)
    user.key(Key.Key_Q, CTRL)
    (question,) = visible_dialogs(QMessageBox)
    assert "What was typed of a patient" in question.informativeText()
    assert "Nuria" not in question.text() + question.informativeText()
    stay(user)
    user.click("Save")
    assert user.workspace.patient.identity.name == "Nuria Typed"
    closes_at_once(user)


def test_who_says_so_loses_it_and_is_asked_once(user):
    type_patient(user)
    assert asked(user)
    lose(user)


def test_a_form_into_which_nothing_was_typed_is_closed_without_a_question(user):
    choose_session(user)
    for keys in ((Key.Key_N, CTRL), (Key.Key_F2,)):
        user.key(*keys)
        assert user.screen.pages.has_form
        user.key(Key.Key_Escape)
    user.key(Key.Key_F2)
    closes_at_once(user)


def test_a_consent_that_is_being_noted_is_asked_for(user):
    choose_session(user)
    user.screen.pages.patient.consents_asked.emit()
    user.click("Research", user.screen.pages.consents)
    assert "What was typed of a patient" in asked(user)
    lose(user)


def test_the_way_back_leads_to_where_it_was_typed(user):
    type_patient(user)
    user.go_to("settings")
    assert asked(user)
    stay(user)
    assert user.window.shown == "patients"
    assert user.screen.pages.has_form
    user.key(Key.Key_Escape)
    closes_at_once(user)


def test_who_is_asked_twice_answers_once(user):
    type_patient(user)
    assert asked(user)
    assert asked(user)
    lose(user)


def test_what_was_typed_before_a_lock_is_not_lost_with_the_locked_window(user):
    type_patient(user)
    user.application.lock()
    user.until(lambda: user.workspace is None)
    user.settle()
    assert "before the window locked" in asked(user)
    stay(user)
    unlock(user)
    assert user.screen.pages.has_form
    assert "What was typed of a patient" in asked(user)
    lose(user)


def test_a_signal_closes_without_this_question(user):
    type_patient(user)
    user.application.end()
    user.until(lambda: not user.window.isVisible())
    assert not visible_dialogs()


def test_markers_that_were_learned_are_asked_for_until_they_are_in_use(user):
    user.go_to("markers")
    led = json.dumps(target_to_document(LedParams(least_brightness=0.9)))
    user.screen.take_back(led)
    assert "The markers that were learned" in asked(user)
    stay(user)
    user.click("Use these markers")
    closes_at_once(user)


def type_notes(user):
    session = choose_session(user)
    user.go_to("review")
    panel = user.screen._notes
    panel.show_notes(session.session_id, "", can_edit=True)
    panel.findChild(QPlainTextEdit).setPlainText("knee, left")
    return session


def test_notes_are_saved_when_the_window_closes(user, tmp_path):
    session = type_notes(user)
    closes_at_once(user)
    with open_store(tmp_path / "store", SECRET) as store:
        assert store.sessions.get(session.session_id).notes == "knee, left"


def test_notes_that_cannot_be_saved_are_asked_for(user, monkeypatch):
    def fail(*_ids, **_fields):
        raise ServerAwayError("The server does not answer.")

    type_notes(user)
    with monkeypatch.context() as patch:
        patch.setattr(user.store.sessions, "change", fail)
        assert "The notes of the session" in asked(user)
        stay(user)
    closes_at_once(user)


def test_what_waits_to_be_tried_again_is_asked_for(user):
    def fail(_decisions):
        raise ServerAwayError("The server does not answer.")

    user.workspace.save_shared(fail)
    assert "can be tried again" in asked(user)
    stay(user)
    user.workspace.withdraw_retry()
    closes_at_once(user)


def test_a_protocol_that_was_changed_is_asked_for(user):
    user.go_to("settings")
    user.screen.marks.protocols.show_changed("{}")
    user.settle()
    assert "The protocol that was changed" in asked(user)
    lose(user)


def test_a_server_that_is_being_described_is_asked_for(user):
    user.go_to("settings")
    page = user.screen.findChild(ServersPage)
    page.findChildren(QLineEdit)[0].setText("Archive")
    assert "What was typed of a DICOM server" in asked(user)
    lose(user)


def open_recording(user, tmp_path):
    user.go_to("behaviour")
    path = make_recording(tmp_path / "child.mcap", 3)
    user.drop(path)
    user.settle()
    user.until(lambda: user.screen._presenter.source is not None)
    return path


def test_a_comment_that_is_being_typed_is_kept_with_the_coding(user, tmp_path):
    path = open_recording(user, tmp_path)
    presenter = user.screen._presenter
    presenter.coding.press(presenter.coding.draft.coding.ethogram.behaviours[0].name)
    presenter.coding.select_next(1)
    field = user.screen._selected._comment
    field.setFocus()
    QTest.keyClicks(field, "looks away")
    closes_at_once(user)
    assert "looks away" in path.with_name("child.coding.csv").read_text(encoding="utf-8")


def test_a_coding_that_cannot_be_written_is_asked_for(user, tmp_path, monkeypatch):
    def fail(*_args):
        raise BehaviourError("The disk is full.")

    open_recording(user, tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr("ui.behaviour.keeping.write_history", fail)
        assert "What was coded in the recording" in asked(user)
        stay(user)
    closes_at_once(user)


def test_a_coding_scheme_that_is_being_changed_is_asked_for(user, tmp_path):
    open_recording(user, tmp_path)
    user.screen._edit_scheme()
    (dialog,) = visible_dialogs(SchemeDialog)
    assert not dialog.unsaved()
    kind = dialog.findChildren(QComboBox)[0]
    kind.setCurrentIndex(1 - kind.currentIndex())
    kind.activated.emit(kind.currentIndex())
    assert "The coding scheme" in asked(user)
    lose(user)


def change_scheme(user, tmp_path):
    """Open the coding scheme and change the kind of a behaviour."""
    open_recording(user, tmp_path)
    user.screen._edit_scheme()
    (dialog,) = visible_dialogs(SchemeDialog)
    kind = dialog.findChildren(QComboBox)[0]
    kind.setCurrentIndex(1 - kind.currentIndex())
    kind.activated.emit(kind.currentIndex())
    return dialog


def test_the_scheme_asks_before_its_own_cancel_loses_what_was_changed(user, tmp_path):
    dialog = change_scheme(user, tmp_path)
    fields = dialog._fields
    QTest.keyClick(dialog, Key.Key_Escape)
    (question,) = visible_dialogs(QMessageBox)
    assert "The coding scheme was changed" in question.text()
    QTest.keyClick(question, Key.Key_Escape)
    assert visible_dialogs(QDialog) == [dialog]
    assert dialog._fields == fields
    QTest.keyClick(dialog, Key.Key_Escape)
    (question,) = visible_dialogs(QMessageBox)
    (close,) = [one for one in question.buttons() if one.text().replace("&", "") == "Close"]
    QTest.mouseClick(close, Qt.MouseButton.LeftButton)
    user.until(lambda: not visible_dialogs(QDialog))


def test_a_scheme_that_was_not_changed_closes_at_once(user, tmp_path):
    open_recording(user, tmp_path)
    user.screen._edit_scheme()
    (dialog,) = visible_dialogs(SchemeDialog)
    QTest.keyClick(dialog, Key.Key_Escape)
    assert not visible_dialogs(QDialog)


def test_a_lock_waits_for_no_answer_of_a_dialog(user, tmp_path):
    change_scheme(user, tmp_path)
    user.application.lock()
    assert not visible_dialogs(QDialog)
    user.until(lambda: user.application.workspace is None)


def test_a_scheme_that_was_being_changed_when_the_window_locked_goes_on(user, tmp_path):
    fields = change_scheme(user, tmp_path)._fields
    user.application.lock()
    user.until(lambda: not user.window.shown and user.workspace is None)
    unlock(user)
    user.until(lambda: user.window.shown == "behaviour")
    assert "What was being changed in the coding scheme is kept" in user.window.told
    assert "The coding scheme" in asked(user)
    stay(user)
    user.drop(tmp_path / "child.mcap")
    user.settle()
    user.until(lambda: user.screen._presenter.source is not None)
    user.screen._edit_scheme()
    (dialog,) = visible_dialogs(SchemeDialog)
    assert dialog._fields == fields
    dialog._on_accepted()
    user.until(lambda: not visible_dialogs(QDialog))
    kinds = [one.kind for one in user.screen._presenter.coding.draft.coding.ethogram.behaviours]
    assert kinds == [one.kind for one in fields.behaviours]
    assert not user.screen.draft()
    closes_at_once(user)


def test_a_scheme_that_its_user_gave_up_is_not_kept(user, tmp_path):
    dialog = change_scheme(user, tmp_path)
    QTest.keyClick(dialog, Key.Key_Escape)
    (question,) = visible_dialogs(QMessageBox)
    (close,) = [one for one in question.buttons() if one.text().replace("&", "") == "Close"]
    QTest.mouseClick(close, Qt.MouseButton.LeftButton)
    user.until(lambda: not visible_dialogs(QDialog))
    assert not user.screen.draft()


def test_who_ends_the_program_waits_for_no_answer_of_a_dialog(user, tmp_path):
    change_scheme(user, tmp_path)
    user.application.end()
    user.until(lambda: not user.window.isVisible())
    assert not visible_dialogs(QDialog)


def test_a_field_that_was_left_for_the_question_takes_the_next_key(user):
    type_patient(user)
    assert asked(user)
    stay(user)
    assert isinstance(user.focus, QLineEdit)
    user.keys(" again")
    assert "Nuria Typed again" in {one.text() for one in visible(user.window, QLineEdit)}
    assert asked(user)
    lose(user)
