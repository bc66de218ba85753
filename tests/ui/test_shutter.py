"""The button that captures keeps the focus of who takes one view after another by keyboard."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit, QPushButton, QVBoxLayout, QWidget

from ui.capture.panel import ShutterPanel


@pytest.fixture
def window(qtbot):
    window = QWidget()
    qtbot.addWidget(window)
    column = QVBoxLayout(window)
    column.addWidget(ShutterPanel(window))
    column.addWidget(QLineEdit(window))
    shutter = window.findChild(ShutterPanel)
    shutter.retranslate()
    shutter.show_readiness("", is_ready=True)
    window.show()
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow)
    return window


def capture_button(window):
    return next(one for one in window.findChildren(QPushButton) if "Capture" in one.text())


def test_the_button_has_the_focus_again_as_soon_as_the_next_view_can_be_captured(window):
    shutter, button, pressed = window.findChild(ShutterPanel), capture_button(window), []
    for signal in (shutter.capture_asked, shutter.learn_asked, shutter.wand_asked):
        signal.connect(lambda: pressed.append("a button"))
    button.setFocus()
    shutter.show_stop(can_stop=True)
    shutter.show_readiness("Wait for the picture.", is_ready=False)
    shutter.show_stop(can_stop=False)
    QTest.keyClick(QApplication.focusWidget(), Qt.Key.Key_Space)
    assert not pressed, "nobody wanted another one"
    shutter.show_readiness("", is_ready=True)
    assert button.hasFocus()


def test_the_button_takes_the_focus_from_nothing_else(window):
    shutter, field = window.findChild(ShutterPanel), window.findChild(QLineEdit)
    capture_button(window).setFocus()
    shutter.show_readiness("Wait for the picture.", is_ready=False)
    field.setFocus()
    shutter.show_readiness("", is_ready=True)
    assert field.hasFocus()
