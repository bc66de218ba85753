"""Every dialog with the keyboard alone: Tab, names for readers, Escape closes, Enter does as told.

The dialogs are those that the code of the window has; one that nobody opens here fails the test.
"""

import ast
import importlib
import pkgutil
import threading
from datetime import UTC, datetime
from pathlib import Path
from unittest.mock import create_autospec

import pytest
from PySide6.QtWidgets import QDialog, QMessageBox, QPushButton, QScrollArea

import ui
from adibas.data.ethogram import Behaviour, Ethogram
from adibas.sessions.conflicts import Conflict
from adibas.texts import LANGUAGES
from tests.ui import export_scene, window_user
from tests.ui.review_scene import saved_session
from tests.ui.test_keyboard_only import Key, assert_keyboard_is_enough, controls, describe, name_of
from tests.ui.test_mnemonics import assert_each_letter_is_one_control
from tests.ui.window_user import visible, visible_dialogs
from tests.unit.store_samples import add_patient
from ui.behaviour.learn_dialog import LearnDialog
from ui.behaviour.learning_presenter import LearningPresenter
from ui.behaviour.scheme_dialog import SchemeDialog
from ui.behaviour.section_dialog import SectionDialog
from ui.capture.wand_dialog import WandDialog
from ui.capture.wand_presenter import WandPresenter
from ui.disputes import Dispute
from ui.export.dialog import ExportDialog, open_export
from ui.limbs.dialog import LimbsDialog, open_limb_editor
from ui.mapping.content import Standing
from ui.mapping.dialog import MapDialog
from ui.mapping.presenter import MapPresenter
from ui.orders.dialog import OrdersDialog
from ui.orders.presenter import OrderLine, OrdersPresenter
from ui.patients.holdings_dialog import HoldingsDialog, open_holdings
from ui.patients.holdings_presenter import Actions
from ui.recovery.dialog import RecoveryKeyDialog, open_recovery_key
from ui.settings.protocol_forms import LandmarkForm, MeasureForm
from ui.theme import Theme
from ui.widgets.dispute_dialog import DisputeDialog
from ui.widgets.question import ask
from ui.widgets.typed_consent import TypedConsent

open_window, named_servers = window_user.open_window, export_scene.named_servers
NOW = datetime(2026, 11, 22, 9, tzinfo=UTC)
UNFINISHED = (LandmarkForm, MeasureForm, LearnDialog, SectionDialog)
"""What they would do waits until something was entered."""

WORKPLACES = (LimbsDialog,)
"""Enter takes what was typed there, and presses nothing."""


def open_section(user):
    return SectionDialog((), (0, 60_000), 5_000, user.window)


def open_scheme(user):
    ethogram = Ethogram("A scheme", behaviours=(Behaviour("sits", "state", "s"),))
    return SchemeDialog(ethogram, lambda _fields: "", user.window)


def open_learning(user):
    dialog = LearnDialog(Theme(user.qapp), user.window)
    dialog.bind(create_autospec(LearningPresenter, instance=True))
    dialog.show_own(("waves",))
    return dialog


def open_wand(user):
    dialog = WandDialog(user.window)
    dialog.bind(create_autospec(WandPresenter, instance=True))
    dialog.show_readiness("", is_ready=True)
    return dialog


def open_key(user):
    return open_recovery_key(user.workspace, user.window, NOW, lambda: None)


def open_map(user):
    dialog = MapDialog("session-7.mcap", user.window)
    dialog.bind(create_autospec(MapPresenter, instance=True))
    dialog.show_standing(Standing(has_map=True))
    return dialog


def open_limbs(user):
    return open_limb_editor(user.workspace, user.window)


def open_landmark(user):
    return LandmarkForm(user.window)


def open_measure(user):
    return MeasureForm({"c7": "C7", "t12": "T12", "l5": "L5", "s1": "S1"}, user.window)


def open_consent(user):
    return TypedConsent("All of it goes.", "P-ABCDEFG", user.window)


def open_dispute(user):
    conflicts = (
        Conflict("notes", "here", "there", "Eva", NOW),
        Conflict("sex", "male", "female", "Eva", NOW),
    )
    return DisputeDialog(Dispute(conflicts, lambda _all: None, lambda: None), user.window)


def open_exporting(user):
    _patient, session, _captures = saved_session(user.store)
    return open_export(user.workspace, user.window, session.session_id)


def open_orders(user):
    dialog = OrdersDialog(user.window)
    dialog.bind(create_autospec(OrdersPresenter, instance=True))
    dialog.show_servers(("pacs", "ris"))
    dialog.show_orders((OrderLine(NOW, "Ana Uno", "HC-9", "Posture"),))
    return dialog


def open_held(user):
    user.workspace.choose_patient(add_patient(user.store))
    actions = create_autospec(Actions, instance=True)
    dialog = open_holdings(user.workspace, user.window, actions)
    user.until(dialog._remove.isEnabled)
    return dialog


OPENERS = {
    SectionDialog: open_section,
    SchemeDialog: open_scheme,
    LearnDialog: open_learning,
    WandDialog: open_wand,
    LimbsDialog: open_limbs,
    MapDialog: open_map,
    LandmarkForm: open_landmark,
    MeasureForm: open_measure,
    TypedConsent: open_consent,
    DisputeDialog: open_dispute,
    ExportDialog: open_exporting,
    OrdersDialog: open_orders,
    RecoveryKeyDialog: open_key,
    HoldingsDialog: open_held,
}


class DialogUser:
    """The same somebody, before a dialog."""

    def __init__(self, user, dialog):
        self._user = user
        self.window = dialog
        self.qapp, self.key = user.qapp, user.key

    @property
    def focus(self):
        return self._user.focus


@pytest.fixture
def user(open_window, named_servers):  # noqa: ARG001  (it is there)
    def open_in(language="en", **changes):
        user = open_window(language=language, **changes)
        user.give_new_passphrase()
        user.settle()
        return user

    return open_in


def opened(user, kind):
    """Open a dialog as a user finds it, and return who is before it."""
    dialog = OPENERS[kind](user)
    if not dialog.isVisible():
        dialog.open()
    dialog.activateWindow()
    user.until(dialog.isActiveWindow)
    user.until(lambda: user.focus is not None and user.focus.window() is dialog)
    user.settle()
    return DialogUser(user, dialog)


def put_away(user):
    for dialog in visible_dialogs():
        dialog.close()
    user.until(lambda: not visible_dialogs())


def classes_of_the_window():
    """Return every class of dialog that the code of the window defines."""
    for module in pkgutil.walk_packages(ui.__path__, "ui."):
        importlib.import_module(module.name)
    found, left = set(), [QDialog]
    while left:
        known = left.pop().__subclasses__()
        found.update(one for one in known if one.__module__.startswith("ui."))
        left += known
    return found


def modules_that_make(name):
    """Return the modules of the window in which a class of Qt is made."""
    folder = Path(ui.__file__).parent
    return {
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == name
    }


def test_no_dialog_of_the_window_is_forgotten_here():
    assert classes_of_the_window() == set(OPENERS)
    assert modules_that_make("QMessageBox") == {"widgets/question.py", "closing.py"}
    assert modules_that_make("QDialog") == set()


@pytest.mark.parametrize("kind", OPENERS, ids=lambda kind: kind.__name__)
def test_tab_reaches_every_control_of_a_dialog_and_each_has_a_name(user, kind):
    somebody = user()
    assert_keyboard_is_enough(opened(somebody, kind))
    put_away(somebody)


@pytest.mark.parametrize("kind", OPENERS, ids=lambda kind: kind.__name__)
def test_with_letters_of_twice_the_size_a_dialog_fits_and_is_reached(user, kind):
    somebody = user("es", font_scale=2.0)
    before = opened(somebody, kind)
    size = before.window.size()
    assert size.width() <= 1280
    assert size.height() <= 800
    assert_keyboard_is_enough(before)
    put_away(somebody)


@pytest.mark.parametrize("kind", OPENERS, ids=lambda kind: kind.__name__)
def test_escape_closes_a_dialog_from_wherever_one_is(user, kind):
    somebody = user()
    before = opened(somebody, kind)
    before.key(Key.Key_Tab)
    assert visible_dialogs()
    before.key(Key.Key_Escape)
    somebody.until(lambda: not visible_dialogs())
    assert somebody.window.isVisible(), "the window behind it stays"


@pytest.mark.parametrize("kind", OPENERS, ids=lambda kind: kind.__name__)
def test_enter_does_what_the_default_button_says_and_nothing_else(user, kind):
    somebody = user()
    before = opened(somebody, kind)
    (default,) = default_buttons(before.window)
    does_it = default.isEnabled() and kind not in WORKPLACES
    assert default.isEnabled() or kind in UNFINISHED
    pressed = []
    for button in visible(before.window, QPushButton):
        button.clicked.connect(lambda _on=False, one=button: pressed.append(one))
    field = next((one for one in stops(before) if takes_enter(one)), default)
    field.setFocus()
    before.key(Key.Key_Return)
    assert pressed == ([default] if does_it else [])
    somebody.qapp.processEvents()
    put_away(somebody)


def default_buttons(dialog):
    return [one for one in visible(dialog, QPushButton) if one.isDefault()]


def stops(before):
    return [one for one in controls(before.window) if one.isEnabled()]


def takes_enter(widget):
    """Say whether Enter means the dialog's button there: where something is typed or ticked."""
    return not isinstance(widget, QPushButton) and type(widget).__name__ in (
        *("QLineEdit", "DecimalField", "WholeNumberField", "QCheckBox", "QRadioButton"),
    )


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_reader_has_a_name_for_every_control_of_a_dialog_in_every_language(user, language):
    somebody = user(language)
    for kind in OPENERS:
        before = opened(somebody, kind)
        nameless = [describe(one) for one in controls(before.window) if not name_of(one)]
        assert not nameless, kind.__name__
        put_away(somebody)


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_letter_goes_to_one_control_of_a_dialog(user, language):
    somebody = user(language)
    for kind in OPENERS:
        assert_each_letter_is_one_control(opened(somebody, kind).window)
        put_away(somebody)


def test_a_question_before_something_is_lost_is_answered_with_keys(user):
    somebody, done = user(), []
    for key, answer in ((Key.Key_Escape, []), (Key.Key_Return, [])):
        ask(somebody.window, "Is it to go?", "&Remove", lambda: done.append("removed"))
        before = asked(somebody)
        assert_keyboard_is_enough(before)
        before.key(key)
        somebody.until(lambda: not visible_dialogs())
        assert done == answer
    ask(somebody.window, "Is it to go?", "&Remove", lambda: done.append("removed"))
    before = asked(somebody)
    before.key(Key.Key_Tab)
    if before.focus.text() != "&Remove":
        before.key(Key.Key_Tab)
    before.key(Key.Key_Space)
    somebody.until(lambda: done == ["removed"])


def asked(somebody):
    somebody.until(lambda: visible_dialogs(QMessageBox))
    (box,) = visible_dialogs(QMessageBox)
    box.activateWindow()
    somebody.until(box.isActiveWindow)
    return DialogUser(somebody, box)


def test_the_question_before_the_window_closes_is_answered_with_keys(user):
    somebody, let_go = user(), threading.Event()
    somebody.application.jobs.start("Writing", lambda _control: let_go.wait(60), str)
    for key in (Key.Key_Escape, Key.Key_Return):
        somebody.window.close()
        before = asked(somebody)
        assert_keyboard_is_enough(before)
        before.key(key)
        somebody.until(lambda: not visible_dialogs())
        assert somebody.window.isVisible()
    let_go.set()
    somebody.settle()


def test_a_part_that_only_scrolls_is_no_stop_without_a_name(user):
    somebody = user()
    for kind in OPENERS:
        before = opened(somebody, kind)
        stopping = [
            one
            for one in before.window.findChildren(QScrollArea)
            if one.focusPolicy() and not name_of(one)
        ]
        assert not stopping, kind.__name__
        put_away(somebody)
