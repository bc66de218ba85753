"""Pictures of a calibration are taken at the right moment, and none is lost whatever happens."""

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import cv2
import numpy as np
import pytest

from adibas.calibration.finder import TEXTS, BoardProblem
from adibas.calibration.kept import KeptCalibrations
from adibas.data.board import Board
from adibas.data.calibration_verdict import SENTENCES, Grade, Reason
from adibas.data.frames import SourceInfo
from adibas.errors import CalibrationError, FileError
from adibas.pipeline.calibration_images import images_in
from adibas.pipeline.calibration_pictures import PictureFolder, read_disparity
from adibas.pipeline.calibration_session import CalibrationSession
from adibas.pipeline.calibration_watch import BLURRED, KNOWN, MOVING
from adibas.pipeline.live_frames import LiveFrame
from adibas.pipeline.sensor_calibration import CalibratedSensor, sensor_of
from tests.unit.board_pictures import (
    BOARD,
    CAMERA,
    INFO,
    N_POSES,
    depth_raw,
    live_frame,
    picture,
)

ROOT = Path(__file__).parents[2]
NOW = datetime(2026, 5, 1, 9, 0, tzinfo=UTC)
SENSOR = CalibratedSensor("SN1", (640, 480), INFO)


def clock():
    return NOW


@pytest.fixture
def kept(tmp_path):
    return KeptCalibrations(tmp_path / "calibrations")


def opened(kept, sensor=SENSOR, board=BOARD):
    return CalibrationSession(sensor, kept, board)


def test_nothing_is_compiled_when_the_window_sees_its_first_frames(kept):
    made = """
import sys
from pathlib import Path
from adibas.calibration.kept import KeptCalibrations
from adibas.markers.disparity_kernels import accumulate, summarise
from tests.unit.test_calibration_session import hold, opened

session = opened(KeptCalibrations(Path(sys.argv[1])))
kernels = accumulate, summarise
before = [len(kernel.signatures) for kernel in kernels]
hold(session, 0)
print(before, [len(kernel.signatures) for kernel in kernels], session._watch._depth is None)
"""
    command = [sys.executable, "-c", made, str(kept.folder)]
    told = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    assert told.strip() == "[1, 1] [1, 1] False"


def hold(session, index, start_s=0.0, **faults):
    """Hold the board still for half a second; return what every frame was."""
    times_s = start_s + np.arange(0.0, 0.55, 0.1)
    return [session.see(live_frame(index, time_s, **faults)) for time_s in times_s]


def take(session, *indices):
    for index in indices:
        session.add(session.keep(session.picture(live_frame(index))))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A folder with all pictures, to be copied from."""
    kept = KeptCalibrations(tmp_path_factory.mktemp("whole"))
    session = opened(kept)
    take(session, *range(N_POSES))
    return kept


def test_a_picture_is_taken_when_the_board_is_still_and_the_view_new(kept):
    session = opened(kept)
    seen = hold(session, 0)
    assert [moment.is_ready for moment in seen] == [False] * 4 + [True] * 2
    assert [moment.hindrance for moment in seen[:4]] == [MOVING] * 4
    shares = [moment.still_share for moment in seen]
    assert shares == pytest.approx([0.0, 0.25, 0.5, 0.75, 1.0, 1.0])
    take(session, 0)
    assert {moment.hindrance for moment in hold(session, 0, 1.0)} == {KNOWN}
    assert hold(session, 2, 2.0)[-1].is_ready


def test_a_board_on_the_move_is_never_taken(kept):
    session = opened(kept)
    moments = [session.see(live_frame(index, 0.1 * index)) for index in range(6)]
    assert [moment.is_ready for moment in moments] == [False] * 6
    assert {moment.still_share for moment in moments} == {0.0}


@pytest.mark.parametrize(
    ("faults", "hindrance"),
    [({"motion_px": (8.0, 0.0)}, BLURRED), ({"is_mirrored": True}, SENTENCES[Reason.MIRRORED])],
)
def test_what_spoils_a_picture_is_told_in_its_own_words(kept, faults, hindrance):
    last = hold(opened(kept), 0, **faults)[-1]
    assert last.hindrance == hindrance
    assert last.text == str(hindrance)


def test_a_mirrored_picture_is_not_taken_by_hand_either(kept):
    session = opened(kept)
    assert session.picture(live_frame(0, is_mirrored=True)) is None
    assert session.picture(live_frame(0, motion_px=(8.0, 0.0))) is not None


def test_another_board_than_said_is_told_with_its_size(kept):
    session = opened(kept, board=Board(7, 5, 0.03))
    moment = session.see(live_frame(0, board=Board(7, 5, 0.03)))
    assert moment.hindrance == TEXTS[BoardProblem.ANOTHER_SIZE]
    assert "9 x 6" in moment.text


def test_a_frame_in_which_the_board_before_was_looked_for_is_passed_over(kept):
    session = opened(kept, board=Board(7, 5, 0.03))
    assert not any(moment.is_ready for moment in hold(session, 0))
    assert session.picture(live_frame(0)) is None


def test_the_depth_of_the_still_board_comes_along(kept):
    session = opened(kept)
    hold(session, 0)
    session.add(session.keep(session.picture(live_frame(0, 0.5))))
    take(opened(kept), 2)  # a single frame says nothing of standing still
    with_depth, without = opened(kept).pictures
    disparity, corners = read_disparity(with_depth), with_depth.still_corners
    np.testing.assert_allclose(corners.pixels, with_depth.corners.pixels)  # of the same picture
    assert corners.sigma_px == pytest.approx(with_depth.corners.sigma_px / np.sqrt(5))
    assert disparity.n_frames == 5
    assert disparity.mean_per_m == pytest.approx(1000.0 / depth_raw(0))
    assert (read_disparity(without), without.still_corners) == (None, None)


def test_depth_that_was_damaged_since_is_an_error_in_words(kept):
    session = opened(kept)
    hold(session, 0)
    picture_kept = session.keep(session.picture(live_frame(0, 0.5)))
    picture_kept.depth_file.write_bytes(b"PK\x03\x04 cut")
    with pytest.raises(FileError, match="depth of picture 1"):
        read_disparity(picture_kept)


def test_a_session_goes_on_where_it_was_left(kept):
    session = opened(kept)
    session.choose_board(Board(9, 6, 0.0301))
    take(session, 0, 3, 7)
    again = opened(kept)
    assert again.board == Board(9, 6, 0.0301)
    assert again.n_lost == 0
    for before, after in zip(session.pictures, again.pictures, strict=True):
        np.testing.assert_array_equal(after.corners.pixels, before.corners.pixels)
        np.testing.assert_array_equal(after.corners.sigma_px, before.corners.sigma_px)
        np.testing.assert_array_equal(after.preview_rgb, before.preview_rgb)
        assert (after.number, after.taken_ns) == (before.number, before.taken_ns)
        assert after.searched.blur_px == before.searched.blur_px
        assert after.searched.name == str(before.number)
    assert again.guidance.next_step == session.guidance.next_step
    pixels = cv2.imread(str(again.pictures[1].color_file))[..., ::-1]
    np.testing.assert_array_equal(pixels, picture(3))


def cut(path):
    path.write_bytes(path.read_bytes()[:-100])


def spoil_document(path):
    document = json.loads(path.read_text())
    path.write_text(json.dumps(document | {"pixels": document["pixels"][:-1]}))


@pytest.mark.parametrize(
    ("name", "damage"),
    [
        ("0002.png", cut),
        ("0002.png", Path.unlink),
        ("0002.json", cut),
        ("0002.json", lambda path: path.write_text("[]")),
        ("0002.json", spoil_document),
    ],
)
def test_a_damaged_picture_costs_itself_alone(kept, name, damage):
    session = opened(kept)
    take(session, 0, 1, 2)
    damage(kept.pictures_folder("SN1", (640, 480)) / name)
    again = opened(kept)
    assert [one.number for one in again.pictures] == [1, 3]
    assert again.n_lost == 1
    take(again, 4)
    assert [one.number for one in opened(kept).pictures] == [1, 3, 4]
    again.start_anew()
    assert opened(kept).n_lost == 0


def test_a_board_file_that_is_damaged_is_told_by_the_pictures(kept):
    session = opened(kept)
    take(session, 0)
    session.choose_board(BOARD)
    (kept.pictures_folder("SN1", (640, 480)) / "board.json").write_text("{")
    again = opened(kept, board=Board(7, 5, 0.03))
    assert again.board == BOARD
    assert len(again.pictures) == 1


KILLED = """
import os, signal, sys
from pathlib import Path
from adibas.calibration.kept import KeptCalibrations
from adibas.pipeline import calibration_pictures
from tests.unit.test_calibration_session import opened, take

session = opened(KeptCalibrations(Path(sys.argv[1])))
take(session, 0, 1)
write, left = calibration_pictures.written_whole, int(sys.argv[2])

def dying(path):
    global left
    left -= 1
    if left < 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return write(path)

calibration_pictures.written_whole = dying
take(session, 2)
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.skipif(os.name == "nt", reason="there is no kill -9")
@pytest.mark.parametrize(("n_files", "n_pictures"), [(0, 2), (1, 2), (2, 3)])
def test_a_killed_program_loses_no_picture_that_was_told_of(tmp_path, n_files, n_pictures):
    kept = KeptCalibrations(tmp_path)
    code = [sys.executable, "-c", KILLED, str(tmp_path), str(n_files)]
    ended = subprocess.run(code, cwd=ROOT, check=False, capture_output=True, text=True)
    assert ended.returncode == -signal.SIGKILL, ended.stderr
    again = opened(kept)
    assert (len(again.pictures), again.n_lost) == (n_pictures, 0)
    take(again, 5)
    assert len(opened(kept).pictures) == n_pictures + 1


def test_another_sensor_and_another_size_have_pictures_of_their_own(kept):
    take(opened(kept), 0)
    assert opened(kept, CalibratedSensor("SN2", (640, 480), INFO)).pictures == ()
    assert opened(kept, CalibratedSensor("SN1", (1280, 1024), INFO)).pictures == ()
    assert opened(kept).is_of(SENSOR)
    assert not opened(kept).is_of(CalibratedSensor("SN2", (640, 480), INFO))


def test_the_sensor_of_a_frame_is_known_by_number_and_size():
    found = sensor_of(live_frame(0), INFO)
    assert (found.key, found.color_size) == ("SN1", (640, 480))
    assert found.intrinsics == INFO.calibration.color.intrinsics
    assert CalibratedSensor("SN1", (320, 240), INFO).intrinsics is None
    assert sensor_of(LiveFrame(1, 1, None, None), INFO) is None


def test_a_sensor_whose_picture_is_turned_is_looked_at_anew(kept):
    turned = sensor_of(replace(live_frame(0), rotation_deg=90), INFO)
    assert turned.rotation_deg == 90
    assert not opened(kept).is_of(turned)
    assert opened(kept, turned).is_of(turned)


def test_a_picture_that_is_removed_stays_away(kept):
    session = opened(kept)
    take(session, 0, 1, 2)
    session.remove(2)
    assert [one.number for one in session.pictures] == [1, 3]
    assert [one.number for one in opened(kept).pictures] == [1, 3]
    assert hold(session, 1)[-1].is_ready


def test_another_square_keeps_the_pictures_and_another_board_does_not(kept):
    session = opened(kept)
    take(session, 0, 1)
    assert session.fits(Board(9, 6, 0.025))
    session.choose_board(Board(9, 6, 0.025))
    assert len(session.pictures) == 2
    assert not session.fits(Board(8, 6, 0.025))
    session.choose_board(Board(8, 6, 0.025))
    assert session.pictures == ()
    assert opened(kept).board == Board(8, 6, 0.025)


def test_a_careful_user_gets_a_calibration_that_is_right(whole):
    session = opened(whole)
    assert not session.n_lost
    outcome = session.outcome(clock)
    color = outcome.calibration.color
    assert outcome.camera.verdict.grade is not Grade.REPEAT
    assert outcome.is_good_enough
    truth = CAMERA.intrinsics
    found = [color.intrinsics.fx, color.intrinsics.fy, color.intrinsics.cx, color.intrinsics.cy]
    assert found == pytest.approx([truth.fx, truth.fy, truth.cx, truth.cy], abs=0.5)
    assert (outcome.previous, outcome.comparison) == (None, None)


def test_what_is_known_of_the_depth_camera_stays_known(whole):
    calibration = opened(whole).outcome(clock).calibration
    assert calibration.depth == INFO.calibration.depth
    assert calibration.sensor_serial == "SN1"
    assert datetime.fromisoformat(calibration.created_utc) == NOW


def test_an_accepted_calibration_is_the_newest_of_its_sensor_and_ends_the_session(tmp_path):
    kept = KeptCalibrations(tmp_path)
    for day in range(2):
        session = opened(kept)
        take(session, *range(N_POSES))
        outcome = session.outcome(clock)
        session.accept(outcome, lambda day=day: NOW + timedelta(days=day))
        assert opened(kept).pictures == ()
    assert outcome.previous.made_utc == NOW
    assert outcome.comparison.largest_change_m == pytest.approx(0.0, abs=1e-9)
    newest = kept.newest("SN1", ((640, 480), (320, 240)))
    assert newest.made_utc == NOW + timedelta(days=1)
    assert newest.calibration.color == outcome.calibration.color


def test_a_bad_calibration_is_refused_and_the_reason_told(kept):
    session = opened(kept)
    take(session, 0, 1, 2)
    outcome = session.outcome(clock)
    assert not outcome.is_good_enough
    with pytest.raises(CalibrationError, match="Too few images show the board: 3"):
        session.accept(outcome, clock)
    assert kept.of_sensor("SN1") == ()
    assert len(opened(kept).pictures) == 3


def test_without_a_picture_there_is_nothing_to_fit(kept):
    with pytest.raises(CalibrationError, match="no images"):
        opened(kept).outcome(clock)


def test_saved_pictures_are_taken_or_refused_each_with_its_reason(kept, tmp_path):
    for name, color_rgb in (
        ("a.png", picture(0)),
        ("b.png", picture(1)[:240, :320]),
        ("c.png", np.full((480, 640, 3), 90, np.uint8)),
        ("d.png", picture(2, is_mirrored=True)),
    ):
        cv2.imwrite(str(tmp_path / name), np.ascontiguousarray(color_rgb[..., ::-1]))
    (tmp_path / "e.png").write_bytes(b"no picture")
    (tmp_path / "notes.txt").write_text("no picture either")
    nobodys = CalibratedSensor("", (640, 480), SourceInfo())
    session = opened(kept, nobodys)
    told = []
    paths = images_in([tmp_path])
    taken, refused = session.read_images(paths, lambda *done: told.append(done))
    session.add(*taken)
    assert [one.searched.name for one in session.pictures] == ["a.png"]
    reasons = {one.name: one.reason.message for one in refused}
    assert list(reasons) == ["b.png", "c.png", "d.png", "e.png"]
    assert "pixels, not" in reasons["b.png"]
    assert reasons["c.png"] == TEXTS[BoardProblem.NO_BOARD]
    assert reasons["d.png"] == SENTENCES[Reason.MIRRORED]
    assert "no whole PNG" in reasons["e.png"]
    assert told == [(done, 5) for done in range(5)]


def test_files_without_any_picture_are_an_error_in_words(tmp_path):
    (tmp_path / "notes.txt").write_text("none")
    with pytest.raises(CalibrationError, match="no picture"):
        images_in([tmp_path, tmp_path / "notes.txt"])


def test_pictures_of_nobodys_sensor_cannot_be_kept_for_it(whole, tmp_path):
    session = opened(KeptCalibrations(tmp_path), CalibratedSensor("", (640, 480), SourceInfo()))
    outcome = opened(whole).outcome(clock)
    with pytest.raises(CalibrationError, match="Nobody knows"):
        session.accept(outcome, clock)


def test_a_full_disk_is_told_and_leaves_what_was_there(kept, monkeypatch):
    session = opened(kept)
    take(session, 0)
    folder = PictureFolder(kept.pictures_folder("SN1", (640, 480)))

    def full(*_args, **_named):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(FileError, match="disk is full"):
        session.keep(session.picture(live_frame(1)))
    assert len(folder.read().pictures) == 1
