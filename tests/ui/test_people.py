"""People and roles in the window: who is in, what is offered to whom, and who looks after it."""

from unittest.mock import create_autospec

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QAbstractButton, QComboBox, QPushButton, QTabWidget

from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.sessions import open_store, people
from adibas.sessions.roles import Permission, Role
from tests.ui import window_user
from tests.ui.conftest import CHEAP, NoSensor
from tests.ui.window_user import CTRL, SECRET
from tests.unit.store_samples import add_patient
from ui.patients.pages import PatientPages
from ui.patients.screen import build_patients_screen
from ui.settings.people_presenter import PeoplePresenter, PeopleView, PersonEntry
from ui.settings.screen import build_settings_screen
from ui.widgets.for_roles import keep_for_roles
from ui.workspace import Workspace

open_window = window_user.open_window
ANNA, CARLA = "anna has a long one", "carla, still another"
ADMINISTRATORS = "Only for administrators."
NAME = "Rosa Ibarra"


@pytest.fixture(autouse=True)
def cheap(monkeypatch):
    """Let guesses cost nothing: no test waits for them."""
    monkeypatch.setattr(people, "Argon2Params", lambda: CHEAP)


@pytest.fixture
def view():
    return create_autospec(PeopleView, instance=True)


@pytest.fixture
def presenter(view, workspace):
    return PeoplePresenter(view, workspace)


@pytest.fixture
def as_operator(store, inline_jobs, preferences):
    """The workspace of Carla, an operator, beside Anna who has the store open."""
    store.people.add("Anna", Role.ADMINISTRATOR, ANNA)
    store.people.add("Carla", Role.OPERATOR, CARLA)
    folder = store.folder
    store.close()
    with open_store(folder, CARLA) as hers:
        yield Workspace(hers, inline_jobs, preferences, NoSensor())


def entry(name, role=Role.OPERATOR, passphrase=CARLA, repeated=CARLA):
    return PersonEntry(name, role, passphrase, repeated)


def test_the_first_person_becomes_the_administrator_and_is_in_at_once(presenter, view, workspace):
    became = []
    workspace.person_changed.subscribe(lambda: became.append(workspace.store.person.name))
    presenter.enter()
    view.show_rights.assert_called_with(is_seen=True, can_change=True)
    view.show_people.assert_called_once_with((), "")
    view.show_person.assert_called_once_with(
        PersonEntry(role=Role.ADMINISTRATOR), is_new=True, can_choose_role=False
    )
    presenter.save(entry("Anna", Role.ADMINISTRATOR, ANNA, ANNA))
    assert became == ["Anna"]
    view.show_people.assert_called_with(("Anna",), "")
    view.show_person.assert_called_with(PersonEntry(), is_new=True, can_choose_role=True)


def test_a_person_gets_a_role_and_a_passphrase_and_goes(presenter, view, workspace):
    presenter.enter()
    presenter.save(entry("Anna", Role.ADMINISTRATOR, ANNA, ANNA))
    presenter.save(entry("Carla"))
    presenter.choose("Carla")
    view.show_person.assert_called_with(
        PersonEntry("Carla", Role.OPERATOR), is_new=False, can_choose_role=True
    )
    presenter.save(entry("Carla", Role.CLINICIAN, "carla has a new one", "carla has a new one"))
    with open_store(workspace.store.folder, "carla has a new one") as hers:
        assert hers.role is Role.CLINICIAN
    presenter.save(entry("Carla", Role.OPERATOR, "", ""))
    with open_store(workspace.store.folder, "carla has a new one") as hers:
        assert hers.role is Role.OPERATOR
    presenter.remove()
    assert [one.name for one in workspace.store.people.all()] == ["Anna"]


def test_a_passphrase_that_cannot_be_leaves_the_role_and_the_page_shows_what_is(
    presenter, view, told, workspace
):
    presenter.enter()
    presenter.save(entry("Anna", Role.ADMINISTRATOR, ANNA, ANNA))
    presenter.save(entry("Carla"))
    presenter.choose("Carla")
    for passphrase in ("short", ANNA):
        view.show_person.reset_mock()
        presenter.save(entry("Carla", Role.ADMINISTRATOR, passphrase, passphrase))
        assert told[-1][0] == "bad"
        assert workspace.store.people.all()[1].role is Role.OPERATOR
        view.show_person.assert_called_once_with(
            PersonEntry("Carla", Role.OPERATOR), is_new=False, can_choose_role=True
        )


def test_what_was_typed_of_a_new_person_stays_where_it_cannot_be_saved(presenter, view, told):
    presenter.enter()
    view.show_person.reset_mock()
    presenter.save(entry("Anna", Role.ADMINISTRATOR, "short", "short"))
    assert told[-1][0] == "bad"
    view.show_person.assert_not_called()


def test_passphrases_that_differ_change_nothing(presenter, told, workspace):
    presenter.enter()
    presenter.save(entry("Anna", Role.ADMINISTRATOR, ANNA, ANNA + "!"))
    assert "differ" in told[0][1]
    assert workspace.store.people.all() == ()


def test_operators_do_not_see_who_else_there_is(view, as_operator):
    presenter = PeoplePresenter(view, as_operator)
    presenter.enter()
    view.show_rights.assert_called_once_with(is_seen=False, can_change=True)
    view.show_people.assert_not_called()


def test_settings_offer_an_operator_nothing_of_administrators(qtbot, as_operator):
    screen = build_settings_screen(as_operator)
    qtbot.addWidget(screen)
    screen.show()
    screen.entered()
    tabs = screen.findChild(QTabWidget)
    kept = {tabs.tabText(index) for index in range(tabs.count()) if not tabs.isTabEnabled(index)}
    assert kept == {"Audit log", "Protocols"}
    assert tabs.tabToolTip(2) == ADMINISTRATORS
    who_works = vars(vars(screen)["_general"])["_operator"]
    assert (who_works.text(), who_works.isReadOnly()) == ("Carla", True)
    as_operator.preferences.change(operator="somebody else")
    assert who_works.text() == "Carla"
    tabs.setCurrentIndex(1)
    assert not screen.protected.people.isVisible()
    for page in (screen.protected.backup, screen.protected.retention):
        assert not page.isEnabled()
        assert page.toolTip() == ADMINISTRATORS
    screen.closed()


def test_an_operator_who_finds_nobody_is_told_how_much_to_type(qtbot, as_operator):
    as_operator.store.patients.add(Identity(NAME, None, "HC-77"))
    screen = build_patients_screen(as_operator)
    qtbot.addWidget(screen)
    screen.entered()
    screen.list.search.setText("HC-7")
    assert "Type three letters" in vars(screen.list)["_count"].text()
    screen.list.search.setText("hc-77")
    assert vars(screen.list)["_count"].text() == ""
    screen.closed()


def test_an_administrator_adds_somebody_in_the_settings(qtbot, workspace):
    screen = build_settings_screen(workspace)
    qtbot.addWidget(screen)
    screen.show()
    screen.entered()
    screen.findChild(QTabWidget).setCurrentIndex(1)
    page = screen.protected.people
    page.show_person(PersonEntry("Anna", Role.ADMINISTRATOR), is_new=True, can_choose_role=False)
    for field in (vars(page)["_passphrase"], vars(page)["_again"]):
        field.setText(ANNA)
    next(one for one in page.findChildren(QPushButton) if "Save" in one.text()).click()
    assert workspace.store.person.name == "Anna"
    chooser = page.findChild(QComboBox)
    assert [chooser.itemText(index) for index in range(chooser.count())] == ["Anna", "A new person"]
    screen.closed()


def test_a_button_for_others_stays_disabled_and_says_why(qtbot):
    pages = PatientPages()
    qtbot.addWidget(pages)
    parts = (*pages.patient.for_roles(), *pages.history.for_roles())
    keep_for_roles(parts, lambda permission: permission is not Permission.PURGE)
    for button, permission in parts:
        button.setEnabled(True)
        button.setToolTip("what it does")
        is_kept = permission is Permission.PURGE
        assert button.isEnabled() is not is_kept
        assert button.toolTip() == (ADMINISTRATORS if is_kept else "what it does")
        assert button.accessibleDescription() == (ADMINISTRATORS if is_kept else "")


@pytest.fixture
def shared(tmp_path):
    """A store with a patient that Anna and Carla may open."""
    with open_store(tmp_path / "store", SECRET, key_params=CHEAP) as store:
        patient = add_patient(store, Identity(NAME, None, "HC-77"))
        store.sessions.start(patient.pseudonym, SessionSetup())
        store.people.add("Anna", Role.ADMINISTRATOR, ANNA)
        store.people.add("Carla", Role.OPERATOR, CARLA)


def unlock(user, passphrase):
    user.until(lambda: not user.window.shown and user.workspace is None)
    user.settle()
    user.window.activateWindow()
    user.until(user.window.isActiveWindow)
    user.give_passphrase(passphrase)
    user.until(lambda: user.window.shown)
    user.settle()


def button(user, name):
    return user.window.findChild(QAbstractButton, f"go-{name}")


@pytest.mark.usefixtures("shared")
def test_each_finds_in_the_window_what_their_role_may_and_only_their_own_typing(open_window):
    user = open_window()
    unlock(user, ANNA)
    person = vars(user.window)["_person"]
    assert person.text() == "Anna  ·  Administrator"
    assert button(user, "reports").isEnabled()
    user.key(Qt.Key.Key_N, CTRL)
    user.keys("Nuria Typed")
    user.application.lock()
    assert not person.isVisible()
    unlock(user, CARLA)
    assert person.text() == "Carla  ·  Operator"
    assert not user.screen.pages.has_form
    for name in ("reports", "comparison"):
        assert not button(user, name).isEnabled()
        assert button(user, name).toolTip() == "Only for clinicians and administrators."
    user.key(Qt.Key.Key_5, CTRL)
    assert user.window.shown == "patients"
    user.application.lock()
    unlock(user, ANNA)
    assert user.screen.pages.has_form
    user.key(Qt.Key.Key_Escape)
    user.close()


@pytest.mark.usefixtures("shared")
def test_an_operator_finds_a_patient_by_name_and_cannot_hide_them(open_window):
    user = open_window()
    unlock(user, CARLA)
    assert NAME not in {row.identity.name for row in user.store.patients.search("")}
    user.keys("ibarra")
    user.key(Qt.Key.Key_Down)
    user.settle()
    assert user.workspace.patient.identity.name == NAME
    user.key(Qt.Key.Key_Delete)
    user.settle()
    assert not user.store.patients.get(user.workspace.patient.pseudonym).is_deleted
    user.close()
