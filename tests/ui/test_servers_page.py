"""The DICOM servers in the settings: named, asked, forgotten, and nothing else is connected to."""

from dataclasses import replace
from unittest.mock import create_autospec

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QCheckBox, QComboBox, QLineEdit, QPushButton, QSpinBox

from adibas.cli import main
from adibas.exchange import dicom_network
from adibas.exchange.servers import DicomServer, read_servers, write_servers
from tests.ui import export_scene
from tests.unit import orthanc_server
from tests.unit.loopback import free_port
from tests.unit.orthanc_server import TITLE
from ui.settings.screen import build_settings_screen
from ui.settings.servers_presenter import ServerEntry, ServersPresenter, ServersView

named_servers = export_scene.named_servers
LEFT = Qt.MouseButton.LeftButton
PACS = DicomServer("pacs.clinic", 11112, "PACS", "ADIBAS2", is_encrypted=True, certificates="/c")
ENTRY = ServerEntry("pacs", "pacs.clinic", 11112, "PACS", "ADIBAS2", True, "/c")


@pytest.fixture
def view():
    return create_autospec(ServersView, instance=True)


@pytest.fixture
def presenter(view, workspace, named_servers):  # noqa: ARG001  (it is there)
    return ServersPresenter(view, workspace)


def test_a_server_is_named_shown_changed_and_forgotten(presenter, view, named_servers, told):
    presenter.enter()
    view.show_servers.assert_called_with((), "")
    view.show_entry.assert_called_with(ServerEntry())
    presenter.save(ENTRY)
    assert read_servers(named_servers) == {"pacs": PACS}
    view.show_servers.assert_called_with(("pacs",), "pacs")
    presenter.save(replace(ENTRY, name="archive", port=104))
    assert read_servers(named_servers) == {"archive": replace(PACS, port=104)}
    presenter.remove()
    assert read_servers(named_servers) == {}
    view.show_entry.assert_called_with(ServerEntry())
    assert [kind for kind, _sentence in told] == ["good"] * 3


def test_a_second_one_is_named_beside_the_first(presenter, view, named_servers):
    write_servers(named_servers, {"pacs": PACS})
    presenter.enter()
    view.show_entry.assert_called_with(ENTRY)
    presenter.choose("")
    presenter.save(replace(ENTRY, name="ris"))
    assert sorted(read_servers(named_servers)) == ["pacs", "ris"]


def test_what_the_command_named_meanwhile_stays(presenter, named_servers):
    presenter.enter()
    command = ["export", "server", "ris", "--host", "ris.clinic", "--port", "104"]
    assert main([*command, "--title", "RIS"]) == 0
    presenter.save(ENTRY)
    assert sorted(read_servers(named_servers)) == ["pacs", "ris"]


@pytest.mark.parametrize(
    "changes",
    [{"name": " "}, {"host": ""}, {"port": 0}, {"title": "SEVENTEEN LETTERS"}, {"own_title": "Ñ"}],
)
def test_what_cannot_be_a_server_is_told_and_not_kept(presenter, named_servers, told, changes):
    presenter.enter()
    presenter.save(replace(ENTRY, **changes))
    presenter.test(replace(ENTRY, **changes))
    assert [kind for kind, _sentence in told] == ["bad", "bad"]
    assert not named_servers.exists()


def test_nobody_is_asked_before_somebody_presses_the_button(presenter, monkeypatch, workspace):
    asked = []
    monkeypatch.setattr(dicom_network, "verify", lambda server, name: asked.append((server, name)))
    presenter.enter()
    presenter.save(ENTRY)
    assert asked == []
    presenter.test(replace(ENTRY, name=" other "))
    assert asked == [(PACS, "other")]
    assert workspace.jobs.labels == ["Asking the DICOM server"]


@pytest.mark.parametrize(("is_encrypted", "kind"), [(True, "good"), (False, "warning")])
def test_who_listens_is_told_where_a_server_answers(
    presenter, monkeypatch, told, is_encrypted, kind
):
    monkeypatch.setattr(dicom_network, "verify", lambda _server, _name: None)
    presenter.test(replace(ENTRY, is_encrypted=is_encrypted))
    assert told[0][0] == kind
    assert told[0][1].startswith("pacs answers.")
    assert ("listens" in told[0][1]) is not is_encrypted


def test_a_damaged_list_is_told(presenter, named_servers, told):
    named_servers.parent.mkdir()
    named_servers.write_text("[]", "utf-8")
    presenter.enter()
    assert "no list of DICOM servers" in told[0][1]


@pytest.fixture
def page(workspace, named_servers, theme, qtbot):  # noqa: ARG001  (it is there)
    screen = build_settings_screen(workspace)
    qtbot.addWidget(screen)
    screen.resize(1100, 900)
    screen.show()
    screen.entered()
    yield screen.servers
    screen.closed()


def button(page, text):
    (found,) = [one for one in page.findChildren(QPushButton) if one.text() == text]
    return found


def fill(page, name, host, port, title):
    """Type a server with the keyboard."""
    lines = [one for one in page.findChildren(QLineEdit) if not one.objectName()]
    for line, text in zip(lines, (name, host, title), strict=False):
        line.selectAll()
        QTest.keyClicks(line, text)
    field = page.findChild(QSpinBox)
    field.selectAll()
    QTest.keyClicks(field, str(port))


def test_a_server_is_typed_and_saved_with_keys_and_mouse(page, named_servers):
    fill(page, "pacs", "pacs.clinic", 11112, "PACS")
    QTest.mouseClick(button(page, "Save the server"), LEFT)
    assert read_servers(named_servers) == {"pacs": DicomServer("pacs.clinic", 11112, "PACS")}
    assert page.findChild(QComboBox).currentText() == "pacs"
    button(page, "Forget the server").setFocus()
    QTest.keyClick(button(page, "Forget the server"), Qt.Key.Key_Space)
    assert read_servers(named_servers) == {}
    assert not button(page, "Forget the server").isEnabled()


def test_a_certificate_is_asked_of_encrypted_servers_alone(page):
    choose = button(page, "Choose the certificate...")
    assert not choose.isEnabled()
    QTest.keyClick(page.findChild(QCheckBox), Qt.Key.Key_Space)
    assert choose.isEnabled()


@pytest.mark.skipif(orthanc_server.PROGRAM is None, reason=orthanc_server.MISSING)
def test_a_real_server_answers_and_one_that_is_not_there_does_not(page, workspace, told, tmp_path):
    running, process = orthanc_server.start(tmp_path / "orthanc")
    try:
        fill(page, "pacs", "127.0.0.1", running.dicom_port, TITLE)
        QTest.mouseClick(button(page, "See whether it answers"), LEFT)
        assert told[-1] == ("good", "pacs answers.")
        fill(page, "pacs", "127.0.0.1", free_port(), TITLE)
        QTest.mouseClick(button(page, "See whether it answers"), LEFT)
        assert "does not answer" in str(workspace.jobs.problems[0])
    finally:
        process.terminate()
        process.wait(30)
