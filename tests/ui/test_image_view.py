"""The picture that is pointed at: where its pixels lie, and what mouse and keyboard tell."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QHelpEvent, QWheelEvent
from PySide6.QtWidgets import QApplication, QToolTip
from scipy.ndimage import map_coordinates

from ui.widgets.image_geometry import MOST_ZOOM, ImagePlacement
from ui.widgets.image_view import ImageView
from ui.widgets.overlays import Curve, Dot, Line, Region, Text
from ui.widgets.shown_picture import ShownPicture

LEFT, MIDDLE = Qt.MouseButton.LeftButton, Qt.MouseButton.MiddleButton
sides = st.integers(1, 3000)
rotations_deg = st.sampled_from((0, 90, 180, 270))


@st.composite
def placements(draw):
    placement = ImagePlacement(
        picture=(draw(sides), draw(sides)),
        widget=(draw(sides), draw(sides)),
        rotation_deg=draw(rotations_deg),
    ).fitted()
    placement = placement.zoomed(draw(st.floats(1.0, 20.0)), draw(sides), draw(sides))
    return placement.moved(draw(st.floats(-500, 500)), draw(st.floats(-500, 500)))


@given(placements(), st.floats(-10, 3000), st.floats(-10, 3000))
def test_a_pixel_that_is_shown_is_found_again(placement, u, v):
    x, y = placement.to_widget(u, v)
    np.testing.assert_allclose(placement.to_picture(x, y), (u, v), atol=1e-6)


@given(placements(), st.floats(0.1, 10.0), st.floats(0, 1), st.floats(0, 1))
def test_zooming_keeps_what_is_under_the_mouse(placement, factor, across, down):
    x, y = across * placement.widget[0], down * placement.widget[1]
    before = placement.to_picture(x, y)
    nearer = placement.zoomed(factor, x, y)
    after = nearer.to_picture(x, y)
    if is_unbounded(nearer, placement, (x, y)):
        np.testing.assert_allclose(after, before, atol=1e-6 * max(placement.picture))


def is_unbounded(nearer, placement, at):
    """Whether the edges of the picture did not have to push it back into the window."""
    u, v = placement.to_picture(*at)
    moved_u, moved_v = (
        under - center for under, center in zip(nearer.to_picture(*at), nearer.center, strict=True)
    )
    wished = u - moved_u, v - moved_v
    seen = [side / nearer.scale for side in nearer.widget]
    if nearer.rotation_deg in (90, 270):
        seen.reverse()
    return all(
        size > length and length / 2 - 0.5 <= center <= size - 0.5 - length / 2
        for center, size, length in zip(wished, nearer.picture, seen, strict=True)
    )


@given(placements())
def test_the_picture_fills_the_window_or_stands_in_its_middle(placement):
    corners = [
        placement.to_widget(u, v)
        for u, v in ((-0.5, -0.5), (placement.picture[0] - 0.5, placement.picture[1] - 0.5))
    ]
    for axis in (0, 1):
        low, high = sorted(corner[axis] for corner in corners)
        size = placement.widget[axis]
        slack = 1e-6 * max(size, high - low)
        fills = low <= slack and high >= size - slack
        is_centered = abs(low - (size - high)) <= slack and low >= -slack
        assert fills or is_centered


@given(placements(), st.floats(0.01, 1e4))
def test_zoom_stays_between_the_whole_picture_and_forty_pixels_a_pixel(placement, factor):
    zoomed = placement.zoomed(factor, 1.0, 1.0)
    assert zoomed.zoom >= 1.0
    assert zoomed.scale <= max(MOST_ZOOM, placement.fitted().scale) * (1 + 1e-9)


@given(placements())
def test_a_fitted_picture_is_seen_whole(placement):
    fitted = placement.fitted()
    width, height = placement.picture
    for u, v in ((-0.5, -0.5), (width - 0.5, -0.5), (-0.5, height - 0.5)):
        x, y = fitted.to_widget(u, v)
        assert -1e-6 <= x <= placement.widget[0] + 1e-6
        assert -1e-6 <= y <= placement.widget[1] + 1e-6


def test_a_quarter_turn_puts_the_top_left_pixel_at_the_top_right():
    placement = ImagePlacement((40, 20), (20, 40), 90).fitted()
    x, y = placement.to_widget(0.0, 0.0)
    assert (x, y) == pytest.approx((19.5, 0.5))


def test_the_border_of_the_picture_is_half_a_pixel_outside_its_pixels():
    placement = ImagePlacement((4, 3), (400, 300)).fitted()
    assert placement.contains(-0.5, -0.5)
    assert placement.contains(3.49, 2.49)
    assert not placement.contains(3.5, 0.0)
    assert not placement.contains(0.0, -0.51)


@pytest.fixture
def view(qtbot):
    view = ImageView()
    qtbot.addWidget(view)
    view.resize(400, 300)
    view.show()
    view.set_picture(np.full((30, 40, 3), 80, np.uint8))
    return view


def at(view, u, v):
    x, y = view.placement.to_widget(u, v)
    return QPoint(round(x), round(y))


def heard(signal):
    told = []
    signal.connect(lambda *values: told.append(values))
    return told


@pytest.mark.parametrize("rotation_deg", [0, 90, 180, 270])
@pytest.mark.parametrize("zoom", [1.0, 3.0])
def test_a_click_tells_the_pixel_under_the_mouse(qtbot, view, rotation_deg, zoom):
    told = heard(view.clicked)
    view.set_rotation(rotation_deg)
    view.zoom_by(zoom)
    u, v = (value + 1.0 for value in view.placement.center)
    qtbot.mouseClick(view, LEFT, pos=at(view, u, v))
    assert told[0] == pytest.approx((u, v), abs=0.6 / view.placement.scale)


def test_a_click_beside_the_picture_tells_nothing(qtbot, view):
    told = heard(view.clicked)
    view.resize(600, 300)
    qtbot.mouseClick(view, LEFT, pos=QPoint(20, 150))
    assert told == []


def test_pixels_are_drawn_where_a_click_finds_them(view):
    picture = np.zeros((30, 40, 3), np.uint8)
    picture[7, 31] = (255, 0, 0)
    view.set_picture(picture)
    for rotation_deg in (0, 90, 180, 270):
        view.set_rotation(rotation_deg)
        drawn = view.grab().toImage()
        ratio = drawn.devicePixelRatio()
        place = at(view, 31.0, 7.0) * ratio
        assert drawn.pixelColor(place).red() > 200
        other = at(view, 29.0, 7.0) * ratio
        assert drawn.pixelColor(other).red() < 50


def press_move_release(qtbot, view, start, end, *, modifier=Qt.KeyboardModifier.NoModifier):
    qtbot.mousePress(view, LEFT, modifier, start)
    qtbot.mouseMove(view, (start + end) / 2)
    qtbot.mouseMove(view, end)
    qtbot.mouseRelease(view, LEFT, modifier, end)


def test_a_movable_dot_is_dragged_and_dropped_where_the_mouse_takes_it(qtbot, view):
    view.set_overlays((Dot(10.0, 10.0, 1.0, "m01", is_movable=True),))
    pressed, dragged = heard(view.dot_pressed), heard(view.dot_dragged)
    dropped, clicked = heard(view.dot_dropped), heard(view.clicked)
    press_move_release(qtbot, view, at(view, 10.0, 10.0), at(view, 20.0, 15.0))
    assert pressed == [("m01",)]
    assert dragged[-1][0] == "m01"
    assert dropped[0][1:] == pytest.approx((20.0, 15.0), abs=0.06)
    assert clicked == []


def test_a_dot_grabbed_beside_its_centre_keeps_that_distance(qtbot, view):
    view.set_overlays((Dot(10.0, 10.0, 1.0, "m01", is_movable=True),))
    dropped = heard(view.dot_dropped)
    beside = QPoint(6, -4)
    start = at(view, 10.0, 10.0) + beside
    press_move_release(qtbot, view, start, at(view, 20.0, 15.0) + beside)
    assert dropped[0][1:] == pytest.approx((20.0, 15.0), abs=0.06)


def test_a_dot_cannot_be_dragged_out_of_the_picture(qtbot, view):
    view.set_overlays((Dot(2.0, 2.0, 1.0, "m01", is_movable=True),))
    dropped = heard(view.dot_dropped)
    press_move_release(qtbot, view, at(view, 2.0, 2.0), QPoint(-300, -300))
    assert dropped == [("m01", 0.0, 0.0)]


def test_a_press_that_hardly_moves_chooses_a_dot_and_leaves_it_in_place(qtbot, view):
    view.set_overlays((Dot(10.0, 10.0, 1.0, "m01", is_movable=True),))
    pressed, dragged, dropped = map(heard, (view.dot_pressed, view.dot_dragged, view.dot_dropped))
    start = at(view, 10.0, 10.0)
    press_move_release(qtbot, view, start, start + QPoint(2, 1))
    assert pressed == [("m01",)]
    assert dragged == dropped == []


def test_a_dot_that_is_only_pickable_is_chosen_but_never_dragged(qtbot, view):
    view.set_overlays((Dot(10.0, 10.0, 1.0, is_pickable=True, key="rejected-0"),))
    pressed, dragged, clicked = map(heard, (view.dot_pressed, view.dot_dragged, view.clicked))
    press_move_release(qtbot, view, at(view, 10.0, 10.0), at(view, 20.0, 15.0))
    assert pressed == [("rejected-0",)]
    assert dragged == clicked == []


def test_a_fixed_dot_lets_the_click_through(qtbot, view):
    view.set_overlays((Dot(10.0, 10.0, 1.0, "m01"),))
    clicked, pressed = heard(view.clicked), heard(view.dot_pressed)
    qtbot.mouseClick(view, LEFT, pos=at(view, 10.0, 10.0))
    assert clicked[0] == pytest.approx((10.0, 10.0), abs=0.06)
    assert pressed == []


def test_the_nearer_of_two_dots_is_grabbed(qtbot, view):
    dots = tuple(Dot(u, 10.0, 3.0, name, is_movable=True) for u, name in ((10, "a"), (12, "b")))
    view.set_overlays(dots)
    pressed = heard(view.dot_pressed)
    qtbot.mouseClick(view, LEFT, pos=at(view, 11.6, 10.0))
    assert pressed == [("b",)]


def test_the_keys_that_are_held_while_dropping_are_known(qtbot, view):
    alt = Qt.KeyboardModifier.AltModifier
    view.set_overlays((Dot(10.0, 10.0, 1.0, "m01", is_movable=True),))
    held = []
    view.dot_dropped.connect(lambda *_told: held.append(view.modifiers))
    press_move_release(qtbot, view, at(view, 10, 10), at(view, 20, 15), modifier=alt)
    press_move_release(qtbot, view, at(view, 10, 10), at(view, 20, 15))
    assert held == [alt, Qt.KeyboardModifier.NoModifier]


@pytest.mark.parametrize("button", [LEFT, MIDDLE])
def test_a_zoomed_picture_moves_with_the_mouse(qtbot, view, button):
    view.zoom_by(3.0)
    clicked = heard(view.clicked)
    before = view.placement.to_picture(200, 150)
    qtbot.mousePress(view, button, pos=QPoint(200, 150))
    qtbot.mouseMove(view, QPoint(215, 160))
    qtbot.mouseMove(view, QPoint(230, 170))
    qtbot.mouseRelease(view, button, pos=QPoint(230, 170))
    assert view.placement.to_picture(230, 170) == pytest.approx(before, abs=1e-6)
    assert clicked == []


def wheel(view, steps, place):
    event = QWheelEvent(
        QPointF(place),
        QPointF(view.mapToGlobal(place)),
        QPoint(),
        QPoint(0, 120 * steps),
        Qt.MouseButton.NoButton,
        Qt.KeyboardModifier.NoModifier,
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(view, event)


def test_the_wheel_zooms_about_the_mouse(view):
    place = QPoint(180, 140)
    before = view.placement.to_picture(180, 140)
    wheel(view, 5, place)
    assert view.placement.zoom == pytest.approx(1.2**5)
    assert view.placement.to_picture(180, 140) == pytest.approx(before, abs=1e-6)
    wheel(view, -20, place)
    assert view.placement.zoom == 1.0


def test_keys_zoom_and_fit(qtbot, view):
    qtbot.keyClick(view, Qt.Key.Key_Plus)
    qtbot.keyClick(view, Qt.Key.Key_Plus)
    qtbot.keyClick(view, Qt.Key.Key_Minus)
    assert view.placement.zoom == pytest.approx(1.2)
    qtbot.keyClick(view, Qt.Key.Key_0)
    assert view.placement.zoom == 1.0


@pytest.mark.parametrize(
    ("rotation_deg", "expected"), [(0, (1, 0)), (90, (0, -1)), (180, (-1, 0)), (270, (0, 1))]
)
def test_the_cross_goes_where_the_arrow_points_however_the_picture_is_turned(
    qtbot, view, rotation_deg, expected
):
    view.set_rotation(rotation_deg)
    told = heard(view.pointed)
    qtbot.keyClick(view, Qt.Key.Key_Right)
    qtbot.keyClick(view, Qt.Key.Key_Right)
    step = np.subtract(told[1], told[0])
    assert step == pytest.approx(expected, abs=1e-9)


def test_shift_takes_the_cross_ten_pixels_and_ctrl_a_tenth(qtbot, view):
    told = heard(view.pointed)
    qtbot.keyClick(view, Qt.Key.Key_Left)
    qtbot.keyClick(view, Qt.Key.Key_Left, Qt.KeyboardModifier.ShiftModifier)
    qtbot.keyClick(view, Qt.Key.Key_Down, Qt.KeyboardModifier.ControlModifier)
    assert np.diff(told, axis=0) == pytest.approx(np.array([(-10, 0), (0, 0.1)]), abs=1e-9)


def test_space_clicks_at_the_cross(qtbot, view):
    told, clicked = heard(view.pointed), heard(view.clicked)
    qtbot.keyClick(view, Qt.Key.Key_Space)
    assert clicked == []  # no cross yet
    qtbot.keyClick(view, Qt.Key.Key_Up)
    qtbot.keyClick(view, Qt.Key.Key_Space)
    assert clicked == told


def test_space_on_a_dot_chooses_it_as_the_mouse_would(qtbot, view):
    told = heard(view.pointed)
    qtbot.keyClick(view, Qt.Key.Key_Up)
    view.set_overlays((Dot(*told[0], 1.0, "m01", is_movable=True),))
    pressed, clicked = heard(view.dot_pressed), heard(view.clicked)
    qtbot.keyClick(view, Qt.Key.Key_Return)
    assert pressed == [("m01",)]
    assert clicked == []


def test_the_cross_stays_inside_the_picture(qtbot, view):
    told = heard(view.pointed)
    for _step in range(6):
        qtbot.keyClick(view, Qt.Key.Key_Left, Qt.KeyboardModifier.ShiftModifier)
    assert [u for u, _v in told] == [9.5, -0.5]


@pytest.mark.parametrize("rotation_deg", [0, 90])
def test_arrows_nudge_what_is_chosen_and_tell_when_they_are_let_go(qtbot, view, rotation_deg):
    view.set_rotation(rotation_deg)
    view.set_nudging(is_on=True)
    nudged, ended, pointed = map(heard, (view.nudged, view.nudge_ended, view.pointed))
    qtbot.keyPress(view, Qt.Key.Key_Down)
    qtbot.keyPress(view, Qt.Key.Key_Down)
    assert ended == []
    qtbot.keyRelease(view, Qt.Key.Key_Down)
    down = {0: (0.0, 1.0), 90: (1.0, 0.0)}[rotation_deg]
    assert np.array(nudged) == pytest.approx(np.array([down, down]), abs=1e-9)
    assert ended == [()]
    assert pointed == []


def test_a_nudge_ends_when_the_focus_goes_or_nothing_is_chosen_any_more(qtbot, view):
    ended = heard(view.nudge_ended)
    for end in (lambda: view.set_nudging(is_on=False), view.clearFocus):
        view.setFocus()
        view.set_nudging(is_on=True)
        qtbot.keyPress(view, Qt.Key.Key_Down)
        end()
    assert len(ended) == 2
    qtbot.keyRelease(view, Qt.Key.Key_Down)
    assert len(ended) == 2


def test_without_a_picture_nothing_is_told(qtbot, view):
    view.set_picture(None)
    view.set_placeholder("No picture yet")
    clicked, pointed = heard(view.clicked), heard(view.pointed)
    qtbot.mouseClick(view, LEFT, pos=QPoint(100, 100))
    qtbot.keyClick(view, Qt.Key.Key_Right)
    assert clicked == pointed == []
    assert not view.grab().isNull()


def test_a_dot_under_the_mouse_says_its_tooltip(view, monkeypatch):
    said = []
    monkeypatch.setattr(QToolTip, "showText", lambda _place, text, _view: said.append(text))
    monkeypatch.setattr(QToolTip, "hideText", lambda: said.append(""))
    view.set_overlays((Dot(10.0, 10.0, 1.0, role="rejected", tooltip="Too large"),))
    for place in (at(view, 10, 10), at(view, 30, 20)):
        event = QHelpEvent(QEvent.Type.ToolTip, place, view.mapToGlobal(place))
        QApplication.sendEvent(view, event)
    assert said == ["Too large", ""]


@pytest.mark.parametrize(
    "overlay",
    [
        Dot(20.0, 15.0, 3.0, "m01", "selected"),
        Dot(20.0, 15.0, 3.0, role="rejected"),
        Line(5.0, 15.0, 35.0, 15.0, text="12 mm"),
        Line(5.0, 15.0, 35.0, 15.0, role="plumb"),
        Curve(((5.0, 5.0), (20.0, 15.0), (5.0, 25.0)), text="90 deg"),
        Text(20.0, 15.0, "here"),
        Region(np.tri(30, 40, dtype=bool), is_filled=True),
    ],
)
def test_every_overlay_is_seen_on_the_picture(view, overlay):
    bare = view.grab().toImage()
    view.set_overlays((overlay,))
    assert view.grab().toImage() != bare


def test_a_pixel_out_of_sight_is_brought_into_it(view):
    view.zoom_by(8.0)
    view.show_pixel(3.0, 3.0)
    x, y = view.placement.to_widget(3.0, 3.0)
    assert 0 <= x <= view.width()
    assert 0 <= y <= view.height()


def test_a_fitted_picture_stays_fitted_when_the_window_grows(view):
    view.resize(800, 600)
    QApplication.processEvents()
    assert view.placement.scale == pytest.approx(20.0)
    assert view.placement.center == pytest.approx((19.5, 14.5))


def test_the_next_picture_of_the_same_size_keeps_the_zoom(view):
    view.zoom_by(4.0)
    before = view.placement
    view.set_picture(np.zeros((30, 40, 3), np.uint8))
    assert view.placement == before
    view.set_picture(np.zeros((60, 80, 3), np.uint8))
    assert view.placement.zoom == 1.0


@pytest.mark.parametrize("scale", [1.5, 2.25])
def test_a_small_picture_that_fills_the_window_shows_its_pixels(qtbot, scale):
    picture = np.random.default_rng(4).integers(0, 256, (60, 80, 3), dtype=np.uint8)
    view = ImageView()
    qtbot.addWidget(view)
    view.resize(round(80 * scale), round(60 * scale))
    view.set_picture(picture)
    view.show()
    drawn = view.grab().toImage()
    for u, v in [(0, 0), (79, 59), (40, 30), (13, 47)]:
        x, y = view.placement.to_widget(u, v)
        color = drawn.pixelColor(int(x), int(y))
        assert (color.red(), color.green(), color.blue()) == tuple(picture[v, u].tolist())


def test_a_picture_made_smaller_is_bilinear_to_a_level():
    noise = np.random.default_rng(5).integers(0, 256, (120, 160, 3), dtype=np.uint8)
    picture = cv2.GaussianBlur(noise, (0, 0), 2.0)
    fitted = ShownPicture(picture).fitted((100, 75), 0, 1.0)
    drawn = np.frombuffer(fitted.constBits(), np.uint8).reshape(75, 100, 4)[..., 2::-1]
    across, down = (np.arange(100) + 0.5) * 1.6 - 0.5, (np.arange(75) + 0.5) * 1.6 - 0.5
    places = np.stack(np.meshgrid(down, across, indexing="ij"))
    for channel in range(3):
        exact = map_coordinates(picture[..., channel].astype(float), places, order=1)
        assert np.abs(drawn[..., channel] - exact).max() <= 1.5
    assert not cv2.ipp.useIPP_NotExact()
