"""Every screen has room in a small window, in every language and with letters of twice the size."""

import pytest
from PySide6.QtCore import Qt

from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.sessions import open_store
from adibas.texts import LANGUAGES
from tests.ui import window_user
from tests.ui.conftest import CHEAP
from tests.ui.window_user import SECRET
from ui.navigation import TITLES

open_window = window_user.open_window


@pytest.fixture(autouse=True)
def prepared(tmp_path):
    """A store with one patient and a session."""
    with open_store(tmp_path / "store", SECRET, key_params=CHEAP) as store:
        patient = store.patients.add(Identity("Rosa Ibarra", None, "HC-77"))
        store.sessions.start(patient.pseudonym, SessionSetup())


@pytest.fixture(autouse=True)
def usual_letters(qapp):
    """Give the next test letters of the usual size: a theme begins with those it finds."""
    font = qapp.font()
    yield
    qapp.setFont(font)


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(("font_scale", "size"), [(2.0, (1280, 800)), (1.0, (1024, 768))])
def test_no_screen_asks_for_more_room_than_there_is(open_window, language, font_scale, size):
    user = open_window(language=language, font_scale=font_scale)
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    user.keys("ibarra")
    user.key(Qt.Key.Key_Down)
    user.settle()
    for name in TITLES:
        user.window.show_screen(name)
        user.settle()
        user.window.resize(*size)
        user.qapp.processEvents()
        least = user.window.minimumSizeHint()
        assert least.width() <= size[0], name
        assert least.height() <= size[1], name
    user.close()
