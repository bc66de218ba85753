"""The pages of the back and of the body: measured when looked at, over a real store."""

from types import SimpleNamespace

import numpy as np
import pytest
from openpyxl import load_workbook
from pypdf import PdfReader
from pyqtgraph import PlotWidget
from PySide6.QtCore import QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QApplication,
    QComboBox,
    QFileDialog,
    QLabel,
    QPushButton,
    QTableView,
    QTabWidget,
)

from adibas.data.patients import Identity
from adibas.pipeline import stored_body
from adibas.pipeline.stored_body import stored_back
from adibas.reports.body_numbers import GREY, on_paper
from adibas.sessions.audit_words import kind_text
from adibas.surface.asymmetry import asymmetry_m
from adibas.surface.merging import BodySurface
from adibas.texts import decimal_text
from tests.ui.disc_samples import discs_at
from tests.unit.standing_bodies import add_body_session, unheard
from tests.unit.store_samples import add_patient
from tests.unit.turning_bodies import add_turn, turn_images
from ui.comparison.back_content import seen_back
from ui.comparison.back_plots import AsymmetryMap, SpinePlot
from ui.comparison.body_content import seen_body
from ui.comparison.screen import build_comparison_screen
from ui.widgets.scrolled import Scrolled
from ui.widgets.space import Space
from ui.widgets.space_view import SpaceView

BACK, BODY = 4, 5
YELLOWISH = 80
"""By how much more red than blue are landmarks and the edges of their names."""


@pytest.fixture
def patient(store, workspace):
    patient = add_patient(store, Identity("Rosa Ibarra"))
    workspace.choose_patient(patient)
    return patient.pseudonym


@pytest.fixture
def screen(workspace, theme, qtbot):
    """The screen of what the store holds, as soon as `entered` is called."""
    screen = build_comparison_screen(workspace, theme)
    qtbot.addWidget(screen)
    screen.resize(1140, 740)
    screen.show()
    yield screen
    screen.left()
    screen.closed()


def page(screen, index):
    tabs = screen.findChild(QTabWidget)
    tabs.setCurrentIndex(index)
    QApplication.processEvents()
    return tabs.widget(index)


def lines(part):
    model = part.findChild(QTableView).model()
    columns = range(model.columnCount())
    return [[model.index(row, one).data() for one in columns] for row in range(model.rowCount())]


def test_backs_are_measured_once_and_only_when_somebody_looks(screen, store, patient, monkeypatch):
    measured = []

    def counted(store, session, progress):
        measured.append(session.session_id)
        return stored_back(store, session, progress)

    monkeypatch.setattr(stored_body, "stored_back", counted)
    sessions = [add_body_session(store, patient).session_id for _visit in range(2)]
    screen.entered()
    assert measured == []
    page(screen, BACK)
    assert measured == sessions
    page(screen, BODY)
    page(screen, BACK)
    assert measured == sessions


def test_the_table_says_what_the_report_says(screen, store, patient):
    session = add_body_session(store, patient)
    add_body_session(store, patient)
    screen.entered()
    shown = {line[0]: line[1:] for line in lines(page(screen, BACK))}
    for measure in stored_back(store, session, unheard).measures:
        value, interval, unit = on_paper(measure)
        before, now, between, difference = shown[f"{measure.definition.name} [{unit}]"]
        if value is None:
            assert (before, now, difference) == ("\N{EN DASH}",) * 3
            continue
        assert before == now == decimal_text(value, 1)
        assert difference == "0.0"
        assert between == (
            "\N{EN DASH}"
            if interval is None
            else f"{decimal_text(interval[0], 1)} to {decimal_text(interval[1], 1)}"
        )


def test_a_session_without_a_back_says_why_beside_the_other(screen, store, patient):
    add_body_session(store, patient, without_depth=("posterior",), views=())
    add_body_session(store, patient)
    screen.entered()
    back = page(screen, BACK)
    before, now = back.findChildren(AsymmetryMap)
    assert not before.isVisible()
    assert now.isVisible()
    told = [one.text() for one in back.findChildren(type(back.titles[0])) if one.isVisible()]
    assert any(text.startswith("Before: No depth was kept") for text in told)


def test_the_map_is_red_where_the_back_lies_further_back_than_the_other_side(
    screen, store, patient
):
    measured = stored_back(store, add_body_session(store, patient), unheard)
    screen.entered()
    (seen,) = [one for one in page(screen, BACK).findChildren(AsymmetryMap) if one.isVisible()]
    plot, picture = seen.findChild(PlotWidget), seen.grab().toImage()
    value_mm = 1e3 * asymmetry_m(measured.grid, measured.line)
    is_right = []
    for row, column in np.argwhere(np.abs(value_mm) > 4.0)[::5]:
        place = QPointF(1e3 * measured.grid.x_m[column], measured.grid.y_m[row])
        at = plot.mapTo(
            seen, plot.mapFromScene(plot.getPlotItem().getViewBox().mapViewToScene(place))
        )
        color = picture.pixelColor(at)
        is_right.append((color.red() > color.blue()) == (value_mm[row, column] > 0))
    assert len(is_right) > 50
    assert np.mean(is_right) > 0.9  # cells of 4 mm and pixels do not meet everywhere


def test_the_profile_hangs_at_its_lowest_turn_and_the_choice_draws_another_curve(
    screen, store, patient
):
    back = stored_back(store, add_body_session(store, patient), unheard)
    screen.entered()
    part = page(screen, BACK)
    names = {name: (value_mm, height_m) for name, value_mm, height_m in seen_back(back).turns}
    assert names["ILS"] == (pytest.approx(0.0), back.shape.ils_m)
    apart_mm = 1e3 * np.ptp(back.profile.back_m(np.array([back.shape.ka_m, back.shape.ils_m])))
    assert abs(names["KA"][0]) == pytest.approx(apart_mm)
    plot, choice = part.findChild(SpinePlot), part.findChild(QComboBox)
    pictures = []
    for index in range(choice.count()):
        choice.setCurrentIndex(index)
        pictures.append(plot.grab().toImage())
        assert plot.accessibleDescription()
    assert all(pictures[one] != pictures[other] for one, other in ((0, 1), (0, 2), (1, 2)))


def test_the_joined_body_is_turned_and_its_girths_stand_below(qtbot, screen, store, patient):
    views = ("posterior", "anterior", "right_lateral", "left_lateral")
    add_body_session(store, patient, views)
    screen.entered()
    body = page(screen, BODY)
    (space,) = [one for one in body.findChildren(SpaceView) if one.isVisible()]
    assert any(line[0].startswith("Least girth of the trunk") for line in lines(body))
    told = [one.text() for one in body.findChildren(QLabel) if one.isVisible()]
    assert any(text.startswith("Views: Back, Front, Right side, Left side.") for text in told)
    before = space.grab().toImage()
    qtbot.keyClick(space, Qt.Key.Key_Right)
    assert space.grab().toImage() != before


def test_where_a_body_has_no_colour_its_discs_are_grey_and_face_as_it_does():
    normals = np.array([[0.0, 0.0, 1.0], [0.9, 0.1, -0.42], [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    colors = np.array([[np.nan] * 3, [np.nan] * 3, [np.nan] * 3, [10.0, 200.0, 30.0]])
    surface = BodySurface(np.zeros((4, 3)), normals, np.ones(4), np.ones(4), colors)
    whole = SimpleNamespace(surface=surface, joined=None)
    body = SimpleNamespace(whole=whole, landmarks=(), n_frames={}, stature_m=None, girths=())
    discs = seen_body(body).space.discs
    assert discs.colors_rgb.tolist() == [[GREY] * 3] * 3 + [[10, 200, 30]]
    # The patient's back (last axis) looks at who stands behind, whose axes go right, down, away.
    assert discs.normals[:, 2].tolist() == pytest.approx([-1.0, 0.42, 1.0, -1.0])
    assert discs.normals[1, :2].tolist() == pytest.approx([0.9, -0.1])


def test_a_turn_is_shown_as_the_body_that_it_gives(screen, store, patient):
    add_turn(store, add_body_session(store, patient, ()), turn_images())
    screen.entered()
    body = page(screen, BODY)
    told = [one.text() for one in body.findChildren(QLabel) if one.isVisible()]
    assert (
        "Now: The standing views do not show the body all around: it is measured in the slow turn."
    ) in told
    assert any("Back, Front, Right side, Left side" in text for text in told)
    assert len(lines(body)) > 4


def test_other_sessions_are_measured_when_they_are_chosen(screen, store, patient):
    add_body_session(store, patient, ("posterior",))
    screen.entered()
    body = page(screen, BODY)
    assert sum(one.isVisible() for one in body.findChildren(SpaceView)) == 1
    add_body_session(store, patient, ("posterior",))
    screen.entered()
    assert sum(one.isVisible() for one in body.findChildren(SpaceView)) == 2


@pytest.fixture
def yellow_pixels(qtbot):
    """Return what shows landmarks on a wall, and gives the pixels of their dots and names."""
    wall_m = np.stack([*np.meshgrid(np.linspace(-1, 1, 80), np.linspace(-1, 1, 80))], axis=-1)
    points_m = np.concatenate([wall_m.reshape(-1, 2), np.full((6400, 1), 2.0)], axis=1)
    wall = discs_at(points_m, np.full((6400, 3), 90), radius_m=0.02)
    view = SpaceView()
    qtbot.addWidget(view)
    view.resize(400, 400)

    def is_yellow(color):
        return color.red() - color.blue() > YELLOWISH

    def found(**landmarks_m):
        places = {name: np.array(place) for name, place in landmarks_m.items()}
        view.show_space(Space(wall, places))
        image = view.grab().toImage()
        every = ((x, y) for x in range(400) for y in range(400))
        return {(x, y) for x, y in every if is_yellow(image.pixelColor(x, y))}

    return found


def test_a_landmark_on_the_far_side_is_not_shown(yellow_pixels):
    assert len(yellow_pixels(c7=(0.2, 0.1, 2.0))) > 20
    assert len(yellow_pixels(c7=(0.2, 0.1, 2.3))) == 0


def test_names_of_landmarks_are_whole_beside_the_edges_and_beside_one_another(yellow_pixels):
    left, right = (-0.6, 0.0, 2.0), (0.6, 0.1, 2.0)
    at_edges = yellow_pixels(left_inferior_scapula=left, right_inferior_scapula=right)
    columns = [x for x, _y in at_edges]
    assert min(columns) > 1
    assert max(columns) < 398
    near, next_to_it = (0.2, 0.1, 2.0), (0.28, 0.1, 2.0)
    alone = len(yellow_pixels(c7=near)) + len(yellow_pixels(l4=next_to_it))
    assert len(yellow_pixels(c7=near, l4=next_to_it)) >= alone


@pytest.mark.parametrize("ending", ["pdf", "xlsx"])
def test_the_report_on_the_later_back_is_written_and_the_log_tells_it(
    screen, store, patient, tmp_path, ending
):
    session = add_body_session(store, patient)
    screen.entered()
    button = next(one for one in page(screen, BACK).findChildren(QPushButton) if one.isVisible())
    button.click()
    dialog = screen.findChild(QFileDialog)
    dialog.selectFile(str(tmp_path / "mine"))
    dialog.filterSelected.emit(next(kind for kind in dialog.nameFilters() if ending in kind))
    dialog.accept()
    path = tmp_path / f"mine.{ending}"
    if ending == "pdf":
        told = " ".join(one.extract_text() for one in PdfReader(path).pages)
    else:
        sheets = load_workbook(path).worksheets
        rows = [row for sheet in sheets for row in sheet.iter_rows(values_only=True)]
        told = " ".join(str(value) for row in rows for value in row)
    assert "Kyphosis" in told
    assert patient in told
    exports = [one for one in store.audit.entries() if one.action == "export"]
    assert [one.subject for one in exports] == [session.session_id]


def test_a_body_without_a_back_has_a_report_of_its_own(screen, store, patient, tmp_path):
    session = add_body_session(store, patient, ("anterior", "right_lateral", "left_lateral"))
    screen.entered()
    body = page(screen, BODY)
    told = [one.text() for one in body.findChildren(QLabel) if one.isVisible()]
    (stature_mm,) = [
        int(text.partition("Stature: ")[2].split()[0]) for text in told if "Stature: " in text
    ]
    assert 1000 < stature_mm < 2200
    button = next(one for one in body.findChildren(QPushButton) if one.isVisible())
    button.click()
    dialog = screen.findChild(QFileDialog)
    assert dialog.windowTitle() == "Report on the body"
    dialog.selectFile(str(tmp_path / "mine"))
    dialog.accept()
    read = " ".join(one.extract_text() for one in PdfReader(tmp_path / "mine.pdf").pages)
    words = " ".join(read.split())
    assert "Report on the body" in words
    assert "Least girth of the trunk" in words
    assert str(stature_mm) in words
    (left,) = [one for one in store.audit.entries() if one.action == "export"]
    assert left.subject == session.session_id
    assert kind_text(left.detail["kind"]) == "the measures of the body"


def test_where_there_is_no_back_there_is_no_report(screen, store, patient):
    add_body_session(store, patient, (), without_depth=("posterior",))
    screen.entered()
    buttons = page(screen, BACK).findChildren(QPushButton)
    assert not any(one.isEnabled() for one in buttons if one.isVisible())


def test_in_a_narrow_window_the_mouse_reaches_every_part_of_the_back(screen, store, patient):
    add_body_session(store, patient)
    screen.resize(560, 740)
    screen.entered()
    back = page(screen, BACK)
    (report,) = back.findChildren(QPushButton)
    above = next(one for one in back.findChildren(Scrolled) if one.isAncestorOf(report))
    across = above.horizontalScrollBar()
    assert across.isVisible()
    above.verticalScrollBar().setValue(above.verticalScrollBar().maximum())
    across.setValue(across.maximum())
    QApplication.processEvents()
    assert report.visibleRegion().boundingRect() == report.rect()


def test_many_notes_leave_the_bodies_their_room_and_are_scrolled(screen, store, patient):
    add_body_session(store, patient)
    screen.entered()
    body = page(screen, BODY)
    rooms = [one.height() for one in body.findChildren(Scrolled)]
    notes = tuple(f"Before: The landmark {number} is strange. Look at it." for number in range(30))
    body.show_sentences(notes)
    QApplication.processEvents()
    told = next(one for one in body.findChildren(QLabel) if notes[-1] in one.text())
    area = next(one for one in body.findChildren(Scrolled) if one.isAncestorOf(told))
    assert area.height() < screen.height() / 4
    assert told.height() >= told.heightForWidth(told.width()), "nothing of it is cut"
    area.setFocus()
    QTest.keyClick(area, Qt.Key.Key_PageDown)
    assert area.verticalScrollBar().value() > 0
    body.show_sentences(notes[:1])
    QApplication.processEvents()
    assert told.visibleRegion().boundingRect() == told.rect()
    assert area.focusPolicy() == Qt.FocusPolicy.NoFocus, "Tab stops where there is more to read"
    body.show_sentences(())
    QApplication.processEvents()
    assert [one.height() for one in body.findChildren(Scrolled) if one.isVisible()] == rooms[-2:]
