"""The calibration screen with real widgets, over a sensor that shows a board."""

import cv2
import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFileDialog,
    QLabel,
    QListWidget,
    QMessageBox,
    QProgressBar,
    QPushButton,
    QSpinBox,
    QTextBrowser,
)

from adibas.calibration.kept import KeptCalibrations
from adibas.data.board import Board
from adibas.data.printed_boards import PRINTED_BOARDS
from adibas.errors import SensorError
from adibas.pipeline.live_frames import SensorState
from adibas.texts import use_language
from tests.unit.board_pictures import BOARD, INFO, N_POSES, live_frame, picture
from ui.calibration.drawing import board_overlays, coverage_overlays, target
from ui.calibration.presenter import CalibrationPresenter
from ui.calibration.view import CalibrationScreen
from ui.widgets.image_view import ImageView
from ui.widgets.overlays import Curve, Region

LEFT = Qt.MouseButton.LeftButton
Key = Qt.Key


class Clinic:
    """The screen, its presenter, and a sensor that the test drives."""

    def __init__(self, qtbot, workspace, folder):
        self.workspace, self.live = workspace, workspace.live
        self.kept = KeptCalibrations(folder)
        self.live.open("openni2", None)
        self.live.state = SensorState("live", info=INFO)
        self.screen = CalibrationScreen()
        qtbot.addWidget(self.screen)
        self.presenter = CalibrationPresenter(self.screen, workspace, self.kept)
        self.screen.bind(self.presenter)
        self.screen.resize(1100, 740)
        self.screen.show()
        self.screen.entered()
        self.time_s = 0.0

    def see(self, index, n_times=1, **faults):
        for _time in range(n_times):
            self.time_s += 0.1
            frame = live_frame(index, self.time_s, **faults)
            self.live.newest = frame
            self.live.frame_arrived.emit(frame)

    def hold(self, *indices):
        for index in indices:
            self.see(index, 6)

    def find(self, kind, name=""):
        found = [
            one
            for one in self.screen.findChildren(kind)
            if one.isVisible() and (not name or one.text().replace("&", "") == name)
        ]
        assert len(found) == 1, (kind, name, len(found))
        return found[0]

    def click(self, text):
        QTest.mouseClick(self.find(QPushButton, text), LEFT)

    @property
    def words(self):
        return [one.text() for one in self.screen.findChildren(QLabel) if one.isVisible()]

    @property
    def listed(self):
        pictures = self.screen.findChild(QListWidget)
        return [pictures.item(row).text() for row in range(pictures.count())]


@pytest.fixture
def clinic(qtbot, workspace, tmp_path):
    made = Clinic(qtbot, workspace, tmp_path / "calibrations")
    yield made
    made.screen.closed()


@pytest.fixture
def calibrating(clinic):
    """The clinic, where the board of the pictures is chosen and a sensor seen."""
    clinic.presenter.choose_board(BOARD)
    clinic.see(0)
    return clinic


def test_a_printed_board_is_chosen_from_the_list(clinic):
    sizes = clinic.screen.findChild(QComboBox)
    assert sizes.currentText() == "A3"
    QTest.keyClick(sizes, Key.Key_Up)
    assert sizes.currentText() == "A4"
    assert clinic.live.board == PRINTED_BOARDS["A4"].board


def test_an_own_board_is_given_by_three_numbers(clinic):
    sizes = clinic.screen.findChild(QComboBox)
    QTest.keyClick(sizes, Key.Key_End)
    assert clinic.live.board == PRINTED_BOARDS["A3"].board  # until something else is typed
    columns, rows = clinic.screen.findChildren(QSpinBox)
    square = clinic.screen.findChild(QDoubleSpinBox)
    for box, text in ((columns, "8"), (rows, "5"), (square, "31.5")):
        box.setFocus()
        box.selectAll()
        QTest.keyClicks(box, text)
        QTest.keyClick(box, Key.Key_Return)
    assert clinic.live.board == Board(8, 5, 0.0315)
    assert sizes.currentText() == "Own board"
    assert not any(
        one.isVisible()
        for one in clinic.screen.findChildren(QPushButton)
        if one.text().startswith("&Print")
    )


def test_the_board_is_drawn_and_taken_when_it_is_still(calibrating):
    image = calibrating.find(ImageView)
    calibrating.see(0)
    assert "Hold the board still for a moment." in calibrating.words
    assert calibrating.listed == []
    calibrating.hold(0)
    assert calibrating.listed == ["1"]
    assert calibrating.find(QProgressBar).value() == 100
    assert image.placement.picture == (640, 480)
    calibrating.hold(3)
    assert calibrating.listed == ["1", "2"]
    assert "○ 2 of 12 pictures" in calibrating.words


def test_what_is_wrong_with_the_board_is_said(clinic):
    clinic.presenter.choose_board(Board(8, 5, 0.03))
    clinic.see(0, board=Board(8, 5, 0.03))
    clinic.see(0, board=Board(8, 5, 0.03))
    assert any("9 x 6" in words for words in clinic.words)


def test_a_picture_is_taken_by_hand_and_removed_by_key(calibrating):
    QTest.mouseClick(calibrating.find(QCheckBox), LEFT, pos=QPoint(10, 10))
    calibrating.hold(0)
    assert calibrating.listed == []
    calibrating.click("Take a picture now")
    calibrating.see(4)
    calibrating.click("Take a picture now")
    assert calibrating.listed == ["1", "2"]
    pictures = calibrating.find(QListWidget)
    pictures.setFocus()
    QTest.keyClick(pictures, Key.Key_Delete)
    assert calibrating.listed == ["1"]


def answer(screen, text):
    (box,) = screen.findChildren(QMessageBox)
    (button,) = (one for one in box.buttons() if one.text() == text)
    QTest.mouseClick(button, LEFT)


def test_starting_anew_can_be_thought_over(calibrating):
    calibrating.hold(0)
    calibrating.click("Start anew...")
    answer(calibrating.screen, "Cancel")
    assert calibrating.listed == ["1"]


def test_all_pictures_go_when_the_user_agrees(calibrating):
    calibrating.hold(0)
    calibrating.click("Start anew...")
    answer(calibrating.screen, "Start anew")
    assert calibrating.listed == []


def test_a_bad_result_says_why_and_cannot_be_used(calibrating):
    calibrating.hold(0, 1)
    assert not calibrating.find(QPushButton, "Calculate the calibration").isEnabled()
    calibrating.hold(2)
    calibrating.click("Calculate the calibration")
    assert "Repeat the calibration, because:" in calibrating.words
    finding = calibrating.presenter.result.outcome.camera.verdict.sentences()[1]
    assert finding in calibrating.find(QTextBrowser).toPlainText()
    assert not calibrating.find(QPushButton, "Use this calibration").isEnabled()
    calibrating.click("Take more pictures")
    assert calibrating.find(ImageView).isVisible()
    assert calibrating.listed == ["1", "2", "3"]


def test_a_good_result_is_used_and_compared_with_the_next(calibrating):
    for n_kept in (1, 2):
        calibrating.hold(*range(N_POSES))
        calibrating.click("Calculate the calibration")
        text = calibrating.find(QTextBrowser).toPlainText()
        assert "95 % interval" in text
        assert ("Against the calibration of" in text) == (n_kept == 2)
        calibrating.click("Use this calibration")
        assert len(calibrating.kept.of_sensor("SN1")) == n_kept
        assert "In use." in calibrating.words
        calibrating.click("Calibrate again")
        calibrating.see(0)
        assert calibrating.listed == []


def test_the_board_is_printed_where_the_user_wants(clinic, tmp_path):
    clinic.click("Print the board...")
    (dialog,) = clinic.screen.findChildren(QFileDialog)
    dialog.fileSelected.emit(str(tmp_path / "mine.pdf"))
    dialog.close()
    assert (tmp_path / "mine.pdf").exists()


@pytest.mark.parametrize(
    ("button", "name"),
    [("Save to a file...", "mine.json"), ("Write a report...", "mine.pdf")],
)
def test_a_result_goes_where_the_user_wants(calibrating, tmp_path, button, name):
    calibrating.hold(*range(6))
    calibrating.click("Calculate the calibration")
    calibrating.click(button)
    (dialog,) = calibrating.screen.findChildren(QFileDialog)
    dialog.fileSelected.emit(str(tmp_path / name))
    dialog.close()
    assert (tmp_path / name).exists()


def test_saved_pictures_are_chosen_in_a_dialog_and_looked_at(calibrating, tmp_path):
    calibrating.live.state = SensorState("closed")
    big = np.ascontiguousarray(np.kron(picture(0), np.ones((2, 2, 1), np.uint8))[..., ::-1])
    cv2.imwrite(str(tmp_path / "big.png"), big)
    calibrating.click("Use saved pictures...")
    (dialog,) = calibrating.screen.findChildren(QFileDialog)
    dialog.filesSelected.emit([str(tmp_path / "big.png")])
    dialog.close()
    assert calibrating.listed == ["big.png"]
    assert calibrating.find(ImageView).placement.picture == (1280, 960)
    calibrating.click("Back to the sensor")
    calibrating.see(0)
    assert calibrating.listed == []


def test_a_dropped_picture_is_used(calibrating, tmp_path):
    cv2.imwrite(str(tmp_path / "one.png"), np.ascontiguousarray(picture(5)[..., ::-1]))
    calibrating.screen.open_file(tmp_path / "one.png")
    assert calibrating.listed == ["one.png"]


def test_a_lost_sensor_is_told(calibrating):
    error = SensorError("The sensor {sensor} was unplugged.", sensor="S")
    calibrating.live.state_changed.emit(SensorState("lost", error))
    assert "The sensor S was unplugged." in calibrating.words
    calibrating.live.state_changed.emit(SensorState("opening"))
    assert "The sensor S was unplugged." not in calibrating.words


def test_every_text_follows_the_language(calibrating):
    calibrating.hold(0, 1, 2)
    calibrating.click("Calculate the calibration")
    use_language("es")
    try:
        calibrating.screen.retranslate()
        assert "Result of the calibration" not in calibrating.words
    finally:
        use_language("en")


def test_lines_cross_in_the_corners_and_skip_what_is_hidden():
    corners = live_frame(0).board.corners
    lines = board_overlays(corners, BOARD, is_ready=False)
    assert len(lines) == BOARD.rows + BOARD.columns
    assert all(isinstance(line, Curve) for line in lines)
    assert lines[0].points[3] == pytest.approx(tuple(corners.pixels[3]))
    assert lines[BOARD.rows + 3].points[0] == pytest.approx(tuple(corners.pixels[3]))


def test_the_part_of_the_picture_that_lacks_most_is_marked(calibrating):
    calibrating.hold(0)
    guidance = calibrating.presenter._bench.session.guidance
    covered, wanted = coverage_overlays(guidance, (480, 640))
    assert isinstance(covered, Region)
    corners = live_frame(0).board.corners.pixels.round().astype(int)
    assert covered.pixels[corners[:, 1], corners[:, 0]].all()
    down, right = target(guidance)
    middle = (round((1.5 + down) * 160), round((1.5 + right) * 640 / 3))
    assert wanted.pixels[middle]
    assert wanted.pixels.mean() == pytest.approx(1 / 9, abs=0.01)
    assert coverage_overlays(guidance, (480, 640))[0] is covered  # its picture is kept then
    assert coverage_overlays(guidance, (48, 64))[0].pixels.shape == (48, 64)
