"""What is held of a patient, told after a withdrawal: decisions without Qt, then the window."""

from unittest.mock import create_autospec

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QLabel, QPushButton, QWidget

from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.sessions.person_keys import Person
from adibas.sessions.roles import Role
from adibas.texts import LANGUAGES, speaking, use_language
from tests.unit.store_samples import add_capture, add_patient
from ui.patients.holdings_dialog import HoldingsDialog, open_holdings
from ui.patients.holdings_presenter import Actions, HoldingsPresenter, HoldingsView, planned
from ui.patients.screen import build_patients_screen
from ui.widgets.typed_consent import TypedConsent

SMALLEST = (1100, 700)
LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def ana(store):
    return add_patient(store, Identity("Ana Ruiz", None, "HC-1"), notes="knee")


@pytest.fixture
def measured(store, ana):
    """Ana with a session of one capture."""
    add_capture(store, store.sessions.start(ana.pseudonym, SessionSetup()))
    return ana


@pytest.fixture
def view():
    return create_autospec(HoldingsView, instance=True)


@pytest.fixture
def done():
    return []


@pytest.fixture
def actions(done):
    return Actions(lambda: done.append("hide"), lambda: done.append("remove"))


def offered(view):
    return view.show_actions.call_args.kwargs


# Decisions


def test_all_of_the_chosen_patient_is_shown_and_can_be_hidden_or_removed(
    view, workspace, actions, done, measured
):
    workspace.choose_patient(measured)
    presenter = HoldingsPresenter(view, workspace, actions)
    assert offered(view) == {"can_hide": False, "can_remove": False}
    presenter.look()
    held = view.show_holdings.call_args.args[0]
    assert (held.pseudonym, len(held.captures)) == (measured.pseudonym, 1)
    assert offered(view) == {"can_hide": True, "can_remove": True}
    presenter.hide()
    presenter.ask_removal()
    assert done == ["hide", "remove"]
    assert view.finish.call_count == 2


def test_who_is_hidden_already_can_only_be_removed(view, workspace, store, actions, measured):
    store.patients.delete(measured.pseudonym)
    workspace.choose_patient(measured)
    HoldingsPresenter(view, workspace, actions).look()
    assert offered(view) == {"can_hide": False, "can_remove": True}


def test_a_window_that_only_reads_lists_and_offers_nothing(view, second_window, actions, measured):
    second_window.choose_patient(measured)
    HoldingsPresenter(view, second_window, actions).look()
    assert len(view.show_holdings.call_args.args[0].captures) == 1
    assert offered(view) == {"can_hide": False, "can_remove": False}


def test_without_a_patient_nothing_is_looked_for(view, workspace, actions):
    HoldingsPresenter(view, workspace, actions).look()
    view.show_holdings.assert_not_called()
    assert workspace.jobs.labels == []


def test_the_backups_of_the_preferences_are_looked_into(preferences, tmp_path):
    assert planned(preferences.now) is None
    preferences.change(backup_folder=str(tmp_path), backup_days=3, backup_keep=5)
    plan = planned(preferences.now)
    assert (plan.folder, plan.every_days, plan.keep) == (tmp_path, 3, 5)


# The window


@pytest.fixture
def screen(qtbot, theme, workspace, measured):
    assert theme
    made = build_patients_screen(workspace)
    qtbot.addWidget(made)
    made.resize(*SMALLEST)
    made.show()
    made.entered()
    workspace.choose_patient(measured)
    yield made
    made.closed()


def press(qtbot, parent, text):
    QApplication.processEvents()
    (found,) = [
        one
        for one in parent.findChildren(QPushButton)
        if one.text().replace("&", "") == text and one.isVisible()
    ]
    qtbot.mouseClick(found, LEFT)


def words(dialog):
    QApplication.processEvents()
    return "\n".join(one.text() for one in dialog.findChildren(QLabel) if not one.isHidden())


def test_withdrawing_shows_what_is_held_and_from_there_it_is_removed(
    qtbot, screen, store, workspace, measured
):
    press(qtbot, screen, "Consent")
    press(qtbot, screen, "Withdraw")
    (dialog,) = screen.findChildren(HoldingsDialog)
    told = words(dialog)
    assert "capture: Front, picture" in told
    assert "withdrawn" in told
    assert "What the program cannot reach" in told
    press(qtbot, dialog, "Remove for good")
    (question,) = screen.findChildren(TypedConsent)
    qtbot.keyClicks(question.field, measured.pseudonym)
    press(qtbot, question, "Remove for good")
    assert store.patients.search("", with_deleted=True) == ()
    assert workspace.patient is None


def test_what_is_held_is_looked_at_without_withdrawing_and_hidden(qtbot, screen, store, measured):
    press(qtbot, screen, "Consent")
    press(qtbot, screen, "What is held...")
    (dialog,) = screen.findChildren(HoldingsDialog)
    assert "it stands" in words(dialog)
    press(qtbot, dialog, "Delete")
    assert store.patients.get(measured.pseudonym).is_deleted
    assert not screen.pages.has_form


@pytest.mark.usefixtures("theme")
@pytest.mark.parametrize("role", [Role.OPERATOR, Role.CLINICIAN, Role.ADMINISTRATOR])
def test_each_role_may_what_it_may_elsewhere(qtbot, workspace, actions, measured, role):
    workspace.store.audit.become(Person("7", "Anna", role))
    workspace.choose_patient(measured)
    window = QWidget()
    qtbot.addWidget(window)
    dialog = open_holdings(workspace, window, actions)
    may_hide, may_remove = role is not Role.OPERATOR, role is Role.ADMINISTRATOR
    assert (dialog._hide.isEnabled(), dialog._remove.isEnabled()) == (may_hide, may_remove)
    assert ("ask one of them" in words(dialog)) is (role is not Role.ADMINISTRATOR)
    dialog.close()


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_list_fits_into_the_smallest_window(screen, workspace, actions, language):
    use_language(language)
    try:
        dialog = open_holdings(workspace, screen, actions)
        QApplication.processEvents()
        assert dialog.width() <= screen.width()
        assert dialog.height() <= screen.height()
        assert not dialog._inside.horizontalScrollBar().isVisible()
        dialog.close()
    finally:
        use_language("en")


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.usefixtures("measured")
def test_the_smallest_list_shows_some_lines_and_all_buttons(screen, workspace, actions, language):
    with speaking(language):
        dialog = open_holdings(workspace, screen, actions)
        dialog.resize(1, 1)
        dialog.show()
        buttons = [one for one in dialog.findChildren(QPushButton) if one.isVisibleTo(dialog)]
        assert len(buttons) == 3
        for button in buttons:
            place = button.geometry()
            assert dialog.rect().contains(place), button.text()
        assert dialog._inside.viewport().height() >= 7 * dialog.fontMetrics().height()
        dialog.close()
