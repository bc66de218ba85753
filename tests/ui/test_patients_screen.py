"""The patients screen under mouse and keyboard, over a real store and real jobs."""

from datetime import UTC, date, datetime

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QCheckBox, QLineEdit, QPushButton

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.patients import Consent, Identity
from adibas.data.posture import Provenance
from adibas.data.sessions import SessionSetup
from adibas.geometry.pinhole import Intrinsics
from adibas.sessions import NewCapture
from adibas.texts import LANGUAGES, speaking, use_language
from tests.unit.store_samples import add_patient, consent
from ui.jobs import JobRunner
from ui.patients.list_panel import PatientListPanel, PatientTable
from ui.patients.patients_model import PatientsModel
from ui.patients.screen import build_patients_screen
from ui.widgets.typed_consent import TypedConsent
from ui.workspace import Workspace

Key = Qt.Key
CTRL = Qt.KeyboardModifier.ControlModifier
LEFT = Qt.MouseButton.LeftButton
NOW = datetime(2026, 5, 4, 12, tzinfo=UTC)


@pytest.fixture
def ana(store):
    identity = Identity("Ana Ruiz", date(2014, 3, 27), "HC-1")
    return add_patient(store, identity, notes="knee")


@pytest.fixture
def bernat(store):
    """Without a consent."""
    return store.patients.add(Identity("Bernat Puig", date(1960, 1, 2)))


@pytest.fixture
def wanted(workspace):
    names = []
    workspace.screen_wanted.subscribe(names.append)
    return names


@pytest.fixture
def screen(ana, bernat, workspace, theme, qtbot):  # noqa: ARG001  (they are there)
    """The screen with two patients, as the window shows it."""
    screen = build_patients_screen(workspace)
    qtbot.addWidget(screen)
    screen.resize(1140, 740)
    screen.show()
    screen.entered()
    yield screen
    screen.closed()


def add_session(store, patient, *views):
    session = store.sessions.start(patient.pseudonym, SessionSetup())
    camera = CameraCalibration(64, 48, Intrinsics(500.0, 500.0, 31.5, 23.5))
    for view in views:
        new = NewCapture(
            view,
            "",
            0,
            30,
            RgbdCalibration(color=camera),
            (),
            (),
            Provenance("", "", "0.1.0", "2026", {}),
        )
        store.captures.add(session.session_id, new, np.full((48, 64, 3), (200, 40, 40), np.uint8))
    return store.sessions.get(session.session_id)


def column(screen, number=0):
    model = screen.list.table.model()
    return [model.index(row, number).data() for row in range(model.rowCount())]


def choose(screen, row=0):
    screen.list.table.setFocus()
    screen.list.table.selectRow(row)


def button(parent, text):
    """Return the button that is seen with these words."""
    QApplication.processEvents()
    found = [
        one
        for one in parent.findChildren(QPushButton)
        if one.text().replace("&", "") == text and one.isVisible()
    ]
    assert len(found) == 1, f"{len(found)} buttons {text!r}"
    return found[0]


def click(parent, text):
    QTest.mouseClick(button(parent, text), LEFT)


def in_focus():
    return QApplication.focusWidget()


def test_a_list_that_gets_narrower_leaves_out_birth_dates_and_then_counts(qtbot):
    model = PatientsModel()
    table = PatientTable()
    qtbot.addWidget(table)
    table.setModel(model)
    model.retranslate()
    table.fit_columns()
    table.show()
    shown = []
    for width in range(900, 250, -10):
        table.resize(width, 300)
        QApplication.processEvents()
        columns = tuple(one for one in range(5) if not table.isColumnHidden(one))
        if columns not in shown:
            shown.append(columns)
        is_scrolled = table.horizontalScrollBar().maximum() > 0
        assert not is_scrolled or columns == (0, 2, 4)
    assert shown == [(0, 1, 2, 3, 4), (0, 2, 3, 4), (0, 2, 4)]
    table.resize(900, 300)
    assert not any(table.isColumnHidden(one) for one in range(5))


def test_the_list_says_who_when_born_and_how_many_sessions(screen, store, ana):
    add_session(store, ana)
    screen.entered()
    assert column(screen) == ["Ana Ruiz", "Bernat Puig"]
    assert column(screen, 1)[0].startswith("27 Mar 2014  (")
    assert column(screen, 2) == ["HC-1", ""]
    assert column(screen, 3) == ["1", ""]


def test_a_session_is_started_by_the_keyboard_alone(screen, store, workspace, wanted, bernat):
    store.patients.give_consent(bernat.pseudonym, consent())
    assert in_focus() is screen.list.search
    QTest.keyClicks(in_focus(), "puig")
    assert column(screen) == ["Bernat Puig"]
    QTest.keyClick(in_focus(), Key.Key_Down)
    assert workspace.patient.pseudonym == bernat.pseudonym
    QTest.keyClick(in_focus(), Key.Key_Return)
    assert in_focus() is screen.pages.history.start
    QTest.keyClick(in_focus(), Key.Key_Return)
    assert workspace.session.patient == bernat.pseudonym
    assert wanted == ["capture"]


def test_up_in_the_first_line_leads_back_to_the_search(screen):
    QTest.keyClick(screen.list.search, Key.Key_Return)
    assert in_focus() is screen.list.table
    QTest.keyClick(in_focus(), Key.Key_Down)
    QTest.keyClick(in_focus(), Key.Key_Up)
    assert in_focus() is screen.list.table
    QTest.keyClick(in_focus(), Key.Key_Up)
    assert in_focus() is screen.list.search
    QTest.keyClick(screen.list.table, Key.Key_F, CTRL)
    assert in_focus() is screen.list.search


def test_nobody_found_says_what_to_do(screen):
    QTest.keyClicks(screen.list.search, "zz")
    QTest.keyClick(screen.list.search, Key.Key_Down)
    assert in_focus() is screen.list.search
    assert "Try fewer letters" in screen.list._count.text()


def test_a_search_keeps_the_chosen_patient_and_chooses_no_other(screen, workspace, ana):
    choose(screen)
    QTest.keyClicks(screen.list.search, "puig")
    assert workspace.patient == ana
    assert not screen.list.table.currentIndex().isValid()
    screen.list.search.clear()
    assert screen.list.table.currentIndex().row() == 0


def test_a_new_patient_with_a_guardian_is_typed_without_the_mouse(screen, workspace):
    QTest.keyClick(screen, Key.Key_N, CTRL)
    assert not screen.list.isEnabled()
    for text in ("Gil Mas", "3/4/2019", "HC-9"):
        QTest.keyClicks(in_focus(), text)
        QTest.keyClick(in_focus(), Key.Key_Tab)
    form = screen.pages.form
    form._consents.setFocus()
    QTest.keyClick(form._consents, Key.Key_Space)
    QTest.keyClick(form._name, Key.Key_Return)
    assert "guardian" in form._problem.text()
    assert in_focus() is form._consent.guardian
    QTest.keyClicks(in_focus(), "Iu Mas")
    QTest.keyClick(in_focus(), Key.Key_Return)
    patient = workspace.patient
    assert patient.identity == Identity("Gil Mas", date(2019, 4, 3), "HC-9")
    (consent,) = patient.consents
    assert (consent.given_by, consent.is_guardian) == ("Iu Mas", True)
    assert screen.list.isEnabled()
    assert column(screen) == ["Ana Ruiz", "Bernat Puig", "Gil Mas"]


def test_f2_changes_and_escape_forgets(screen, workspace):
    choose(screen)
    QTest.keyClick(screen.list.table, Key.Key_F2)
    QTest.keyClicks(in_focus(), "!")
    QTest.keyClick(in_focus(), Key.Key_Escape)
    assert workspace.patient.identity.name == "Ana Ruiz"
    assert in_focus() is screen.list.table
    QTest.keyClick(in_focus(), Key.Key_F2)
    assert in_focus().text() == "Ana Ruiz"
    QTest.keyClick(in_focus(), Key.Key_End)
    QTest.keyClicks(in_focus(), " Gil")
    QTest.keyClick(in_focus(), Key.Key_Return)
    assert workspace.patient.identity.name == "Ana Ruiz Gil"
    assert column(screen)[0] == "Ana Ruiz Gil"


def test_ctrl_enter_saves_the_open_form_and_starts_no_session(screen, store, workspace, wanted):
    choose(screen)
    ana = workspace.patient
    QTest.keyClick(screen, Key.Key_N, CTRL)
    QTest.keyClicks(in_focus(), "Carla Nova")
    QTest.keyClick(screen.pages.form._notes, Key.Key_Return, CTRL)
    assert workspace.patient.identity.name == "Carla Nova"
    click(screen, "Consent")
    QTest.keyClick(in_focus(), Key.Key_Return, CTRL)
    assert [one.given_by for one in workspace.patient.consents] == ["Carla Nova"]
    assert (store.sessions.of_patient(ana.pseudonym), wanted) == ((), [])
    QTest.keyClick(in_focus(), Key.Key_Return, CTRL)
    assert workspace.session.patient == workspace.patient.pseudonym
    assert wanted == ["capture"]


def test_a_consent_is_given_and_withdrawn(screen, store, workspace, ana):
    store.patients.withdraw_consent(ana.pseudonym, 0)
    choose(screen)
    assert "withdrawn" in screen.pages.patient._consent.text()
    click(screen, "Consent")
    click(screen, "Save the consent")
    assert "guardian" in screen.pages.consents._problem.text()
    QTest.keyClicks(in_focus(), "Eva Ruiz")
    QTest.keyClick(in_focus(), Key.Key_Return)
    assert workspace.patient.consents[1].given_by == "Eva Ruiz"
    assert "Eva Ruiz" in screen.pages.patient._consent.text()
    click(screen, "Consent")
    click(screen, "Withdraw")
    assert workspace.patient.consents[1].withdrawn_utc is not None
    click(screen, "Consent")
    assert not [
        b
        for b in screen.pages.consents.findChildren(QPushButton)
        if b.text() == "Withdraw" and b.isVisible()
    ]
    QTest.keyClick(in_focus(), Key.Key_Escape)
    assert "withdrawn" in screen.pages.patient._consent.text()


def test_who_starts_without_a_consent_records_one_and_starts(screen, workspace, bernat, wanted):
    choose(screen, 1)
    assert workspace.patient.pseudonym == bernat.pseudonym
    assert "No consent" in screen.pages.patient._consent.text()
    click(screen, "Start a session")
    assert workspace.session is None
    click(screen, "Save the consent")
    assert "Treatment" in screen.pages.patient._consent.text()
    click(screen, "Start a session")
    assert workspace.session.patient == bernat.pseudonym
    assert wanted == ["patients", "patients", "capture"]


def test_delete_hides_and_undo_brings_back(screen, workspace, ana):
    choose(screen)
    QTest.keyClick(screen.list.table, Key.Key_Delete)
    assert column(screen) == ["Bernat Puig"]
    click(screen, "Undo")
    assert column(screen) == ["Ana Ruiz", "Bernat Puig"]
    QTest.keyClick(screen.list.table, Key.Key_Delete)
    assert column(screen) == ["Bernat Puig"]
    QTest.keyClick(screen.list.table, Key.Key_Z, CTRL)
    assert workspace.patient.pseudonym == ana.pseudonym


def test_delete_in_the_search_field_deletes_letters_alone(screen):
    choose(screen)
    QTest.keyClicks(screen.list.search, "a")
    QTest.keyClick(screen.list.search, Key.Key_Delete)
    assert "Ana Ruiz" in column(screen)


def test_nothing_is_removed_for_good_before_the_word_is_typed(screen, store):
    choose(screen)
    QTest.mouseClick(screen.list.findChild(QCheckBox), LEFT)
    click(screen, "Delete")
    click(screen, "Remove for good")
    dialog = screen.findChild(TypedConsent)
    field = dialog.findChild(QLineEdit)
    QTest.keyClicks(field, "yes")
    QTest.mouseClick(dialog.remove, LEFT)
    QTest.keyClick(field, Key.Key_Return)
    assert len(store.patients.search("", with_deleted=True)) == 2
    click(screen, "Remove for good")
    dialog = screen.findChildren(TypedConsent)[-1]
    QTest.keyClicks(dialog.findChild(QLineEdit), screen._patients._pseudonym())
    QTest.mouseClick(dialog.remove, LEFT)
    assert column(screen) == ["Bernat Puig"]


@pytest.mark.usefixtures("theme")
def test_the_history_shows_pictures_read_in_another_thread(ana, store, workspace, qtbot):
    session = add_session(store, ana, "anterior", "posterior")
    workspace.jobs = jobs = JobRunner(pytest.fail)
    screen = build_patients_screen(workspace)
    qtbot.addWidget(screen)
    screen.resize(1140, 740)
    screen.show()
    screen.entered()
    choose(screen)
    history = screen.pages.history.list
    model = history.shown_model
    qtbot.waitUntil(lambda: all(one.pixmap for one in model.shown(0).captures))
    assert [one.caption for one in model.shown(0).captures] == ["Front", "Back"]
    qtbot.waitUntil(lambda: not jobs.is_busy)
    picture = history.viewport().grab().toImage()
    cells = history._delegate._cells(
        history.visualRect(model.index(0)),
        2,
        model.shown(0).text,
        history.fontMetrics(),
    )
    assert picture.pixelColor(cells[1].center() - QPoint(0, 8)).red() > 180
    assert session.session_id == model.session(0).session_id
    screen.closed()
    jobs.close()


def test_a_double_click_on_a_picture_opens_its_capture(screen, store, workspace, wanted, ana):
    session = add_session(store, ana, "anterior", "posterior")
    choose(screen)
    history = screen.pages.history.list
    rect = history.visualRect(history.shown_model.index(0))
    cells = history._delegate._cells(
        rect, 2, history.shown_model.shown(0).text, history.fontMetrics()
    )
    QTest.mouseDClick(history.viewport(), LEFT, Qt.KeyboardModifier.NoModifier, cells[1].center())
    assert workspace.capture_id == session.capture_ids[1]
    assert wanted == ["review"]


def test_enter_opens_and_delete_hides_a_session(screen, store, workspace, wanted, ana):
    session = add_session(store, ana, "anterior")
    choose(screen)
    history = screen.pages.history.list
    history.setFocus()
    QTest.keyClick(history, Key.Key_Down)
    QTest.keyClick(history, Key.Key_Return)
    assert workspace.capture_id == session.capture_ids[0]
    assert wanted == ["review"]
    QTest.keyClick(history, Key.Key_Delete)
    assert workspace.session is None
    assert not history.isVisible()
    click(screen, "Undo")
    assert history.shown_model.rowCount() == 1
    QTest.mouseClick(screen.list.findChild(QCheckBox), LEFT)
    history.setCurrentIndex(history.shown_model.index(0))
    click(screen.pages.history, "Delete")
    click(screen.pages.history, "Remove for good")
    dialog = screen.findChild(TypedConsent)
    QTest.keyClicks(dialog.field, ana.pseudonym.lower())
    QTest.mouseClick(dialog.remove, LEFT)
    assert store.sessions.of_patient(ana.pseudonym, with_deleted=True) == ()


def test_a_session_that_got_a_capture_elsewhere_shows_it(screen, store, workspace, ana):
    choose(screen)
    session = store.sessions.start(ana.pseudonym, SessionSetup())
    workspace.choose_session(session)
    assert "0 captures" in screen.pages.history.list.shown_model.index(0).data()
    workspace.choose_session(add_session(store, ana, "anterior"))
    assert "1 capture" in screen.pages.history.list.shown_model.index(0).data()
    assert column(screen, 3)[0] == "2"


def test_a_store_that_is_only_read_says_why_nothing_can_be_changed(
    ana, read_only_store, inline_jobs, preferences, qtbot
):
    workspace = Workspace(read_only_store, inline_jobs, preferences, None)
    screen = build_patients_screen(workspace)
    qtbot.addWidget(screen)
    screen.show()
    screen.entered()
    choose(screen)
    assert workspace.patient == ana
    assert screen.list._read_only.isVisible()
    for text in ("New patient", "Edit", "Consent", "Start a session"):
        assert not button(screen, text).isEnabled()
    for key, modifier in ((Key.Key_N, CTRL), (Key.Key_F2, Qt.KeyboardModifier.NoModifier)):
        QTest.keyClick(screen.list.table, key, modifier)
        assert not screen.pages.has_form
    QTest.keyClick(screen.list.table, Key.Key_Delete)
    assert column(screen) == ["Ana Ruiz"]
    assert "Record one" not in screen.pages.patient._consent.text()
    screen.closed()


def test_every_text_changes_with_the_language(screen, store, ana):
    store.patients.give_consent(ana.pseudonym, Consent(("treatment",), "Eva", True, NOW))
    choose(screen)
    QTest.keyClick(screen.list.table, Key.Key_Delete)
    click(screen, "Undo")
    use_language("es")
    screen.retranslate()
    spoken = {one.text().replace("&", "") for one in screen.findChildren(QPushButton)}
    use_language("en")
    screen.retranslate()
    english = {one.text().replace("&", "") for one in screen.findChildren(QPushButton)}
    assert len(spoken) > 10
    assert spoken.isdisjoint(english - {""})


def test_every_control_can_be_named_aloud(screen, store, ana):
    add_session(store, ana)
    choose(screen)
    nameless = [
        widget
        for kind in (QPushButton, QCheckBox)
        for widget in screen.findChildren(kind)
        if not widget.text() and not widget.accessibleName()
    ]
    assert not nameless
    buddies = {label.buddy() for label in screen.pages.form._labels.values()}
    lines = set(screen.pages.form.findChildren(QLineEdit))
    assert lines <= {*buddies, screen.pages.form._consent.guardian}
    assert screen.list.search.accessibleName()
    assert screen.list.table.accessibleName()
    assert screen.pages.history.list.accessibleName()


def test_a_repeat_is_ticked_beside_the_list_of_sessions(screen, store, workspace, ana):
    repeat, sessions = screen.pages.history._repeat, screen.pages.history.list
    _first, second = (add_session(store, ana, "anterior") for _n in range(2))
    workspace.choose_patient(ana)
    for ticked in (False, True, False):
        sessions.setCurrentIndex(sessions.shown_model.index(1))
        assert repeat.isHidden(), "nothing was before the first one"
        sessions.setCurrentIndex(sessions.shown_model.index(0))
        assert not repeat.isHidden()
        assert repeat.isChecked() == ticked
        QTest.mouseClick(repeat, LEFT, pos=QPoint(8, repeat.height() // 2))
        assert store.sessions.get(second.session_id).setup.is_repeat != ticked


def test_two_sessions_with_pictures_can_be_compared(screen, store, workspace, ana, wanted):
    compare, protocol = screen.pages.history._compare, screen.pages.history._protocol
    add_session(store, ana, "anterior")
    workspace.choose_patient(ana)
    assert compare.isHidden()
    add_session(store, ana, "anterior")
    workspace.choose_patient(ana)
    QTest.mouseClick(compare, LEFT)
    assert wanted == ["comparison"]
    protocol.setCurrentIndex(protocol.findData("sapo-1"))
    protocol.activated.emit(protocol.currentIndex())
    assert workspace.preferences.now.protocol == "sapo-1"
    assert protocol.currentText() == "SAPO-1"


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_patients_are_found_by_is_in_the_tip_where_the_field_is_narrow(qtbot, language):
    with speaking(language):
        panel = PatientListPanel()
        qtbot.addWidget(panel)
        panel.retranslate()
    hint = panel.search.placeholderText()
    assert hint in panel.search.toolTip()
    assert "Ctrl+F" in panel.search.toolTip()
