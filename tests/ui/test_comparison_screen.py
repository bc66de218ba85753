"""The comparison screen under mouse and keyboard: pictures, tables, plots, over a real store."""

import numpy as np
import pytest
from PySide6.QtCore import QLocale, Qt
from PySide6.QtGui import QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QApplication,
    QCheckBox,
    QComboBox,
    QFileDialog,
    QLineEdit,
    QPushButton,
    QSlider,
    QTableView,
    QTabWidget,
)

from adibas.sessions import open_store
from adibas.texts import use_language
from tests.ui.comparison_scene import StepClock, add_patient, add_session, fill_clinic
from tests.ui.conftest import CHEAP, PASSPHRASE, InlineJobs, NoSensor
from ui.comparison.agreement_plot import AgreementPlot
from ui.comparison.screen import build_comparison_screen
from ui.comparison.trend_plot import TrendPlot, spaced
from ui.preferences import PreferencesFile
from ui.theme import Theme
from ui.widgets.image_view import ImageView
from ui.widgets.overlays import Dot, Line
from ui.widgets.plot import spread, tick_texts
from ui.workspace import Workspace

LEFT = Qt.MouseButton.LeftButton
Key = Qt.Key


@pytest.fixture(scope="module")
def clinic(tmp_path_factory):
    """A store of ten patients measured twice, and one with four visits; made once."""
    clock = StepClock()
    folder = tmp_path_factory.mktemp("clinic")
    store = open_store(
        folder / "store", PASSPHRASE, operator="tester", key_params=CHEAP, clock=clock
    )
    fill_clinic(store, clock)
    patient = add_patient(store)
    for height_m in (0.0, 0.004, 0.01, 0.03):
        clock.days_pass(30)
        add_session(store, patient.pseudonym, height_m, views=("anterior", "posterior"))
    preferences = PreferencesFile(folder / "preferences.json")
    preferences.change(language="en")
    yield Workspace(store, InlineJobs(), preferences, NoSensor()), patient
    store.close()


class User:
    """Somebody at the screen."""

    def __init__(self, screen):
        self.screen = screen
        self.tabs = screen.findChild(QTabWidget)
        self.pictures, self.differences, self.trends, self.repeats = (
            self.tabs.widget(index) for index in range(4)
        )

    def open(self, page):
        self.tabs.setCurrentWidget(page)
        QApplication.processEvents()
        return page

    def button(self, text):
        return next(
            one
            for one in self.screen.findChildren(QPushButton)
            if one.text().replace("&", "") == text and one.isVisible()
        )

    def click(self, text):
        QTest.mouseClick(self.button(text), LEFT)

    def table(self, name):
        tables = self.screen.findChildren(QTableView)
        return next(one for one in tables if one.accessibleName() == name)

    def lines(self, name):
        model = self.table(name).model()
        return [
            [model.index(row, column).data() for column in range(model.columnCount())]
            for row in range(model.rowCount())
        ]


@pytest.fixture(scope="module")
def shown(clinic, qapp):
    """The screen, made once: it measures two dozen sessions."""
    workspace, patient = clinic
    use_language("en")
    QLocale.setDefault(QLocale("en"))
    theme = Theme(qapp)
    theme.use("light", 1.0)
    workspace.choose_patient(workspace.store.patients.get(patient.pseudonym))
    screen = build_comparison_screen(workspace, theme)
    screen.resize(1140, 740)
    screen.show()
    screen.entered()
    yield User(screen)
    screen.left()
    screen.closed()
    screen.close()
    screen.deleteLater()


@pytest.fixture
def user(shown):
    """The screen as it was at first."""
    yield shown
    for field in shown.screen.findChildren(QLineEdit):
        field.clear()


def dots(image, role):
    return {one.name: (one.u, one.v) for one in image._overlays if getattr(one, "role", "") == role}


def test_both_pictures_stand_side_by_side_with_their_markers(user):
    images = {one.accessibleName(): one for one in user.pictures.findChildren(ImageView)}
    user.open(user.pictures)
    before, now = images["Earlier picture with markers"], images["Later picture with markers"]
    earlier, later = dots(before, "earlier"), dots(now, "later")
    assert earlier.keys() == later.keys()
    assert later["left_acromion"][1] < earlier["left_acromion"][1] - 3
    user.click("Back")
    assert "c7" in dots(now, "later")


def test_the_slider_blends_the_pictures_and_markers_of_both_are_joined(user):
    user.open(user.pictures)
    user.click("Overlaid")
    both, slider = user.pictures._both, user.pictures.findChild(QSlider)
    assert "floor and the plumb line" in user.pictures._way.text()
    lines = [one for one in both._overlays if isinstance(one, Line)]
    shared = [one for one in both._overlays if isinstance(one, Dot) and one.role == "later"]
    assert len(lines) == len(shared)
    means = []
    slider.setFocus()
    for key in (Key.Key_Home, Key.Key_End):
        QTest.keyClick(slider, key)
        means.append(float(np.mean(both._picture._pixels)))
    assert abs(means[1] - means[0]) > 2
    user.click("Side by side")
    assert user.pictures._way.isHidden()


def test_the_table_of_differences_is_filtered_and_sorted(user):
    page = user.open(user.differences)
    lines = user.lines("Differences")
    assert ["Front", "Horizontal alignment of the acromia [deg]"] in [line[:2] for line in lines]
    words = page.findChild(QLineEdit)
    words.setFocus()
    QTest.keyClicks(words, "acromia front")
    found = user.lines("Differences")
    assert {line[1] for line in found} == {
        "Horizontal alignment of the acromia [deg]",
        "Angle between acromia and ASIS [deg]",
    }
    assert all(line[-1] == "beyond MDC95" for line in found)
    assert found[0][4] == "3.2"
    words.clear()
    verdict = page.findChild(QComboBox)
    verdict.setCurrentIndex(1)
    assert {line[-1] for line in user.lines("Differences")} == {"beyond MDC95"}
    verdict.setCurrentIndex(3)
    assert {line[0] for line in user.lines("Differences")} == {"Back"}
    verdict.setCurrentIndex(0)
    table = user.table("Differences")
    table.sortByColumn(4, Qt.SortOrder.DescendingOrder)
    numbers = [float(line[4]) for line in user.lines("Differences")]
    assert numbers == sorted(numbers, reverse=True)
    assert "if nothing had changed" in page._chance.text()
    assert page.findChild(QCheckBox).isHidden(), "the protocol has no pairs and triplets"


def test_pairs_and_triplets_are_shown_where_a_protocol_has_nothing_else(user):
    user.screen._presenter.choose_protocol("joints-15")
    assert "without measures" not in user.differences._empty.said
    assert user.differences.findChild(QCheckBox).isHidden()
    user.screen._presenter.choose_protocol("sapo-1")


def test_enter_on_a_difference_shows_its_trend(user):
    page = user.open(user.differences)
    page.findChild(QLineEdit).setText("acromia front horizontal")
    table = user.table("Differences")
    table.setFocus()
    table.selectRow(0)
    QTest.keyClick(table, Key.Key_Return)
    assert user.tabs.currentWidget() is user.trends
    assert user.trends._title.text() == "Horizontal alignment of the acromia [deg]"
    assert len(user.lines("Values of each session")) == 4


def test_the_trend_is_drawn_with_intervals_band_and_reference(user):
    user.open(user.trends)
    user.trends.choose(("anterior", "ANT.ACR.H"))
    plot = user.trends.findChild(TrendPlot)
    kinds = [type(item).__name__ for item in plot._widget.getPlotItem().items]
    assert kinds.count("ErrorBarItem") == 1
    assert kinds.count("LinearRegionItem") == 1
    assert "InfiniteLine" not in kinds, "no value of others unless it is wanted"
    user.trends._has_reference.setChecked(True)
    kinds = [type(item).__name__ for item in plot._widget.getPlotItem().items]
    assert "InfiniteLine" in kinds
    assert "SAPO 0.68" in user.trends._legend.text()
    user.trends._has_reference.setChecked(False)
    assert "smallest detectable change" in user.trends._legend.text()


def test_a_plot_that_was_drawn_asks_for_no_more_room_than_its_page_keeps_for_it(user):
    user.open(user.trends)
    plot = user.trends.findChild(TrendPlot)
    assert plot.is_drawn
    assert plot.sizeHint().height() == plot.minimumHeight()


def test_the_keyboard_goes_from_session_to_session_in_plot_and_table(user):
    user.open(user.trends)
    user.trends.choose(("anterior", "ANT.ACR.H"))
    plot, table = user.trends.findChild(TrendPlot), user.table("Values of each session")
    plot.setFocus()
    assert plot.chosen == 3
    QTest.keyClick(plot, Key.Key_Left)
    assert (plot.chosen, table.currentIndex().row()) == (2, 2)
    QTest.keyClick(plot, Key.Key_Home)
    QTest.keyClick(plot, Key.Key_Left)
    assert (plot.chosen, table.currentIndex().row()) == (0, 0)
    table.selectRow(1)
    assert plot.chosen == 1
    QTest.keyClick(plot, Key.Key_End)
    assert plot.chosen == 3
    assert "beyond MDC95" in plot.accessibleDescription()
    QTest.keyClick(plot, Key.Key_A)
    assert plot.chosen == 3


def test_repeats_are_listed_and_plotted_and_every_number_has_its_interval(user):
    user.open(user.repeats)
    user.repeats._rows.choose(("anterior", "ANT.ACR.H"))
    line = next(x for x in user.lines("Repeats of each measure") if "acromia [deg]" in x[1])
    assert line[2] == "10"
    told = user.repeats._numbers.text()
    assert told.startswith("SEM 0.")
    assert "ICC(2,1)" in told
    plot = user.repeats.findChild(AgreementPlot)
    assert plot.n_points == 10
    assert "limits of agreement" in plot.accessibleDescription()
    plot.setFocus()
    QTest.keyClick(plot, Key.Key_Right)
    assert plot.chosen == 0
    user.repeats._rows.words.setText("scapulae back")
    assert plot.isHidden()
    assert "measured twice" in user.repeats._reasons.text()


def test_a_plot_is_saved_as_a_picture(user, tmp_path):
    user.open(user.trends)
    user.click("Save the plot...")
    (dialog,) = [one for one in user.screen.findChildren(QFileDialog) if one.isVisible()]
    dialog.fileSelected.emit(str(tmp_path / "plot.png"))
    dialog.close()
    image = QImage(str(tmp_path / "plot.png"))
    assert image.width() > 600
    colors = {image.pixel(x, y) for x in range(0, image.width(), 7) for y in range(0, 400, 5)}
    assert len(colors) > 5


def test_another_language_reaches_every_page(user):
    model = user.differences._rows.table.model()
    use_language("es")
    try:
        user.screen.retranslate()
        assert model.index(0, 0).data() == "De frente"
        names = [model.index(row, 1).data() for row in range(model.rowCount())]
        assert any("Alineación" in name for name in names)
    finally:
        use_language("en")
        user.screen.retranslate()


def test_choosing_in_the_lists_compares_others(user):
    earlier, _later, _protocol = user.screen._choosers.findChildren(QComboBox)
    first = earlier.count() - 1
    earlier.setCurrentIndex(first)
    earlier.activated.emit(first)
    line = next(one for one in user.lines("Differences") if "acromia [deg]" in one[1])
    assert line[2] == "0.0"
    assert "Apr 2026" in user.pictures._titles[0].text()


def test_dates_under_an_axis_keep_their_distance():
    assert spaced([0.0, 1.0, 5.0, 9.5, 10.0], 3.0) == [0, 2, 4]
    assert spaced([0.0], 3.0) == [0]
    assert spaced([0.0, 1.0], 3.0) == [0]


def test_axes_show_no_noise_and_numbers_as_the_language_writes_them():
    assert spread([1.0, 1.1], "deg") == pytest.approx((0.05, 2.05))
    assert spread([-5.0, 5.0], "mm") == (-5.0, 5.0)
    assert tick_texts([0.5, 1.0], 1.0, 0.5) == ["0.5", "1.0"]
    use_language("es")
    assert tick_texts([10.0], 1.0, 10.0) == ["10"]
    assert tick_texts([0.25], 1.0, 0.05) == ["0,25"]
    use_language("en")
