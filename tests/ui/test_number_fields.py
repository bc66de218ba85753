"""Fields for numbers."""

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent

from ui.widgets.number_fields import DecimalField, WholeNumberField


@pytest.fixture(params=[WholeNumberField, DecimalField])
def field(request, qtbot):
    field = request.param()
    qtbot.addWidget(field)
    field.setValue(7)
    field.show()
    return field


def wheel(field, qapp):
    """Turn the wheel one step over the field; say whether the field took it."""
    middle = QPointF(field.rect().center())
    event = QWheelEvent(
        middle,
        field.mapToGlobal(middle),
        QPoint(0, 0),
        QPoint(0, 120),
        Qt.MouseButton.NoButton,
        Qt.KeyboardModifier.NoModifier,
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    qapp.sendEvent(field, event)
    return event.isAccepted()


def test_the_wheel_passes_over_a_field_and_changes_nothing(field, qapp):
    field.clearFocus()
    assert not wheel(field, qapp)
    assert field.value() == 7
    assert not field.hasFocus()


def test_the_wheel_turns_the_number_of_the_field_that_has_the_focus(field, qapp, qtbot):
    field.activateWindow()
    field.setFocus()
    qtbot.waitUntil(field.hasFocus)
    assert wheel(field, qapp)
    assert field.value() == 8
