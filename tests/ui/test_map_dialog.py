"""The map dialog: what its presenter decides, and the window around a recording of a room."""

from unittest.mock import create_autospec

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QColor
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QCheckBox, QFileDialog, QLabel, QPushButton, QWidget

from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import StoreError
from adibas.pipeline.recording_access import FILES
from adibas.recordings import open_recording
from adibas.sessions.audit_words import kind_text
from tests.ui import window_user
from tests.ui.disc_samples import discs_at
from tests.unit.room_recordings import INFO, room_frames, written
from tests.unit.store_samples import add_patient
from ui.behaviour.screen import build_behaviour_screen
from ui.mapping.content import MapView, RecordingToMap, Standing
from ui.mapping.dialog import MapDialog
from ui.mapping.presenter import MapPresenter
from ui.theme import DRAWN
from ui.widgets.space import Space
from ui.widgets.space_view import SpaceView

open_window = window_user.open_window
N_FRAMES = 8


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    return written(tmp_path_factory.mktemp("map") / "room.mcap", room_frames()[0])


@pytest.fixture
def view():
    return create_autospec(MapView, instance=True)


@pytest.fixture
def presenter(view, workspace, room):
    presenter = MapPresenter(view, workspace, to_map(room))
    yield presenter
    presenter.close()


def to_map(path, note_export=lambda: None):
    return RecordingToMap(path.name, path.stem, path, FILES, note_export)


def standing(view):
    return view.show_standing.call_args.args[0]


def told(view):
    return view.show_told.call_args


def test_a_map_is_shown_told_and_saved(presenter, view, tmp_path):
    assert standing(view) == Standing()
    presenter.start(is_body=False)
    assert standing(view) == Standing(has_map=True)
    (shown,) = view.show_growing.call_args.args
    assert len(shown.discs) > 5000
    assert shown.path_m.shape == (N_FRAMES, 3)
    assert f"from {N_FRAMES} of {N_FRAMES} frames" in told(view).args[0][0]
    presenter.save_surface(tmp_path / "m.ply")
    presenter.save_path(tmp_path / "t.txt")
    assert (tmp_path / "m.ply").read_bytes().startswith(b"ply\n")
    assert np.loadtxt(tmp_path / "t.txt").shape == (N_FRAMES, 8)
    assert told(view).args[0] == ("t.txt was saved.",)


def test_a_map_that_was_stopped_goes_on(presenter, view, inline_jobs):
    inline_jobs.is_stopped = True
    presenter.start(is_body=False)
    assert standing(view) == Standing(has_begun=True)
    inline_jobs.is_stopped = False
    presenter.start(is_body=False)
    assert standing(view).has_map
    assert any("this one went on" in sentence for sentence in told(view).args[0])


def test_what_cannot_be_mapped_is_told_in_words(view, workspace, tmp_path):
    one = written(tmp_path / "one.mcap", room_frames()[0][:1])
    presenter = MapPresenter(view, workspace, to_map(one))
    presenter.start(is_body=False)
    assert "No two frames could be put together in one.mcap." in told(view).args[0][0]
    assert told(view).kwargs["is_problem"]
    assert standing(view) == Standing()
    presenter.save_surface(tmp_path / "m.ply")
    assert not (tmp_path / "m.ply").exists()
    presenter.close()


def test_nothing_leaves_where_it_may_not(view, workspace, tmp_path, room):
    def refuse():
        raise StoreError("nothing may leave")

    presenter = MapPresenter(view, workspace, to_map(room, refuse))
    presenter.start(is_body=False)
    presenter.save_surface(tmp_path / "m.ply")
    assert told(view).args[0] == ("nothing may leave",)
    assert not (tmp_path / "m.ply").exists()
    presenter.close()


def test_what_is_unfinished_is_in_no_file(
    view, workspace, room, inline_jobs, monkeypatch, tmp_path
):
    """How a patient moved is nobody's to find in the system's folder for temporary files."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(temporary))
    before = {path.name for path in room.parent.iterdir()}
    presenter = MapPresenter(view, workspace, to_map(room))
    inline_jobs.is_stopped = True
    presenter.start(is_body=False)
    inline_jobs.is_stopped = False
    presenter.start(is_body=False)
    assert standing(view).has_map
    assert list(temporary.iterdir()) == []
    assert {path.name for path in room.parent.iterdir()} == before
    presenter.close()


def test_a_surface_that_grows_is_looked_at_from_where_one_looked(qtbot):
    space = SpaceView()
    qtbot.addWidget(space)
    points = np.random.default_rng(0).normal(size=(500, 3))
    colors = np.zeros((500, 3), np.uint8)
    space.show_space(Space(discs_at(points[:400], colors[:400])))
    QTest.keyClick(space, Qt.Key.Key_Left)
    turned = space._yaw_rad
    space.renew_space(Space(discs_at(points, colors)))
    assert space._yaw_rad == turned != 0.0
    space.show_space(Space(discs_at(points, colors)))
    assert space._yaw_rad == 0.0


def test_the_way_of_the_camera_is_drawn_over_the_surface(qtbot):
    space = SpaceView()
    qtbot.addWidget(space)
    space.resize(300, 300)
    points = np.random.default_rng(0).uniform(-1, 1, (2000, 3))
    discs = discs_at(points, np.full((2000, 3), 90), radius_m=0.1)
    path_m = np.array([[-0.5, 0.5, 0.0], [0.0, 0.5, 0.0], [0.5, -0.5, 0.0]])
    way = QColor(DRAWN["outline"]).rgb()

    def n_green():
        image = space.grab().toImage()
        return sum(image.pixel(x, y) == way for x in range(300) for y in range(300))

    space.show_space(Space(discs))
    assert n_green() == 0
    space.show_space(Space(discs, path_m=path_m))
    places, _depths = space.project(path_m)
    assert n_green() >= np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
    x, y = places[-1].round().astype(int)
    assert space.grab().toImage().pixel(x, y) == way, "where the camera is now"


def test_in_the_smallest_dialog_nothing_is_squeezed(qtbot):
    window = QWidget()
    qtbot.addWidget(window)
    window.resize(1280, 800)
    window.show()
    dialog = MapDialog("Recording", window)
    dialog.bind(create_autospec(MapPresenter, instance=True))
    dialog.show_told(("What is told of a map takes more than one line. " * 9,) * 3, is_problem=True)
    dialog.show()
    dialog.resize(0, 0)
    qtbot.waitUntil(lambda: dialog.height() < 500)
    told, space = dialog._told, dialog.findChild(SpaceView)
    assert told.height() >= told.heightForWidth(told.width()) > 5 * dialog.fontMetrics().height()
    assert space.height() >= 8 * dialog.fontMetrics().height()
    for button in dialog.findChildren(QPushButton):
        assert button.height() >= button.sizeHint().height()
        assert button.geometry().bottom() < dialog.height()
    dialog.close()


def named(dialog, text):
    (found,) = [one for one in dialog.findChildren(QPushButton) if one.text() == text]
    return found


def behaviour_screen(qtbot, workspace, theme):
    screen = build_behaviour_screen(workspace, theme)
    qtbot.addWidget(screen)
    screen.resize(1200, 800)
    screen.show()
    return screen


def ask_for_map(screen):
    (action,) = [one for one in screen.findChildren(QAction) if one.text().startswith("Map in")]
    action.trigger()
    return screen.findChild(MapDialog)


def test_without_a_recording_the_menu_says_what_to_do(qtbot, workspace, theme, request):
    screen = behaviour_screen(qtbot, workspace, theme)
    notices = request.getfixturevalue("told")
    assert ask_for_map(screen) is None
    assert notices == [("warning", "Open a recording of a moving camera first.")]
    screen.closed()


def test_what_is_watched_out_of_the_store_is_mapped_and_the_log_says_so(
    qtbot, workspace, theme, room, tmp_path
):
    store = workspace.store
    patient = add_patient(store, Identity("Rosa Ibarra", None, "HC-77"))
    session = store.sessions.start(patient.pseudonym, SessionSetup())
    with (
        open_recording(room) as reader,
        store.recordings.create(session.session_id, INFO) as writer,
    ):
        for index in range(len(reader)):
            writer.write(reader.read(index))
    screen = behaviour_screen(qtbot, workspace, theme)
    workspace.choose_patient(patient)
    workspace.choose_session(session)
    screen._presenter.open_stored(writer.recording_id)
    dialog = ask_for_map(screen)
    assert not named(dialog, "Save the &surface...").isEnabled()
    named(dialog, "&Map").click()
    assert any(f"from {N_FRAMES} of" in label.text() for label in dialog.findChildren(QLabel))
    named(dialog, "Save the &surface...").click()
    (asked,) = dialog.findChildren(QFileDialog)
    asked.fileSelected.emit(str(tmp_path / "m.ply"))
    asked.close()
    assert (tmp_path / "m.ply").exists()
    dialog.close()
    screen.closed()
    (logged,) = [one for one in store.audit.entries() if one.action == "export"]
    assert (logged.subject, logged.detail) == (session.session_id, {"kind": "map"})
    assert kind_text(logged.detail["kind"]) == "a map in 3-D"


def test_in_the_real_window_a_map_grows_is_stopped_and_goes_on_with_keys(open_window, room):
    user = open_window()
    user.give_new_passphrase()
    user.settle()
    user.go_to("behaviour")
    user.screen.open_file(room)
    user.settle()
    dialog = ask_for_map(user.screen)
    dialog.activateWindow()
    user.until(dialog.isActiveWindow)
    run = dialog.focusWidget()
    user.key(window_user.Key.Key_Return)
    user.until(lambda: run.text() == "S&top")
    assert not dialog.findChild(QCheckBox).isEnabled()
    user.key(window_user.Key.Key_Return)
    user.until(lambda: run.text() in ("&Go on", "&Map"))
    user.key(window_user.Key.Key_Return)
    user.until(lambda: named(dialog, "Save the &surface...").isEnabled())
    user.settle()
    dialog.close()
