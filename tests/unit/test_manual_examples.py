"""What the manual shows to developers works: a sensor, a protocol, a kind of measure, a gesture."""

import importlib.util
import json
import sys

import numpy as np
import pytest

from adibas.data import protocols
from adibas.data.protocols import KINDS
from adibas.errors import SensorError
from adibas.measures import comparison, protocol_rules, protocol_values, trends
from adibas.measures.kind_values import PROJECTED, SPATIAL
from adibas.measures.protocol_file import load_protocol
from adibas.measures.protocol_measures import Capturing, measure_protocol
from adibas.pipeline.recording import record
from adibas.recordings import open_recording
from adibas.recordings.joints_csv import read_joints_csv
from adibas.sensors import SensorOptions
from installers.manual.pictures import MANUAL
from tests.unit.standing_points import LEVEL, seen_from, standing

FOLDER = MANUAL / "developers"
KIND = "distance_share"
N_TRIALS = 2000
NOISE_M = 0.002


def example(name):
    spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def test_the_example_of_a_sensor_is_recorded_as_it_gives_itself(tmp_path):
    camera = example("sensor_example").WallCamera(SensorOptions(color_size=(640, 480)))
    path = tmp_path / "wall.mcap"
    with camera:
        summary = record(camera, path, seconds=0.2)
    camera.close()
    with pytest.raises(SensorError, match="closed"):
        camera.read()
    assert summary.n_dropped == 0
    with open_recording(path) as reader:
        assert reader.info.sensor_name == "Wall"
        frames = [reader.read(index) for index in range(len(reader))]
    assert len(frames) == summary.n_frames > 3
    for frame in frames:
        assert (frame.depth_raw[:, :8] == 0).all()
        assert (frame.depth_raw[:, 8:] == 2000).all()
        assert frame.color_timestamp_ns == frame.timestamp_ns


def test_the_example_of_a_protocol_measures_a_patient():
    protocol = load_protocol(FOLDER / "protocol_example.json")
    places = standing() | {"sternal_notch": np.array([0.0, 1.38, 0.06])}
    places["left_acromion"] = places["left_acromion"] + (0.02, 0.01, 0.0)
    markers = seen_from("anterior", places)
    found = measure_protocol(protocol, markers, Capturing("anterior", LEVEL)).results
    values = {one.definition.measure_id: one.main.value for one in found}
    right, left = places["right_acromion"], places["left_acromion"]
    line = left - right
    assert values["ACR.H"] == pytest.approx(np.arctan2(line[1], line[0]))
    notch = places["sternal_notch"]  # its main value is the one in the plane
    expected = np.linalg.norm((notch - right)[:2]) - np.linalg.norm((notch - left)[:2])
    assert values["ACR.DIFF"] == pytest.approx(expected)


@pytest.fixture
def new_kind(monkeypatch):
    """The three entries that the manual tells of."""
    module = example("measure_example")
    known = {**KINDS, KIND: module.RULE}
    for user in (protocols, protocol_rules, protocol_values, comparison, trends):
        monkeypatch.setattr(user, "KINDS", known)
    for table in (PROJECTED, SPATIAL):
        monkeypatch.setitem(table, KIND, module.distance_share)
    return module


def leg_and_trunk():
    return {
        "format": "adibas-protocol", "version": 1, "id": "shares", "revision": "1",
        "title": "Shares", "source": "a test",
        "landmarks": [
            {"id": name, "name": name, "views": ["anterior"]}
            for name in ("right_asis", "right_medial_malleolus", "right_acromion")
        ],
        "measures": [{
            "id": "SHARE", "name": "Leg to trunk", "views": ["anterior"], "kind": KIND,
            "points": ["right_asis", "right_medial_malleolus", "right_asis", "right_acromion"],
            "unit": "%",
        }],
    }  # fmt: skip


def test_a_new_kind_is_measured_through_a_protocols_file(new_kind, tmp_path):
    path = tmp_path / "shares.json"
    path.write_text(json.dumps(leg_and_trunk()), encoding="utf-8")
    places = standing()
    markers = seen_from("anterior", places)
    found = measure_protocol(load_protocol(path), markers, Capturing("anterior", LEVEL))
    (result,) = found.results
    leg = np.linalg.norm(places["right_asis"] - places["right_medial_malleolus"])
    trunk = np.linalg.norm(places["right_asis"] - places["right_acromion"])
    assert result.main.value == pytest.approx(leg / trunk)
    low, high = result.main.interval
    assert low < result.main.value < high
    assert new_kind.RULE.quantity == "share"


def test_a_new_kind_is_none_where_points_coincide(new_kind):
    points_m = np.zeros((2, 4, 3))
    points_m[0, 1] = points_m[0, 3] = (0.3, 0.4, 0.0)
    shares = new_kind.distance_share(points_m, (np.eye(3)[0], np.eye(3)[1]))
    assert shares[0] == pytest.approx(1.0)
    assert np.isnan(shares[1])


def test_intervals_of_a_new_kind_hold_the_truth(new_kind):
    rng = np.random.default_rng(8)
    from adibas.measures.propagation import Inputs, first_order

    true_m = np.array([[0.1, 0.0, 0.0], [0.1, 0.9, 0.05], [0.1, 0.0, 0.0], [0.15, -0.45, 0.02]])
    noisy_m = true_m + rng.normal(0.0, NOISE_M, (N_TRIALS, 4, 3))
    inputs = Inputs(noisy_m, np.broadcast_to(NOISE_M**2 * np.eye(12), (N_TRIALS, 12, 12)), 0.0)

    def of(points_m, _tilts_rad):
        return new_kind.distance_share(points_m, (np.eye(3)[0], np.eye(3)[1]))

    found = first_order(of, inputs, is_angle=False)
    truth = new_kind.distance_share(true_m, (np.eye(3)[0], np.eye(3)[1]))
    held = [one.interval[0] <= truth <= one.interval[1] for one in found]
    assert np.mean(held) == pytest.approx(0.95, abs=0.015)


def test_the_example_of_gestures_writes_what_can_be_learned_from(tmp_path):
    example("gesture_example").write_examples(tmp_path, n_people=2)
    tracks = [read_joints_csv(tmp_path / f"p{k}.joints.csv").tracks for k in range(2)]
    assert all(len(one) == 1 and np.isfinite(one[0].joints_m).all() for one in tracks)
    events = (tmp_path / "events.csv").read_text(encoding="utf-8").splitlines()
    assert len(events) == 1 + 2 * 4
