"""What the calibration screen says of pictures and results, without Qt."""

import re
from dataclasses import replace

import numpy as np
import pytest

from adibas.calibration.guidance import DEPTH, DISTANT, ENOUGH, guide
from adibas.data.calibration_verdict import Verdict
from adibas.texts import speaking
from tests.unit.board_pictures import N_POSES, taken
from ui.calibration.wording import progress_of, result_html
from ui.reminders import Reminder


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    return taken(tmp_path_factory.mktemp("taken"))


@pytest.fixture(scope="module")
def outcome(session):
    return session.outcome()


def rows_under(html, heading):
    """Return the cells of the table that follows a heading."""
    table = html.split(f"<h3>{heading}</h3>")[1].split("<table")[1].split("</table>")[0]
    lines = [
        re.findall(r"<t[hd][^>]*>(.*?)(?:&nbsp;)*</t[hd]>", row) for row in table.split("<tr>")
    ]
    return [line for line in lines if line]


def test_what_is_added_to_a_measured_depth_stands_with_its_interval(outcome):
    bias = outcome.calibration.depth_bias
    header, *rows = rows_under(result_html(outcome), "Depth camera")
    assert header == ["Depth [m]", "Added [mm]", "95 % interval"]
    assert [row[0] for row in rows][:3] == ["0.5", "1.0", "1.5"]
    for measured, added, half in rows:
        z_m = float(measured)
        expected_mm = 1000.0 * (bias.a + bias.b * z_m + bias.c * z_m**2 - z_m)
        told = float(added.replace("\N{MINUS SIGN}", "-"))
        assert told == pytest.approx(expected_mm, abs=0.051)
        assert half.startswith("± ")


def test_each_picture_tells_the_error_that_is_left_of_its_depth(outcome):
    header, *rows = rows_under(result_html(outcome), "Pictures")
    assert header[4] == "Depth error [mm]"
    shots = {shot.name: shot for shot in outcome.depth.fit.shots}
    assert len(rows) == N_POSES
    for row in rows:
        shot = shots[row[0]]
        # More of 1/z is nearer.
        told = float(row[4].replace("\N{MINUS SIGN}", "-"))
        expected_mm = 1000.0 * (1.0 / (1.0 / shot.distance_m + shot.error_per_m) - shot.distance_m)
        assert told == pytest.approx(expected_mm, abs=0.06)


def test_without_depth_there_is_no_word_of_it(outcome):
    camera = replace(outcome.camera, verdict=Verdict())
    html = result_html(replace(outcome, camera=camera, depth=None))
    assert "epth" not in html
    assert len(rows_under(html, "Pictures")[0]) == 5


def test_pictures_left_out_are_marked(outcome):
    worst = replace(outcome.depth.fit.shots[0], is_outlier=True)
    fit = replace(outcome.depth.fit, shots=(worst, *outcome.depth.fit.shots[1:]))
    html = result_html(replace(outcome, depth=replace(outcome.depth, fit=fit)))
    rows = {row[0]: row for row in rows_under(html, "Pictures")}
    assert rows[worst.name][-1] == "left out: it contradicts the others"


def test_the_ticks_count_pictures_with_depth(session):
    ticks = dict(progress_of(session.guidance))
    assert ticks[f"{N_POSES} of 8 with depth"]
    assert not ticks["As far as patients"]
    assert DISTANT in session.guidance.lacking


def stances(session, **changes):
    return [replace(stance, **changes) for stance in session._stances]


def test_a_board_as_far_as_patients_or_as_small_as_can_be_found_is_far_enough(session):
    corners = [one.corners for one in session.pictures]
    has_depth = [True] * N_POSES
    for changes in ({"distance_m": 2.5}, {"square_px": 11.0}):
        guidance = guide(corners, stances(session, **changes), has_depth=has_depth)
        assert guidance.has_distant
        assert DISTANT not in guidance.lacking
    without = guide(corners, stances(session, distance_m=2.5), has_depth=[False] * N_POSES)
    assert not without.has_distant
    assert without.lacking[-2:] == (DISTANT, DEPTH)


def test_a_sensor_without_depth_is_asked_for_none(session):
    corners = [one.corners for one in session.pictures]
    guidance = guide(corners, session._stances)
    assert guidance.n_depths is None
    assert not {DISTANT, DEPTH} & set(guidance.lacking)
    assert guidance.next_step in {*guidance.lacking, ENOUGH}
    assert len(progress_of(guidance)) == len(progress_of(session.guidance)) - 2


def test_the_distance_of_a_board_is_that_of_its_middle(session):
    board = session.board
    for stance, picture in zip(session._stances, session.pictures, strict=True):
        pixels = picture.corners.pixels.reshape(board.rows, board.columns, 2)
        sides_px = np.linalg.norm(np.diff(pixels, axis=1), axis=-1)
        assert stance.square_px == pytest.approx(sides_px.mean(), rel=0.35)  # tilted ones shrink
        assert stance.distance_m * stance.square_px == pytest.approx(0.03 * 530.0, rel=1e-6)


def test_a_reminder_follows_the_language():
    reminder = Reminder(3, is_urgent=False)
    assert reminder.text == "This sensor was calibrated 3 days ago."
    with speaking("es"):
        assert "3 días" in reminder.text
