"""A new recovery key in the window: shown once, and in force when it is printed, saved or kept."""

from datetime import UTC, datetime
from unittest.mock import create_autospec

import pytest
from pypdf import PdfReader
from PySide6.QtCore import Qt
from PySide6.QtPrintSupport import QPrintDialog, QPrinter
from PySide6.QtWidgets import QGroupBox, QLabel, QPushButton, QWidget

from adibas.errors import FileError
from adibas.reports.recovery_sheet import recovery_sheet
from adibas.sessions import open_store
from adibas.sessions.key_file import KEY_FILE, read_key_file
from adibas.sessions.keys import key_by_recovery
from adibas.sessions.recovering import administrators
from adibas.sessions.recovery_key import make_recovery_key, read_recovery_key
from adibas.sessions.roles import Role
from tests.ui import window_user
from tests.ui.conftest import CHEAP
from tests.ui.window_user import visible_dialogs
from ui.recovery import printing
from ui.recovery.dialog import RecoveryKeyDialog, open_recovery_key
from ui.recovery.presenter import RecoveryKeyPresenter, RecoveryKeyView
from ui.settings.recovery_page import RecoveryPage
from ui.settings.recovery_presenter import RecoveryPresenter, RecoveryView
from ui.settings.screen import build_settings_screen
from ui.workspace import Workspace

open_window = window_user.open_window
DAY = datetime(2026, 11, 25, 12, tzinfo=UTC)


@pytest.fixture
def view():
    return create_autospec(RecoveryKeyView, instance=True)


@pytest.fixture
def held():
    """What was told of keys that opened the store."""
    return []


@pytest.fixture
def presenter(view, workspace, held):
    return RecoveryKeyPresenter(view, workspace, None, lambda: held.append(True))


def shown(view):
    return "-".join(view.show_key.call_args.args[0])


def opens(store, recovery_key):
    file = read_key_file(store.folder)
    return key_by_recovery(file, recovery_key) is not None


# The decisions, without Qt


def test_a_key_that_is_put_off_opens_nothing_and_leaves_the_one_of_before(
    view, workspace, store, held
):
    before = make_recovery_key()
    store.recovery.hold(before)
    presenter = RecoveryKeyPresenter(view, workspace, DAY, lambda: held.append(True))
    assert view.show_key.call_args.args[1] == DAY
    assert read_recovery_key(shown(view)) == shown(view)
    presenter.end()
    assert not held
    assert opens(store, before)
    assert not opens(store, shown(view))


def test_who_says_that_it_is_kept_has_a_key_that_opens(presenter, view, store, held):
    presenter.keep()
    assert opens(store, shown(view))
    assert held == [True]
    view.close_dialog.assert_called_once_with()


def test_what_is_printed_opens_the_store_before_it_is_printed(presenter, view, store, held):
    view.print_sheet.side_effect = lambda _sheet: held.append(opens(store, shown(view)))
    presenter.print_it()
    assert held == [True, True]
    (sheet,) = view.print_sheet.call_args.args
    assert "  ".join(sheet.lines).split() == shown(view).split("-")
    assert store.recovery.store_id in dict(sheet.facts).values()
    view.close_dialog.assert_not_called()


def test_the_saved_page_has_the_key_and_one_key_is_held_once(presenter, view, store, tmp_path):
    path = tmp_path / "on a stick" / "key.pdf"
    presenter.save(path)
    presenter.print_it()
    presenter.keep()
    text = PdfReader(path).pages[0].extract_text()
    assert all(group in text for group in shown(view).split("-"))
    view.show_saved.assert_called_once_with("key.pdf")
    done = [one.detail["did"] for one in store.audit.entries() if one.subject == "people"]
    assert done == ["recovery key made"]
    assert [one.name for one in path.parent.iterdir()] == ["key.pdf"]


def test_a_page_that_cannot_be_saved_is_told_and_the_key_is_still_shown(
    presenter, view, store, tmp_path
):
    (tmp_path / "a file").touch()
    presenter.save(tmp_path / "a file" / "key.pdf")
    assert "cannot be written" in view.show_problem.call_args.args[0]
    view.close_dialog.assert_not_called()
    assert opens(store, shown(view))


def test_a_full_disk_is_told_and_the_dialog_stays(presenter, view, store, held, monkeypatch):
    def full(_key):
        raise FileError("{file} cannot be written: the disk is full.", file=KEY_FILE)

    monkeypatch.setattr(store.recovery, "hold", full)
    presenter.keep()
    assert "disk is full" in view.show_problem.call_args.args[0]
    view.close_dialog.assert_not_called()
    assert not held


def test_who_is_no_administrator_is_refused(view, inline_jobs, preferences, store, held):
    store.people.add("Anna", Role.ADMINISTRATOR, "the words of Anna", CHEAP)
    store.people.add("Boris", Role.CLINICIAN, "the words of Boris", CHEAP)
    store.close()
    with open_store(store.folder, "the words of Boris") as of_boris:
        workspace = Workspace(of_boris, inline_jobs, preferences, create_autospec(object))
        RecoveryKeyPresenter(view, workspace, None, lambda: held.append(True)).keep()
        assert "only for administrators" in view.show_problem.call_args.args[0]
        assert not held
        assert of_boris.recovery.made_utc() is None


def test_what_ends_after_the_dialog_shows_nothing_in_it(view, workspace, store, held, inline_jobs):
    works = []
    inline_jobs.start = lambda _label, work, done, _failed=None, **_more: works.append((work, done))
    presenter = RecoveryKeyPresenter(view, workspace, None, lambda: held.append(True))
    presenter.keep()
    presenter.end()
    ((work, done),) = works
    done(work(None))
    assert held == [True]
    assert opens(store, shown(view))
    view.show_held.assert_not_called()
    view.close_dialog.assert_not_called()


@pytest.mark.usefixtures("qapp")
def test_the_settings_tell_whether_there_is_one_and_show_the_next(workspace, store):
    page, asked = create_autospec(RecoveryView, instance=True), []
    presenter = RecoveryPresenter(page, workspace, lambda *given: asked.append(given))
    presenter.enter()
    page.show_state.assert_called_once_with(None, can_change=True)
    presenter.make()
    ((replaced_utc, held),) = asked
    assert replaced_utc is None
    store.recovery.hold(make_recovery_key())
    held()
    page.show_state.assert_called_with(store.recovery.made_utc(), can_change=True)
    presenter.make()
    assert asked[1][0] == store.recovery.made_utc()


def test_a_second_window_changes_nothing(second_window):
    page = create_autospec(RecoveryView, instance=True)
    RecoveryPresenter(page, second_window, lambda *_given: None).enter()
    page.show_state.assert_called_once_with(None, can_change=False)


# The widgets


def test_the_page_reminds_as_long_as_there_is_none(qtbot, theme):
    assert theme is not None
    page = RecoveryPage()
    qtbot.addWidget(page)
    page.show_state(None, can_change=True)
    (label,) = page.findChildren(QLabel)
    assert label.text().startswith("There is no recovery key yet")
    assert label.property("kind") == "warning"
    assert page.make.text() == "Make a recovery key..."
    page.show_state(DAY, can_change=False)
    assert "since 25 Nov 2026" in label.text()
    assert label.property("kind") == ""
    assert page.make.text() == "Make a new recovery key..."
    assert not page.findChild(QGroupBox).isEnabled()


def test_the_settings_of_an_operator_do_not_offer_it(qtbot, inline_jobs, preferences, store):
    store.people.add("Anna", Role.ADMINISTRATOR, "the words of Anna", CHEAP)
    store.people.add("Boris", Role.OPERATOR, "the words of Boris", CHEAP)
    store.close()
    with open_store(store.folder, "the words of Boris") as of_boris:
        screen = build_settings_screen(
            Workspace(of_boris, inline_jobs, preferences, create_autospec(object))
        )
        qtbot.addWidget(screen)
        assert not screen.protected.recovery.make.isEnabled()
        screen.closed()


def test_the_printed_page_says_what_the_pdf_says(qapp, tmp_path):
    assert qapp is not None
    recovery_key, store_id = make_recovery_key(), "0123456789abcdef" * 2
    sheet = recovery_sheet(recovery_key, store_id, DAY)
    printer = QPrinter(QPrinter.PrinterMode.HighResolution)
    printer.setOutputFormat(QPrinter.OutputFormat.PdfFormat)
    printer.setOutputFileName(str(tmp_path / "printed.pdf"))
    printing.print_on(printer, sheet)
    (page,) = PdfReader(tmp_path / "printed.pdf").pages
    sides_mm = [round(float(side) / 72 * 25.4) for side in page.mediabox.upper_right]
    assert sides_mm == [210, 297]
    html = printing.page_html(sheet)
    for text in (*recovery_key.split("-"), store_id, "2026-11-25", *sheet.warnings, sheet.heading):
        assert text in html


def test_nothing_is_printed_before_a_printer_is_chosen(qtbot, tmp_path):
    parent, out = QWidget(), tmp_path / "printed.pdf"
    qtbot.addWidget(parent)
    parent.show()
    printing.print_sheet(recovery_sheet(make_recovery_key(), "0" * 32, DAY), parent)
    (dialog,) = visible_dialogs(QPrintDialog)
    assert dialog.isModal()
    assert dialog.printer().docName() == "ADiBAS"
    dialog.printer().setOutputFileName(str(out))
    assert not out.exists()
    dialog.done(QPrintDialog.DialogCode.Accepted)
    qtbot.waitUntil(out.is_file)
    assert [one.name for one in tmp_path.iterdir()] == ["printed.pdf"]


def test_the_button_asks_for_a_printer_when_the_key_holds(qtbot, workspace, monkeypatch):
    asked = []
    monkeypatch.setattr("ui.recovery.dialog.print_sheet", lambda *given: asked.append(given))
    dialog = open_recovery_key(workspace, None, None, lambda: None)
    (button,) = [one for one in dialog.findChildren(QPushButton) if one.text() == "&Print..."]
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
    ((sheet, parent),) = asked
    assert parent is dialog
    assert workspace.store.recovery.made_utc() is not None
    assert len("".join(sheet.lines).replace(" ", "")) == 28
    dialog.close()


# The first start


def test_at_the_first_start_the_key_is_shown_once_saved_and_opens_the_store(
    open_window, tmp_path, caplog
):
    user = open_window()
    user.give_new_passphrase(puts_key_off=False)
    user.until(lambda: visible_dialogs(RecoveryKeyDialog))
    (dialog,) = visible_dialogs(RecoveryKeyDialog)
    recovery_key = "-".join(dialog._key.text().split())
    assert read_recovery_key(recovery_key) == recovery_key
    user.click("Save as PDF...", dialog)
    path = tmp_path / "stick"
    path.mkdir()
    user.answer_file_dialog(path / "key.pdf")
    user.until((path / "key.pdf").is_file)
    user.settle()
    user.click("It is kept in a safe place", dialog)
    user.until(lambda: not visible_dialogs())
    assert user.store.recovery.made_utc() is not None
    user.close()
    assert administrators(tmp_path / "store", recovery_key) == ()
    assert recovery_key[:4] in PdfReader(path / "key.pdf").pages[0].extract_text()
    others = [one for one in tmp_path.rglob("*") if one.is_file() and one.parent != path]
    assert not [one for one in others if recovery_key.encode() in one.read_bytes()]
    assert recovery_key not in caplog.text
    again = open_window()
    again.give_passphrase()
    again.until(lambda: again.window.shown)
    again.settle()
    assert not visible_dialogs()  # it is shown once
    again.close()


def test_who_puts_it_off_is_reminded_in_the_settings_and_a_lock_closes_the_dialog(open_window):
    user = open_window()
    user.give_new_passphrase()
    user.settle()
    assert user.store.recovery.made_utc() is None
    user.go_to("settings")
    user.screen._tabs.setCurrentIndex(1)
    user.settle()
    recovery = user.screen.protected.recovery
    assert "There is no recovery key yet" in recovery._state.text()
    recovery.make.click()
    user.until(lambda: visible_dialogs(RecoveryKeyDialog))
    user.application.lock()
    assert not visible_dialogs()
    user.until(lambda: user.workspace is None)
    user.settle()
    user.close()
