"""The calibration screen's decisions, without Qt."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from unittest.mock import create_autospec

import cv2
import numpy as np
import pytest

from adibas.calibration.files import read_calibration
from adibas.calibration.kept import REMIND_AFTER, KeptCalibrations
from adibas.data.board import Board
from adibas.data.frames import SourceInfo
from adibas.data.printed_boards import PRINTED_BOARDS
from adibas.pipeline.live_frames import LiveFrame, SensorState
from adibas.sensors.ports import SensorOptions
from tests.unit.board_pictures import BOARD, INFO, MAKERS, N_POSES, live_frame, picture
from ui.calibration.ports import CalibrationView
from ui.calibration.presenter import CalibrationPresenter
from ui.ports import CancelledError

NOW = datetime(2026, 5, 1, 9, 0, tzinfo=UTC)
OPTIONS = SensorOptions(color_size=(640, 480))


class Clock:
    def __init__(self):
        self.now = NOW

    def __call__(self):
        return self.now


class Wizard:
    """The presenter, a view that notes, and a sensor that the test drives."""

    def __init__(self, workspace, folder, source="openni2"):
        self.workspace = workspace
        self.live = workspace.live
        self.kept = KeptCalibrations(folder)
        self.clock = Clock()
        self.told = []
        workspace.noticed.subscribe(lambda *notice: self.told.append(notice))
        self.view = create_autospec(CalibrationView, instance=True)
        self.live.open(source, OPTIONS)
        self.live.state = SensorState("live", info=INFO)
        self.presenter = CalibrationPresenter(self.view, workspace, self.kept, self.clock)
        self.time_s = 0.0

    @property
    def result(self):
        return self.presenter.result

    @property
    def shown(self):
        return self.view.show_session.call_args.args[0]

    @property
    def numbers(self):
        return [one.number for one in self.shown.pictures]

    @property
    def moment(self):
        return self.view.show_frame.call_args.args[1]

    def enter(self):
        self.presenter.enter()
        self.presenter.choose_board(BOARD)
        self.see(0)  # brings the session
        return self

    def see(self, index, **faults):
        self.time_s += 0.1
        frame = live_frame(index, self.time_s, **faults)
        self.live.newest = frame
        self.live.frame_arrived.emit(frame)

    def hold(self, *indices):
        for index in indices:
            for _time in range(6):
                self.see(index)

    def consent(self):
        """Press the button of the question that was asked."""
        self.view.confirm.call_args.args[2]()


@pytest.fixture
def wizard(workspace, tmp_path):
    return Wizard(workspace, tmp_path / "calibrations")


def test_the_board_is_looked_for_while_the_screen_is_seen(wizard):
    wizard.presenter.enter()
    assert wizard.live.board == PRINTED_BOARDS["A3"].board
    wizard.presenter.choose_board(BOARD)
    assert wizard.live.board == BOARD
    wizard.presenter.leave()
    assert wizard.live.board is None
    assert wizard.live.orders == [("openni2", OPTIONS)]


def test_a_closed_sensor_is_opened(wizard):
    wizard.live.state = SensorState("closed")
    wizard.presenter.enter()
    assert wizard.live.orders == [("openni2", OPTIONS)] * 2


def test_in_the_simulator_somebody_carries_the_board_about(workspace, tmp_path):
    wizard = Wizard(workspace, tmp_path, "simulator:posterior")
    wizard.presenter.enter()
    assert wizard.live.opened[0] == "simulator:board"
    assert wizard.live.board == PRINTED_BOARDS["A0"].board
    wizard.presenter.leave()
    assert wizard.live.opened[0] == "simulator"


def test_a_still_board_is_taken_once_with_a_sound(wizard):
    wizard.enter().hold(0)
    assert wizard.numbers == [1]
    wizard.view.show_taken.assert_called_once_with()
    wizard.view.beep.assert_called_once_with()
    wizard.hold(0)
    assert wizard.numbers == [1]
    wizard.hold(2, 3)
    assert wizard.numbers == [1, 2, 3]


def test_without_the_wish_for_sound_there_is_none(wizard):
    wizard.workspace.preferences.change(has_sound=False)
    wizard.enter().hold(0)
    assert wizard.numbers == [1]
    wizard.view.beep.assert_not_called()


def test_pictures_are_taken_by_hand_alone_where_that_is_wished(wizard):
    wizard.enter()
    wizard.presenter.set_automatic(False)
    wizard.hold(0)
    assert wizard.numbers == []
    wizard.presenter.take()
    assert wizard.numbers == [1]


def test_by_hand_a_board_that_is_not_seen_is_told(wizard):
    wizard.enter()
    wizard.see(0, is_mirrored=True)
    wizard.presenter.take()
    assert [kind for kind, _sentence in wizard.told] == ["warning"]
    assert wizard.numbers == []


def test_before_the_first_picture_of_the_sensor_nothing_can_be_taken(wizard):
    wizard.presenter.enter()
    wizard.presenter.take()
    assert "no picture of the sensor" in wizard.told[0][1]


def test_the_wizard_goes_on_where_it_was_left(wizard, workspace, tmp_path):
    wizard.enter().hold(0, 2)
    wizard.presenter.close()
    assert wizard.live.board is None
    again = Wizard(workspace, tmp_path / "calibrations")
    again.presenter.enter()
    again.see(5)
    assert again.numbers == [1, 2]
    assert again.live.board == BOARD
    wizard.view.show_frame.reset_mock()
    again.see(5)
    wizard.view.show_frame.assert_not_called()


def test_damaged_pictures_are_told(wizard, workspace, tmp_path):
    wizard.enter().hold(0, 2)
    (wizard.kept.pictures_folder("SN1", (640, 480)) / "0001.png").unlink()
    again = Wizard(workspace, tmp_path / "calibrations")
    again.presenter.enter()
    again.see(5)
    assert again.numbers == [2]
    assert again.told == [("warning", "1 picture is damaged and was left out. Take it again.")]


def test_another_sensor_has_its_own_pictures(wizard):
    wizard.enter().hold(0)
    wizard.live.state = SensorState("live", info=SourceInfo(sensor_serial="SN2"))
    wizard.see(0)
    assert wizard.numbers == []


def test_a_sensor_without_colour_has_none(wizard):
    wizard.presenter.enter()
    wizard.live.frame_arrived.emit(LiveFrame(1, 1, None, None))
    assert wizard.moment.corners is None
    assert wizard.shown.guidance is None


def test_nothing_is_shown_of_a_screen_that_is_left(wizard):
    wizard.enter()
    wizard.presenter.leave()
    wizard.view.reset_mock()
    wizard.see(0)
    wizard.live.state_changed.emit(SensorState("lost"))
    wizard.view.show_frame.assert_not_called()
    wizard.view.show_sensor.assert_not_called()


def test_how_the_sensor_fares_is_shown(wizard):
    wizard.enter()
    lost = SensorState("lost")
    wizard.live.state_changed.emit(lost)
    wizard.view.show_sensor.assert_called_with(lost)


def test_a_picture_can_be_taken_away(wizard):
    wizard.enter().hold(0, 2, 3)
    wizard.presenter.remove(2)
    assert wizard.numbers == [1, 3]


def test_another_board_costs_the_pictures_only_after_a_question(wizard):
    wizard.enter().hold(0, 2)
    wizard.presenter.choose_board(Board(9, 6, 0.031))
    wizard.view.confirm.assert_not_called()
    wizard.presenter.choose_board(Board(8, 6, 0.03))
    question = wizard.view.confirm.call_args.args[0]
    assert question.startswith("2 pictures show another board.")
    assert wizard.shown.board == Board(9, 6, 0.031)
    wizard.consent()
    assert (wizard.shown.board, wizard.numbers) == (Board(8, 6, 0.03), [])
    assert wizard.live.board == Board(8, 6, 0.03)


def test_starting_anew_asks_first(wizard):
    wizard.presenter.start_anew()
    wizard.view.confirm.assert_not_called()
    wizard.enter().hold(0)
    wizard.presenter.start_anew()
    assert wizard.numbers == [1]
    wizard.consent()
    assert wizard.numbers == []


def test_the_result_is_tried_with_three_pictures_and_refused(wizard):
    wizard.enter().hold(0, 1)
    assert not wizard.shown.can_compute
    wizard.hold(2)
    assert wizard.shown.can_compute
    wizard.result.compute()
    outcome = wizard.view.show_outcome.call_args.args[0]
    assert not outcome.is_good_enough
    wizard.result.accept()
    (problem,) = wizard.workspace.jobs.problems
    assert outcome.camera.verdict.sentences()[1] in str(problem)
    assert wizard.kept.of_sensor("SN1") == ()


def test_while_a_result_is_shown_no_picture_is_taken(wizard):
    wizard.enter().hold(0, 1, 2)
    wizard.result.compute()
    wizard.hold(3)
    assert wizard.numbers == [1, 2, 3]
    wizard.result.take_more()
    wizard.view.show_outcome.assert_called_with(None, is_accepted=False)
    wizard.hold(3)
    assert wizard.numbers == [1, 2, 3, 4]


def test_an_accepted_calibration_is_kept_and_the_sensor_opened_with_it(wizard):
    wizard.enter().hold(*range(N_POSES))
    wizard.result.compute()
    wizard.result.accept()
    assert len(wizard.kept.of_sensor("SN1")) == 1
    assert wizard.told[-1] == ("good", "The new calibration is in use from now on.")
    assert wizard.live.orders == [("openni2", OPTIONS)] * 2
    assert wizard.view.show_outcome.call_args.kwargs == {"is_accepted": True}
    wizard.result.accept()  # a second click
    assert len(wizard.kept.of_sensor("SN1")) == 1
    wizard.result.take_more()
    wizard.see(0)
    assert wizard.numbers == []
    assert wizard.shown.reminder.text == "This sensor was calibrated today."


def test_a_good_result_is_unsaved_until_it_is_in_use_or_in_a_file(wizard, tmp_path):
    assert not wizard.result.is_unsaved
    wizard.enter().hold(*range(N_POSES))
    wizard.result.compute()
    assert wizard.result.is_unsaved
    wizard.result.save(tmp_path / "mine.json")
    assert not wizard.result.is_unsaved
    wizard.result.compute()
    assert wizard.result.is_unsaved
    wizard.result.accept()
    assert not wizard.result.is_unsaved


def test_a_result_can_be_thrown_away(wizard):
    wizard.enter().hold(0, 1, 2)
    wizard.result.compute()
    wizard.presenter.start_anew()
    wizard.consent()
    assert wizard.numbers == []
    wizard.view.show_outcome.assert_called_with(None, is_accepted=False)


def test_a_result_goes_to_a_file_too(wizard, tmp_path):
    path = tmp_path / "mine.json"
    wizard.result.save(path)
    assert not path.exists()
    wizard.enter().hold(*range(6))
    wizard.result.compute()
    wizard.result.save(path)
    assert read_calibration(path).sensor_serial == "SN1"
    assert wizard.told[-1] == ("good", "Written: mine.json")


def test_a_report_is_written_as_its_name_says(wizard, tmp_path):
    wizard.result.report(tmp_path / "none.pdf")
    wizard.enter().hold(*range(6))
    wizard.result.compute()
    for name in ("one.xlsx", "two.pdf", "three"):
        wizard.result.report(tmp_path / name)
    written = {path.name: path.read_bytes()[:4] for path in tmp_path.glob("*.*") if path.is_file()}
    assert written == {"one.xlsx": b"PK\x03\x04", "two.pdf": b"%PDF", "three.pdf": b"%PDF"}


@pytest.mark.parametrize(
    ("age", "sentence", "is_urgent"),
    [
        (timedelta(days=0), "This sensor was calibrated today.", False),
        (timedelta(days=1), "This sensor was calibrated 1 day ago.", False),
        (timedelta(days=100), "This sensor was calibrated 3 months ago.", False),
        (
            REMIND_AFTER + timedelta(days=30),
            "This sensor was calibrated 7 months ago. Calibrate it again.",
            True,
        ),
    ],
)
def test_the_user_is_reminded_by_age(wizard, age, sentence, is_urgent):
    wizard.kept.keep(replace(MAKERS, created_utc=NOW.isoformat()))
    wizard.clock.now = NOW + age
    wizard.enter()
    reminder = wizard.shown.reminder
    assert (reminder.text, reminder.is_urgent) == (sentence, is_urgent)


def test_a_sensor_that_was_never_calibrated_is_told(wizard):
    wizard.enter()
    assert wizard.shown.reminder.text == "This sensor was never calibrated on this computer."
    assert wizard.shown.reminder.is_urgent


def test_a_board_is_printed(wizard, tmp_path):
    wizard.presenter.print_board("A4", tmp_path / "board.pdf")
    assert (tmp_path / "board.pdf").read_bytes().startswith(b"%PDF")
    assert wizard.told[0][1].startswith("board.pdf is written. Print it at 100 %")


def save(path, color_rgb):
    cv2.imwrite(str(path), np.ascontiguousarray(color_rgb[..., ::-1]))
    return path


def test_saved_pictures_of_the_size_of_the_sensor_are_counted_as_its_own(wizard, tmp_path):
    wizard.enter().hold(0)
    wizard.presenter.open_images((save(tmp_path / "one.png", picture(3)),))
    assert [one.searched.name for one in wizard.shown.pictures] == ["1", "one.png"]
    assert not wizard.shown.is_offline
    assert wizard.told[-1] == ("good", "1 picture was added.")


def test_without_a_sensor_saved_pictures_stand_alone(wizard, tmp_path):
    for index in range(N_POSES):
        save(tmp_path / f"{index:02d}.png", picture(index))
    wizard.live.state = SensorState("closed")
    wizard.presenter.choose_board(BOARD)
    wizard.presenter.enter()
    wizard.presenter.open_images((tmp_path,))
    assert len(wizard.shown.pictures) == N_POSES
    assert wizard.shown.is_offline
    assert wizard.view.show_kept.call_args.args[0].shape == (480, 640, 3)
    wizard.result.compute()
    wizard.result.save(tmp_path / "mine.json")
    assert read_calibration(tmp_path / "mine.json").color.width == 640
    wizard.result.accept()
    assert "Nobody knows" in str(wizard.workspace.jobs.problems[0])
    wizard.result.take_more()
    wizard.see(0)
    assert wizard.shown.is_offline
    wizard.presenter.show_sensor()
    assert not wizard.shown.is_offline
    assert wizard.numbers == []


def test_why_saved_pictures_are_refused_is_told_of_three(wizard, tmp_path):
    wizard.enter()
    grey = np.full((480, 640, 3), 90, np.uint8)
    paths = [save(tmp_path / f"{name}.png", grey) for name in "abcde"]
    wizard.presenter.open_images((paths[0], *paths[1:]))
    ((kind, sentence),) = wizard.told
    assert kind == "warning"
    assert sentence.startswith("0 pictures were added. a.png: No chessboard is seen.")
    assert sentence.endswith("2 more pictures were left out.")
    assert "d.png" not in sentence


def test_files_without_a_picture_are_a_problem_in_words(wizard, tmp_path):
    wizard.presenter.open_images((tmp_path,))
    assert "no picture among these files" in str(wizard.workspace.jobs.problems[0])
    assert wizard.shown.pictures == ()


def test_a_job_that_was_stopped_leaves_the_screen_usable(wizard, tmp_path):
    wizard.enter()
    paths = (save(tmp_path / "one.png", picture(3)),)
    wizard.workspace.jobs.is_stopped = True
    wizard.presenter.open_images(paths)
    assert (wizard.numbers, wizard.shown.is_busy) == ([], False)
    wizard.workspace.jobs.is_stopped = False
    wizard.presenter.open_images(paths)
    assert wizard.numbers == [1]


class WaitingJobs:
    """Jobs that are done when the test says so."""

    def __init__(self):
        self.waiting = []

    def start(self, _label, work, done, _failed=None, ended=None):
        job = WaitingJob(work, done, ended)
        self.waiting.append(job)
        return job


class WaitingJob:
    def __init__(self, work, done, ended):
        self.is_running = True
        self._parts = work, done, ended

    def progress(self, *_done):
        if not self.is_running:
            raise CancelledError

    def cancel(self):
        self.is_running = False

    def finish(self):
        work, done, ended = self._parts
        result = work(self)
        self.is_running = False
        ended()
        done(result)


def test_one_thing_is_done_at_a_time(wizard):
    wizard.enter().hold(0, 1, 2)
    jobs = WaitingJobs()
    wizard.workspace.jobs = jobs
    wizard.hold(3, 4)
    assert len(jobs.waiting) == 1  # the next picture waits until this one is on the disk
    assert wizard.shown.is_busy
    wizard.result.compute()
    wizard.presenter.remove(1)
    wizard.presenter.start_anew()
    wizard.presenter.open_images((Path("a.png"),))
    assert len(jobs.waiting) == 1
    jobs.waiting[0].finish()
    assert wizard.numbers == [1, 2, 3, 4]
    assert not wizard.shown.is_busy
