"""What a user may do wrong, and what may happen meanwhile, on the real window and a real store."""

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QAbstractButton,
    QComboBox,
    QDialog,
    QGroupBox,
    QLabel,
    QPlainTextEdit,
    QTableView,
    QTabWidget,
    QTextEdit,
)

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import ServerAwayError
from adibas.recordings import create_recording
from adibas.sessions import open_store
from adibas.texts import translate
from tests.ui import window_user
from tests.ui.conftest import CHEAP
from tests.ui.review_scene import saved_session
from tests.ui.window_user import CTRL, SECRET, visible, visible_dialogs
from ui.navigation import TITLES
from ui.widgets.help_page import HelpDock

open_window = window_user.open_window
Key = Qt.Key
LEAVES = {"Lock", "Help"}
"""Buttons after which another page is seen."""


@pytest.fixture(autouse=True)
def prepared(tmp_path):
    """A store with a patient, a session and two captures."""
    with open_store(tmp_path / "store", SECRET, key_params=CHEAP) as store:
        saved_session(store, ("anterior", "posterior"))


@pytest.fixture
def user(open_window):
    return at_work(open_window())


def at_work(user):
    """Unlock, and look at the session and its first capture."""
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    user.settle()
    (row,) = user.store.patients.search("Somebody")
    user.workspace.choose_patient(user.store.patients.get(row.pseudonym))
    (session,) = user.store.sessions.of_patient(row.pseudonym)
    user.workspace.choose_session(session)
    user.workspace.choose_capture(session.capture_ids[0])
    user.settle()
    return user


def words(user):
    """Return everything that is read in the window now."""
    told = [user.window.told]
    told += [one.text() for one in visible(user.window, QLabel)]
    for kind in (QPlainTextEdit, QTextEdit):
        told += [one.toPlainText() for one in visible(user.window, kind)]
    return "\n".join(told)


def cut_recording(path):
    """Write a recording and leave half of it away."""
    with create_recording(path, SourceInfo()) as writer:
        for index in range(4):
            depth = np.full((48, 64), 1000 + index, np.uint16)
            writer.write(SensorFrame(index, 33_000_000 * index, depth_raw=depth))
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def spoil(path):
    """Make a file, or a folder, that is not what its name says."""
    if path.suffix:
        path.write_bytes(b"no frames at all" * (0 if path.stem == "empty" else 50))
    else:
        path.mkdir()


@pytest.mark.parametrize(
    "name", ["empty.mcap", "garbage.mcap", "gone.mcap", "garbage.oni", "folder", "garbage.png"]
)
def test_what_is_dropped_and_is_no_recording_is_told_in_a_sentence(user, tmp_path, name, caplog):
    path = tmp_path / "dropped" / name
    path.parent.mkdir()
    if path.stem != "gone":
        spoil(path)
    assert user.drop(path)
    user.until(lambda: name in words(user))
    assert user.workspace.session is not None
    assert not [one for one in caplog.records if one.levelname == "CRITICAL"]
    user.close()


def test_a_recording_that_was_cut_is_played_as_far_as_it_goes(user, tmp_path, caplog):
    path = tmp_path / "cut.mcap"
    cut_recording(path)
    assert user.drop(path)
    user.until(lambda: user.workspace.live.newest is not None or "cut.mcap" in words(user))
    assert not [one for one in caplog.records if one.levelname == "CRITICAL"]
    user.close()


def test_what_could_be_tried_again_goes_from_the_window_with_its_patient(user):
    def fail(_decisions):
        raise ServerAwayError("The server does not answer.")

    user.workspace.save_shared(fail)
    assert user.window.told == "The server does not answer."
    user.workspace.choose_patient(None)
    assert user.window.told == ""
    user.close()


def texts(user):
    """Return the words of all controls and headings that are seen."""
    found = set()
    for kind in (QLabel, QAbstractButton):
        found |= {one.text() for one in visible(user.window, kind)}
    found |= {one.title() for one in visible(user.window, QGroupBox)}
    for tabs in visible(user.window, QTabWidget):
        found |= {tabs.tabText(index) for index in range(tabs.count())}
    for box in visible(user.window, QComboBox):
        found |= {box.itemText(index) for index in range(box.count())}
    for table in visible(user.window, QTableView):
        model = table.model()
        columns = range(model.columnCount())
        found |= {str(model.headerData(column, Qt.Orientation.Horizontal)) for column in columns}
    return found


def test_with_content_every_screen_speaks_the_new_language(user):
    english = {}
    for name in TITLES:
        user.go_to(name)
        user.settle()
        english[name] = texts(user)
    user.application.preferences.change(language="ca")
    user.qapp.processEvents()
    for name in TITLES:
        user.go_to(name)
        user.settle()
        same = (english[name] & texts(user)) - {"Somebody"}  # the patient's name
        assert sorted(text for text in same if translate(text) != text) == [], name
    user.close()


def press_everything(user):
    """Press every button of the screen that is seen, and put away what opens."""
    for button in visible(user.screen, QAbstractButton):
        text = button.text().replace("&", "")
        if button.isVisible() and button.isEnabled() and text not in LEAVES:
            button.click()
            user.qapp.processEvents()
            for dialog in visible_dialogs(QDialog):
                dialog.reject()
            user.qapp.processEvents()


@pytest.mark.parametrize("is_second", [False, True], ids=["first", "second"])
def test_whoever_presses_everything_breaks_nothing(open_window, is_second, caplog):
    first = at_work(open_window())
    user = at_work(open_window()) if is_second else first
    assert user.store.is_read_only == is_second
    for name in TITLES:
        user.window.show_screen(name)
        user.settle()
        press_everything(user)
        user.settle()
    assert not [one for one in caplog.records if one.levelname == "CRITICAL"]
    assert first.store.verify(lambda *_progress: None).is_sound
    user.lose("\N{BULLET} What was typed of a DICOM server")  # its box was ticked
    if is_second:
        first.close()


def test_a_help_that_floats_is_put_away_by_the_lock(open_window):
    user = at_work(open_window(font_scale=2.0))
    user.go_to("capture")
    user.window.show_help()
    help_dock = user.window.findChild(HelpDock)
    assert help_dock.isFloating()
    user.key(Key.Key_L, CTRL)
    user.until(lambda: user.workspace is None)
    assert not help_dock.isVisible()
    user.window.activateWindow()
    user.until(user.window.isActiveWindow)
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    user.window.show_help()
    assert help_dock.isVisible()
    user.close()
