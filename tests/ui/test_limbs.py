"""The editor of labelled images: what its presenter decides, and the window with a mouse."""

from dataclasses import replace
from unittest.mock import create_autospec

import cv2
import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QAction
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QDialogButtonBox,
    QFileDialog,
    QListWidget,
    QMessageBox,
    QProgressBar,
    QPushButton,
    QRadioButton,
)

from adibas.data.frames import SensorFrame
from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import FileError, LimbError
from adibas.limbs.training_set import LimbFolder
from adibas.pipeline import limb_label_files, limb_labelling
from adibas.pipeline.limb_labelling import LabellingDesk
from adibas.recordings import RecordingOptions, create_recording, open_recording
from adibas.sessions.sealed_recordings import SealedRecordings
from adibas.texts import LANGUAGES, speaking
from tests.ui.limb_scene import BOX, HEIGHT, INFO, WIDTH, record_box
from tests.ui.test_mnemonics import assert_each_letter_is_one_control
from tests.unit.store_samples import add_patient
from ui.behaviour.screen import build_behaviour_screen
from ui.limbs.dialog import LimbsDialog
from ui.limbs.paint_view import PaintView
from ui.limbs.ports import LimbsView, StoredRecording
from ui.limbs.presenter import LimbsPresenter

HEAD, TORSO = 1, 3


@pytest.fixture
def video(tmp_path):
    return record_box(tmp_path / "box.mcap")


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "box-limbs"


@pytest.fixture
def view():
    return create_autospec(LimbsView, instance=True)


@pytest.fixture
def presenter(view, workspace, video):
    presenter = LimbsPresenter(view, workspace)
    presenter.open(video)
    presenter.set_beyond(is_on=True)
    yield presenter
    presenter.close()


def allowed(view):
    return view.show_allowed.call_args.args[0]


def progress(view):
    return view.show_progress.call_args.args


def kept(folder, index):
    """Return the labels that lie in the folder."""
    found = [*folder.glob(f"{index:05d}.draft.png"), *folder.glob(f"{index:05d}.labels.png")]
    assert len(found) <= 1
    return cv2.imread(str(found[0]), cv2.IMREAD_UNCHANGED) if found else None


def fill_box(presenter, label=TORSO):
    presenter.choose_label(label)
    presenter.choose_tool("fill")
    presenter.click(25, 15)


def test_nothing_can_be_done_before_a_recording_is_open(view, workspace, told):
    presenter = LimbsPresenter(view, workspace)
    assert not allowed(view).can_edit
    for action in (presenter.propose, presenter.carry, presenter.finish, presenter.enclose):
        action()
    presenter.click(3, 3)
    presenter.go_by(1)
    presenter.point(3, 3)
    presenter.close()
    view.show_picture.assert_not_called()
    assert not told


def test_a_stroke_is_one_step_and_can_be_taken_back(presenter, view, folder):
    presenter.choose_label(HEAD)
    presenter.set_radius(1)
    for u in range(5, 10):
        presenter.drag(u, 20)
    assert not allowed(view).can_undo
    presenter.drop()
    presenter.undo()
    assert not allowed(view).can_undo
    presenter.redo()
    presenter.leave()
    labels = kept(folder, 0)
    assert set(np.argwhere(labels)[:, 1]) == set(range(4, 11))
    assert set(np.unique(labels)) == {0, HEAD}


def test_steps_are_taken_back_through_all_frames_and_done_again(presenter, view, folder):
    fill_box(presenter)
    presenter.go(2)
    fill_box(presenter, HEAD)
    presenter.go(1)
    assert allowed(view).can_undo
    presenter.undo()
    assert progress(view)[0] == 2
    presenter.point(25, 15)
    view.show_under.assert_called_with("")
    presenter.undo()
    assert progress(view)[0] == 0
    presenter.point(25, 15)
    view.show_under.assert_called_with("")
    assert not allowed(view).can_undo
    presenter.redo()
    presenter.redo()
    assert progress(view)[0] == 2
    presenter.leave()
    assert kept(folder, 0)[15, 25] == TORSO
    assert kept(folder, 2)[15, 25] == HEAD
    assert not allowed(view).can_redo


def test_a_step_in_a_frame_that_cannot_be_read_any_more_stays_to_be_undone(
    presenter, view, folder, inline_jobs
):
    fill_box(presenter)
    presenter.go(1)
    (folder / "00000.draft.png").write_bytes(b"no picture")
    presenter.undo()
    assert "00000.draft.png in box-limbs is damaged" in str(inline_jobs.problems[-1])
    assert progress(view)[0] == 1
    assert allowed(view).can_undo


def test_another_recording_begins_without_steps(presenter, view, tmp_path):
    fill_box(presenter)
    presenter.open(record_box(tmp_path / "other.mcap"))
    assert not allowed(view).can_undo


def test_filling_stops_at_the_edge_of_depth_and_the_limb_there_is_told(presenter, view, folder):
    fill_box(presenter)
    presenter.leave()
    wanted = np.zeros((HEIGHT, WIDTH), np.uint8)
    wanted[BOX] = TORSO
    np.testing.assert_array_equal(kept(folder, 0), wanted)
    presenter.point(25, 15)
    view.show_under.assert_called_with("torso")
    presenter.point(-4, 15)
    view.show_under.assert_called_with("")


def test_a_polygon_is_filled_once_it_has_three_corners(presenter, view, folder):
    presenter.choose_tool("polygon")
    for u, v in ((2, 2), (8, 2), (8, 8)):
        assert not allowed(view).can_enclose
        presenter.click(u, v)
    assert allowed(view).can_enclose
    presenter.enclose()
    view.show_corners.assert_called_with(())
    presenter.leave()
    assert kept(folder, 0)[3, 7] == HEAD
    presenter.click(4, 4)
    presenter.choose_tool("brush")
    view.show_corners.assert_called_with(())


def test_nothing_is_painted_beside_the_person_unless_it_is_asked_for(presenter, folder):
    presenter.set_beyond(is_on=False)
    fill_box(presenter)
    presenter.go_by(1)
    assert kept(folder, 0) is None


def test_what_was_labelled_is_there_again_after_a_restart(presenter, view, workspace, video):
    fill_box(presenter)
    presenter.go_by(1)
    presenter.close()
    again = LimbsPresenter(view, workspace)
    again.open(video)
    index, known = progress(view)
    assert (index, known.begun, known.done) == (0, {0}, frozenset())
    again.point(25, 15)
    view.show_under.assert_called_with("torso")
    again.close()


def test_frames_that_are_done_can_be_trained_on_and_the_next_one_is_shown(
    presenter, view, folder, told
):
    presenter.finish()
    assert told[-1][0] == "warning"
    for _ in range(3):
        fill_box(presenter)
        presenter.finish()
    assert told[-1][0] == "good"
    assert progress(view)[1].done == {0, 1, 2}
    images = LimbFolder(folder)
    assert len(images) == 3
    depth_m, labels, focal_px = images.read(0)
    assert focal_px == 60
    np.testing.assert_allclose(depth_m[labels == TORSO], 2.0)
    presenter.choose_label(0)
    presenter.click(25, 15)
    presenter.leave()
    assert progress(view)[1].begun == {2}
    assert len(LimbFolder(folder)) == 2, "what is worked on again is not trained on"


def test_labels_are_carried_to_where_the_limb_is_by_then(presenter, view, folder, told):
    fill_box(presenter)
    presenter.go(1)
    fill_box(presenter, HEAD)  # from now on the box counts as somebody here
    presenter.go(0)
    presenter.carry()
    assert progress(view)[0] == 1
    presenter.leave()
    wanted = np.zeros((HEIGHT, WIDTH), np.uint8)
    wanted[10:30, 21:41] = TORSO
    np.testing.assert_array_equal(kept(folder, 1), wanted)
    presenter.carry()
    assert "nobody was found" in told[-1][1]
    assert progress(view)[0] == 2
    assert kept(folder, 2) is None
    presenter.carry()
    assert progress(view)[0] == 2, "there is no next one"


def test_where_nobody_is_nothing_is_proposed_and_a_word_said(presenter, inline_jobs):
    presenter.propose()
    assert "Nobody was found" in str(inline_jobs.problems[-1])


@pytest.mark.parametrize("content", [b"", b"no picture"])
def test_damaged_labels_are_told_and_the_frame_before_stays(
    presenter, view, folder, inline_jobs, content
):
    fill_box(presenter)
    presenter.leave()
    (folder / "00001.draft.png").write_bytes(content)
    presenter.go(1)
    assert "00001.draft.png in box-limbs is damaged" in str(inline_jobs.problems[-1])
    assert progress(view)[0] == 0
    assert allowed(view).can_edit


def test_a_folder_of_another_recording_is_refused(presenter, folder, tmp_path):
    fill_box(presenter)
    presenter.leave()
    other = record_box(tmp_path / "other.mcap")

    with open_recording(other) as recording:
        with pytest.raises(LimbError, match=r"holds labels of box\.mcap"):
            LabellingDesk(recording, "other.mcap", folder)
        (folder / "progress.json").write_text("{")
        with pytest.raises(LimbError, match="damaged"):
            LabellingDesk(recording, "box.mcap", folder)


def test_what_cannot_be_labelled_is_refused_in_words_and_nothing_is_written(
    view, workspace, inline_jobs, tmp_path
):
    create_recording(tmp_path / "empty.mcap", INFO).close()
    sealed = SealedRecordings(tmp_path)
    writer = sealed.create("ab" * 16, bytes(32), INFO, RecordingOptions())
    writer.write(SensorFrame(0, 1, depth_raw=np.ones((HEIGHT, WIDTH), np.uint16)))
    writer.close()
    before = set(tmp_path.iterdir())
    presenter = LimbsPresenter(view, workspace)
    presenter.open(tmp_path / "empty.mcap")
    assert "empty.mcap has no frames" in str(inline_jobs.problems[-1])
    presenter.open(sealed.path_of("ab" * 16))
    assert "is sealed. Open the store" in str(inline_jobs.problems[-1])
    presenter.close()
    assert set(tmp_path.iterdir()) == before


@pytest.fixture
def stored(video):
    """A recording of the store, and what was logged of it."""
    logged = []
    return StoredRecording(
        "Monday, anterior", "ab12cd34", lambda: open_recording(video), lambda: logged.append(1)
    ), logged


def test_a_recording_of_the_store_is_labelled_where_the_reader_says_and_that_is_logged_and_told(
    view, workspace, stored, tmp_path, told
):
    presenter = LimbsPresenter(view, workspace)
    presenter.open_stored(stored[0])
    view.ask_folder.assert_called_once_with("Monday, anterior")
    assert not stored[1]
    presenter.choose_folder(tmp_path / "labels")
    assert stored[1] == [1]
    assert "not sealed" in told[-1][1]
    view.show_recording.assert_called_with("Monday, anterior", str(tmp_path / "labels"))
    presenter.set_beyond(is_on=True)
    fill_box(presenter)
    presenter.finish()
    presenter.close()
    assert len(LimbFolder(tmp_path / "labels")) == 1
    assert "ab12cd34" in (tmp_path / "labels" / "progress.json").read_text()
    assert "Monday" not in (tmp_path / "labels" / "progress.json").read_text()
    presenter.choose_folder(tmp_path / "again")
    assert not (tmp_path / "again").exists(), "a question is answered once"


def test_limbs_of_the_store_are_labelled_as_the_pictures_of_the_session_were_turned(
    view, workspace, stored, tmp_path, monkeypatch
):
    setups = []
    desk = limb_labelling.LabellingDesk

    def laid(recording, name, folder, setup):
        setups.append(setup)
        return desk(recording, name, folder, setup)

    monkeypatch.setattr(limb_labelling, "LabellingDesk", laid)
    presenter = LimbsPresenter(view, workspace)
    presenter.open_stored(replace(stored[0], rotation_deg=270))
    presenter.choose_folder(tmp_path / "labels")
    presenter.close()
    assert [setup.rotation_deg for setup in setups] == [270]


def test_a_recording_of_the_store_is_not_opened_where_that_cannot_be_logged(
    view, workspace, stored, tmp_path
):
    def cannot():
        raise FileError("the disk is full")

    presenter = LimbsPresenter(view, workspace)
    presenter.open_stored(replace(stored[0], note_export=cannot))
    presenter.choose_folder(tmp_path / "labels")
    view.show_recording.assert_not_called()
    assert not (tmp_path / "labels").exists()
    presenter.close()


def test_labels_that_are_done_outlive_a_disk_that_fails_before_their_draft_is_removed(
    presenter, view, workspace, video, folder, monkeypatch
):
    fill_box(presenter)
    presenter.leave()
    monkeypatch.setattr(limb_label_files, "remove_file", no_disk)
    presenter.finish()
    presenter.close()
    monkeypatch.undo()
    again = LimbsPresenter(view, workspace)
    again.open(video)
    assert progress(view)[1].done == {0}
    again.go(0)
    again.point(25, 15)
    view.show_under.assert_called_with("torso")
    again.close()
    assert (folder / "00000.labels.png").is_file()


def no_disk(_path):
    raise FileError("the disk is gone")


@pytest.fixture
def editor(qtbot, workspace, theme, video):
    """The editor as the menu of the behaviour screen opens it, with what is watched there."""
    screen = build_behaviour_screen(workspace, theme)
    qtbot.addWidget(screen)
    screen.resize(1200, 800)
    screen.show()
    screen.open_file(video)
    (action,) = [
        one for one in screen.findChildren(QAction) if one.text().startswith("Label limbs")
    ]
    action.trigger()
    yield screen.findChild(LimbsDialog)
    screen.closed()


def button(editor, text):
    (found,) = [one for one in editor.findChildren(QAbstractButton) if one.text() == text]
    return found


def test_a_limb_is_painted_with_the_mouse_and_kept_when_the_window_closes(editor, folder):
    button(editor, "Paint beside the person, too").click()
    editor.findChild(QListWidget).setCurrentRow(HEAD)
    picture = editor.findChild(PaintView)
    begin, end = (QPoint(*map(round, picture.placement.to_widget(u, 20))) for u in (10, 40))
    QTest.mousePress(picture, Qt.MouseButton.LeftButton, pos=begin)
    QTest.mouseMove(picture, end)
    QTest.mouseRelease(picture, Qt.MouseButton.LeftButton, pos=end)
    assert button(editor, "&Undo").isEnabled()
    button(editor, "Pol&ygon").click()
    for u, v in ((50, 40), (60, 40), (60, 46)):
        at = QPoint(*map(round, picture.placement.to_widget(u, v)))
        QTest.mouseClick(picture, Qt.MouseButton.LeftButton, pos=at)
    button(editor, "Fill the polygon").click()
    QTest.keyClick(picture, Qt.Key.Key_PageDown)
    assert editor.findChild(QProgressBar).maximum() == 3
    editor.close()
    labels = kept(folder, 0)
    assert labels[20, 25] == labels[41, 58] == HEAD


def test_the_editor_asks_before_it_closes_with_labels_that_cannot_be_kept(editor, folder):
    button(editor, "Paint beside the person, too").click()
    editor.page.presenter.click(25, 15)
    folder.write_text("a file in the place of the folder")
    close = editor.findChild(QDialogButtonBox).buttons()[0]
    close.click()
    assert editor.isVisible()
    box = editor.findChild(QMessageBox)
    (cancel,) = [one for one in box.buttons() if one.text() == "Cancel"]
    cancel.click()
    assert editor.isVisible()
    folder.unlink()
    close.click()
    assert not editor.isVisible()
    assert kept(folder, 0).any()


def test_the_editor_closes_once_it_is_said_that_the_labels_may_be_lost(editor, folder):
    button(editor, "Paint beside the person, too").click()
    editor.page.presenter.click(25, 15)
    folder.write_text("a file in the place of the folder")
    editor.findChild(QDialogButtonBox).buttons()[0].click()
    box = editor.findChild(QMessageBox)
    (lose,) = [one for one in box.buttons() if one.text() == "Close"]
    lose.click()
    assert not editor.isVisible()


@pytest.mark.usefixtures("large_letters")
@pytest.mark.parametrize("language", LANGUAGES)
def test_the_editor_has_a_letter_for_each_control_and_room_for_large_ones(
    qtbot, workspace, language
):
    with speaking(language):
        dialog = LimbsDialog(workspace)
        qtbot.addWidget(dialog)
        dialog.show()
        assert_each_letter_is_one_control(dialog)
        least = dialog.minimumSizeHint()
        assert least.width() <= 1280
        assert least.height() <= 800
        named = (QPushButton, QRadioButton, QListWidget, QProgressBar, PaintView)
        assert all(one.accessibleName() or hasattr(one, "text") for kind in named
                   for one in dialog.findChildren(kind))  # fmt: skip
        dialog.close()


@pytest.fixture(params=["workspace", "second_window"])
def either_window(request):
    """The workspace of the window that changes the store, or of one that may only read it."""
    return request.getfixturevalue(request.param)


def test_what_is_watched_out_of_the_store_is_labelled_and_the_log_says_so(
    qtbot, either_window, store, theme, video, tmp_path
):
    workspace = either_window
    patient = add_patient(store, Identity("Rosa Ibarra", None, "HC-77"))
    session = store.sessions.start(patient.pseudonym, SessionSetup())
    with (
        open_recording(video) as reader,
        store.recordings.create(session.session_id, INFO) as writer,
    ):
        for index in range(len(reader)):
            writer.write(reader.read(index))
    screen = build_behaviour_screen(workspace, theme)
    qtbot.addWidget(screen)
    screen.resize(1200, 800)
    screen.show()
    workspace.choose_patient(patient)
    workspace.choose_session(session)
    screen._presenter.open_stored(writer.recording_id)
    (action,) = [
        one for one in screen.findChildren(QAction) if one.text().startswith("Label limbs")
    ]
    action.trigger()
    dialog = screen.findChild(LimbsDialog)
    page = dialog.page
    asked = page.findChild(QFileDialog)
    assert asked.isVisible()
    asked.close()
    page.presenter.choose_folder(tmp_path / "labels")
    page.presenter.set_beyond(is_on=True)
    fill_box(page.presenter)
    page.presenter.finish()
    dialog.close()
    screen.closed()
    assert len(LimbFolder(tmp_path / "labels")) == 1
    (logged,) = [one for one in store.audit.entries() if one.action == "export"]
    assert (logged.subject, logged.detail) == (session.session_id, {"kind": "limb labels"})
    assert "Rosa" not in (tmp_path / "labels" / "progress.json").read_text()
