"""The same view in two sessions: side by side, or laid over one another."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QButtonGroup,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSlider,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from adibas.pipeline.picture_overlay import WAYS
from adibas.texts import message
from adibas.texts import translate as _
from ui.comparison.content import Pair, Seen
from ui.comparison.drawing import blended, both_overlays, marker_overlays
from ui.comparison.empty_or import EmptyOr
from ui.view_names import VIEW_NAMES
from ui.widgets.flow import FlowLayout
from ui.widgets.image_view import ImageView
from ui.widgets.overlays import Role

NOT_BOTH = message("Only one of the two sessions has a picture of this view.")
PERCENT = 100
HALF = 50
LARGE_STEP, SMALL_STEP = 10, 2


class PicturesPage(QWidget):
    """View, way of showing, and the pictures."""

    view_chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._pair: Pair | None = None
        self._dates = ("", "")
        self._views: dict[str, QPushButton] = {}
        self._view_group = QButtonGroup(self)
        self._beside, self._over = QPushButton(self), QPushButton(self)
        self._way_group = QButtonGroup(self)
        for button in (self._beside, self._over):
            button.setCheckable(True)
            self._way_group.addButton(button)
        self._beside.setChecked(True)
        self._way, self._titles = QLabel(self), (QLabel(self), QLabel(self))
        self._blend_titles = (QLabel(self), QLabel(self))
        self._images = (ImageView(self), ImageView(self))
        self._both = ImageView(self)
        self._slider = QSlider(Qt.Orientation.Horizontal, self)
        self._slider.setRange(0, PERCENT)
        self._slider.setValue(HALF)
        self._slider.setSingleStep(SMALL_STEP)
        self._slider.setPageStep(LARGE_STEP)
        self._pages = QStackedWidget(self)
        self._lay_out()
        self._beside.toggled.connect(lambda _on: self._show_way())
        self._slider.valueChanged.connect(lambda _value: self._show_blend())

    def _lay_out(self) -> None:
        self._tools = FlowLayout()
        for button in (self._beside, self._over):
            self._tools.addWidget(button)
        self._way.setWordWrap(True)
        self._way.setProperty("kind", "quiet")
        for page in (self._beside_page(), self._over_page()):
            self._pages.addWidget(page)
        content = QWidget(self)
        column = QVBoxLayout(content)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self._pages, 1)
        column.addWidget(self._way)
        self._empty = EmptyOr(content, self)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(8, 8, 8, 8)
        outer.addLayout(self._tools)
        outer.addWidget(self._empty, 1)

    def _beside_page(self) -> QWidget:
        page = QWidget(self)
        grid = QGridLayout(page)
        grid.setContentsMargins(0, 0, 0, 0)
        for column, (title, image) in enumerate(zip(self._titles, self._images, strict=True)):
            title.setWordWrap(True)
            grid.addWidget(title, 0, column)
            grid.addWidget(image, 1, column)
            grid.setColumnStretch(column, 1)
        grid.setRowStretch(1, 1)
        return page

    def _over_page(self) -> QWidget:
        page = QWidget(self)
        column = QVBoxLayout(page)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self._both, 1)
        row = QHBoxLayout()
        earlier, later = self._blend_titles
        row.addWidget(earlier)
        row.addWidget(self._slider, 1)
        row.addWidget(later)
        column.addLayout(row)
        return page

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._beside.setText(_("&Side by side"))
        self._over.setText(_("O&verlaid"))
        self._slider.setAccessibleName(_("How much of the later picture is seen"))
        self._slider.setToolTip(_("Left: the earlier picture. Right: the later one. (Arrows)"))
        self._images[0].setAccessibleName(_("Earlier picture with markers"))
        self._images[1].setAccessibleName(_("Later picture with markers"))
        self._both.setAccessibleName(_("Both pictures with the markers of both"))
        for view, button in self._views.items():
            button.setText(_(VIEW_NAMES[view]))
        self._word()

    def show_dates(self, earlier: str, later: str) -> None:
        """Say when the two sessions were."""
        self._dates = (earlier, later)
        self._word()

    def show_pair(self, views: tuple[str, ...], pair: Pair | None) -> None:
        """Show one view of both sessions; None: it is being read."""
        self._pair = pair
        self._offer(views, "" if pair is None else pair.view)
        before = None if pair is None else pair.earlier
        now = None if pair is None else pair.later
        _show_seen(self._images[0], before, "earlier")
        _show_seen(self._images[1], now, "later")
        self._show_way()

    def say(self, sentence: str) -> None:
        """Say what to do first in place of the pictures; nothing: show them."""
        self._empty.say(sentence)

    def _offer(self, views: tuple[str, ...], chosen: str) -> None:
        if tuple(self._views) != views:
            for button in self._views.values():
                self._view_group.removeButton(button)
                button.deleteLater()
            self._views = {view: self._view_button(view) for view in views}
        if chosen in self._views:
            self._views[chosen].setChecked(True)

    def _view_button(self, view: str) -> QPushButton:
        button = QPushButton(_(VIEW_NAMES[view]), self)
        button.setCheckable(True)
        button.clicked.connect(lambda _checked: self.view_chosen.emit(view))
        self._view_group.addButton(button)
        self._tools.addWidget(button)
        return button

    def _show_way(self) -> None:
        has_both = self._pair is not None and self._pair.overlay is not None
        self._over.setEnabled(has_both)
        is_over = self._over.isChecked() and has_both
        self._pages.setCurrentIndex(1 if is_over else 0)
        if is_over:
            self._show_blend()
        self._word()

    def _show_blend(self) -> None:
        pair = self._pair
        if pair is None or pair.later is None or self._pages.currentIndex() != 1:
            return
        self._both.set_rotation(pair.later.rotation_deg)
        self._both.set_picture(blended(pair, self._slider.value() / PERCENT))
        self._both.set_overlays(both_overlays(pair))

    def _word(self) -> None:
        earlier, later = self._dates
        titles = (_("Before: {when}").format(when=earlier), _("Now: {when}").format(when=later))
        for labels in (self._titles, self._blend_titles):
            for label, text in zip(labels, titles, strict=True):
                label.setText(text)
        pair = self._pair
        told = "" if pair is None else _(NOT_BOTH)
        if pair is not None and pair.overlay is not None:
            told = _(WAYS[pair.overlay.way]) if self._pages.currentIndex() else ""
        self._way.setText(told)
        self._way.setVisible(bool(told))
        is_read = pair is not None
        for image in self._images:
            image.set_placeholder(
                _("No picture of this view") if is_read else _("The picture is being read")
            )


def _show_seen(image: ImageView, seen: Seen | None, role: Role) -> None:
    if seen is None:
        image.set_picture(None)
        image.set_overlays(())
        return
    image.set_rotation(seen.rotation_deg)
    image.set_picture(seen.picture_rgb)
    image.set_overlays(marker_overlays(seen.markers, role))
