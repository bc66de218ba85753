"""The learner under mouse and keyboard, on a picture of the simulator, with real jobs."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QApplication,
    QLabel,
    QListWidget,
    QPushButton,
    QRadioButton,
    QSlider,
)

from adibas.data.frames import SourceInfo
from adibas.pipeline.live import LiveFrame, SensorState
from adibas.simulation.scenes import open_scene
from adibas.texts import use_language
from tests.ui.conftest import NoSensor
from ui.jobs import JobRunner
from ui.markers.screen import build_markers_screen
from ui.widgets.image_view import ImageView
from ui.workspace import Workspace

LEFT = Qt.MouseButton.LeftButton
PATIENCE_MS = 60_000


@pytest.fixture(scope="module")
def simulated():
    return open_scene("anterior", seed=5).frame(0)


@pytest.fixture
def facing(simulated):
    """Markers that the camera sees well, with the true colour of the sticker about them."""
    return sorted(simulated.truth.markers, key=lambda marker: marker.view_angle_rad)[:4]


@pytest.fixture
def jobs(qapp):  # noqa: ARG001  (signals need it)
    jobs = JobRunner(lambda error: pytest.fail(str(error)))
    yield jobs
    jobs.close()


@pytest.fixture
def screen(store, jobs, preferences, theme, qtbot, simulated):  # noqa: ARG001
    live = NoSensor()
    live.newest = LiveFrame(1, 0, simulated.sensor_frame.color, None)
    live.state = SensorState("live", None, SourceInfo())
    live.view = SimpleNamespace(calibration=None)
    screen = build_markers_screen(Workspace(store, jobs, preferences, live))
    qtbot.addWidget(screen)
    screen.resize(1140, 740)
    with qtbot.waitExposed(screen):
        screen.show()
    screen.entered()
    yield screen
    screen.closed()


@pytest.fixture
def settle(jobs, qtbot):
    def wait():
        qtbot.waitUntil(lambda: not jobs.is_busy, timeout=PATIENCE_MS)
        QApplication.processEvents()  # what a layout has taken up is shown a moment later

    return wait


def at(screen, u, v):
    view, placement = screen.findChild(ImageView), None
    while placement != view.placement:  # the picture has its place when all is laid out
        placement = view.placement
        QApplication.processEvents()
    x, y = placement.to_widget(u, v)
    return QPoint(round(x), round(y))


def click_on(screen, marker):
    QTest.mouseClick(screen.findChild(ImageView), LEFT, pos=at(screen, marker.u, marker.v))


def button(screen, text):
    (found,) = [
        one for one in screen.findChildren(QPushButton) if one.text().replace("&", "") == text
    ]
    return found


def words(screen):
    return [label.text() for label in screen.findChildren(QLabel) if label.isVisible()]


def swatches(screen):
    names = [label.accessibleName() for label in screen.findChildren(QLabel) if label.isVisible()]
    return [name for name in names if name.startswith("#")]


def test_clicks_on_stickers_find_the_markers(screen, facing, settle):
    for marker in facing[:2]:
        click_on(screen, marker)
        settle()
    assert screen.findChild(QListWidget).count() == 2
    counted = next(text for text in words(screen) if "found" in text)
    assert int(counted.split()[0]) >= 8
    assert button(screen, "Use these markers").isEnabled()
    assert button(screen, "Save...").isEnabled()


def test_the_swatches_have_the_sticker_s_colour(screen, facing, settle, simulated):
    click_on(screen, facing[0])
    settle()
    u, v = round(facing[0].u), round(facing[0].v)
    sticker = simulated.sensor_frame.color[v, u].astype(int)
    colors = [np.array([int(name[i : i + 2], 16) for i in (1, 3, 5)]) for name in swatches(screen)]
    assert min(np.abs(color - sticker).max() for color in colors) <= 25


def test_the_region_is_drawn_at_once_and_follows_the_keys(screen, facing, settle):
    click_on(screen, facing[0])
    settle()
    sizes = []
    slider = screen.findChild(QSlider)
    for _ in range(3):
        QTest.keyClick(slider, Qt.Key.Key_PageUp)
        sizes.append(screen.findChild(QListWidget).item(0).text())
        assert str(slider.value()) in words(screen), "the value stands beside the slider"
    assert slider.value() == 35
    grown = [int(text.split()[0]) for text in sizes]
    assert grown == sorted(grown)
    settle()


def test_a_region_is_discarded_by_the_delete_key(screen, facing, settle):
    for marker in facing[:2]:
        click_on(screen, marker)
        settle()
    regions = screen.findChild(QListWidget)
    assert regions.currentRow() == 1, "the new one"
    regions.setFocus()
    QTest.keyClick(regions, Qt.Key.Key_Delete)
    assert regions.count() == 1
    QTest.keyClick(regions, Qt.Key.Key_Delete)
    settle()
    assert regions.count() == 0
    assert not button(screen, "Discard the region").isEnabled()
    assert not button(screen, "Use these markers").isEnabled()
    assert swatches(screen) == []


def test_the_mode_chooses_controls_and_advice(screen, settle):
    led = next(one for one in screen.findChildren(QRadioButton) if "LED" in one.text())
    QTest.mouseClick(led, LEFT, pos=QPoint(10, led.height() // 2))
    settle()
    assert any("LED" in text and "lower" in text for text in words(screen))
    assert not screen.findChild(QListWidget).isVisible()
    assert [slider.isVisible() for slider in screen.findChildren(QSlider)] == [False, True]


def test_freezing_and_letting_go(screen, settle, qtbot):
    assert not button(screen, "Show the sensor").isEnabled()
    qtbot.mouseClick(button(screen, "Freeze"), LEFT)
    settle()
    assert not button(screen, "Freeze").isEnabled()
    qtbot.mouseClick(button(screen, "Show the sensor"), LEFT)
    assert button(screen, "Freeze").isEnabled()


def test_it_speaks_another_language_and_keeps_what_was_learned(screen, facing, settle):
    click_on(screen, facing[0])
    settle()
    before = swatches(screen)
    use_language("es")
    try:
        screen.retranslate()
        assert any("marcador" in text for text in words(screen))
    finally:
        use_language("en")
        screen.retranslate()
    assert swatches(screen) == before != []


def test_everything_is_named_and_reached_by_the_keyboard(screen):
    for kind in (QPushButton, QRadioButton):
        for one in screen.findChildren(kind):
            assert one.text() or one.accessibleName()
            assert one.focusPolicy() & Qt.FocusPolicy.TabFocus
    assert screen.findChild(ImageView).accessibleName()


def test_a_picture_of_another_size_is_drawn_without_the_old_regions(screen, facing, settle):
    click_on(screen, facing[0])
    settle()
    workspace = screen._presenter._workspace
    small = np.ascontiguousarray(workspace.live.newest.color_rgb[::2, ::2])
    workspace.live.newest = replace(workspace.live.newest, color_rgb=small)
    screen._presenter.show_sensor()
    screen.grab()
    click_on(screen, replace(facing[0], u=facing[0].u / 2, v=facing[0].v / 2))
    settle()
    screen.grab()
    assert screen.findChild(ImageView).placement.picture == (640, 512)
    assert screen.findChild(QListWidget).count() == 1
