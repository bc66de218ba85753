"""A sensor is calibrated in the real main window, from the choice of the board to its use."""

from dataclasses import replace

import pytest
from keyring.backends import fail
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox, QListWidget

from adibas.calibration.kept import KeptCalibrations
from adibas.data.frames import SourceInfo
from adibas.sensors import simulator
from adibas.simulation.boards_scenes import BoardScene, BoardSceneSettings
from adibas.simulation.frame_times import frame_time_ns
from adibas.simulation.scenes import open_scene
from tests.ui import conftest as rules
from tests.ui import window_user
from tests.unit.store_samples import use_keyring

LEFT = Qt.MouseButton.LeftButton
SMALL = (480, 640)
PATIENCE_MS = 240_000
"""A walk and its calculation take half a minute; a busy computer misses half of the stops."""

STILL_EVERY, FRAMES_A_STOP = 3, 8
"""Ten frames a second for 0.7 s tell that the board is held still, some of them missed."""

nothing_left_behind = rules.nothing_left_behind
open_window = window_user.open_window


class HurriedScene:
    """The board of the simulator at its stops alone, and at each for less than a second.

    What is left out the wizard would pass over; each picture is the scene's own.
    """

    def __init__(self, scene):
        self._scene = scene
        self.info: SourceInfo = scene.info
        self._kept = self._frames_to_keep()
        self.n_frames = len(self._kept)

    def _frames_to_keep(self):
        seed, walk = self._scene.settings.seed, self._scene.walk
        first_ns = frame_time_ns(seed, 0)
        by_stop = {}
        for index in range(0, round(walk.duration_s * 30), STILL_EVERY):
            stop = walk.station_at((frame_time_ns(seed, index) - first_ns) * 1e-9)
            if stop is not None:
                by_stop.setdefault(stop, []).append(index)
        return [index for stop in by_stop.values() for index in stop[:FRAMES_A_STOP]]

    def frame(self, index):
        simulated = self._scene.frame(self._kept[index])
        time_ns = round(index * STILL_EVERY * 1e9 / 30)
        frame = replace(
            simulated.sensor_frame,
            sequence=index,
            timestamp_ns=time_ns,
            color_timestamp_ns=time_ns,
        )
        return replace(simulated, sensor_frame=frame)


@pytest.fixture(autouse=True)
def hurried(monkeypatch):
    def opened(name, seed=0, **changes):
        changes["color_size"] = SMALL
        if name != "board":
            return open_scene(name, seed, **changes)
        settings = replace(BoardSceneSettings(seed), **changes)
        return HurriedScene(BoardScene(settings))

    monkeypatch.setattr(simulator, "open_scene", opened)


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
