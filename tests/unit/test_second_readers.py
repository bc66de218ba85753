"""What goes to other programs is opened by readers that others wrote: of C3D, TRC and ELAN.

Each is another one than the library with which the file was written. For BORIS there is no library;
its projects are read by its rule. MCAP's own library reads recordings in `test_mcap_recordings.py`.
"""

import json

import c3d
import numpy as np
import pytest
from pympi import Eaf
from trc import TRCData

from adibas.data.coding import Section
from adibas.data.joints import JOINT_NAMES
from adibas.data.skeleton_track import track_of
from adibas.movement.joint_angles import INDEX
from adibas.movement.measuring import measure_movement
from adibas.recordings.boris_writing import write_boris
from adibas.recordings.elan_writing import write_elan
from adibas.reports.motion_files import upright_axes
from adibas.reports.movement import write_movement
from tests.unit.coding_samples import ETHOGRAM, coding
from tests.unit.movement_samples import bending, source

UNSEEN = slice(40, 70)
ROUNDED_MM = 1e-3


@pytest.fixture(scope="module")
def movement():
    """Fifteen joints, one of which is not seen for a second."""
    track = bending(noise_m=0.002)
    joints_m = track.joints_m.copy()
    joints_m[UNSEEN, INDEX["left_hand"]] = np.nan
    return measure_movement(track_of(track.times_s, joints_m), source(patient="P-7"))


@pytest.fixture
def places_mm(movement):
    """Of each frame and joint: to the right, away, up."""
    return 1000 * movement.joints_m @ upright_axes(movement.up).T


@pytest.mark.filterwarnings("ignore::UserWarning:c3d")
def test_c3d_is_read_by_a_library_that_did_not_write_it(movement, places_mm, tmp_path):
    write_movement(movement, tmp_path / "m.c3d", "en")
    with (tmp_path / "m.c3d").open("rb") as file:
        reader = c3d.Reader(file)
        assert [name.strip() for name in reader.point_labels] == list(JOINT_NAMES)
        assert reader.point_rate == pytest.approx(movement.rate_hz, rel=1e-5)
        assert reader.get("POINT:UNITS").string_value.strip() == "mm"
        points = np.array([points for _number, points, _analog in reader.read_frames()])
    is_seen = np.isfinite(places_mm).all(axis=2)
    assert ((points[..., 3] >= 0) == is_seen).all()
    np.testing.assert_allclose(points[is_seen, :3], places_mm[is_seen], atol=ROUNDED_MM)


def test_trc_is_read_by_a_library_of_others(movement, places_mm, tmp_path):
    """It splits lines at white space: a joint that is not seen must not shift the others."""
    write_movement(movement, tmp_path / "m.trc", "en")
    read = TRCData()
    read.load(str(tmp_path / "m.trc"))
    assert read["Markers"] == list(JOINT_NAMES)
    assert (read["Units"], read["NumFrames"]) == ("mm", len(movement.times_s))
    np.testing.assert_allclose(read["Time"], movement.times_s, atol=1e-6)
    points = np.moveaxis(np.array([read[name] for name in JOINT_NAMES]), 0, 1)
    right, away, up = np.moveaxis(places_mm, 2, 0)
    np.testing.assert_allclose(points, np.stack([away, up, right], axis=2), atol=ROUNDED_MM)


def test_elan_files_are_read_by_a_library_of_others(tmp_path):
    one = coding(
        ("fidgets", 0, 4, "child", ("pen",)),
        ("fidgets", 2, 5, "child"),
        ("nods", 3, 3),
        ("seated", 6, 9.25, "peer"),
        sections=(Section("game", 0, 9000),),
    )
    write_elan(tmp_path / "c.eaf", one)
    read = Eaf(str(tmp_path / "c.eaf"))
    found = {name: read.get_annotation_data_for_tier(name) for name in read.get_tier_names()}
    assert {name: spans for name, spans in found.items() if spans} == {
        "fidgets@child": [(0, 4000, json.dumps({"modifiers": ["pen"]}))],
        "fidgets@child (2)": [(2000, 5000, "")],
        "nods": [(3000, 3001, "")],
        "seated@peer": [(6000, 9250, "")],
        "adibas sections": [(0, 9000, "game")],
    }
    assert {one.name for one in ETHOGRAM.behaviours} <= set(found)
    assert read.get_parameters_for_tier("seated@peer")["PARTICIPANT"] == "peer"


def test_a_project_of_boris_says_what_lasted_to_who_pairs_its_events_as_boris_does(tmp_path):
    """Written after BORIS' own rule: events of one subject, code and modifiers begin and end.

    BORIS 8.27 itself opened such a file and found its states paired; it is no library.
    """
    one = coding(
        ("fidgets", 0, 4, "child", ("pen",)),
        ("fidgets", 2, 5, "child"),
        ("nods", 3, 3),
        ("seated", 6, 9.25, "peer"),
    )
    write_boris(tmp_path / "c.boris", [one])
    project = json.loads((tmp_path / "c.boris").read_text("utf-8"))
    kinds = {each["code"]: each["type"] for each in project["behaviors_conf"].values()}
    begun, found = {}, []
    for time_s, *what, _comment in project["observations"]["session 1"]["events"]:
        name = tuple(what)
        if kinds[what[1]] == "Point event":
            found.append((*name, time_s, time_s))
        elif name in begun:
            found.append((*name, begun.pop(name), time_s))
        else:
            begun[name] = time_s
    assert not begun
    assert sorted(found) == [
        ("", "nods", "None", 3.0, 3.0),
        ("child", "fidgets", "None|None", 2.0, 5.0),
        ("child", "fidgets", "pen|None", 0.0, 4.0),
        ("peer", "seated", "", 6.0, 9.25),
    ]
