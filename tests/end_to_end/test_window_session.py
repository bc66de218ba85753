"""A whole session in the real main window, over recorded frames: by mouse, then by keyboard."""

import threading

import openpyxl
import pytest
from keyring.backends import fail
from pypdf import PdfReader
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

import ui.capture.presenter as capture
import ui.markers.presenter as learner
import ui.reports.presenter as reports
from adibas import sessions
from adibas.measures.geometry_tables import all_distances
from adibas.recordings import create_recording
from adibas.sessions.captures import Captures
from adibas.simulation.scenes import open_scene
from tests.ui import conftest as rules
from tests.ui import window_user
from tests.ui.window_user import ALT, CTRL, LEFT, NO_KEY, SHIFT, at, drag, visible
from tests.unit.store_samples import use_keyring
from ui.widgets.image_view import ImageView

N_FRAMES = 6
N_CLICKS = 3
DRAG_PX = 3.0
"""Of the picture: a mouse stops at whole pixels of the window, two of the picture."""
LEAST_MARKERS = 8
VIEWS = ["anterior", "posterior", "right_lateral", "left_lateral"]
HEAVY = {
    "LearningBoard",
    "open_store",
    "picture",
    "stored_report",
    "surface",
    "take_capture",
    "write_session_reports",
}
Key = Qt.Key

nothing_left_behind = rules.nothing_left_behind
open_window = window_user.open_window


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Return a recording of the simulated patient seen from the front, and its visible markers."""
    scene = open_scene("anterior", color_size=(1024, 1280))
    path = tmp_path_factory.mktemp("recorded") / "front.mcap"
    with create_recording(path, scene.info) as writer:
        frames = [scene.frame(index) for index in range(N_FRAMES)]
        for frame in frames:
            writer.write(frame.sensor_frame)
    seen = [one for one in frames[-1].truth.markers if one.is_visible]
    return path, sorted(seen, key=lambda one: one.view_angle_rad)


@pytest.fixture(autouse=True)
def no_keyring(monkeypatch):
    use_keyring(monkeypatch, fail.Keyring())


@pytest.fixture
def heavy_threads(monkeypatch):
    """Note in which threads the heavy calls of the core run."""
    noted = {}

    def watch(owner, name):
        whole = getattr(owner, name)

        def noting(*args, **named):
            noted.setdefault(name, set()).add(threading.current_thread())
            return whole(*args, **named)

        monkeypatch.setattr(owner, name, noting)

    watch(capture, "take_capture")
    watch(reports, "write_session_reports")
    watch(reports, "stored_report")
    watch(learner, "LearningBoard")
    watch(Captures, "picture")
    watch(Captures, "surface")
    watch(sessions, "open_store")
    return noted


def rows_of(workbook, title):
    header, *rows = workbook[title].iter_rows(values_only=True)
    return [dict(zip(header, row, strict=True)) for row in rows]


def distances_mm(store, capture_id):
    """Return all distances of a capture as the core measures its markers now."""
    markers = store.captures.get(capture_id).markers()
    return {(d.a, d.b): 1000 * d.value_m for d in all_distances(markers)}


def distances_by_capture(user):
    session = user.store.sessions.get(user.workspace.session.session_id)
    return {one: distances_mm(user.store, one) for one in session.capture_ids}


def add_patient(user):
    """Type a new patient and a consent, and start a session, without the mouse."""
    user.key(Key.Key_N, CTRL)
    for text in ("Rosa Ibarra", "3/4/1971", "HC-77"):
        user.keys(text)
        user.key(Key.Key_Tab)
    user.tab_to_button("Save")
    user.key(Key.Key_Space)
    assert user.workspace.patient.identity.name == "Rosa Ibarra"
    for button in ("Start a session", "Save the consent", "Start a session"):
        user.tab_to_button(button)
        user.key(Key.Key_Space)
    assert user.window.shown == "capture"


def learn(user, seen):
    """Freeze the live picture and click on some of the markers that are seen."""
    user.click("Learn the marker colour")
    assert user.window.shown == "markers"
    user.until(lambda: user.button("Freeze").isEnabled())
    user.click("Freeze")
    user.settle()
    picture = user.screen.findChild(ImageView)
    for marker in seen[:N_CLICKS]:
        QTest.mouseClick(picture, LEFT, NO_KEY, at(picture, marker.u, marker.v))
        user.settle()
    user.click("Use these markers")
    assert user.window.shown == "capture"


def take_views(user, press):
    """Capture the four views; `press` presses the button."""
    for number in range(1, len(VIEWS) + 1):
        press()
        user.until(lambda number=number: len(user.workspace.session.capture_ids) == number)
        user.settle()
    captures = user.store.captures.of_session(user.workspace.session.session_id)
    assert [one.view for one in captures] == VIEWS
    assert all(len(one.detected) >= LEAST_MARKERS for one in captures)


def correct_by_mouse(user):
    """Drag a marker, undo that, and drag it again; return the distances of all captures."""
    user.go_to("review")
    user.settle()
    chosen = user.workspace.capture_id
    marker = user.store.captures.get(chosen).markers()[0]
    picture = visible(user.screen, ImageView)[0]
    here, there = (marker.u, marker.v), (marker.u + 60.0, marker.v + 25.0)

    def place():
        first = user.store.captures.get(chosen).markers()[0]
        return first.u, first.v

    before = distances_by_capture(user)
    drag(picture, here, there, ALT)
    assert place() == pytest.approx(there, abs=DRAG_PX)
    user.key(Key.Key_Z, CTRL)
    assert place() == here
    assert distances_by_capture(user) == before
    drag(picture, here, there, ALT)
    assert place() == pytest.approx(there, abs=DRAG_PX)
    user.settle()
    after = distances_by_capture(user)
    assert after != before
    return after


def point_by_keys(user, picture, target):
    """Move the cross to a pixel with the arrows, and click there."""
    places = []
    picture.pointed.connect(lambda u, v: places.append((u, v)))
    user.key(Key.Key_Right)
    for axis, (back, forth) in enumerate(
        ((Key.Key_Left, Key.Key_Right), (Key.Key_Up, Key.Key_Down))
    ):
        while abs(gap := target[axis] - places[-1][axis]) > 0.5:
            user.key(forth if gap > 0 else back, SHIFT if abs(gap) > 10 else NO_KEY)
    user.key(Key.Key_Space)


def learn_by_keys(user, seen):
    user.tab_to_button("Learn the marker colour")
    user.key(Key.Key_Space)
    user.until(lambda: user.button("Freeze").isEnabled())
    user.tab_to_button("Freeze")
    user.key(Key.Key_Space)
    user.settle()
    picture = user.tab_to(lambda one: isinstance(one, ImageView))
    for marker in seen[:N_CLICKS]:
        point_by_keys(user, picture, (marker.u, marker.v))
        user.settle()
    user.tab_to_button("Use these markers")
    user.key(Key.Key_Space)
    assert user.window.shown == "capture"


def correct_by_keys(user):
    """Nudge a marker, undo, redo; return the distances of all captures."""
    user.key(Key.Key_4, CTRL)
    user.until(lambda: user.window.shown == "review")
    user.settle()
    before = distances_by_capture(user)
    user.tab_to(lambda one: one.accessibleName() == "Markers")
    user.key(Key.Key_Down)
    user.tab_to(lambda one: isinstance(one, ImageView))
    for _step in range(3):
        user.key(Key.Key_Left, SHIFT)
    after = distances_by_capture(user)
    assert after != before
    for _step in range(3):
        user.key(Key.Key_Z, CTRL)
    assert distances_by_capture(user) == before
    for _step in range(3):
        user.key(Key.Key_Z, CTRL | SHIFT)
    assert distances_by_capture(user) == after
    user.settle()
    return after


def report_by_keys(user, folder):
    user.key(Key.Key_5, CTRL)
    user.until(lambda: user.window.shown == "reports")
    user.settle()
    user.tab_to_button("PDF to print")
    user.key(Key.Key_Space)
    user.tab_to_button("Write the report...")
    user.key(Key.Key_Space)
    folder.mkdir()
    user.answer_file_dialog(folder)
    user.until(lambda: user.window.told.startswith("2 files are written"))


def check_report(folder, corrected, pseudonym):
    """Hold workbook and PDF against what the store keeps after the corrections."""
    (workbook,), (pdf,) = folder.glob("*.xlsx"), folder.glob("*.pdf")
    rows = rows_of(openpyxl.load_workbook(workbook), "Distances")
    written = {(row["View"], row["A"], row["B"]): row["Distance [mm]"] for row in rows}
    kept = {
        (view.replace("_", " "), *pair): value
        for view, distances in zip(VIEWS, corrected.values(), strict=True)
        for pair, value in distances.items()
    }
    assert written == pytest.approx(kept, abs=1e-9)
    text = "\n".join(page.extract_text() for page in PdfReader(pdf).pages)
    assert pseudonym in text
    assert "Ibarra" not in text
    changed = max(corrected[list(corrected)[-1]].values())
    assert f"{changed:.1f}" in text


def reopen_and_look(user):
    """Unlock, search the patient and open the session by keys; return all distances."""
    user.give_passphrase()
    user.until(lambda: user.window.shown)
    assert "Ibarra" not in user.window.windowTitle()
    user.keys("ibarra")
    user.key(Key.Key_Down)
    assert user.workspace.patient.identity.record_number == "HC-77"
    user.tab_to(lambda one: one.accessibleName() == "Sessions of this patient")
    user.key(Key.Key_Down)
    user.key(Key.Key_Return)
    user.until(lambda: user.window.shown == "review")
    user.settle()
    return distances_by_capture(user)


def test_from_the_first_start_to_a_report_by_mouse(
    open_window, tmp_path, recorded, heavy_threads, caplog
):
    recording, seen = recorded
    user = open_window()
    user.give_new_passphrase()
    assert [row.identity.name for row in user.store.patients.search("")] == ["Demo patient"]
    add_patient(user)
    assert user.drop(recording)
    user.until(lambda: user.workspace.live.newest is not None)
    learn(user, seen)
    take_views(user, lambda: user.click("Capture this view"))
    corrected = correct_by_mouse(user)
    user.go_to("reports")
    user.settle()
    user.click("PDF to print")
    user.click("Write the report...")
    (tmp_path / "out").mkdir()
    user.answer_file_dialog(tmp_path / "out")
    user.until(lambda: user.window.told.startswith("2 files are written"))
    pseudonym = user.workspace.patient.pseudonym
    user.close()
    check_report(tmp_path / "out", corrected, pseudonym)

    again = open_window()
    assert reopen_and_look(again) == corrected
    again.close()
    assert set(heavy_threads) == HEAVY
    for name, threads in heavy_threads.items():
        assert threading.main_thread() not in threads, f"{name} runs in the window's thread"
    assert not [record for record in caplog.records if record.levelname == "CRITICAL"]


def test_from_the_first_start_to_a_report_by_keyboard_alone(
    open_window, tmp_path, recorded, caplog
):
    recording, seen = recorded
    user = open_window()
    user.give_new_passphrase()
    add_patient(user)
    user.tab_to_button("Recording...")
    user.key(Key.Key_Space)
    user.answer_file_dialog(recording)
    user.until(lambda: user.workspace.live.newest is not None)
    learn_by_keys(user, seen)

    def press_capture():
        user.tab_to_button("Capture this view")
        user.key(Key.Key_Space)

    take_views(user, press_capture)
    corrected = correct_by_keys(user)
    report_by_keys(user, tmp_path / "out")
    pseudonym = user.workspace.patient.pseudonym
    user.key(Key.Key_Q, CTRL)
    user.until(lambda: not user.window.isVisible())
    check_report(tmp_path / "out", corrected, pseudonym)
    again = open_window()
    assert reopen_and_look(again) == corrected
    again.close()
    assert not [record for record in caplog.records if record.levelname == "CRITICAL"]
