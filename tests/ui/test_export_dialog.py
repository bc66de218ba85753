"""A session is handed over in the real window, with the mouse and with the keyboard alone."""

import json
import threading

import pydicom
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFileDialog,
    QLabel,
    QLineEdit,
    QListWidget,
    QPushButton,
    QRadioButton,
)

from adibas.exchange import dicom_network, dicom_pictures
from adibas.exchange.orders import Order
from adibas.exchange.servers import DicomServer, write_servers
from adibas.reports import pdf
from adibas.sessions import open_store
from tests.ui import export_scene, window_user
from tests.ui.conftest import CHEAP
from tests.ui.export_scene import exports
from tests.ui.window_user import SECRET, Key, visible, visible_dialogs
from tests.unit import orthanc_server
from tests.unit.exchange_samples import add_clinic_session, secrets_in
from tests.unit.orthanc_server import TITLE
from ui.export import presenter as export_presenter
from ui.export.dialog import ExportDialog
from ui.orders.dialog import OrdersDialog
from ui.patients.history_list import HistoryList

ORDER = Order(
    *("A-1", "1.2.826.0.1.3680043.2.1", "HC-004711", "Quetzal^Ximena", "20140327", "F"),
    *("R-1", "Posture", "20261121090000"),
)
open_window, named_servers = window_user.open_window, export_scene.named_servers


@pytest.fixture
def user(tmp_path, open_window, named_servers, monkeypatch):  # noqa: ARG001  (it is there)
    """Somebody who has chosen the patient and looks at her only session."""
    monkeypatch.setattr(pdf, "PICTURE_HEIGHT_PX", 200)
    monkeypatch.setattr(dicom_pictures, "HEIGHT_PX", 200)
    with open_store(tmp_path / "store", SECRET, key_params=CHEAP) as store:
        add_clinic_session(store)
    user = open_window()
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    user.settle()
    user.keys("ximena")
    user.key(Key.Key_Down)
    user.settle()
    user.screen.findChild(HistoryList).setCurrentIndex(
        user.screen.findChild(HistoryList).model().index(0, 0)
    )
    user.settle()
    return user


def dialog_of(user):
    user.until(lambda: visible_dialogs(ExportDialog))
    (dialog,) = visible_dialogs(ExportDialog)
    dialog.activateWindow()
    user.until(dialog.isActiveWindow)
    return dialog


def choose_as_is(dialog):
    """Let the pictures show everything: no depth was kept to hide a head by."""
    pictures = visible(dialog, QComboBox)[-2]
    while pictures.currentText() != "As they are":
        QTest.keyClick(pictures, Key.Key_Up)


def told(user):
    user.settle()
    return user.window.told


def test_a_bundle_is_exported_from_the_patients_screen_with_the_mouse(user, tmp_path):
    user.click("Export...")
    dialog = dialog_of(user)
    choose_as_is(dialog)
    user.click("Export...", dialog)
    user.answer_file_dialog(tmp_path / "out.json")
    user.until(lambda: not visible_dialogs(ExportDialog))
    assert "out.json" in told(user)
    assert json.loads((tmp_path / "out.json").read_text("utf-8"))["resourceType"] == "Bundle"
    assert not secrets_in((tmp_path / "out.json").read_bytes())
    assert exports(user.store) == ["fhir"]


def test_files_with_the_identity_are_exported_from_the_reports_with_keys_alone(user, tmp_path):
    user.screen.findChild(HistoryList).setFocus()
    user.key(Key.Key_Return)  # look at the session
    user.go_to("reports")
    user.settle()
    user.tab_to_button("Export (FHIR, DICOM)...")
    user.key(Key.Key_Space)
    dialog = dialog_of(user)
    assert isinstance(user.focus, QRadioButton)
    user.key(Key.Key_Down)
    assert user.focus.text() == "&DICOM files, for picture archives"
    user.tab_to(lambda one: isinstance(one, QCheckBox))
    user.key(Key.Key_Space)
    assert "whoever gets it knows" in seen(dialog)
    out = tmp_path / "out"
    out.mkdir()
    user.key(Key.Key_Return)
    answer_folder_dialog(user, out)
    told(user)
    (folder,) = out.iterdir()
    assert len(list(folder.iterdir())) == 4
    assert "Ximena" in str(pydicom.dcmread(folder / "report.dcm").PatientName)
    assert exports(user.store) == ["dicom, with identity"]


def answer_folder_dialog(user, folder):
    user.until(lambda: visible_dialogs(QFileDialog))
    (dialog,) = visible_dialogs(QFileDialog)
    field = dialog.findChild(QLineEdit, "fileNameEdit")
    field.setText(str(folder))  # typed, the list of folders that fit would take the keyboard
    QTest.keyClick(field, Key.Key_Return)
    user.until(lambda: not visible_dialogs(QFileDialog))


def seen(dialog):
    return " ".join(one.text() for one in visible(dialog, QLabel))


def test_the_identity_is_never_ticked_at_first_and_a_place_is_not_remembered(user, tmp_path):
    for name in ("out.json", "again.json"):
        user.click("Export...")
        dialog = dialog_of(user)
        (tick,) = visible(dialog, QCheckBox)
        assert not tick.isChecked()
        choose_as_is(dialog)
        user.click("Export...", dialog)
        user.until(lambda: visible_dialogs(QFileDialog))
        (files,) = visible_dialogs(QFileDialog)
        assert str(tmp_path) not in files.directory().absolutePath()
        user.answer_file_dialog(tmp_path / name)
        user.settle()
    written = (tmp_path / "preferences.json").read_text("utf-8")
    assert "out.json" not in written


def test_an_order_is_looked_up_for_the_files_and_let_go_again(
    user, tmp_path, named_servers, monkeypatch
):
    write_servers(named_servers, {"pacs": DicomServer("pacs.clinic", 104, TITLE)})
    monkeypatch.setattr(dicom_network, "orders", lambda *_question: (ORDER,))
    user.click("Export...")
    dialog = dialog_of(user)
    assert "For an order of the work list..." not in buttons(dialog)
    user.key(Key.Key_Down)  # DICOM files
    user.click("For an order of the work list...", dialog)
    user.until(lambda: visible_dialogs(OrdersDialog))
    (orders,) = visible_dialogs(OrdersDialog)
    user.until(lambda: orders.findChild(QListWidget).count())
    user.click("Take over", orders)
    user.until(lambda: not visible_dialogs(OrdersDialog))
    assert dialog_of(user) is dialog
    assert "answer the order A-1" in seen(dialog)
    user.tab_to_button("For no order")
    user.key(Key.Key_Space)
    assert user.focus.text() == "For an &order of the work list..."
    assert "answer the order" not in seen(dialog)
    assert "For no order" not in buttons(dialog)
    assert exports(user.store) == []
    user.key(Key.Key_Escape)
    user.until(lambda: not visible_dialogs())
    assert not any(tmp_path.rglob("*.dcm"))


def buttons(dialog):
    return [one.text().replace("&", "") for one in visible(dialog, QPushButton)]


def test_another_protocol_is_chosen_with_keys_and_measured(user, tmp_path):
    user.click("Export...")
    dialog = dialog_of(user)
    choose_as_is(dialog)
    protocols = visible(dialog, QComboBox)[-3]
    assert protocols.currentText() == "As the session says"
    while protocols.currentText() != "Upper quadrant":
        QTest.keyClick(protocols, Key.Key_Down)
    user.click("Export...", dialog)
    user.answer_file_dialog(tmp_path / "out.json")
    user.until(lambda: not visible_dialogs(ExportDialog))
    told(user)
    text = (tmp_path / "out.json").read_text("utf-8")
    assert "CVA" in text
    assert "ANT.ACR.H" not in text


def test_escape_exports_nothing(user):
    user.click("Export...")
    dialog_of(user)
    user.key(Key.Key_Escape)
    user.until(lambda: not visible_dialogs())
    assert exports(user.store) == []


def test_what_cannot_be_is_said_in_the_bar_above(user, tmp_path):
    user.click("Export...")
    user.click("Export...", dialog_of(user))
    user.answer_file_dialog(tmp_path / "out.json")
    assert "No depth was kept" in told(user)
    assert not (tmp_path / "out.json").exists()


def test_it_is_stopped_by_the_button_at_the_bottom(user, tmp_path, monkeypatch):
    began, goes_on = threading.Event(), threading.Event()
    write = export_presenter._write_fhir

    def slow(*args):
        began.set()
        goes_on.wait(60)
        return write(*args)

    monkeypatch.setattr(export_presenter, "_write_fhir", slow)
    user.click("Export...")
    dialog = dialog_of(user)
    choose_as_is(dialog)
    user.click("Export...", dialog)
    user.answer_file_dialog(tmp_path / "out.json")
    user.until(began.is_set)
    user.until(lambda: any(one.text() == "Cancel" for one in visible(user.window, QPushButton)))
    user.click("Cancel")
    goes_on.set()
    user.settle()
    assert not (tmp_path / "out.json").exists()
    assert exports(user.store) == []


def test_several_sessions_are_exported_one_by_one(user):
    with_captures = add_clinic_session(user.store)
    assert with_captures.capture_ids
    user.go_to("reports")
    user.settle()
    sessions = user.screen.findChild(QListWidget)
    for row in range(sessions.count()):
        sessions.item(row).setCheckState(Qt.CheckState.Checked)
    user.settle()
    user.click("Export (FHIR, DICOM)...")
    assert "one by one" in user.window.told
    assert not visible_dialogs(ExportDialog)


def test_without_a_server_nothing_can_be_sent_and_it_says_where_one_is_named(user):
    user.click("Export...")
    dialog = dialog_of(user)
    sending = visible(dialog, QRadioButton)[-1]
    assert not sending.isEnabled()
    assert "Settings" in seen(dialog)
    user.key(Key.Key_Escape)


@pytest.mark.skipif(orthanc_server.PROGRAM is None, reason=orthanc_server.MISSING)
def test_what_is_sent_from_the_window_arrives_at_a_real_server(user, tmp_path, named_servers):
    running, process = orthanc_server.start(tmp_path / "orthanc")
    try:
        server = DicomServer("127.0.0.1", running.dicom_port, TITLE)
        write_servers(named_servers, {"pacs": server})
        user.click("Export...")
        dialog = dialog_of(user)
        user.click("Send to the DICOM server", dialog)
        choose_as_is(dialog)
        user.click("Send", dialog)
        assert told(user) == "pacs has 4 files."
        files = [running.ask(f"/instances/{one}/file") for one in running.ask("/instances")]
        assert len(files) == 4
        assert not any(secrets_in(content) for content in files)
        assert exports(user.store) == ["dicom server"]
    finally:
        process.terminate()
        process.wait(30)
