"""Started as a process of its own: a first session in the window, from the start to the report.

Usage: ``python -m benchmarks.first_report_probe mouse|keys FOLDER STICKERS STARTED``. FOLDER is
empty: no store, no preferences. STICKERS are pixels of the live picture that are clicked on, as
JSON. STARTED is the time in seconds (`time.time`) at which the program was called. Prints seconds,
actions, seconds of waiting, seconds of CPU time, and how many distances the Excel file holds.
"""

import json
import math
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from PySide6.QtWidgets import QApplication

    from benchmarks.window_hand import Hand
    from ui.widgets.image_view import ImageView

VIEWS = ("anterior", "posterior", "right_lateral", "left_lateral")
PASSPHRASE = "four words are enough"  # noqa: S105  (of a store that is thrown away)
NAME, BORN, RECORD = "Rosa Ibarra", "3/4/1971", "HC-77"
Pixels: TypeAlias = list[tuple[float, float]]


def main() -> None:
    """Go through the session and print its figures."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    way, folder, started_s = sys.argv[1], Path(sys.argv[2]).resolve(), float(sys.argv[4])
    stickers = [(float(u), float(v)) for u, v in json.loads(sys.argv[3])]
    from ui.collector import put_off

    put_off()  # as `ui.main` does
    from PySide6.QtWidgets import QApplication

    reports = folder / "reports"
    reports.mkdir()
    os.chdir(reports)  # the folder that the dialog proposes
    hand = _open_window(QApplication([]), folder)
    hand.waited_s = time.time() - started_s
    (_by_mouse if way == "mouse" else _by_keys)(hand, stickers)
    total_s = time.time() - started_s
    figures = (total_s, hand.n_actions, hand.waited_s, time.process_time(), _read_back(reports))
    sys.stdout.write(" ".join(f"{one:.1f}" for one in figures) + "\n")
    sys.stdout.flush()
    os._exit(0)


def _open_window(app: "QApplication", folder: Path) -> "Hand":
    """Open the window over an empty folder, on a desktop without a keyring."""
    from keyring import set_keyring
    from keyring.backends import fail

    from benchmarks.window_hand import Hand
    from ui.application import Application
    from ui.preferences import PreferencesFile
    from ui.screens import preload

    set_keyring(fail.Keyring())  # type: ignore[no-untyped-call]
    preferences = PreferencesFile(folder / "preferences.json")
    preferences.change(language="en")
    application = Application(app, preferences, folder / "store")
    application.start()
    application.window.activateWindow()
    preload()
    return Hand(app, application)


def _by_mouse(hand: "Hand", stickers: Pixels) -> None:
    from PySide6.QtCore import Qt
    from PySide6.QtWidgets import QListWidget

    _give_passphrase(hand)
    hand.press("New patient")
    for text in (NAME, BORN, RECORD):
        hand.write(text)
        hand.key(Qt.Key.Key_Tab)
    hand.press("Save")
    for button in ("Start a session", "Save the consent", "Start a session"):
        hand.press(button)
    _wait_for_picture(hand)
    hand.press("Learn the marker colour")
    hand.press("Freeze")
    for u, v in stickers:
        hand.point(_picture(hand), u, v)
    hand.press("Use these markers")
    for number in range(1, len(VIEWS) + 1):
        hand.press("Capture this view")
        _wait_for_capture(hand, number)
    hand.go_to("review")
    strip = hand.seen(QListWidget, parent=hand.window.screen_named("review"))
    for row in range(len(VIEWS)):
        hand.click(strip.viewport(), strip.visualItemRect(strip.item(row)).center())
        _look(hand)
    u, v = _first_marker(hand)
    hand.drag(_picture(hand), (u, v), (u + 12.0, v + 8.0))
    hand.press("Undo")
    hand.go_to("reports")
    _wait_for_rest(hand)
    hand.press("Write the report...")
    hand.take_proposed_folder(has_mouse=True)
    _wait_for_report(hand)


def _by_keys(hand: "Hand", stickers: Pixels) -> None:
    from PySide6.QtCore import Qt

    from ui.widgets.image_view import ImageView

    control = Qt.KeyboardModifier.ControlModifier
    _give_passphrase(hand)
    hand.key(Qt.Key.Key_N, control)
    for text in (NAME, BORN, RECORD):
        hand.write(text)
        hand.key(Qt.Key.Key_Tab)
    hand.alt("Save")
    for button in ("Start a session", "Save the consent", "Start a session"):
        hand.alt(button)
    _wait_for_picture(hand)
    hand.alt("Learn the marker colour")
    hand.alt("Freeze")
    hand.tab_to(lambda one: isinstance(one, ImageView))
    for u, v in stickers:
        _point_by_keys(hand, _picture(hand), (u, v))
    hand.alt("Use these markers")
    for number in range(1, len(VIEWS) + 1):
        hand.alt("Capture this view")
        _wait_for_capture(hand, number)
    hand.key(Qt.Key.Key_4, control)
    _correct_by_keys(hand)
    hand.key(Qt.Key.Key_5, control)
    _wait_for_rest(hand)
    hand.alt("Write the report...")
    hand.take_proposed_folder(has_mouse=False)
    _wait_for_report(hand)


def _correct_by_keys(hand: "Hand") -> None:
    """Look at all captures, nudge a marker, and take that back."""
    from PySide6.QtCore import Qt
    from PySide6.QtWidgets import QListWidget

    from ui.widgets.image_view import ImageView

    _wait_for_rest(hand)
    hand.tab_to(lambda one: isinstance(one, QListWidget))
    for _ in range(len(VIEWS) - 1):
        hand.key(Qt.Key.Key_Down)
        _look(hand)
    hand.tab_to(lambda one: one.accessibleName() == "Markers")
    hand.key(Qt.Key.Key_Down)
    hand.tab_to(lambda one: isinstance(one, ImageView))
    hand.key(Qt.Key.Key_Left)
    hand.key(Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)


def _give_passphrase(hand: "Hand") -> None:
    from PySide6.QtCore import Qt
    from PySide6.QtWidgets import QLineEdit, QWidget

    from ui.recovery.dialog import RecoveryKeyDialog

    def seen(parent: QWidget, kind: type[QWidget]) -> list[QWidget]:
        return [one for one in parent.findChildren(kind) if one.isVisible()]

    page, n_fields = hand.window.unlock_page, 2
    hand.wait("the first page", lambda: len(seen(page, QLineEdit)) == n_fields)
    hand.write(PASSPHRASE)
    hand.key(Qt.Key.Key_Tab)
    hand.write(PASSPHRASE)
    hand.key(Qt.Key.Key_Return)
    hand.wait("the patients", lambda: hand.window.shown == "patients")
    hand.wait("the recovery key", lambda: seen(hand.window, RecoveryKeyDialog))
    hand.key(Qt.Key.Key_Escape)  # later
    hand.wait("the end of the dialog", lambda: not seen(hand.window, RecoveryKeyDialog))
    hand.window.activateWindow()  # what a desktop does by itself


def _wait_for_picture(hand: "Hand") -> None:
    """Wait until the live picture shows the person's outline."""

    def sees_somebody() -> bool:
        workspace = hand.application.workspace
        newest = None if workspace is None else workspace.live.newest
        return newest is not None and newest.outline is not None

    hand.wait("the live picture", sees_somebody)


def _wait_for_capture(hand: "Hand", n_captures: int) -> None:
    """Wait for countdown, burst, and what is measured in it."""

    def is_there() -> bool:
        workspace = hand.application.workspace
        session = None if workspace is None else workspace.session
        return session is not None and len(session.capture_ids) == n_captures

    hand.wait(f"capture {n_captures}", is_there)


def _wait_for_rest(hand: "Hand") -> None:
    hand.wait("the end of jobs", lambda: not hand.application.jobs.is_busy)


def _wait_for_report(hand: "Hand") -> None:
    hand.wait("the report", lambda: "written" in hand.window.told.lower())


def _look(hand: "Hand") -> None:
    """Look at a capture as soon as it is there."""
    _wait_for_rest(hand)
    hand.look()


def _picture(hand: "Hand") -> "ImageView":
    from ui.widgets.image_view import ImageView

    return hand.seen(ImageView, parent=hand.window.screen_named(hand.window.shown))


def _first_marker(hand: "Hand") -> tuple[float, float]:
    """Return where the first marker of the capture lies that is looked at."""
    workspace = hand.application.workspace
    if workspace is None or workspace.capture_id is None:
        raise LookupError("no capture is chosen")
    marker = workspace.store.captures.get(workspace.capture_id).markers()[0]
    return marker.u, marker.v


def _point_by_keys(hand: "Hand", picture: "ImageView", target: tuple[float, float]) -> None:
    """Move the cross to a pixel with the arrows, and click there."""
    from PySide6.QtCore import Qt

    places: list[tuple[float, float]] = []
    connection = picture.pointed.connect(lambda u, v: places.append((u, v)))
    shift = Qt.KeyboardModifier.ShiftModifier
    hand.key(Qt.Key.Key_Right)
    for axis, (back, forth) in enumerate(
        ((Qt.Key.Key_Left, Qt.Key.Key_Right), (Qt.Key.Key_Up, Qt.Key.Key_Down))
    ):
        for step, modifiers in ((10.0, shift), (1.0, Qt.KeyboardModifier.NoModifier)):
            gap = target[axis] - places[-1][axis]
            hand.hold(forth if gap > 0 else back, math.floor(abs(gap) / step + 0.5), modifiers)
    picture.pointed.disconnect(connection)
    hand.key(Qt.Key.Key_Space)


def _read_back(folder: Path) -> int:
    """Count the distances in the one Excel file; all four views must be in it."""
    import openpyxl

    (path,) = folder.glob("*.xlsx")
    header, *rows = openpyxl.load_workbook(path)["Distances"].iter_rows(values_only=True)
    views = {row[header.index("View")] for row in rows}
    if len(views) != len(VIEWS):
        raise ValueError(f"the report has the views {views}")
    return len(rows)


if __name__ == "__main__":
    main()
