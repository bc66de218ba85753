"""The report screen under mouse and keyboard, over a real store."""

from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtGui import QDesktopServices
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QApplication,
    QCheckBox,
    QComboBox,
    QFileDialog,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QStyle,
    QTabBar,
    QTextBrowser,
)

from adibas.texts import use_language
from benchmarks.identity_search import found_below
from tests.ui.review_scene import saved_session
from ui.reports.pages_bar import PagesBar
from ui.reports.screen import build_reports_screen
from ui.widgets.image_view import ImageView
from ui.widgets.wrapped_lines import WrappedLines

LEFT = Qt.MouseButton.LeftButton
Key = Qt.Key


@pytest.fixture
def screen(store, workspace, theme, qtbot):  # noqa: ARG001  (it is there)
    """The screen with two sessions, of which the first is looked at."""
    patient, session, _captures = saved_session(store, ("anterior", "posterior"))
    saved_session(store)
    workspace.choose_patient(patient)
    workspace.choose_session(session)
    screen = build_reports_screen(workspace)
    qtbot.addWidget(screen)
    screen.resize(1140, 740)
    screen.show()
    screen.entered()
    yield screen
    screen.left()
    screen.closed()
    use_language("en")


def button(screen, text):
    (found,) = [
        one for one in screen.findChildren(QPushButton) if one.text().replace("&", "") == text
    ]
    return found


def accept(folder):
    """Choose a folder in the dialog that is open."""
    (dialog,) = [one for one in QApplication.topLevelWidgets() if isinstance(one, QFileDialog)]
    dialog.fileSelected.emit(str(folder))
    dialog.reject()


def test_a_page_a_view_is_previewed(screen):
    pages, picture = screen.findChild(QTabBar), screen.findChild(ImageView)
    assert [pages.tabText(index) for index in range(pages.count())] == ["Anterior", "Posterior"]
    assert picture.placement.picture[0] > 100
    facts = screen.findChild(QTextBrowser)
    first = facts.toPlainText()
    pages.setFocus()
    QTest.keyClick(pages, Key.Key_Right)
    assert pages.currentIndex() == 1
    assert facts.toPlainText() != first


def test_titles_of_pages_take_two_lines_where_one_row_is_too_short(qtbot):
    titles = ("anterior", "lateral derecha", "lateral izquierda")
    bar = PagesBar()
    qtbot.addWidget(bar)
    bar.resize(900, 60)
    bar.show_titles(titles)
    bar.setCurrentIndex(2)
    bar.show()

    def shown():
        return tuple(bar.tabText(index) for index in range(bar.count()))

    assert shown() == titles
    one_line = sum(bar.tabSizeHint(index).width() for index in range(3))
    height = bar.sizeHint().height()
    bar.resize(one_line - 5, 60)
    assert bar.sizeHint().height() == height + bar.fontMetrics().lineSpacing()
    assert shown() == ("anterior", "lateral\nderecha", "lateral\nizquierda")
    assert sum(bar.tabSizeHint(index).width() for index in range(3)) <= bar.width()
    bar.resize(900, 60)
    assert shown() == titles
    bar.show_titles(titles)
    assert bar.currentIndex() == 2
    bar.show_titles(titles[:1])
    assert (shown(), bar.currentIndex()) == (titles[:1], 0)


def test_sessions_are_ticked_with_the_space_bar(screen, workspace):
    sessions = screen.findChild(QListWidget)
    ticks = [sessions.item(row).checkState() for row in range(sessions.count())]
    assert sorted(ticks, key=str) == [Qt.CheckState.Checked, Qt.CheckState.Unchecked]
    sessions.setFocus()
    sessions.setCurrentRow(ticks.index(Qt.CheckState.Unchecked))
    QTest.keyClick(sessions, Key.Key_Space)
    assert len(screen._presenter._chosen) == 2
    assert workspace.session.session_id in screen._presenter._chosen


def test_language_and_pictures_are_chosen_with_the_keyboard(screen):
    language, pictures, _compared_with = screen.findChildren(QComboBox)
    QTest.keyClick(language, Key.Key_Down)
    assert screen._presenter._wish.language == "es"
    assert "Paciente" in screen.findChild(QTextBrowser).toPlainText()
    QTest.keyClick(pictures, Key.Key_End)
    assert screen._presenter._wish.pictures.name == "DEPTH"


def test_what_is_ticked_is_written_and_its_folder_opened(screen, tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr(QDesktopServices, "openUrl", opened.append)
    show_folder = button(screen, "Open the folder")
    assert show_folder.isHidden()
    for box in screen.findChildren(QCheckBox):
        if "CSV" in box.text():
            QTest.mouseClick(box, LEFT, pos=QPoint(8, box.height() // 2))
    QTest.mouseClick(button(screen, "Write the report..."), LEFT)
    accept(tmp_path / "out")
    assert sorted(path.suffix for path in (tmp_path / "out").iterdir()) == [".csv", ".xlsx"]
    QTest.mouseClick(show_folder, LEFT)
    assert [Path(url.toLocalFile()) for url in opened] == [tmp_path / "out"]


def test_the_dialog_begins_where_reports_were_written_last_and_no_file_tells_it(screen, tmp_path):
    """Many folders are called after a patient."""
    folder = tmp_path / "Rosa Ibarra"
    folder.mkdir()
    QTest.mouseClick(button(screen, "Write the report..."), LEFT)
    accept(folder)
    QTest.mouseClick(button(screen, "Write the report..."), LEFT)
    dialogs = [one for one in QApplication.topLevelWidgets() if isinstance(one, QFileDialog)]
    (dialog,) = [one for one in dialogs if one.isVisible()]
    assert Path(dialog.directory().absolutePath()) == folder
    dialog.reject()
    for path in folder.iterdir():
        path.unlink()
    folder.rmdir()
    assert found_below(tmp_path, ["Rosa", "Ibarra"]) == {}


def test_without_a_choice_there_is_no_preview(screen):
    sessions = screen.findChild(QListWidget)
    for row in range(sessions.count()):
        sessions.item(row).setCheckState(Qt.CheckState.Unchecked)
    assert screen.findChild(QTabBar).count() == 0
    assert "Choose a session" in screen.findChild(QTextBrowser).toPlainText()


def test_every_text_changes_with_the_language(screen):
    def texts():
        kinds = (QPushButton, QCheckBox, QLabel)
        return {one.text().replace("&", "") for kind in kinds for one in screen.findChildren(kind)}

    english = texts()
    use_language("ca")
    screen.retranslate()
    assert texts().isdisjoint(english - {""})


def test_every_control_can_be_named_aloud(screen):
    named = {label.buddy() for label in screen.findChildren(QLabel)}
    for kind in (QListWidget, QComboBox):
        assert set(screen.findChildren(kind)) <= named
    for kind in (ImageView, QTextBrowser, QTabBar):
        assert all(one.accessibleName() for one in screen.findChildren(kind))


@pytest.mark.usefixtures("large_letters")
@pytest.mark.parametrize("width_px", range(186, 220, 5))
def test_a_line_beside_its_box_is_as_high_as_its_words_need(qtbot, width_px):
    lines = WrappedLines()
    qtbot.addWidget(lines)
    lines.resize(width_px, 400)
    item = QListWidgetItem("Paciente de demostración\n21 nov 2026, 21:50\n4 vistas", lines)
    item.setCheckState(Qt.CheckState.Checked)
    lines.show()
    box_px = lines.style().pixelMetric(QStyle.PixelMetric.PM_IndicatorWidth, None, lines)
    beside = QRect(0, 0, lines.viewport().width() - box_px, 0)
    words = lines.fontMetrics().boundingRect(beside, Qt.TextFlag.TextWordWrap, item.text())
    assert lines.visualItemRect(item).height() >= words.height()
