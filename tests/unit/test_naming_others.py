"""After a hand named a marker, a model names the others; what is there already stays."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.joints import JOINT_NAMES, other_side
from adibas.data.markers import Marker
from adibas.data.surface import BurstDisparity
from adibas.errors import MarkerError
from adibas.geometry.pinhole import Intrinsics
from adibas.measures.protocol_store import find_protocol
from adibas.pipeline import naming_others
from adibas.pipeline.naming_others import names_of_others
from adibas.simulation.body import load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.poses import standing

CALIBRATION = RgbdCalibration(
    color=CameraCalibration(1280, 1024, Intrinsics(1050.0, 1050.0, 639.5, 511.5))
)
SURFACE = BurstDisparity(np.full((4, 4), 0.5, np.float32), np.full((4, 4), 3), 3)


@pytest.fixture(scope="module")
def markers():
    """Fifteen markers as flat as a picture: their places alone do not tell front from back."""
    body = load_body_model().shaped(BodyShape("male", 35, 1.78, 75))
    joints_m = body.posed(standing()).joints_m * [1.0, 1.0, 0.0] + [0.0, 0.8, 2.2]
    return tuple(
        Marker(f"m{i:02d}", 0.0, 0.0, 4.0, np.eye(2), position_m.copy(), np.eye(3) * 1e-6)
        for i, position_m in enumerate(joints_m, 1)
    )


def others(markers, view=""):
    found = names_of_others(find_protocol("joints-15"), markers, view, CALIBRATION)
    return {label: marker.label for label, marker in found.items()}


@pytest.mark.parametrize(("given", "side_of"), [("left_hand", str), ("right_hand", other_side)])
def test_one_named_hand_lets_all_other_markers_be_named(markers, given, side_of):
    hand = JOINT_NAMES.index("left_hand")
    with_hand = (*markers[:hand], replace(markers[hand], label=given), *markers[hand + 1 :])
    numbers = {name: one.label for name, one in zip(JOINT_NAMES, markers, strict=True)}
    assert set(others(markers).values()) == {"head", "neck", "torso"}
    assert others(with_hand) == {
        numbers[name]: side_of(name) for name in JOINT_NAMES if name != "left_hand"
    }


def test_a_name_that_no_model_knows_stays_and_harms_no_other(markers):
    torso = JOINT_NAMES.index("torso")
    scarred = (*markers[:torso], replace(markers[torso], label="scar"), *markers[torso + 1 :])
    found = others(scarred, "anterior")
    assert list(found.values()) == [name for name in JOINT_NAMES if name != "torso"]


def test_a_protocol_that_no_model_knows_is_told(markers):
    with pytest.raises(MarkerError, match="No model knows the landmarks"):
        names_of_others(find_protocol("sapo-1"), markers, "anterior", CALIBRATION)


def test_the_surface_of_the_capture_tells_the_other_names_as_well(markers, monkeypatch):
    def on_nobody(namer, depth_m, view, calibration, rotation_deg):
        assert (view, calibration, rotation_deg) == ("anterior", CALIBRATION, 0)
        np.testing.assert_allclose(depth_m, 2.0)
        return namer.who_sees(lambda points_m: np.full((len(points_m), len(JOINT_NAMES)), -20.0))

    monkeypatch.setattr(naming_others, "with_body", on_nobody)
    protocol = find_protocol("joints-15")
    alone = naming_others.names_of_others(protocol, markers, "anterior", CALIBRATION, 0)
    against = naming_others.names_of_others(protocol, markers, "anterior", CALIBRATION, 0, SURFACE)
    assert len(alone) == len(JOINT_NAMES)
    assert not against
