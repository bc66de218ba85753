"""What the program measured is shown as tables and plots, by section and in time bins."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QApplication, QFileDialog

from adibas.behaviour.editing import with_section
from adibas.data.coding import Section
from adibas.data.joints import JOINT_NAMES
from adibas.data.skeleton_track import track_of
from adibas.pipeline.behaviour import BehaviourRequest, analyse_behaviour, divided
from adibas.pipeline.found_joints import FoundJoints
from tests.unit.coding_samples import coding
from tests.unit.test_activity import HAND, circling, still
from ui.behaviour.agreement_page import AgreementPage
from ui.behaviour.counts_page import CountsPage
from ui.behaviour.counts_presenter import EVERYBODY, TABLES
from ui.behaviour.measured import (
    MEASURED,
    HeatMap,
    heat_map,
    measured_table,
    of_person,
    people_of,
    raster,
)
from ui.behaviour.tables import counted_table
from ui.behaviour.time_plot import TimePlot

OBSERVED = coding(("fidgets", 10, 20, "child"), ("nods", 30, 30), end_ms=60_000)


@pytest.fixture(scope="module")
def analysis(tmp_path_factory):
    """A minute in which somebody circles a hand for 20 s, then shifts; another comes late."""
    times_s, first_m = still(900, 15.0, 0.005, begin_s=0.0)
    first_m[:300] = circling(first_m[:300], HAND, 0.1, 1.0, 15.0)
    first_m[600:, :, 0] += 0.3
    _times, second_m = still(900, 15.0, 0.005, seed=1)
    second_m[:300] = np.nan
    joints = FoundJoints((track_of(times_s, first_m), track_of(times_s, second_m, 2)))
    source = tmp_path_factory.mktemp("joints") / "play.joints.csv"
    source.write_text("")
    request = BehaviourRequest(source, joints=joints)
    return analyse_behaviour(request, lambda _done, _total: None)


def test_activity_is_told_under_each_section(analysis):
    parts = (Section("game", 0, 20_000), Section("task", 20_000, 90_000))
    parted = divided(analysis, parts, 20_000)
    table = measured_table("joints", parted)
    hand = [line for line in table.lines if line[1:3] == ("Person 1", "Left hand")]
    assert [line[0] for line in hand] == ["whole session", "game", "task"]
    moved_s = [float(line[5]) for line in hand]
    assert moved_s[0] == pytest.approx(moved_s[1] + moved_s[2], abs=0.2)
    assert moved_s[1] > 15 > moved_s[2]
    assert measured_table("detected", parted).lines
    assert {line[0] for line in measured_table("detected", parted).lines} >= {"game", "task"}


def test_paths_in_bins_add_up_to_the_whole(analysis):
    parted = divided(analysis, (), 15_000)
    paths = [line for line in measured_table("paths", parted).lines if line[2] == "Person 1"]
    assert len(paths) == 4
    whole = next(
        line for line in measured_table("joints", parted).lines
        if line[1:3] == ("Person 1", "Left hand")
    )  # fmt: skip
    column = measured_table("paths", parted).titles.index("Left hand [m]")
    told_m = sum(float(line[column]) for line in paths)
    assert told_m == pytest.approx(float(whole[7]), abs=0.03)


def test_band_power_has_a_line_for_each_joint_and_for_its_noise(analysis):
    table = measured_table("bands", analysis)
    assert len(table.lines) == 2 * 2 * len(JOINT_NAMES)
    assert {len(line) for line in table.lines} == {len(table.titles)}


def test_the_heat_map_shows_who_moved_when_and_who_was_not_seen(analysis):
    found = heat_map(analysis, OBSERVED, 10_000)
    hand = found.rows.index("Person 1: Left hand")
    assert found.values.shape == (2 * len(JOINT_NAMES), 6)
    assert found.values[hand, :2].min() > 10 * found.values[hand, 2:].max()
    assert np.isnan(found.values[len(JOINT_NAMES) :, 0]).all()
    alone = replace(analysis, people=analysis.people[:1])
    assert heat_map(alone, OBSERVED, 10_000).rows[0] == "Head"


def test_the_raster_shows_what_was_coded_and_below_it_what_was_seen(analysis):
    found = raster(with_section_of(OBSERVED), analysis.detected)
    assert found.rows[:2] == ("nods (nobody in particular, AB)", "fidgets (child, AB)")
    assert any(name.startswith("posture change (Person 1") for name in found.rows)
    (bar,) = [one for one in found.bars if one[0] == 1]
    assert bar[1:3] == (10.0, 20.0)
    assert found.sections == (("game", 0.0, 30.0),)
    assert found.duration_s == 60.0
    assert raster(OBSERVED, None).rows == found.rows[:2]


def test_what_the_program_saw_stands_at_the_time_of_the_session(analysis):
    """Joints begin when somebody comes into view, which may be later than the session."""
    changes = [one for one in analysis.detected.occurrences if one.behaviour == "posture change"]
    late = replace(analysis.detected, begin_ms=20_000, occurrences=tuple(changes))
    n_coded = len(raster(OBSERVED, None).rows)
    found = [bar[1] for bar in raster(OBSERVED, late).bars if bar[0] >= n_coded]
    assert found == [one.begin_ms / 1000 for one in changes]
    assert found


def with_section_of(observed):
    from adibas.behaviour.editing import Draft

    return with_section(Draft(observed), Section("game", 0, 30_000)).coding


@pytest.fixture
def plot(qtbot, theme):
    made = TimePlot(theme)
    made.resize(500, 400)
    qtbot.addWidget(made)
    made.show()
    return made


def picture(plot):
    QApplication.processEvents()
    return plot.grab().toImage()


def test_plots_are_drawn_and_said_in_words(plot, analysis):
    plot.show_content(None)
    plot.show_content(raster(with_section_of(OBSERVED), analysis.detected))
    assert "fidgets (child, AB): 1" in plot.accessibleDescription()
    first = picture(plot)
    plot.show_content(heat_map(analysis, OBSERVED, 10_000))
    assert "Person 1: Left hand:" in plot.accessibleDescription()
    assert picture(plot) != first
    unseen = np.full((1, 2), np.nan)
    plot.show_content(HeatMap(("Head",), unseen, 30.0, (), 60.0))
    assert plot.accessibleDescription() == "Head: not seen"


def test_a_bin_is_drawn_where_it_is_also_if_the_last_one_is_cut_off(plot, analysis):
    plot.show_content(heat_map(analysis, OBSERVED, 40_000))
    (image,) = [one for one in plot._widget.getPlotItem().items if hasattr(one, "getColorMap")]
    box = image.mapRectToParent(image.boundingRect())
    assert (box.left(), box.width()) == (0.0, 80.0)
    across, _up = plot._widget.viewRange()
    assert across == [0.0, 60.0]


def test_arrow_keys_are_left_to_the_video(plot, analysis):
    plot.show_content(raster(OBSERVED, analysis.detected))
    event = QKeyEvent(QKeyEvent.Type.KeyPress, Qt.Key.Key_Right, Qt.KeyboardModifier.NoModifier)
    plot.keyPressEvent(event)
    assert not event.isAccepted()
    assert plot.chosen == -1


def test_the_page_shows_tables_plots_and_what_lacks(qtbot, theme, analysis):
    page = CountsPage(theme)
    qtbot.addWidget(page)
    page.retranslate()
    page.show()
    assert [
        page._kind.itemText(at) for at in range(len(TABLES)) if not page._kind.itemText(at)
    ] == []
    page.show_plot(raster(OBSERVED, analysis.detected))
    assert page._plot.isVisibleTo(page)
    page.show_counts(counted_table("totals", OBSERVED, 1000))
    assert page._table.isVisibleTo(page)
    page.show_unmeasured(is_unmeasured=True)
    assert "has not looked" in page._unmeasured.text()
    assert set(MEASURED) < set(TABLES)


@pytest.mark.parametrize(
    ("page_of", "proposed"),
    [
        (CountsPage, "noon+1-ab12-behaviour"),
        (lambda _theme: AgreementPage(), "noon+1-ab12-agreement"),
    ],
)
def test_files_are_proposed_under_the_recordings_name(qtbot, theme, page_of, proposed):
    page = page_of(theme)
    qtbot.addWidget(page)
    page.show_name("noon+1-ab12")
    page._ask_file()
    (dialog,) = page.findChildren(QFileDialog)
    assert [Path(name).stem for name in dialog.selectedFiles()] == [proposed]
    dialog.reject()


def test_one_of_several_people_is_chosen_for_the_activity(analysis):
    assert people_of(analysis) == ((1, "Person 1"), (2, "Person 2"))
    second = of_person(analysis, 2)
    assert {line[1] for line in measured_table("joints", second).lines} == {"Person 2"}
    assert {line[2] for line in measured_table("paths", second).lines} == {"Person 2"}
    assert len(measured_table("bands", second).lines) == 2 * len(JOINT_NAMES)
    found = heat_map(second, OBSERVED, 10_000)
    assert found.rows[0] == "Head"
    assert np.isnan(found.values[:, 0]).all()
    assert people_of(second) == people_of(None) == ()


def test_the_page_offers_people_and_tells_who_was_chosen(qtbot, theme, analysis):
    page = CountsPage(theme)
    qtbot.addWidget(page)
    chosen = []
    page.person_chosen.connect(chosen.append)
    page.show_people(people_of(analysis), 2)
    assert not page._person.isHidden()
    assert page._person.currentText() == "Person 2"
    page._person.activated.emit(page._person.findText("Person 1"))
    page._person.activated.emit(page._person.findText("Everybody"))
    assert chosen == [1, EVERYBODY]
    page.show_people((), EVERYBODY)
    assert page._person.isHidden()
