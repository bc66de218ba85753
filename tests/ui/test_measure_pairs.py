"""Measures of the body in two sessions, beside each other."""

from adibas.data.body_measures import BodyMeasure
from adibas.surface.girths import VOLUME_LEFT_CALF
from ui.comparison.measure_pairs import measure_pairs, pair_row

EARLIER = BodyMeasure(VOLUME_LEFT_CALF, 0.001_979, (0.0018, 0.002_157))
LATER = BodyMeasure(VOLUME_LEFT_CALF, 0.002_039, (0.001_857, 0.002_223))


def test_the_window_tells_a_change_of_some_hundredths_of_a_litre():
    (pair,) = measure_pairs([EARLIER], [LATER])
    assert pair_row(pair).cells[1:] == ("1.98", "2.04", "1.86 to 2.22", "0.06")
