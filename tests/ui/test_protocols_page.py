"""The page of protocols: opened, changed, checked line by line, saved as one's own."""

import json
from dataclasses import replace
from unittest.mock import create_autospec

import pytest
from PySide6.QtCore import QPoint, QSize, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QLabel,
    QLineEdit,
    QListWidget,
    QMessageBox,
    QPlainTextEdit,
    QPushButton,
    QTabWidget,
)

from adibas.measures import protocol_store
from adibas.measures.protocol_file import read_protocol
from adibas.measures.protocol_store import (
    find_protocol,
    new_protocol_text,
    protocol_text,
    protocol_titles,
)
from tests.unit.store_samples import add_session
from ui.settings.protocol_forms import LandmarkForm, MeasureForm
from ui.settings.protocols_presenter import Mistake, ProtocolsPresenter, ProtocolsView
from ui.settings.screen import build_settings_screen
from ui.settings.view import PROTOCOLS_TAB


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch):
    folder = tmp_path / "own protocols"
    monkeypatch.setattr(protocol_store.platformdirs, "user_data_path", lambda *_a, **_k: folder)
    return folder / "protocols"


@pytest.fixture
def view():
    return create_autospec(ProtocolsView, instance=True)


@pytest.fixture
def presenter(view, workspace):
    return ProtocolsPresenter(view, workspace)


def mine():
    """Return the text of a shipped protocol under another id."""
    return protocol_text("upper-quadrant").replace('"upper-quadrant"', '"mine"', 1)


def test_the_first_time_a_protocol_is_opened_and_checked(presenter, view):
    presenter.enter()
    names, chosen, _folder = view.show_names.call_args.args
    assert names == ("joints-15", "sapo-1", "trunk-symmetry", "upper-quadrant")
    assert chosen == "joints-15"
    assert '"id": "joints-15"' in view.show_text.call_args.args[0]
    mistakes, summary = view.show_check.call_args.args
    assert (mistakes, summary) == ((), "No mistake: 15 landmarks, 1470 measures.")


def test_every_mistake_is_told_with_its_line(presenter, view):
    presenter.check('{"format": "adibas-protocol",\n "version": 1,\n "id": "x y"}')
    mistakes, summary = view.show_check.call_args.args
    assert summary == ""
    assert all(isinstance(one, Mistake) for one in mistakes)
    assert len(mistakes) > 1
    assert {one.line for one in mistakes} <= {1, 2, 3}


def test_an_own_protocol_is_saved_under_its_id(presenter, view, told, own_folder):
    presenter.enter()
    presenter.save(mine())
    assert json.loads((own_folder / "mine.json").read_text("utf-8"))["id"] == "mine"
    assert view.show_names.call_args.args[1] == "mine"
    assert told == [("good", "Written: mine.json")]
    assert find_protocol("mine").protocol_id == "mine"
    assert "mine" in dict(protocol_titles())
    presenter.open("mine")
    assert view.show_text.call_args.args[0] == mine()


def test_a_new_protocol_begins_without_a_mistake_under_a_free_id(presenter, view, told):
    presenter.begin()
    text = view.show_text.call_args.args[0]
    assert view.show_check.call_args.args == ((), "No mistake: 2 landmarks, 1 measure.")
    assert view.show_names.call_args.args[1] == ""
    presenter.save(text)
    assert told == [("good", "Written: mine.json")]
    presenter.begin()
    assert '"id": "mine-2"' in view.show_text.call_args.args[0]


def test_no_other_protocol_of_ones_own_is_replaced(presenter, told, own_folder):
    presenter.begin()
    presenter.save(mine())
    presenter.save(mine().replace('"revision": "', '"revision": "2', 1))
    assert [kind for kind, _sentence in told] == ["good", "good"]
    presenter.open("upper-quadrant")
    presenter.save(mine())
    assert told[-1][0] == "bad"
    assert "There is a protocol named mine among yours" in told[-1][1]
    assert json.loads((own_folder / "mine.json").read_text("utf-8"))["revision"].startswith("2")


def test_a_protocol_that_was_being_changed_can_be_saved_after_a_lock(presenter, view, told):
    presenter.save(mine())
    presenter.take_back("mine", mine() + " ")
    view.show_changed.assert_called_once_with(mine() + " ")
    presenter.save(mine() + " ")
    assert [kind for kind, _sentence in told] == ["good", "good"]


def test_what_is_wrong_or_shipped_is_not_saved(presenter, told, own_folder):
    presenter.save(protocol_text("sapo-1"))
    presenter.save(mine().replace('"source"', '"sauce"', 1))
    assert [kind for kind, _sentence in told] == ["bad", "bad"]
    assert "comes with the program" in told[0][1]
    assert "line" in told[1][1]
    assert not own_folder.exists()


def test_a_protocol_that_cannot_be_read_does_not_show_the_text_of_another(
    presenter, view, own_folder
):
    presenter.open("sapo-1")
    own_folder.mkdir(parents=True)
    (own_folder / "broken.json").write_bytes(b"\xff\xfe{")
    presenter.open("broken")
    assert view.show_text.call_args.args == ("",)
    view.show_own.assert_called_with(is_own=True)


def test_an_own_protocol_is_deleted_after_a_question_and_saving_its_text_brings_it_back(
    presenter, view, told, own_folder
):
    presenter.save(mine())
    presenter.open("mine")
    view.show_own.assert_called_with(is_own=True)
    presenter.ask_delete(mine())
    question, _consent, act = view.confirm.call_args.args
    assert "Delete the protocol mine?" in question
    assert (own_folder / "mine.json").is_file()
    act()
    assert not (own_folder / "mine.json").exists()
    assert told[-1] == ("good", "mine was deleted.")
    assert view.show_names.call_args.args[:2] == (
        ("joints-15", "sapo-1", "trunk-symmetry", "upper-quadrant"),
        "",
    )
    view.show_own.assert_called_with(is_own=False)
    view.show_changed.assert_called_once_with(mine())
    presenter.save(mine())
    assert (own_folder / "mine.json").is_file()


def test_a_protocol_that_sessions_follow_is_not_deleted_and_they_are_counted(
    presenter, view, told, workspace, own_folder
):
    presenter.save(mine())
    sessions = [add_session(workspace.store) for _ in range(3)]
    for one in sessions[:2]:
        setup = replace(one.setup, protocol="mine")
        workspace.store.sessions.change(one.session_id, setup=setup)
    workspace.store.sessions.delete(sessions[1].session_id)
    presenter.ask_delete(mine())
    view.confirm.assert_not_called()
    assert told[-1][0] == "warning"
    assert told[-1][1].startswith("2 sessions follow the protocol mine")
    assert (own_folder / "mine.json").is_file()


def test_what_comes_with_the_program_or_has_no_file_is_not_deleted(presenter, view):
    for name in ("sapo-1", "gone"):
        presenter.open(name)
        view.show_own.assert_called_with(is_own=False)
        presenter.ask_delete("")
    presenter.begin()
    presenter.ask_delete("")
    view.confirm.assert_not_called()


def test_a_protocol_that_is_gone_or_no_text_is_told(presenter, told, own_folder):
    presenter.open("gone")
    own_folder.mkdir(parents=True)
    (own_folder / "broken.json").write_bytes(b"\xff\xfe{")
    presenter.open("broken")
    assert "No protocol is named gone" in told[0][1]
    assert "broken.json cannot be read" in told[1][1]


def test_what_is_typed_is_checked_after_a_pause_and_saved_with_a_button(
    workspace, qtbot, own_folder
):
    screen = build_settings_screen(workspace)
    qtbot.addWidget(screen)
    screen.resize(1140, 740)
    screen.show()
    screen.findChild(QTabWidget).setCurrentIndex(PROTOCOLS_TAB)
    page = screen.marks.protocols
    names = page.findChild(QComboBox)
    names.setCurrentIndex(names.findText("upper-quadrant"))
    names.activated.emit(names.currentIndex())
    text, mistakes = page.findChild(QPlainTextEdit), page.findChild(QListWidget)
    (save,) = [one for one in page.findChildren(QPushButton) if "own" in one.text()]
    assert save.isEnabled()
    text.setPlainText(mine().replace('"revision"', '"revison"', 1))
    assert not save.isEnabled()
    qtbot.waitUntil(lambda: mistakes.count() > 0)
    assert not save.isEnabled()
    item = mistakes.item(0)
    mistakes.itemActivated.emit(item)
    line = text.textCursor().blockNumber() + 1
    assert line == item.data(Qt.ItemDataRole.UserRole)
    (new,) = [one for one in page.findChildren(QPushButton) if "Ne&w" in one.text()]
    QTest.mouseClick(new, Qt.MouseButton.LeftButton)
    assert names.currentIndex() == -1
    text.setPlainText(mine())
    qtbot.waitUntil(save.isEnabled)
    QTest.mouseClick(save, Qt.MouseButton.LeftButton)
    assert (own_folder / "mine.json").is_file()
    assert screen.draft() == ""
    screen.closed()


def test_the_button_asks_before_it_deletes(workspace, qtbot, own_folder):
    screen = build_settings_screen(workspace)
    qtbot.addWidget(screen)
    screen.findChild(QTabWidget).setCurrentIndex(PROTOCOLS_TAB)
    page = screen.marks.protocols
    (delete,) = [one for one in page.findChildren(QPushButton) if one.text() == "Delete"]
    assert not delete.isEnabled()
    page.saved.emit(mine())
    assert delete.isEnabled()
    delete.click()
    box = page.findChild(QMessageBox)
    assert "Delete the protocol mine?" in box.text()
    assert box.defaultButton().text() == "Cancel"
    (yes,) = [one for one in box.buttons() if one.text() == "Delete"]
    yes.click()
    assert not (own_folder / "mine.json").exists()
    assert not delete.isEnabled()
    assert screen.draft() == "\n" + mine()
    screen.closed()


def test_what_is_typed_outlives_a_lock_and_another_protocol(workspace, qtbot):
    screen = build_settings_screen(workspace)
    qtbot.addWidget(screen)
    screen.marks.protocols.show_text(mine())
    assert screen.draft() == ""
    screen.marks.protocols.findChild(QPlainTextEdit).insertPlainText(" ")
    draft = screen.draft()
    assert draft == "\n " + mine()
    screen.closed()
    again = build_settings_screen(workspace)
    qtbot.addWidget(again)
    again.take_back(draft)
    assert again.draft() == draft
    again.marks.protocols.show_text("another")
    again.marks.protocols.findChild(QPlainTextEdit).undo()
    assert again.marks.protocols.findChild(QPlainTextEdit).toPlainText() == draft[1:]
    again.closed()


@pytest.fixture
def page(workspace, qtbot):
    screen = build_settings_screen(workspace)
    qtbot.addWidget(screen)
    screen.show()
    screen.marks.protocols.show_text(new_protocol_text())
    yield screen.marks.protocols
    screen.closed()


def button(widget, text):
    return next(one for one in widget.findChildren(QPushButton) if one.text() == text)


def typed(page):
    return json.loads(page.findChild(QPlainTextEdit).toPlainText())


def test_a_landmark_is_added_by_a_form_and_taken_back_by_undo(page):
    button(page, "Add a land&mark...").click()
    form = page.findChild(LandmarkForm)
    add = button(form, "&Add to the protocol")
    assert not add.isEnabled()
    form.findChild(QLineEdit).setText("Tip of the nose")
    assert not add.isEnabled()
    boxes = {one.text(): one for one in form.findChildren(QCheckBox)}
    boxes["Front"].click()
    add.click()
    assert typed(page)["landmarks"][-1] == {
        "id": "tip_of_the_nose",
        "name": {"en": "Tip of the nose"},
        "views": ["anterior"],
    }
    assert page.changed_text
    page.findChild(QPlainTextEdit).undo()
    assert typed(page) == json.loads(new_protocol_text())


def test_a_measure_of_eight_landmarks_squeezes_no_field_of_its_form(page, qapp):
    page.resize(1024, 768)
    button(page, "Add a meas&ure...").click()
    form = page.findChild(MeasureForm)
    kind, *points, _axis = form.findChildren(QComboBox)
    kind.setCurrentIndex(kind.findData("trunk_symmetry"))
    for size in (form.size(), QSize(0, 0)):  # as it is, and as small as it lets itself be made
        form.resize(size)
        qapp.processEvents()
        assert all(box.isVisible() for box in points)
        assert [box.height() for box in points] == [box.sizeHint().height() for box in points]
        assert points[-1].mapTo(form, QPoint(0, points[-1].height())).y() < form.height()
    form.reject()


def test_a_measure_is_added_by_a_form_without_writing_json(page, qtbot):
    button(page, "Add a meas&ure...").click()
    form = page.findChild(MeasureForm)
    name, positive = form.findChildren(QLineEdit)
    kind, *points, axis = form.findChildren(QComboBox)
    name.setText("Shoulder beside the middle")
    {one.text(): one for one in form.findChildren(QCheckBox)}["Front"].click()
    assert [box.isVisibleTo(form) for box in points] == [True] * 2 + [False] * 6
    kind.setCurrentIndex(kind.findData("offset"))
    assert [axis.itemData(i) for i in range(axis.count())] == ["left", "right", "up"]
    points[0].setCurrentIndex(points[0].findText("Acromion, left"))
    points[1].setCurrentIndex(points[1].findText("Middle of the acromia"))
    add = button(form, "&Add to the protocol")
    assert not add.isEnabled()  # what a positive value means is not said
    positive.setText("to the patient's left")
    add.click()
    checked = read_protocol(page.findChild(QPlainTextEdit).toPlainText(), "new")
    assert checked.errors == ()
    added = checked.protocol.measures[-1]
    assert (added.kind, added.points, added.axis) == (
        "offset",
        ("left_acromion", "mid_acromia"),
        "left",
    )
    told = "No mistake: 2 landmarks, 2 measures."
    qtbot.waitUntil(lambda: told in [one.text() for one in page.findChildren(QLabel)])


def test_a_distance_has_neither_direction_nor_sign(page):
    button(page, "Add a meas&ure...").click()
    form = page.findChild(MeasureForm)
    kind, *_points, axis = form.findChildren(QComboBox)
    kind.setCurrentIndex(kind.findData("distance"))
    form.findChildren(QLineEdit)[0].setText("Shoulders")
    {one.text(): one for one in form.findChildren(QCheckBox)}["Back"].click()
    assert not axis.isVisibleTo(form)
    button(form, "&Add to the protocol").click()
    added = typed(page)["measures"][-1]
    assert (added["kind"], added["unit"], added["points"]) == (
        "distance",
        "mm",
        ["right_acromion", "left_acromion"],
    )
    assert not {"axis", "positive"} & set(added)


def test_a_text_with_mistakes_of_writing_opens_no_form_and_says_why(page, told):
    page.show_text("{")
    button(page, "Add a meas&ure...").click()
    button(page, "Add a land&mark...").click()
    assert page.findChild(LandmarkForm) is None
    assert "mistakes of writing" in told[-1][1]
