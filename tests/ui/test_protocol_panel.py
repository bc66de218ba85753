"""The measures of a protocol beside the picture: named, worded, and why one is missing."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel

from adibas.data.protocol_measures import (
    Estimate,
    MeasureResult,
    PlaneChoice,
    ProtocolMeasures,
    VerticalOrigin,
)
from adibas.data.sentence import Sentence
from adibas.measures.protocol_measures import NO_VERTICAL, UNKNOWN_SD
from adibas.measures.protocol_store import find_protocol
from adibas.texts import use_language
from ui.review.protocol_panel import ProtocolPanel
from ui.widgets.line_table import LineTable

PROTOCOL = find_protocol("sapo-1")


@pytest.fixture
def panel(qtbot):
    panel = ProtocolPanel()
    qtbot.addWidget(panel)
    panel.resize(500, 300)
    panel.show()
    yield panel
    use_language("en")


def measures(*results, notices=()):
    return ProtocolMeasures(
        PROTOCOL, "anterior", PlaneChoice.SENSOR, VerticalOrigin.GRAVITY, results, notices
    )


def definition(unit):
    return next(one for one in PROTOCOL.measures if one.unit == unit and not one.is_spatial)


def lines(panel):
    model = panel.findChild(LineTable).model()
    return [
        tuple(model.index(row, column).data() for column in range(model.columnCount()))
        for row in range(model.rowCount())
    ]


def told(panel):
    return [label.text() for label in panel.findChildren(QLabel) if label.isVisible()]


def test_a_measure_is_told_in_its_unit_with_its_interval(panel):
    wanted = definition("deg")
    value = Estimate(0.1, (0.09, 0.11))  # radians
    panel.show_protocol(measures(MeasureResult(wanted, value, None)))
    (line,) = lines(panel)
    assert line == (f"{wanted.name.text} [deg]", "5.7", "5.2 to 6.3")
    assert any(f"Positive means: {wanted.positive.text}." in text for text in told(panel))
    assert any(text.startswith(f"{PROTOCOL.title.text}. Plane: ") for text in told(panel))
    assert any("instrument only" in text for text in told(panel))


def test_a_measure_without_a_value_says_why_and_no_number(panel):
    wanted = definition("deg")
    panel.show_protocol(measures(MeasureResult(wanted, None, None, Sentence(NO_VERTICAL))))
    (line,) = lines(panel)
    assert line[1:] == ("\u2013", "\u2013")
    assert f"{wanted.name.text}.\n{NO_VERTICAL}." in "".join(told(panel))


def test_what_must_be_known_of_the_measures_stands_above_them(panel):
    panel.show_protocol(measures(notices=(Sentence(UNKNOWN_SD),)))
    assert UNKNOWN_SD in told(panel)
    panel.show_protocol(measures())
    assert UNKNOWN_SD not in told(panel)


def test_without_a_protocol_it_says_so(panel):
    panel.show_protocol(None)
    assert not panel.findChild(LineTable).isVisible()
    assert told(panel) == ["No protocol."]


def test_another_language_is_spoken_at_once(panel):
    wanted = definition("deg")
    panel.show_protocol(measures(MeasureResult(wanted, Estimate(0.1, (0.09, 0.11)), None)))
    use_language("es")
    panel.retranslate()
    assert lines(panel)[0][1:3] == ("5,7", "de 5,2 a 6,3")
    title = panel.findChild(LineTable).model().headerData(0, Qt.Orientation.Horizontal)
    assert title == "Medida"
