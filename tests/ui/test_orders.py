"""An order is chosen from the work list of a server that somebody named."""

from datetime import date, datetime
from unittest.mock import create_autospec

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QComboBox, QLabel, QLineEdit, QListWidget, QPushButton

from adibas.errors import ExchangeError
from adibas.exchange import dicom_network
from adibas.exchange.orders import Order
from adibas.exchange.servers import DicomServer, write_servers
from tests.ui import export_scene, window_user
from tests.ui.window_user import Key, visible, visible_dialogs
from tests.unit import orthanc_server
from tests.unit.orthanc_server import TITLE, add_order
from ui.orders.dialog import OrdersDialog
from ui.orders.presenter import OrderLine, OrdersPresenter, OrdersView

named_servers, open_window = export_scene.named_servers, window_user.open_window
PACS = DicomServer("pacs.clinic", 104, "PACS")
TODAY = date(2026, 11, 21)
ORDER = Order("A-1", "", "HC-9", "Uno^Ana", "20140327", "F", "R-1", "Posture", "20261121090000")


class Lists:
    """Servers that answer with what a test put into their lists."""

    def __init__(self, monkeypatch):
        self.asked = []
        self.answer = (ORDER,)
        monkeypatch.setattr(dicom_network, "orders", self.orders)

    def orders(self, server, name, day=None, accession_number=""):
        self.asked.append((server.host, name, day, accession_number))
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


@pytest.fixture
def lists(monkeypatch):
    return Lists(monkeypatch)


@pytest.fixture
def view():
    return create_autospec(OrdersView, instance=True)


@pytest.fixture
def taken():
    return []


@pytest.fixture
def presenter(view, workspace, named_servers, lists, taken):  # noqa: ARG001  (it answers)
    write_servers(named_servers, {"pacs": PACS})
    return OrdersPresenter(view, workspace, taken.append, lambda: TODAY)


def test_todays_orders_are_looked_up_at_first_and_all_when_wanted(presenter, view, lists):
    assert presenter.open()
    view.show_servers.assert_called_once_with(("pacs",))
    line = OrderLine(datetime(2026, 11, 21, 9), "Ana Uno", "HC-9", "Posture")
    view.show_orders.assert_called_once_with((line,))
    presenter.look("pacs", is_of_today=False)
    assert lists.asked == [("pacs.clinic", "pacs", TODAY, ""), ("pacs.clinic", "pacs", None, "")]
    assert "Ana" not in repr(line)


def test_the_chosen_order_is_given_to_who_asked(presenter, taken):
    presenter.open()
    presenter.take(0)
    assert taken == [ORDER]


def test_a_server_that_fails_is_told_where_one_looks(presenter, view, lists):
    lists.answer = ExchangeError("{server} does not answer.", server="pacs")
    presenter.open()
    view.show_problem.assert_called_once_with("pacs does not answer.")
    view.show_orders.assert_not_called()


def test_without_a_server_nobody_is_asked(view, workspace, named_servers, lists):  # noqa: ARG001
    assert not OrdersPresenter(view, workspace, list).open()
    assert lists.asked == []


@pytest.fixture
def user(open_window, named_servers):
    """Somebody in a new store of a clinic with one server."""
    write_servers(named_servers, {"pacs": PACS})
    user = open_window()
    user.give_new_passphrase()
    user.settle()
    return user


def dialog_of(user):
    user.until(lambda: visible_dialogs(OrdersDialog))
    (dialog,) = visible_dialogs(OrdersDialog)
    dialog.activateWindow()
    user.until(dialog.isActiveWindow)
    user.settle()
    return dialog


def test_a_patient_is_taken_over_with_keys_alone_and_saved(user, lists):
    lists.answer = (ORDER, ORDER.__class__("A-2", "", "HC-7", "Dos^Luis", "", "M", "", "", ""))
    user.key(Key.Key_N, Qt.KeyboardModifier.ControlModifier)
    user.tab_to_button("From the work list...")
    user.key(Key.Key_Space)
    dialog = dialog_of(user)
    user.tab_to(lambda one: isinstance(one, QListWidget))
    user.key(Key.Key_Down)
    user.key(Key.Key_Return)
    user.until(lambda: not dialog_is_open())
    user.window.activateWindow()
    user.click("Save")
    user.settle()
    assert user.workspace.patient.identity.name == "Luis Dos"
    assert user.workspace.patient.identity.record_number == "HC-7"
    assert user.workspace.patient.sex == "male"
    assert dialog is not None


def test_the_birth_date_of_an_order_is_in_the_form_as_it_is_typed(user, lists):
    assert lists.answer == (ORDER,)
    user.click("New patient")
    user.click("From the work list...")
    QTest.keyClick(dialog_of(user).findChild(QListWidget), Key.Key_Return)
    user.until(lambda: not dialog_is_open())
    user.window.activateWindow()
    assert "27/03/2014" in [one.text() for one in visible(user.window, QLineEdit)]


def dialog_is_open():
    return bool(visible_dialogs(OrdersDialog))


def test_what_was_ordered_on_other_days_is_a_choice(user, lists):
    user.click("New patient")
    user.click("From the work list...")
    days = visible(dialog_of(user), QComboBox)[1]
    lists.answer = ()
    QTest.keyClick(days, Key.Key_Down)
    user.settle()
    assert lists.asked[-1][2] is None
    (dialog,) = visible_dialogs(OrdersDialog)
    assert "Nothing is ordered." in [one.text() for one in visible(dialog, QLabel)]
    assert not user.button("Take over", dialog).isEnabled()
    user.key(Key.Key_Escape)
    user.until(lambda: not dialog_is_open())


def test_who_is_changed_is_not_taken_from_a_list(user):
    user.click("New patient")
    user.click("Cancel")
    user.screen.list.table.selectRow(0)
    user.settle()
    user.click("Edit")
    assert "From the work list..." not in [one.text() for one in visible(user.window, QPushButton)]
    user.click("Cancel")


def test_without_a_server_no_work_list_is_offered(open_window, named_servers):
    assert not named_servers.exists()
    user = open_window()
    user.give_new_passphrase()
    user.settle()
    user.click("New patient")
    assert "From the work list..." not in [one.text() for one in visible(user.window, QPushButton)]


@pytest.mark.skipif(orthanc_server.PROGRAM is None, reason=orthanc_server.MISSING)
def test_orders_of_a_real_server_are_shown(user, tmp_path, named_servers):
    running, process = orthanc_server.start(tmp_path / "orthanc")
    try:
        add_order(tmp_path / "orthanc", "A-1")
        add_order(tmp_path / "orthanc", "A-2", day=f"{date.today():%Y%m%d}", name="Otro^Uno")
        server = DicomServer("127.0.0.1", running.dicom_port, TITLE)
        write_servers(named_servers, {"pacs": server})
        user.click("New patient")
        user.click("From the work list...")
        shown = dialog_of(user).findChild(QListWidget)
        assert [shown.item(row).text().split("  ")[0] for row in range(shown.count())] == [
            "Uno Otro"
        ]
        user.key(Key.Key_Escape)
        user.until(lambda: not dialog_is_open())
    finally:
        process.terminate()
        process.wait(30)
