"""A wand before a session: the presenter's decisions without Qt, then the real dialog."""

from datetime import UTC, datetime, timedelta
from unittest.mock import create_autospec

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox, QDoubleSpinBox, QLabel, QPushButton, QWidget

from adibas.calibration.wand import WandResult
from adibas.data.frames import SourceInfo
from adibas.data.markers import Marker
from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import MarkerError
from adibas.markers.led import LedParams
from adibas.pipeline.live import SensorState
from adibas.pipeline.wand_check import SeenWand, compare_ends, wand_from_document
from adibas.texts import LANGUAGES, speaking
from tests.unit.store_samples import add_patient
from ui.capture import wand_presenter
from ui.capture.ports import CaptureView
from ui.capture.presenter import CapturePresenter
from ui.capture.sources import usual_sources
from ui.capture.wand_dialog import WandDialog
from ui.capture.wand_presenter import WandPresenter, WandView, without_old_wand

LIVE = SensorState("live", None, SourceInfo(frame_rate_hz=30.0))
NOW = datetime(2026, 5, 4, 9, 30, tzinfo=UTC)
MILLIMETRE = 0.001


def marker(label, x_m, sd_m=0.4 * MILLIMETRE):
    position_m = np.array([x_m, 0.1, 2.0])
    covariance_m2 = np.eye(3) * sd_m**2
    return Marker(label, 320 + 500 * x_m, 240.0, 5.0, np.eye(2), position_m, covariance_m2)


def wand(*places_m):
    markers = tuple(marker(f"m{i:02d}", x_m) for i, x_m in enumerate(places_m, 1))
    return SeenWand(markers, np.full((480, 640, 3), 90, np.uint8))


@pytest.fixture
def seeing(monkeypatch):
    """What the next bursts show; an exception is raised."""
    given = []

    def see(_live, _target, progress):
        progress(1, 2)
        one = given.pop(0)
        if isinstance(one, Exception):
            raise one
        return one

    monkeypatch.setattr(wand_presenter, "see_wand", see)
    return given


@pytest.fixture
def ready(workspace):
    workspace.live.state = LIVE
    workspace.set_target(LedParams())
    return workspace


@pytest.fixture
def view():
    return create_autospec(WandView, instance=True)


@pytest.fixture
def kept():
    return []


@pytest.fixture
def shown(view, ready, kept):
    return WandPresenter(view, ready, kept.append, clock=lambda: NOW)


def verdict(view):
    check, when = view.show_check.call_args.args
    return check.result, when


@pytest.mark.parametrize(
    ("state", "target", "word"),
    [("lost", LedParams(), "picture"), ("live", None, "colour")],
)
def test_what_lacks_is_said(state, target, word, view, workspace, seeing):
    workspace.live.state = SensorState(state)
    workspace.set_target(target)
    presenter = WandPresenter(view, workspace, print)
    sentence, is_ready = view.show_readiness.call_args.args[0], view.show_readiness.call_args.kwargs
    assert word in sentence
    assert is_ready == {"is_ready": False}
    presenter.measure()
    assert seeing == []
    view.show_measuring.assert_not_called()


def test_two_markers_are_the_ends_and_the_check_is_kept(shown, view, seeing, kept, ready):
    seeing.append(wand(-0.25, 0.251))
    shown.measure()
    assert view.show_seen.call_args.args[1] == (0, 1)
    assert verdict(view) == (WandResult.PASSED, "")
    [document] = kept
    check, checked_utc = wand_from_document(document)
    assert check.measured_m == pytest.approx(0.501, abs=1e-6)
    assert checked_utc == NOW
    shown.set_length(520.0)
    assert verdict(view)[0] is WandResult.FAILED
    assert ready.preferences.now.wand_length_mm == 520.0
    assert kept[-1]["result"] == "failed"


def test_among_more_markers_the_user_chooses(shown, view, seeing, kept):
    seeing.append(wand(-0.25, 0.0, 0.25))
    shown.measure()
    assert view.show_seen.call_args.args[1] is None
    assert "3 markers are seen" in view.show_problem.call_args.args[0]
    assert kept == []
    shown.choose((0, 0))
    assert kept == []
    shown.choose((0, 2))
    assert verdict(view)[0] is WandResult.PASSED
    assert len(kept) == 1


def test_a_burst_that_fails_is_told_and_can_be_repeated(shown, view, seeing, kept, inline_jobs):
    seeing += [MarkerError("Nobody is seen."), wand(-0.25, 0.25)]
    shown.measure()
    assert [str(problem) for problem in inline_jobs.problems] == ["Nobody is seen."]
    assert view.show_measuring.call_args.kwargs == {"is_measuring": False}
    assert kept == []
    shown.measure()
    assert len(kept) == 1


def test_the_check_of_the_session_is_shown_again(shown, view, seeing, kept, ready):
    seeing.append(wand(-0.25, 0.25))
    shown.measure()
    again = create_autospec(WandView, instance=True)
    WandPresenter(again, ready, kept.append, kept[0])
    result, when = verdict(again)
    assert result is WandResult.PASSED
    assert when.startswith("2026-05-04 ")
    assert verdict(view)[0] is result


def test_a_new_session_takes_todays_check_along_and_no_older_one(shown, seeing, kept):
    seeing.append(wand(-0.25, 0.25))
    shown.measure()
    setup = SessionSetup(wand=kept[0])
    assert without_old_wand(setup, NOW + timedelta(hours=2)) is setup
    assert without_old_wand(setup, NOW + timedelta(days=1)).wand is None
    assert without_old_wand(SessionSetup(), NOW).wand is None


def test_the_capture_screen_keeps_the_check_with_the_session(view, ready, seeing, store):
    capture = CapturePresenter(
        create_autospec(CaptureView, instance=True), ready, look=usual_sources
    )
    patient = add_patient(store, Identity("Ana"))
    ready.choose_patient(patient)
    assert capture.may_check_wand()
    before = capture.check_wand(view)
    seeing += [wand(-0.25, 0.25), wand(-0.25, 0.26)]
    before.measure()
    ready.choose_session(store.sessions.start(patient.pseudonym, capture.sources.setup))
    assert store.sessions.get(ready.session.session_id).setup.wand["result"] == "passed"
    before.measure()
    assert store.sessions.get(ready.session.session_id).setup.wand["result"] == "failed"
    capture.sources.choose_source("openni2")
    assert store.sessions.get(ready.session.session_id).setup.wand is None


@pytest.mark.usefixtures("large_letters")
@pytest.mark.parametrize("language", LANGUAGES)
def test_with_large_letters_the_dialog_is_no_higher_than_the_window(qtbot, workspace, language):
    parent = QWidget()
    qtbot.addWidget(parent)
    parent.resize(1280, 800)
    with speaking(language):
        dialog = WandDialog(parent)
        dialog.bind(WandPresenter(dialog, workspace, lambda _document: None))
        dialog.open()
        assert dialog.minimumHeight() <= parent.height()
        failed = compare_ends(marker("m01", -0.25), marker("m02", 0.25), 0.53)
        dialog.show_check(failed, "2026-05-04 09:30")
        assert dialog.minimumHeight() <= parent.height()
    dialog.close()


def test_the_dialog_measures_by_a_click_and_shows_the_verdict(qtbot, ready, seeing, kept):
    parent = QWidget()
    qtbot.addWidget(parent)
    dialog = WandDialog(parent)
    dialog.bind(WandPresenter(dialog, ready, kept.append, clock=lambda: NOW))
    dialog.open()
    seeing.append(wand(-0.25, 0.0, 0.25))
    (button,) = [one for one in dialog.findChildren(QPushButton) if one.text() == "&Measure"]
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
    words = [label.text() for label in dialog.findChildren(QLabel)]
    assert any("Choose the two at the ends" in text for text in words)
    for box, index in zip(dialog.findChildren(QComboBox), (0, 2), strict=True):
        box.setCurrentIndex(index)
        box.activated.emit(index)
    words = [label.text() for label in dialog.findChildren(QLabel)]
    assert any("The wand of 500.0 mm measures 500.0 mm" in text for text in words)
    dialog.findChild(QDoubleSpinBox).setValue(530.0)
    words = [label.text() for label in dialog.findChildren(QLabel)]
    assert any("calibrate again" in text for text in words)
    assert kept[-1]["result"] == "failed"
    dialog.close()
    qtbot.waitUntil(lambda: not parent.findChildren(WandDialog))
