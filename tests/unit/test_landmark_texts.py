"""Names of joints follow the language; what was typed does not."""

from adibas.data.joints import JOINT_NAMES
from adibas.data.landmark_texts import JOINTS, landmark_label, landmark_text
from adibas.texts import speaking


def test_every_joint_has_a_name_for_readers_and_is_known_by_it_again():
    assert tuple(JOINTS) == JOINT_NAMES
    with speaking("es"):
        names = [landmark_text(joint) for joint in JOINT_NAMES]
        assert names[JOINT_NAMES.index("left_hand")] == "Mano izquierda"
        assert len(set(names)) == len(names)
        assert tuple(landmark_label(name) for name in names) == JOINT_NAMES


def test_what_a_user_typed_stays_as_it_is():
    assert landmark_text("Acromion (der.)") == "Acromion (der.)"
    assert landmark_label("Acromion (der.)") == "Acromion (der.)"
