"""Opening the store: what is asked for, and what is said when it does not open."""

import json
from unittest.mock import create_autospec

import pytest
from keyring.backends import fail
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QLineEdit, QPushButton

from adibas.errors import PassphraseError, ServerPasswordError
from adibas.sessions import open_store
from adibas.sessions.key_file import KEY_FILE
from adibas.sessions.recovery_key import make_recovery_key
from adibas.sessions.roles import Role
from adibas.sessions.server_address import ServerAddress, read_server_file, write_server_file
from adibas.sessions.server_password import kept_password
from adibas.sessions.sqlite_file import SqliteFile
from tests.ui.conftest import CHEAP, PASSPHRASE
from tests.unit.store_samples import MemoryKeyring, use_keyring
from ui.ports import CancelledError
from ui.unlock_page import UnlockPage
from ui.unlock_presenter import UnlockPresenter, UnlockView


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


@pytest.fixture
def view():
    return create_autospec(UnlockView, instance=True)


@pytest.fixture
def opened():
    """The stores that were handed over, each with whether it is new; closed at the end."""
    stores = []
    yield stores
    for store, _is_new in stores:
        store.close()


@pytest.fixture
def presenter(view, folder, inline_jobs, opened):
    return UnlockPresenter(
        view, folder, "somebody", inline_jobs, lambda *store: opened.append(store)
    )


@pytest.fixture
def keyring_there(monkeypatch):
    use_keyring(monkeypatch, MemoryKeyring())


@pytest.fixture
def no_keyring(monkeypatch):
    use_keyring(monkeypatch, fail.Keyring())


@pytest.fixture
def behind_passphrase(folder, no_keyring):  # noqa: ARG001  (it is used)
    open_store(folder, PASSPHRASE, key_params=CHEAP).close()


def told(view):
    view.show_problem.assert_called_once()
    return view.show_problem.call_args.args[0]


@pytest.mark.usefixtures("keyring_there")
def test_with_a_keyring_nothing_is_asked_for(presenter, view, opened):
    presenter.begin()
    ((store, is_new),) = opened
    assert is_new
    assert store.operator == "somebody"
    view.show_problem.assert_not_called()
    view.ask_passphrase.assert_not_called()


@pytest.mark.usefixtures("keyring_there")
def test_the_second_start_opens_the_same_store(presenter, folder, opened):
    open_store(folder).close()
    presenter.begin()
    ((_store, is_new),) = opened
    assert not is_new


@pytest.mark.usefixtures("keyring_there")
def test_after_a_lock_a_keyring_does_not_open_by_itself(presenter, view, folder, opened):
    open_store(folder).close()
    presenter.ask()
    view.ask_unlock.assert_called()
    assert not opened
    presenter.open_from_keyring()
    assert len(opened) == 1


@pytest.mark.usefixtures("no_keyring")
def test_without_a_keyring_a_passphrase_is_chosen_by_typing_it_twice(presenter, view, opened):
    presenter.begin()
    view.ask_new_passphrase.assert_called_once()
    presenter.give_new_passphrase(PASSPHRASE, PASSPHRASE + "!")
    assert "differ" in told(view)
    assert not opened
    presenter.give_new_passphrase(PASSPHRASE, PASSPHRASE)
    ((_store, is_new),) = opened
    assert is_new


@pytest.mark.usefixtures("no_keyring")
def test_a_short_passphrase_is_asked_for_again(presenter, view, folder, opened):
    presenter.begin()
    presenter.give_new_passphrase("ab", "ab")
    assert "characters at least" in told(view)
    assert view.ask_new_passphrase.call_count == 2
    assert not opened
    assert not (folder / KEY_FILE).exists()


@pytest.mark.usefixtures("behind_passphrase")
def test_a_wrong_passphrase_is_asked_for_again(presenter, view, opened):
    presenter.begin()
    view.ask_passphrase.assert_called_once()
    presenter.give_passphrase("not this one")
    assert "passphrase is wrong" in told(view)
    assert view.ask_passphrase.call_count == 2
    presenter.give_passphrase(PASSPHRASE)
    assert len(opened) == 1


@pytest.mark.usefixtures("keyring_there")
def test_a_key_that_the_keyring_lost_can_be_tried_again(
    presenter, view, folder, opened, monkeypatch
):
    memory = MemoryKeyring()
    use_keyring(monkeypatch, memory)
    open_store(folder).close()
    use_keyring(monkeypatch, MemoryKeyring())
    presenter.begin()
    assert "keyring has lost the key" in told(view)
    view.ask_unlock.assert_called()
    use_keyring(monkeypatch, memory)
    presenter.open_from_keyring()
    assert len(opened) == 1


@pytest.mark.parametrize("text", ["", "{", '{"format": "adibas-key", "version": 1}', "[]"])
@pytest.mark.usefixtures("behind_passphrase")
def test_a_damaged_key_file_is_said_in_one_sentence(presenter, view, folder, opened, text):
    whole = (folder / KEY_FILE).read_text()
    (folder / KEY_FILE).write_text(text)
    presenter.begin()
    assert "key.json of the patient store is damaged" in told(view)
    view.ask_unlock.assert_called()
    (folder / KEY_FILE).write_text(whole)
    presenter.ask()
    view.ask_passphrase.assert_called()
    assert not opened


@pytest.mark.usefixtures("behind_passphrase")
def test_a_key_file_of_a_later_version_asks_for_an_update(presenter, view, folder):
    document = json.loads((folder / KEY_FILE).read_text())
    (folder / KEY_FILE).write_text(json.dumps(document | {"version": 99}))
    presenter.begin()
    assert "Update the program" in told(view)


@pytest.mark.usefixtures("behind_passphrase")
def test_a_database_of_a_later_version_asks_for_an_update(presenter, view, folder, opened):
    with open_store(folder, PASSPHRASE) as store, store._database.changing() as transaction:
        transaction.exec_driver_sql("UPDATE alembic_version SET version_num = '9999'")
    presenter.give_passphrase(PASSPHRASE)
    assert "later version of ADiBAS" in told(view)
    assert not opened


@pytest.mark.usefixtures("no_keyring")
def test_a_folder_that_cannot_be_written_is_said(presenter, view, folder, opened):
    folder.write_text("a file stands here")
    presenter.begin()
    presenter.give_new_passphrase(PASSPHRASE, PASSPHRASE)
    assert "store" in view.show_problem.call_args.args[0]
    assert not opened


@pytest.mark.usefixtures("behind_passphrase")
def test_who_cancels_the_opening_is_asked_again(presenter, view, inline_jobs, opened, folder):
    class Stopped:
        def progress(self, _done, _total):
            raise CancelledError

    works = []
    inline_jobs.start = lambda _label, work, *_told, ended: works.append((work, ended))
    presenter.give_passphrase(PASSPHRASE)
    ((work, ended),) = works
    with pytest.raises(CancelledError):
        work(Stopped())
    ended()
    view.ask_passphrase.assert_called_once()
    assert not opened
    with open_store(folder, PASSPHRASE) as store:  # the one that was opened is closed
        assert not store.is_read_only


@pytest.fixture
def on_a_server(folder, behind_passphrase, monkeypatch):  # noqa: ARG001  (it is used)
    """A store that opens with the password "letmein" of a server besides."""
    write_server_file(folder, ServerAddress("clinic.example", 5432, "adibas"))

    def answer(where, passphrase, *, server_password=None, **_more):
        (where / "server.json").rename(where / "kept")
        try:
            if server_password != "letmein":
                raise ServerPasswordError("The database needs the password of its user.")
            return open_store(where, passphrase)
        finally:
            (where / "kept").rename(where / "server.json")

    monkeypatch.setattr("adibas.sessions.open_store", answer, raising=False)
    # What stands in for the server is a file, which must not notice that there is a server.
    monkeypatch.setattr(SqliteFile, "check_in_place", lambda _self: None)


@pytest.mark.usefixtures("on_a_server")
def test_the_password_of_the_server_is_asked_after_the_passphrase(presenter, view, opened):
    presenter.give_passphrase(PASSPHRASE)
    view.ask_server_password.assert_called_once_with()
    view.show_problem.assert_not_called()
    presenter.give_server_password("wrong")
    assert "needs the password" in told(view)
    assert view.ask_server_password.call_args_list
    presenter.give_server_password("letmein")
    ((store, is_new),) = opened
    assert not is_new
    assert store.patients.search("") == ()


@pytest.mark.usefixtures("on_a_server")
def test_a_password_that_the_server_took_is_kept_in_the_keyring(
    presenter, folder, opened, monkeypatch
):
    kept = use_keyring(monkeypatch, MemoryKeyring())
    presenter.give_passphrase(PASSPHRASE)
    presenter.give_server_password("wrong")
    assert kept.entries == {}
    presenter.give_server_password("letmein")
    assert opened
    assert kept_password(read_server_file(folder)) == "letmein"


def test_the_page_asks_for_the_servers_password_in_its_own_words(qtbot, theme):
    page = UnlockPage(theme)
    qtbot.addWidget(page)
    page.ask_server_password()
    assert page._first.placeholderText() == "Password of the server"
    assert page._first.echoMode() == page._first.EchoMode.Password
    page.ask_passphrase()
    assert page._first.placeholderText() == "Passphrase"


# The recovery key


@pytest.fixture
def with_key(folder, behind_passphrase):  # noqa: ARG001  (it is used)
    """A store behind `PASSPHRASE`; gives its recovery key."""
    recovery_key = make_recovery_key()
    with open_store(folder, PASSPHRASE) as store:
        store.recovery.hold(recovery_key)
    return recovery_key


def test_who_lost_the_passphrase_opens_by_the_recovery_key_and_a_new_one(
    presenter, view, folder, opened, with_key
):
    presenter.begin()
    presenter.begin_recovery()
    view.ask_recovery_key.assert_called_once_with()
    presenter.give_recovery_key(with_key.lower())
    view.ask_replacement.assert_called_once_with(())
    presenter.give_replacement("", "another sentence", "another sentenca")
    assert "differ" in told(view)
    assert not opened
    presenter.give_replacement("", "another sentence", "another sentence")
    ((store, is_new),) = opened
    assert not is_new
    assert not store.is_read_only
    store.close()
    with pytest.raises(PassphraseError):
        open_store(folder, PASSPHRASE)
    open_store(folder, "another sentence").close()


def test_a_mistyped_key_another_one_and_none_are_told_apart_and_asked_for_again(
    presenter, view, folder, opened, with_key
):
    before = (folder / KEY_FILE).read_bytes()
    for typed, said in ((with_key[:-1], "and 27 were given"), (make_recovery_key(), "belongs to")):
        view.reset_mock()
        presenter.give_recovery_key(typed)
        view.ask_recovery_key.assert_called_once_with()
        view.ask_replacement.assert_not_called()
        assert said in told(view)
    assert not opened
    assert (folder / KEY_FILE).read_bytes() == before


@pytest.mark.usefixtures("behind_passphrase")
def test_a_store_without_a_recovery_key_says_so(presenter, view):
    presenter.give_recovery_key(make_recovery_key())
    assert "has no recovery key" in told(view)


@pytest.mark.usefixtures("no_keyring")
def test_of_several_administrators_the_user_says_whose_passphrase_is_lost(
    presenter, view, folder, opened, with_key
):
    with open_store(folder, PASSPHRASE) as store:
        for name in ("Anna", "Carla"):
            store.people.add(name, Role.ADMINISTRATOR, f"the words of {name}", CHEAP)
        store.people.add("Boris", Role.OPERATOR, "the words of Boris", CHEAP)
    presenter.give_recovery_key(with_key)
    view.ask_replacement.assert_called_once_with(("Anna", "Carla"))
    presenter.give_replacement("Carla", "short", "short")
    assert "characters at least" in told(view)
    assert view.ask_replacement.call_args.args == (("Anna", "Carla"),)
    presenter.give_replacement("Carla", "another sentence", "another sentence")
    ((store, _is_new),) = opened
    assert store.person.name == "Carla"


def test_who_goes_back_is_asked_for_the_passphrase_again(presenter, view, with_key):
    presenter.begin_recovery()
    presenter.give_recovery_key(with_key)
    presenter.leave_recovery()
    view.ask_passphrase.assert_called_once_with()
    assert with_key not in repr(vars(presenter))


def test_the_page_leads_from_the_lost_passphrase_into_the_store(
    qtbot, theme, folder, inline_jobs, opened, with_key
):
    page = UnlockPage(theme)
    qtbot.addWidget(page)
    page.show()
    presenter = UnlockPresenter(
        page, folder, "somebody", inline_jobs, lambda *store: opened.append(store)
    )
    page.bind(presenter)
    presenter.begin()

    def press(text):
        (button,) = [
            one for one in page.findChildren(QPushButton) if one.isVisible() and one.text() == text
        ]
        qtbot.mouseClick(button, Qt.MouseButton.LeftButton)

    def fields():
        return [one for one in page.findChildren(QLineEdit) if one.isVisible()]

    press("Passphrase or keyring lost?")
    press("Go back")
    assert [one.accessibleName() for one in fields()] == ["Passphrase"]
    press("Passphrase or keyring lost?")
    (key,) = fields()
    assert key.hasFocus() or page.focusWidget() is key
    assert key.echoMode() is QLineEdit.EchoMode.Normal
    qtbot.keyClicks(key, with_key[:-1])
    press("Go on")
    assert key.text() == with_key[:-1]  # to be mended
    assert any("27 were given" in one.text() for one in page.findChildren(QLabel))
    qtbot.keyClicks(key, with_key[-1])
    qtbot.keyClick(key, Qt.Key.Key_Return)
    first, second = sorted(fields(), key=lambda one: one.y())
    assert not key.isVisible()
    assert key.text() == ""
    for field in (first, second):
        assert field.echoMode() is QLineEdit.EchoMode.Password
        qtbot.keyClicks(field, "another sentence")
    press("Open the patient store")
    assert len(opened) == 1
