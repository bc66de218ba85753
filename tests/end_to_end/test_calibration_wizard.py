"""A sensor is calibrated in the real main window, from the choice of the board to its use."""

from dataclasses import replace

import pytest
from keyring.backends import fail
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox, QListWidget

from adibas.calibration.kept import KeptCalibrations
from adibas.sensors import simulator
from adibas.simulation.boards_scenes import BoardScene, BoardSceneSettings
from tests.end_to_end.hurried_board import SMALL, hurried_scene
from tests.ui import conftest as rules
from tests.ui import window_user
from tests.unit.store_samples import use_keyring

LEFT = Qt.MouseButton.LeftButton
PATIENCE_MS = 240_000
"""A walk and its calculation take half a minute; a busy computer misses half of the stops."""

nothing_left_behind = rules.nothing_left_behind
open_window = window_user.open_window


@pytest.fixture(autouse=True)
def hurried(monkeypatch):
    monkeypatch.setattr(simulator, "open_scene", hurried_scene)


@pytest.fixture(autouse=True)
def no_keyring(monkeypatch):
    use_keyring(monkeypatch, fail.Keyring())


@pytest.fixture(autouse=True)
def own_calibrations(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))


def pictures_of(user):
    return user.screen.findChild(QListWidget).count()


def test_a_sensor_is_calibrated_and_used_with_its_new_calibration(open_window):
    user = open_window()
    user.give_new_passphrase()
    user.go_to("calibration")
    sizes = user.screen.findChild(QComboBox)
    user.until(lambda: sizes.currentText() == "A0")  # what the simulator's people hold
    user.until(lambda: pictures_of(user) >= 4)

    # Somebody needs the computer for something else meanwhile.
    n_before = pictures_of(user)
    user.application.lock()
    user.until(lambda: not user.window.shown and user.workspace is None)
    user.give_passphrase()
    user.until(lambda: user.window.shown == "calibration")
    user.until(lambda: pictures_of(user) >= n_before)

    user.qtbot.waitUntil(lambda: not user.screen._shown.guidance.lacking[1:], timeout=PATIENCE_MS)
    user.settle()
    user.click("Calculate the calibration")
    user.qtbot.waitUntil(lambda: not user.application.jobs.is_busy, timeout=PATIENCE_MS)
    user.until(lambda: user.button("Use this calibration").isVisible())
    user.click("Use this calibration")
    user.until(lambda: user.window.told == "The new calibration is in use from now on.")

    truth = BoardScene(replace(BoardSceneSettings(), color_size=SMALL)).device.calibration
    user.go_to("capture")
    user.until(lambda: user.workspace.live.newest is not None)
    used = user.workspace.live.view.calibration
    (kept,) = KeptCalibrations().of_sensor(truth.sensor_serial)
    assert used.created_utc == kept.calibration.created_utc
    assert used.color == kept.calibration.color
    assert used.color.intrinsics.fx == pytest.approx(truth.color.intrinsics.fx, rel=2e-3)
    user.until(lambda: user.workspace.live.newest.outline is not None)
    assert not kept.path.parent.joinpath("pictures-640x480", "0001.png").exists()
    user.close()
