"""Images that OpenNI2's player loses are taken in the next round, each once and in order."""

import pytest

from adibas.errors import SensorError
from adibas.sensors.openni2_playback import Playback


def take(playback, events):
    return [event for event in events if playback.accepts(*event)]


def test_a_lost_image_is_waited_for_and_the_order_is_kept():
    playback = Playback("a.oni", {"depth": 4})
    first_round = [("depth", index) for index in (1, 2, 4)]
    assert take(playback, first_round) == first_round[:2]
    assert not playback.is_over
    assert take(playback, [("depth", index) for index in (1, 2, 3, 4)]) == [
        ("depth", 3),
        ("depth", 4),
    ]
    assert playback.is_over


def test_streams_are_counted_apart():
    playback = Playback("a.oni", {"depth": 2, "color": 1})
    events = [("depth", 1), ("color", 1), ("depth", 2)]
    assert take(playback, events) == events
    assert playback.is_over


def test_an_image_that_never_comes_ends_in_words_not_in_an_endless_round():
    playback = Playback("a.oni", {"depth": 3})
    with pytest.raises(SensorError, match=r"^a\.oni is damaged: 2 of its images are not found"):
        for _ in range(1000):
            take(playback, [("depth", 1), ("depth", 3)])


def test_silence_is_damage_where_the_length_is_known_else_the_end():
    with pytest.raises(SensorError, match="3 of its images"):
        Playback("a.oni", {"depth": 3}).give_up()
    cut = Playback("a.oni", {"depth": 0})
    assert not cut.knows_its_length
    assert take(cut, [("depth", 1), ("depth", 2)]) == [("depth", 1), ("depth", 2)]
    assert not cut.is_over
    cut.give_up()
    assert cut.is_over


def test_files_that_count_in_their_own_way_are_played_as_they_come():
    playback = Playback("a.oni", {"depth": 3})
    events = [("depth", 100), ("depth", 102), ("depth", 103)]
    assert take(playback, events) == events
    assert playback.is_over
