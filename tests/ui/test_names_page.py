"""Who names the markers: what the page decides, and the page itself."""

from unittest.mock import create_autospec

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel, QPushButton, QTableWidget, QTabWidget

from adibas.pipeline.namers import keep_own_model, own_model_path, own_models
from adibas.pipeline.skeleton_examples import LandmarkSet
from adibas.skeleton.model_files import read_model
from tests.unit.name_samples import PLACES, add_example, add_examples
from ui.ports import Jobs
from ui.settings.names_presenter import NamesPresenter, NamesView
from ui.settings.screen import build_settings_screen
from ui.settings.view import PROTOCOLS_TAB

FREE = LandmarkSet()


@pytest.fixture(autouse=True)
def no_own_models(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))


@pytest.fixture
def view():
    return create_autospec(NamesView, instance=True)


@pytest.fixture
def presenter(view, workspace):
    return NamesPresenter(view, workspace)


def shown(view):
    return view.show_names.call_args.args


def test_corrected_sessions_are_counted_and_their_protocols_have_titles(presenter, view, store):
    presenter.enter()
    assert shown(view) == ((), ())
    add_examples(store, 1)
    add_examples(store, 1, protocol="joints-15")
    add_examples(store, 1, protocol="lost")
    presenter.enter()
    rows, titles = shown(view)
    assert [row.n_captures for row in rows] == [1, 1, 1]
    assert titles == ("", "15 joints", "lost")


def test_what_was_learned_names_markers_from_then_on_and_is_told(presenter, view, store, told):
    add_examples(store, 10)
    presenter.learn(FREE)
    assert [call.kwargs["is_running"] for call in view.show_learning.call_args_list] == [
        True,
        False,
    ]
    (own,) = own_models()
    assert set(own.namer.names) == set(PLACES)
    assert told[0][0] == "good"
    assert "Of 10 captures that it had not seen" in told[0][1]
    assert shown(view)[0][0].learned["n_captures"] == 10


def test_too_few_captures_are_told_and_nothing_changes(presenter, view, store, inline_jobs, told):
    add_examples(store, 9)
    presenter.learn(FREE)
    (problem,) = inline_jobs.problems
    assert "There are 9 captures" in str(problem)
    assert own_models() == ()
    assert told == []
    assert view.show_learning.call_args.kwargs == {"is_running": False}


def test_a_cancelled_learning_leaves_all_as_it_was(presenter, view, store, inline_jobs):
    add_examples(store, 10)
    inline_jobs.is_stopped = True
    presenter.learn(FREE)
    assert inline_jobs.problems == []
    assert own_models() == ()
    assert view.show_learning.call_args.kwargs == {"is_running": False}


def test_one_way_leads_back(presenter, view, store, told):
    add_examples(store, 10)
    presenter.learn(FREE)
    presenter.go_back(FREE)
    assert own_models() == ()
    assert "no longer used" in told[-1][1]
    assert shown(view)[0][0].learned is None


def test_a_model_that_stays_is_told(presenter, told):
    own_model_path().mkdir(parents=True)
    presenter.go_back(FREE)
    assert [kind for kind, _sentence in told] == ["bad"]


def test_nothing_is_learned_twice_at_once_and_the_newest_count_wins(view, workspace):
    jobs = create_autospec(Jobs, instance=True)
    workspace.jobs = jobs
    presenter = NamesPresenter(view, workspace)
    presenter.learn(FREE)
    presenter.learn(FREE)
    assert jobs.start.call_count == 1
    presenter.enter()
    jobs.start.return_value.cancel.assert_not_called()
    presenter.enter()
    jobs.start.return_value.cancel.assert_called_once()


@pytest.fixture
def screen(workspace, qtbot):
    screen = build_settings_screen(workspace)
    qtbot.addWidget(screen)
    screen.resize(1140, 740)
    screen.show()
    screen.findChild(QTabWidget).setCurrentIndex(PROTOCOLS_TAB)
    yield screen
    screen.closed()


def buttons(page):
    return {
        one.text().replace("&", ""): one
        for one in page.findChildren(QPushButton)
        if one.isVisible()
    }


def press(page, text):
    QTest.mouseClick(buttons(page)[text], Qt.MouseButton.LeftButton)


def texts(page):
    return " ".join(one.text() for one in page.findChildren(QLabel) if one.isVisible())


def test_a_user_learns_from_corrections_and_goes_back(screen, store):
    press(screen.marks.protocols, "Who names the markers")
    page, table = screen.marks.names, screen.marks.names.findChild(QTableWidget)
    assert "No session has corrected names yet" in texts(page)
    assert set(buttons(page)) == {"Back to the protocols"}
    session = add_examples(store, 9)
    press(page, "Back to the protocols")
    press(screen.marks.protocols, "Who names the markers")
    assert table.item(0, 0).text() == "Sessions without a protocol"
    assert "9 captures are corrected, and a model needs 10" in texts(page)
    assert not buttons(page)["Learn from these sessions"].isEnabled()
    add_example(store, session, np.random.default_rng(3))
    screen.entered()
    assert "Names were corrected in 1 session: it can be learned from" in texts(page)
    press(page, "Learn from these sessions")
    assert table.item(0, 1).text() == "Own model"
    assert "from 10 captures of 1 patient." in texts(page)
    press(page, "Use the own model no more")
    assert table.item(0, 1).text() == "Nobody"
    assert own_models() == ()


def test_a_model_of_a_file_and_one_that_was_held_against_the_shipped_are_told(
    screen, store, presenter
):
    add_examples(store, 10)
    presenter.learn(FREE)
    model = read_model(own_model_path())
    told = model.provenance
    held_out = told["held_out"] | {"shipped_right": 8, "shipped_wrong": 2}
    object.__setattr__(model, "provenance", told | {"held_out": held_out, "protocol": "joints-15"})
    keep_own_model(model)
    object.__setattr__(model, "provenance", {"source": "points.csv"})
    keep_own_model(model)
    press(screen.marks.protocols, "Who names the markers")
    page, table = screen.marks.names, screen.marks.names.findChild(QTableWidget)
    assert "from points.csv" in texts(page)
    table.selectRow(1)
    assert "the shipped model 8 and 2" in texts(page)
    assert "Go back to the shipped model" in buttons(page)
