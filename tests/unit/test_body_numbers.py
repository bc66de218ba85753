"""Measures of a body as they are read: as many decimals as tell two legs apart."""

from types import SimpleNamespace

import pytest

from adibas.data.body_measures import BodyMeasure
from adibas.reports import body_excel, body_facts
from adibas.reports.body_facts import measure_rows
from adibas.surface.back_measures import KYPHOSIS
from adibas.surface.girths import GIRTH_LEFT_CALF, VOLUME_LEFT_CALF
from adibas.texts import speaking

LEFT = BodyMeasure(VOLUME_LEFT_CALF, 0.001_979, (0.0018, 0.002_157))
GIRTH = BodyMeasure(GIRTH_LEFT_CALF, 0.367_27, (0.355_75, 0.378_79))


@pytest.fixture
def rows(monkeypatch):
    monkeypatch.setattr(body_facts, "measures_of", lambda body: body.measures)
    return measure_rows(SimpleNamespace(measures=(LEFT, GIRTH)))


def test_a_report_tells_litres_with_two_decimals_and_millimetres_with_one(rows):
    assert [row[2:5] for row in rows] == [
        ("1.98", "1.80 … 2.16", "l"),
        ("367.3", "355.8 … 378.8", "mm"),
    ]


def test_a_report_in_another_language_has_its_sign_for_degrees(monkeypatch):
    monkeypatch.setattr(body_facts, "measures_of", lambda body: body.measures)
    monkeypatch.setattr(body_excel, "measures_of", lambda body: body.measures)
    angle = BodyMeasure(KYPHOSIS, 0.6, (0.5, 0.7))
    with speaking("pt"):
        (row,) = measure_rows(SimpleNamespace(measures=(angle,)))
        (cells,) = body_excel._measures(SimpleNamespace(measures=(angle,)))
    assert row[4] == cells[5] == "°"
    (unknown,) = measure_rows(SimpleNamespace(measures=(BodyMeasure(KYPHOSIS, None, None, "x"),)))
    assert unknown[4] == "deg"
