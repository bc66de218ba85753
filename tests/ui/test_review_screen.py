"""The review screen through its widgets: mouse, keyboard, undo, a restart."""

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import (
    QApplication,
    QComboBox,
    QLabel,
    QLineEdit,
    QListWidget,
    QPlainTextEdit,
    QPushButton,
    QTableView,
    QToolBar,
)

from adibas.data.markers import AutomaticName
from adibas.sessions import open_store
from adibas.texts import use_language
from tests.ui.conftest import PASSPHRASE, NoSensor
from tests.ui.disc_samples import discs_at
from tests.ui.review_scene import (
    DOTS,
    REFUSED,
    UNNOTICED,
    detected,
    mm_between,
    places,
    saved_session,
)
from ui.jobs import JobRunner
from ui.review.content import MeasureRow, Points
from ui.review.drawing import overlays_of
from ui.review.markers_model import MarkersModel
from ui.review.measures_model import INTERVAL, KIND, NAME, VALUE, MeasuresModel
from ui.review.screen import build_review_screen
from ui.widgets.image_view import ImageView
from ui.widgets.overlays import Curve, Dot, Line
from ui.widgets.space import Space
from ui.widgets.space_view import SpaceView
from ui.workspace import Workspace

LEFT = Qt.MouseButton.LeftButton
ALT, SHIFT = Qt.KeyboardModifier.AltModifier, Qt.KeyboardModifier.ShiftModifier
CTRL, NO_KEY = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.NoModifier


class User:
    """Somebody at the screen."""

    def __init__(self, qtbot, screen):
        self.qtbot, self.screen = qtbot, screen
        self.image = screen.findChild(ImageView)
        self.tables = screen.findChildren(QTableView)

    @property
    def markers(self):
        return next(t for t in self.tables if t.accessibleName() == "Markers")

    @property
    def chosen(self):
        return next(t for t in self.tables if t.accessibleName() == "Chosen measures")

    @property
    def all(self):
        return next(t for t in self.tables if t.accessibleName() == "All measures")

    def place(self, u, v):
        QApplication.processEvents()  # a hint that just came may move the picture
        x, y = self.image.placement.to_widget(u, v)
        return QPoint(round(x), round(y))

    def click(self, u, v, keys=NO_KEY):
        self.qtbot.mouseClick(self.image, LEFT, keys, self.place(u, v))

    def drag(self, start, end, keys=NO_KEY):
        here, there = self.place(*start), self.place(*end)
        self.qtbot.mousePress(self.image, LEFT, keys, here)
        self.qtbot.mouseMove(self.image, (here + there) / 2)
        self.qtbot.mouseMove(self.image, there)
        self.qtbot.mouseRelease(self.image, LEFT, keys, there)

    def key(self, key, modifiers=NO_KEY):
        self.qtbot.keyClick(QApplication.focusWidget() or self.screen, key, modifiers)

    def tool(self, name):
        return self.screen.findChild(QToolBar).action_named(name)

    def button(self, text):
        return next(b for b in self.screen.findChildren(QPushButton) if b.text() == text)

    def lines(self, table):
        model = table.model()
        return [
            [model.index(row, column).data() for column in range(model.columnCount())]
            for row in range(model.rowCount())
        ]

    def names(self):
        return [line[0] for line in self.lines(self.markers)]


def shown(qtbot, workspace, theme):
    screen = build_review_screen(workspace, theme)
    qtbot.addWidget(screen, before_close_func=lambda one: one.closed())
    screen.resize(1180, 720)
    screen.show()
    screen.activateWindow()
    screen.entered()
    user = User(qtbot, screen)
    user.image.setFocus()
    qtbot.waitUntil(screen.isActiveWindow)
    return user


@pytest.fixture
def saved(store):
    return saved_session(store, ("anterior", "posterior"))


@pytest.fixture
def user(qtbot, workspace, theme, saved):
    workspace.choose_patient(saved[0])
    workspace.choose_session(saved[1])
    return shown(qtbot, workspace, theme)


@pytest.fixture
def capture(store, saved):
    return lambda: store.captures.get(saved[2][0].capture_id)


def test_a_point_is_dragged_undone_and_redone(user, capture):
    user.drag(DOTS["m01"], (200.0, 120.0), ALT)
    moved = places(capture())["m01"]
    assert moved == pytest.approx((200.0, 120.0), abs=0.5)
    user.key(Qt.Key.Key_Z, CTRL)
    assert places(capture())["m01"] == DOTS["m01"]
    user.key(Qt.Key.Key_Z, CTRL | SHIFT)
    assert places(capture())["m01"] == moved


def test_a_correction_can_be_undone_after_a_restart(qtbot, user, store, workspace, theme):
    user.drag(DOTS["m01"], (200.0, 120.0), ALT)
    user.screen.hide()
    session_id, folder = workspace.session.session_id, store.folder
    store.close()
    with open_store(folder, PASSPHRASE) as again:
        later = Workspace(again, workspace.jobs, workspace.preferences, NoSensor())
        later.choose_session(again.sessions.get(session_id))
        second = shown(qtbot, later, theme)
        assert second.lines(second.markers)[0][4] == "corrected by hand"
        second.key(Qt.Key.Key_Z, CTRL)
        assert places(again.captures.of_session(session_id)[0]) == DOTS


def test_a_point_dropped_near_a_blob_snaps_unless_alt_is_held(user, capture):
    near = (UNNOTICED[0] + 4, UNNOTICED[1] + 4)
    user.drag(DOTS["m01"], near)
    assert places(capture())["m01"] == pytest.approx(UNNOTICED, abs=0.3)
    for label, keys in (("m02", ALT), ("m03", CTRL)):
        user.drag(DOTS[label], near, keys)
        assert places(capture())[label] == pytest.approx(near, abs=0.5)
        user.key(Qt.Key.Key_Z, CTRL)


def test_a_point_of_a_picture_that_is_turned_upright_is_dragged(qtbot, workspace, theme, store):
    _patient, session, captures = saved_session(store, rotation_deg=90)
    workspace.choose_session(session)
    user = shown(qtbot, workspace, theme)
    assert user.image.placement.rotation_deg == 90
    user.drag(DOTS["m01"], (200.0, 120.0), ALT)
    moved = places(store.captures.get(captures[0].capture_id))["m01"]
    assert moved == pytest.approx((200.0, 120.0), abs=0.5)
    user.click(*DOTS["m03"])
    user.key(Qt.Key.Key_Right)  # to the right of what is seen: up in the picture
    nudged = places(store.captures.get(captures[0].capture_id))["m03"]
    assert nudged == (DOTS["m03"][0], DOTS["m03"][1] - 1)
    icon = user.screen.findChild(QListWidget).item(0).icon().availableSizes()[0]
    assert icon.height() > icon.width()


def test_nothing_is_saved_while_the_mouse_is_down(qtbot, user, capture):
    qtbot.mousePress(user.image, LEFT, NO_KEY, user.place(*DOTS["m01"]))
    qtbot.mouseMove(user.image, user.place(150.0, 100.0))
    qtbot.mouseMove(user.image, user.place(160.0, 110.0))
    assert places(capture()) == DOTS
    assert user.lines(user.markers)[0][1] != ""
    user.key(Qt.Key.Key_Escape)
    qtbot.mouseRelease(user.image, LEFT, NO_KEY, user.place(160.0, 110.0))
    assert places(capture()) == DOTS


@pytest.mark.qt_log_ignore("This plugin does not support")  # a list of suggestions drops down
def test_points_are_added_deleted_and_renamed_with_keys(qtbot, user, capture):
    user.key(Qt.Key.Key_A)
    user.click(*UNNOTICED)
    assert user.names() == ["m01", "m02", "m03", "m04"]
    user.key(Qt.Key.Key_Delete)
    assert user.names() == ["m01", "m02", "m03"]
    user.key(Qt.Key.Key_Escape)
    user.click(*DOTS["m02"])
    user.key(Qt.Key.Key_F2)
    editor = user.markers.findChild(QLineEdit)
    editor.selectAll()
    qtbot.keyClicks(editor, "Left acromion")
    qtbot.keyClick(editor, Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: user.names() == ["m01", "Left acromion", "m03"])
    assert list(places(capture())) == ["m01", "Left acromion", "m03"]


def test_landmarks_are_named_one_after_the_other_by_clicks(qtbot, workspace, theme, store):
    _patient, session, captures = saved_session(store, protocol="sapo-1")
    workspace.choose_session(session)
    user = shown(qtbot, workspace, theme)
    qtbot.waitUntil(user.tool("name-next").isEnabled)
    user.key(Qt.Key.Key_N)
    hints = [one.text() for one in user.screen.findChildren(QLabel)]
    assert any(text.startswith("Click Glabella") for text in hints)
    user.click(*DOTS["m01"])
    user.key(Qt.Key.Key_N)  # the right tragus is not seen: on to the next landmark
    user.click(*DOTS["m02"])
    user.click(*UNNOTICED)  # where no marker was found
    assert user.names() == ["Glabella", "Tragus, left", "m03", "Menton"]
    named = places(store.captures.get(captures[0].capture_id))
    assert list(named) == ["glabella", "left_tragus", "m03", "menton"]
    assert named["menton"] == pytest.approx(UNNOTICED, abs=0.3)
    user.key(Qt.Key.Key_Z, CTRL)
    assert user.names() == ["Glabella", "Tragus, left", "m03"]


def test_a_name_that_no_measure_of_this_view_uses_is_told(qtbot, workspace, theme, store):
    _patient, session, _captures = saved_session(store, protocol="sapo-1")
    workspace.choose_session(session)
    user = shown(qtbot, workspace, theme)
    qtbot.waitUntil(user.tool("name-next").isEnabled)
    told = []
    workspace.noticed.subscribe(lambda *notice: told.append(notice))
    points = user.screen._presenter.points
    points.rename("m01", "glabella")
    assert told == []
    points.rename("m02", "c7")
    ((kind, sentence),) = told
    assert kind == "warning"
    assert sentence.startswith("c7 is no landmark of this protocol in this view")


def test_a_model_is_asked_for_the_other_names_by_a_key(qtbot, workspace, theme, store, inline_jobs):
    _patient, session, _captures = saved_session(store, protocol="sapo-1")
    workspace.choose_session(session)
    user = shown(qtbot, workspace, theme)
    qtbot.waitUntil(user.tool("name-others").isEnabled)
    user.key(Qt.Key.Key_N, Qt.KeyboardModifier.ShiftModifier)
    (problem,) = inline_jobs.problems
    assert "No model knows the landmarks of this protocol" in str(problem)
    for label in ("m01", "m02", "m03"):
        user.screen._presenter.points.rename(label, f"scar {label}")
    assert not user.tool("name-others").isEnabled()


def test_without_a_protocol_no_landmark_is_next(qtbot, user):
    qtbot.waitUntil(user.tool("add-marker").isEnabled)
    assert not user.tool("name-next").isEnabled()
    assert not user.tool("name-others").isEnabled()


def test_the_bones_between_joints_are_drawn(qtbot, user):
    qtbot.waitUntil(user.tool("add-marker").isEnabled)
    points = user.screen._presenter.points
    points.rename("m01", "left_elbow")
    points.rename("m02", "left_hand")
    (bone,) = [one for one in user.image._overlays if isinstance(one, Line)]
    assert bone.role == "bone"
    assert {(bone.u1, bone.v1), (bone.u2, bone.v2)} == {DOTS["m01"], DOTS["m02"]}


@pytest.mark.qt_log_ignore("This plugin does not support")  # a list of suggestions drops down
def test_a_joint_is_named_in_the_readers_language_and_kept_under_its_own_name(qtbot, user, capture):
    user.click(*DOTS["m02"])
    user.key(Qt.Key.Key_F2)
    editor = user.markers.findChild(QLineEdit)
    editor.selectAll()
    qtbot.keyClicks(editor, "Left hand")
    qtbot.keyClick(editor, Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: user.names() == ["m01", "Left hand", "m03"])
    assert list(places(capture())) == ["m01", "left_hand", "m03"]


def test_landmarks_are_suggested_as_a_name_is_typed(qtbot, user):
    user.click(*DOTS["m02"])
    user.key(Qt.Key.Key_F2)
    editor = user.markers.findChild(QLineEdit)
    qtbot.keyClicks(editor, "")
    completer = editor.completer()
    completer.setCompletionPrefix("patel")
    assert completer.completionCount() == 2
    assert editor.maxLength() == 40
    qtbot.keyClick(editor, Qt.Key.Key_Escape)
    assert user.names() == ["m01", "m02", "m03"]


def test_arrows_move_the_chosen_point(user, capture):
    user.click(*DOTS["m03"])
    user.key(Qt.Key.Key_Right)
    user.key(Qt.Key.Key_Down, SHIFT)
    user.key(Qt.Key.Key_Down, CTRL)
    u, v = DOTS["m03"]
    assert places(capture())["m03"] == (u + 1, v + 10.1)
    assert len(capture().history.corrections) == 3


def test_list_and_picture_choose_the_same_point(user):
    user.click(*DOTS["m03"])
    assert user.markers.currentIndex().row() == 2
    user.markers.setFocus()
    user.key(Qt.Key.Key_Up)
    selected = [dot for dot in drawn(user, Dot) if dot.role == "selected"]
    assert [dot.label for dot in selected] == ["m02"]
    user.image.setFocus()
    user.key(Qt.Key.Key_Escape)
    assert not user.markers.currentIndex().isValid()


def drawn(user, kind):
    return [one for one in user.image._overlays if isinstance(one, kind)]


def test_a_distance_and_an_angle_are_clicked_and_drawn_with_their_values(user):
    user.key(Qt.Key.Key_D)
    user.click(*DOTS["m01"])
    user.click(*DOTS["m02"])
    user.key(Qt.Key.Key_G)
    for name in ("m01", "m02", "m03"):
        user.click(*DOTS[name])
    expected = f"{mm_between(DOTS['m01'], DOTS['m02']):.1f} mm"
    lines = user.lines(user.chosen)
    assert [line[:2] for line in lines] == [
        ["Distance", "m01 \u2013 m02"],
        ["Angle", "m01 \u2013 m02 \u2013 m03"],
    ]
    assert lines[0][2] == expected
    assert expected in [line.text for line in drawn(user, Line)]
    assert [curve.text for curve in drawn(user, Curve)] == [lines[1][2]]
    assert lines[1][2].endswith("\u00b0")
    user.chosen.setFocus()
    user.chosen.selectRow(0)
    user.key(Qt.Key.Key_Delete)
    assert len(user.lines(user.chosen)) == 1
    assert user.names() == ["m01", "m02", "m03"]


def test_a_distance_is_measured_with_the_keyboard_alone(user):
    user.key(Qt.Key.Key_D)
    user.markers.setFocus()
    user.key(Qt.Key.Key_Down)
    user.key(Qt.Key.Key_Return)
    user.key(Qt.Key.Key_Down)
    user.key(Qt.Key.Key_Return)
    assert len(user.lines(user.chosen)) == 1


def test_measures_follow_a_drag(qtbot, user):
    user.key(Qt.Key.Key_D)
    user.click(*DOTS["m01"])
    user.click(*DOTS["m02"])
    user.key(Qt.Key.Key_M)
    before = user.lines(user.chosen)[0][2], user.lines(user.all)[0][2]
    qtbot.mousePress(user.image, LEFT, NO_KEY, user.place(*DOTS["m01"]))
    qtbot.mouseMove(user.image, user.place(150.0, 100.0))
    qtbot.mouseMove(user.image, user.place(160.0, 110.0))
    during = user.lines(user.chosen)[0][2], user.lines(user.all)[0][2]
    assert before[0] == before[1] != during[0] == during[1]
    qtbot.mouseRelease(user.image, LEFT, NO_KEY, user.place(160.0, 110.0))


def test_all_measures_are_filtered_and_kept(qtbot, user):
    assert len(user.lines(user.all)) == 6
    named = {edit.accessibleName(): edit for edit in user.screen.findChildren(QLineEdit)}
    text = named["Show only measures of these markers"]
    qtbot.keyClicks(text, "M02 m03")
    assert {line[1] for line in user.lines(user.all)} >= {"m02 \u2013 m03"}
    user.screen.findChild(QComboBox).setCurrentIndex(1)
    assert [line[1] for line in user.lines(user.all)] == ["m02 \u2013 m03"]
    user.all.selectRow(0)
    user.all.setFocus()
    user.key(Qt.Key.Key_Return)
    assert [line[1] for line in user.lines(user.chosen)] == ["m02 \u2013 m03"]
    user.chosen.selectRow(0)
    user.button("Remove").click()
    assert user.lines(user.chosen) == []
    assert not user.button("Remove").isEnabled()


def test_refused_blobs_say_why_and_become_markers_by_a_click(user, capture):
    user.tool("refused").trigger()
    dots = [dot for dot in drawn(user, Dot) if dot.role == "rejected"]
    assert REFUSED.reason in dots[0].tooltip
    user.click(REFUSED.u, REFUSED.v)
    assert places(capture())["m04"] == (REFUSED.u, REFUSED.v)
    assert not [dot for dot in drawn(user, Dot) if dot.role == "rejected"]


def test_the_strip_opens_another_capture(user, workspace, saved):
    strip = user.screen.findChild(QListWidget)
    assert [strip.item(row).text() for row in range(2)] == ["Front\n3 markers", "Back\n3 markers"]
    strip.setFocus()
    user.key(Qt.Key.Key_Down)
    assert workspace.capture_id == saved[2][1].capture_id
    user.image.setFocus()
    user.click(*DOTS["m01"])
    user.key(Qt.Key.Key_Delete)
    assert strip.item(1).text() == "Back\n2 markers\ncorrected"


def test_notes_are_saved_when_the_field_or_the_screen_is_left(qtbot, user, store, saved):
    notes = user.screen.findChild(QPlainTextEdit)
    notes.parent().parent().parent().setCurrentIndex(1)
    notes.setFocus()
    qtbot.keyClicks(notes, "Leans left")
    user.markers.setFocus()
    qtbot.keyClicks(notes, ".")
    user.screen.left()
    assert store.sessions.get(saved[1].session_id).notes == "Leans left."


def test_undo_in_the_notes_is_of_the_notes(qtbot, user, capture):
    user.click(*DOTS["m01"])
    user.key(Qt.Key.Key_Delete)
    notes = user.screen.findChild(QPlainTextEdit)
    notes.parent().parent().parent().setCurrentIndex(1)
    notes.setFocus()
    qtbot.keyClicks(notes, "abc")
    qtbot.keyClick(notes, Qt.Key.Key_Z, CTRL)
    assert notes.toPlainText() == ""
    assert "m01" not in places(capture())


def test_the_surface_is_turned_and_the_picture_comes_back(qtbot, user):
    user.tool("space").trigger()
    space = user.screen.findChild(SpaceView)
    assert space.hasFocus()
    before = space.grab().toImage()
    for key in (Qt.Key.Key_Left, Qt.Key.Key_Down, Qt.Key.Key_Plus, Qt.Key.Key_Minus, Qt.Key.Key_0):
        qtbot.keyClick(space, key)
        after = space.grab().toImage()
        assert after != before
        before = after
    qtbot.mousePress(space, LEFT, NO_KEY, QPoint(50, 50))
    qtbot.mouseMove(space, QPoint(90, 70))
    qtbot.mouseRelease(space, LEFT, NO_KEY, QPoint(90, 70))
    assert space.grab().toImage() != before
    for name in ("zoom-in", "fit", "zoom-out"):
        before = space.grab().toImage()
        user.tool(name).trigger()
        assert space.grab().toImage() != before
    assert user.image.placement.zoom == 1.0
    assert any("turn the surface" in one.text() for one in user.screen.findChildren(QLabel))
    before = space.grab().toImage()
    user.screen._markers.chosen.emit("m01")
    user.key(Qt.Key.Key_Delete)
    assert space.grab().toImage() != before
    user.tool("space").trigger()
    assert user.image.isVisible()


def test_a_read_only_store_is_looked_at(
    qtbot, theme, read_only_store, inline_jobs, preferences, saved
):
    workspace = Workspace(read_only_store, inline_jobs, preferences, NoSensor())
    workspace.choose_session(saved[1])
    user = shown(qtbot, workspace, theme)
    user.drag(DOTS["m01"], (200.0, 120.0))
    user.click(*DOTS["m02"])
    assert user.markers.currentIndex().row() == 1
    for name in ("add-marker", "undo", "delete", "rename", "distance"):
        assert not user.tool(name).isEnabled()
    assert places(read_only_store.captures.of_session(saved[1].session_id)[0]) == DOTS
    assert any("read only" in one.text() for one in user.screen.findChildren(QLabel))


def test_without_a_session_there_is_a_way_to_one(qtbot, workspace, theme):
    user = shown(qtbot, workspace, theme)
    wanted = []
    workspace.screen_wanted.subscribe(wanted.append)
    user.button("Go to Patients").click()
    assert wanted == ["patients"]
    use_language("es")
    try:
        user.screen.retranslate()
        assert not [one for one in user.screen.findChildren(QLabel) if "session" in one.text()]
    finally:
        use_language("en")


def test_all_that_can_be_used_has_a_name_and_a_key(user):
    bar = user.screen.findChild(QToolBar)
    for action in bar.actions():
        if not action.isSeparator():
            button = bar.widgetForAction(action)
            assert button.accessibleName()
            assert button.focusPolicy() & Qt.FocusPolicy.TabFocus
            assert "(" in action.toolTip()
    for widget in (user.image, *user.tables, user.screen.findChild(QListWidget)):
        assert widget.accessibleName()


def test_the_screen_speaks_another_language_at_once(user):
    model = user.markers.model()
    use_language("es")
    try:
        user.screen.retranslate()
        assert user.tool("undo").text() == "Deshacer"
        assert user.tool("undo").shortcut().toString() == "Ctrl+Z"
        assert model.headerData(0, Qt.Orientation.Horizontal) == "Marcador"
    finally:
        use_language("en")


def test_reading_happens_beside_the_window(qtbot, store, preferences, theme, saved, monkeypatch):
    import threading

    threads = []
    for name in ("picture", "surface"):
        read = getattr(store.captures, name)

        def spy(capture_id, read=read):
            threads.append(threading.current_thread())
            return read(capture_id)

        monkeypatch.setattr(store.captures, name, spy)
    jobs = JobRunner(lambda error: pytest.fail(str(error)))
    workspace = Workspace(store, jobs, preferences, NoSensor())
    workspace.choose_session(saved[1])
    user = shown(qtbot, workspace, theme)
    qtbot.waitUntil(lambda: user.tool("add-marker").isEnabled(), timeout=20_000)
    qtbot.waitUntil(lambda: not jobs.is_busy, timeout=20_000)
    jobs.close()
    assert len(threads) == 2
    assert threading.main_thread() not in threads


def test_an_arc_goes_the_shorter_way_round_its_vertex(user):
    points = Points(
        markers=user.screen._points.markers,
        measures=(MeasureRow(("m01", "m03", "m02"), 90.0, (89.0, 91.0)),),
    )
    arc = next(one for one in overlays_of(points) if isinstance(one, Curve))
    vertex = np.array(DOTS["m03"])
    radii = np.linalg.norm(np.array(arc.points) - vertex, axis=1)
    np.testing.assert_allclose(radii, radii[0])
    assert max(v for _u, v in arc.points) < DOTS["m03"][1]  # both arms go up


def test_the_list_says_which_names_the_program_gave_and_how_sure_it_was(theme, qtmodeltester):
    first, second, third = detected()
    named = replace(first, label="neck", named_by=AutomaticName("model of May", 0.936))
    moved = replace(second, label="head", named_by=AutomaticName("model of May", 0.5))
    model = MarkersModel(theme)
    model.show_points(Points(markers=(named, moved, third), by_hand=frozenset({"head"})))
    assert model.texts() == [
        ("Neck", "named automatically, 93 %"),
        ("Head", "corrected by hand; named automatically, 50 %: please check"),
        ("m03", ""),
    ]
    qtmodeltester.check(model)


def test_thousands_of_measures_are_sorted_by_what_is_seen(qtmodeltester):
    rows = [
        MeasureRow(("a", "b"), 12.0, (10.0, 14.0)),
        MeasureRow(("a", "c"), 7.0, (6.5, 7.5)),
        MeasureRow(("b", "a", "c"), 90.0, (80.0, 95.0)),
        MeasureRow(("b", "c")),
    ]
    model = MeasuresModel()
    qtmodeltester.check(model)
    model.show_rows(tuple(rows))
    qtmodeltester.check(model)

    def names():
        return [model.measure(row).labels for row in range(model.rowCount())]

    model.sort(VALUE)
    assert names() == [("b", "c"), ("a", "c"), ("a", "b"), ("b", "a", "c")]
    model.sort(INTERVAL, Qt.SortOrder.DescendingOrder)
    assert names() == [("b", "a", "c"), ("a", "b"), ("a", "c"), ("b", "c")]
    model.sort(NAME, Qt.SortOrder.DescendingOrder)
    assert names()[0] == ("b", "a", "c")
    model.sort(KIND)
    assert names()[-1] == ("b", "a", "c")
    model.sort(-1)
    model.filter("B", is_angle=False)
    assert names() == [("a", "b"), ("b", "c")]
    assert model.index(1, VALUE).data() == "\u2013"


def test_points_of_the_surface_are_painted_where_they_project(qtbot):
    view = SpaceView()
    qtbot.addWidget(view)
    view.resize(200, 200)
    points_m = np.array([[-0.5, -0.5, 2.0], [0.5, 0.5, 2.0], [0.0, 0.0, 2.0]])
    colors = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255]], np.uint8)
    view.show_space(Space(discs_at(points_m, colors, radius_m=0.03)))
    picture = view.grab().toImage()
    places_px, depths = view.project(points_m)
    for (x, y), color in zip(places_px, colors, strict=True):
        assert picture.pixelColor(int(x), int(y)).getRgb()[:3] == tuple(color)
    assert places_px[0][0] < places_px[1][0]
    assert places_px[0][1] < places_px[1][1]
    assert np.ptp(depths) == pytest.approx(0.0)


def test_a_capture_without_depth_says_so_instead_of_a_surface(qtbot, workspace, theme, store):
    workspace.choose_session(saved_session(store, surface=None)[1])
    user = shown(qtbot, workspace, theme)
    user.tool("space").trigger()
    space = user.screen.findChild(SpaceView)
    assert space.isVisible()
    assert not space.grab().isNull()
    assert "no depth here" in user.lines(user.markers)[0] or user.lines(user.markers)[0][3]
