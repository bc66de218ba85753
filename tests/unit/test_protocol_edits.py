"""Landmarks and measures are added to a protocol's text, which else stays as it was typed."""

import json

import pytest

from adibas.data.protocols import KINDS
from adibas.errors import ProtocolError
from adibas.measures.protocol_edits import (
    NewEntry,
    NewMeasure,
    landmarks_of,
    with_landmark,
    with_measure,
)
from adibas.measures.protocol_file import read_protocol
from adibas.measures.protocol_store import new_protocol_text, protocol_text

HIP = NewEntry("Espinilla ilíaca, derecha", "es", ("anterior",))
BOTH = ("anterior", "posterior")


def is_subsequence(short, long):
    letters = iter(long)
    return all(letter in letters for letter in short)


@pytest.mark.parametrize("name", ["", "sapo-1", "upper-quadrant"])
def test_a_landmark_is_added_and_nothing_that_was_typed_is_lost(name):
    text = protocol_text(name) if name else new_protocol_text()
    changed = with_landmark(text, HIP)
    assert is_subsequence("".join(text.split()), "".join(changed.split()))
    checked = read_protocol(changed, "new")
    assert checked.errors == ()
    added = checked.protocol.landmarks[-1]
    assert (added.landmark_id, added.views) == ("espinilla_iliaca_derecha", ("anterior",))
    assert added.name.by_language == {"es": "Espinilla ilíaca, derecha"}
    before, after = json.loads(text), json.loads(changed)
    assert after["landmarks"].pop()["id"] == added.landmark_id
    assert after == before


@pytest.mark.parametrize("kind", KINDS)
def test_a_measure_of_every_kind_can_be_added_and_is_right(kind):
    text = with_landmark(with_landmark(new_protocol_text(), NewEntry("Knee", "en", BOTH)), HIP)
    rule = KINDS[kind]
    known = ("right_acromion", "knee", "left_acromion", "mid_acromia")
    places = (2 * known)[: rule.n_points]
    measure = NewMeasure(kind, places, "left" if rule.has_axis else "", " higher ")
    if not rule.has_axis:
        measure = NewMeasure(kind, places)
    changed = with_measure(text, NewEntry("Knee to shoulder", "en", BOTH), measure)
    checked = read_protocol(changed, "new")
    assert checked.errors == ()
    added = checked.protocol.measures[-1]
    assert (added.measure_id, added.kind, added.points) == ("KNEE.TO.SHOULDER", kind, places)
    assert (added.positive is None) == (not rule.has_axis)
    assert added.positive is None or added.positive.text == "higher"


def test_ids_are_never_given_twice_and_are_made_of_letters_that_ids_take():
    text = new_protocol_text()
    for number in range(3):
        text = with_landmark(text, NewEntry("Right acromion", "en", BOTH))
        assert list(landmarks_of(text))[2 + number] == f"right_acromion_{2 + number}"
    assert "new" in landmarks_of(with_landmark(text, NewEntry("膝", "en", BOTH)))


def test_landmarks_are_listed_with_those_that_are_computed():
    assert landmarks_of(new_protocol_text()) == {
        "right_acromion": "Acromion, right",
        "left_acromion": "Acromion, left",
        "mid_acromia": "Middle of the acromia",
    }


def test_an_empty_list_takes_a_first_entry():
    changed = with_landmark('{"landmarks": []}', HIP)
    assert [one["id"] for one in json.loads(changed)["landmarks"]] == ["espinilla_iliaca_derecha"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "mistakes of writing"),
        ("[]", "mistakes of writing"),
        ('{"landmarks": [}', "mistakes of writing"),
        ("{}", "no list"),
        ('{"measures": []}', "no list"),
        ('{"landmarks": {"a": 1}}', "no list"),
    ],
)
def test_a_text_that_cannot_be_added_to_is_told(text, told):
    with pytest.raises(ProtocolError, match=told):
        with_landmark(text, HIP)
