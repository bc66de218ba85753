"""The tools above the picture: what a click does, and what can be done."""

from PySide6.QtCore import QEvent, QSize, Qt, Signal
from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QToolBar, QToolButton, QWidget

from adibas.texts import translate as _
from ui.review.content import Mode, Points
from ui.review.wording import MODE_TITLES
from ui.theme import Theme

ICON_PX = 22
MORE_BUTTON = "qt_toolbar_ext_button"
"""What Qt calls the button that shows what does not fit."""
ROOM_FOR_MORE_PX = 9
"""By so much the style sheet makes it wider than Qt leaves room for at the end."""
MODE_ICONS = {
    Mode.CHOOSE: "move",
    Mode.ADD: "add-marker",
    Mode.NAME: "name-next",
    Mode.DISTANCE: "distance",
    Mode.ANGLE: "angle",
}
KEYS = {
    "move": ("M",),
    "add-marker": ("A",),
    "name-next": ("N",),
    "name-others": ("Shift+N",),
    "distance": ("D",),
    "angle": ("G",),
    "undo": ("Ctrl+Z",),
    "redo": ("Ctrl+Shift+Z", "Ctrl+Y"),
    "delete": ("Delete",),
    "rename": ("F2",),
    "refused": ("R",),
    "space": ("3",),
    "zoom-out": (),
    "fit": (),
    "zoom-in": (),
}
"""Of each tool, in the order in which they stand; zoom keys are the picture's own."""
ICONS_ALONE = ("undo", "redo", "zoom-out", "fit", "zoom-in")
"""Everybody knows these; their names are in the tips."""
ASKED = ("name-others", "undo", "redo", "delete", "rename", "zoom-out", "fit", "zoom-in")
"""Tools that do something at once and have no state."""
GROUPS_END = ("angle", "rename", "space")


class ReviewTools(QToolBar):
    """Actions with text and icon; those that do not fit go behind the arrow at the end."""

    mode_chosen = Signal(object)
    asked = Signal(str)
    """A tool without a state was used: its name."""
    switched = Signal(str, bool)
    """Refused blobs or the 3-D view are to be shown, or not any more."""

    def __init__(self, theme: Theme, screen: QWidget) -> None:
        super().__init__(screen)
        self._theme = theme
        self._actions = {name: self._action(name, screen) for name in KEYS}
        self._modes = QActionGroup(self)
        self._n_refused = 0
        for mode, name in MODE_ICONS.items():
            action = self._actions[name]
            action.setCheckable(True)
            self._modes.addAction(action)
            action.triggered.connect(lambda _on, mode=mode: self.mode_chosen.emit(mode))
        for name in ("refused", "space"):
            self._actions[name].setCheckable(True)
            self._actions[name].triggered.connect(
                lambda is_on, name=name: self.switched.emit(name, is_on)
            )
        for name in ASKED:
            self._actions[name].triggered.connect(lambda _on, name=name: self.asked.emit(name))
        self.setIconSize(QSize(ICON_PX, ICON_PX))
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
        for name in ICONS_ALONE:
            button = self.widgetForAction(self._actions[name])
            if isinstance(button, QToolButton):
                button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
        more = self.findChild(QToolButton, MORE_BUTTON)
        if isinstance(more, QToolButton):
            more.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMovable(False)
        self.setContentsMargins(0, 0, ROOM_FOR_MORE_PX, 0)

    def _action(self, name: str, screen: QWidget) -> QAction:
        action = QAction(self)
        action.setShortcuts([QKeySequence(key) for key in KEYS[name]])
        action.setShortcutContext(Qt.ShortcutContext.WidgetWithChildrenShortcut)
        screen.addAction(action)
        self.addAction(action)
        button = self.widgetForAction(action)
        button.setObjectName(f"tool-{name}")
        button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        if name in GROUPS_END:
            self.addSeparator()
        return action

    def action_named(self, name: str) -> QAction:
        """Return a tool."""
        return self._actions[name]

    def retranslate(self) -> None:
        """Set the texts in the language in use, and the icons in the theme."""
        self.setAccessibleName(_("Tools"))
        texts = {
            **{MODE_ICONS[mode]: _(title) for mode, title in MODE_TITLES.items()},
            "name-others": _("Name the others"),
            "undo": _("Undo"),
            "redo": _("Redo"),
            "delete": _("Delete"),
            "rename": _("Rename"),
            "refused": self._refused_text(),
            "space": _("3-D"),
            "zoom-out": _("Farther"),
            "fit": _("Whole"),
            "zoom-in": _("Nearer"),
        }
        zoom_keys = {"zoom-out": "-", "fit": "0", "zoom-in": "+"}
        for name, text in texts.items():
            action = self._actions[name]
            keys = zoom_keys.get(name) or action.shortcut().toString(
                QKeySequence.SequenceFormat.NativeText
            )
            action.setText(text)
            action.setToolTip(f"{text} ({keys})")
            self.widgetForAction(action).setAccessibleName(text)
        # On its button, beside the one for names, there is room for one word.
        self._actions["name-others"].setIconText(_("Others"))
        self.dress()

    def dress(self) -> None:
        """Draw the icons in the theme in use."""
        for name, action in self._actions.items():
            action.setIcon(self._theme.icon(name))

    def show_points(self, points: Points) -> None:
        """Offer what can be done now."""
        for mode, name in MODE_ICONS.items():
            is_possible = mode is not Mode.NAME or points.unnamed is not None
            self._actions[name].setEnabled(points.can_edit and is_possible)
            self._actions[name].setChecked(mode is points.mode)
        has_chosen = points.can_edit and points.selected is not None
        for name, is_possible in (
            ("name-others", points.can_name_others),
            ("undo", points.can_undo),
            ("redo", points.can_redo),
            ("delete", has_chosen),
            ("rename", has_chosen),
            ("refused", points.n_rejected > 0),
        ):
            self._actions[name].setEnabled(is_possible)
        if points.n_rejected != self._n_refused:
            self._n_refused = points.n_rejected
            self._actions["refused"].setText(self._refused_text())

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        super().changeEvent(event)
        if event.type() in (QEvent.Type.StyleChange, QEvent.Type.PaletteChange):
            self.dress()

    def _refused_text(self) -> str:
        if not self._n_refused:
            return _("Refused")
        return _("Refused ({count})").format(count=self._n_refused)
