"""Names that the program knows follow the language; what was typed does not."""

import pytest

from adibas.data.joints import JOINT_NAMES
from adibas.data.landmark_texts import (
    JOINTS,
    KNOWN,
    LANDMARKS,
    SPINE,
    VERTEBRAE,
    LandmarkNames,
    landmark_label,
    landmark_text,
)
from adibas.data.sentence import Sentence
from adibas.measures.protocol_measures import NOT_MARKED
from adibas.measures.protocol_store import find_protocol, protocol_files
from adibas.texts import LANGUAGES, speaking

NAMES = {
    "left_hand": "Mano izquierda",
    "c7": "C7",
    "menton": "Mentón",
    "right_acromion": "Acromion (der.)",
}


def test_names_are_told_in_the_language_in_use():
    with speaking("es"):
        assert {label: landmark_text(label) for label in NAMES} == NAMES


def test_a_sentence_names_landmarks_in_the_language_in_which_it_is_read():
    lacking = Sentence(NOT_MARKED, {"names": LandmarkNames(("right_acromion", "c7", "m07"))})
    assert lacking.text == "not marked: Acromion, right; C7; m07"
    with speaking("es"):
        assert lacking.text == "sin marcar: Acromion (der.); C7; m07"


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_joint_and_landmark_is_known_again_by_its_name(language):
    with speaking(language):
        assert tuple(landmark_label(landmark_text(label)) for label in KNOWN) == KNOWN


def test_the_landmarks_of_all_shipped_protocols_have_a_name():
    assert tuple(JOINTS) == JOINT_NAMES
    protocols = map(find_protocol, protocol_files())
    assert {one.landmark_id for each in protocols for one in each.landmarks} == set(KNOWN)
    assert len(KNOWN) == len(LANDMARKS) + len(JOINTS)


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_vertebra_is_written_in_capitals_whether_or_not_a_protocol_names_it(language):
    with speaking(language):
        for label in ("c1", "c7", "t4", "t10", "l2", "s1", "s5"):
            assert landmark_text(label) == label.upper()
            assert landmark_label(label.upper()) == label
        for label in ("c8", "t0", "t13", "l6", "s6", "t04"):
            assert landmark_text(label) == label
    assert set(VERTEBRAE) <= set(SPINE)


@pytest.mark.parametrize("typed", ["m07", "Acromion (der.)", "left_thing", "left_c7"])
def test_what_a_user_typed_stays_as_it_is(typed):
    assert landmark_text(typed) == typed
    assert landmark_label(typed) == typed
