"""A picture that can be looked at closely, and what is drawn upon it."""

from dataclasses import replace

from PySide6.QtCore import QRect, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QResizeEvent, QWheelEvent
from PySide6.QtWidgets import QSizePolicy, QWidget

from adibas.arrays import Float32Array, UInt8Array
from ui.theme import DRAWN, PICTURE_GROUND
from ui.widgets.image_geometry import ImagePlacement
from ui.widgets.image_rects import covered_rect, fitted_size, rect_with_rim, rects_beside
from ui.widgets.overlay_painter import paint_overlays
from ui.widgets.overlays import Overlay
from ui.widgets.shown_picture import Coloring, ShownPicture

GROUND = QColor(PICTURE_GROUND)
WHEEL_STEP = 1.2


class PictureCanvas(QWidget):
    """Shows an RGB picture, fitted or zoomed, and overlays in the picture's pixels."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._picture: ShownPicture | None = None
        self._placement = ImagePlacement((1, 1), (1, 1))
        self._overlays: tuple[Overlay, ...] = ()
        self._placeholder = ""
        self._draws_beside = False
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)  # nothing shines through
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(160, 120)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)

    def set_picture(self, picture_rgb: UInt8Array | None) -> None:
        """Show an (H, W, 3) picture; zoom and place stay where the size stays."""
        if picture_rgb is None:
            self._picture = None
            self.update()
        else:
            self._show(ShownPicture(picture_rgb))

    def set_numbers(self, numbers: Float32Array, coloring: Coloring) -> None:
        """Show an (H, W) picture of numbers: it is drawn for less than one of colours."""
        self._show(ShownPicture(numbers, coloring))

    def _show(self, picture: ShownPicture) -> None:
        self._refresh()
        self._picture = picture
        if self._placement.picture != picture.size:
            self._placement = replace(self._placement, picture=picture.size).fitted()
            self.picture_resized()

    def picture_resized(self) -> None:
        """Draw anew: places in the picture before are places no more."""
        self.update()

    def set_overlays(self, overlays: tuple[Overlay, ...]) -> None:
        """Draw these over the picture."""
        self._overlays = overlays
        self._refresh()

    def _refresh(self) -> None:
        """Have the picture painted anew; what is beside it only where something is drawn there."""
        if self._picture is None or self._draws_beside or self._placement.zoom != 1:
            self.update()
        else:
            self.update(rect_with_rim(self._placement, self.devicePixelRatioF()))

    def set_rotation(self, rotation_deg: int) -> None:
        """Turn the picture clockwise by 0, 90, 180 or 270 degrees."""
        if rotation_deg != self._placement.rotation_deg:
            self._placement = replace(self._placement, rotation_deg=rotation_deg).fitted()
            self.update()

    def set_placeholder(self, text: str) -> None:
        """Say this where there is no picture."""
        self._placeholder = text
        self.update()

    @property
    def placement(self) -> ImagePlacement:
        """Where the picture lies; for tests and for what is drawn beside it."""
        return self._placement

    def fit(self) -> None:
        """Show the whole picture."""
        self._place(self._placement.fitted())

    def zoom_by(self, factor: float) -> None:
        """Come nearer to the middle, or go away from it."""
        x, y = self.width() / 2, self.height() / 2
        self._place(self._placement.zoomed(factor, x, y))

    def show_pixel(self, u: float, v: float) -> None:
        """Move the picture so that pixel (u, v) is seen."""
        x, y = self._placement.to_widget(u, v)
        if not self.rect().adjusted(20, 20, -20, -20).contains(int(x), int(y)):
            self._place(self._placement.centered(u, v))

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802  (Qt's name)
        painter = QPainter(self)
        if self._picture is None:
            painter.fillRect(event.rect(), GROUND)
            painter.setPen(QColor("#B3C0CB"))
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, self._placeholder)
        else:
            self._paint_picture(painter, self._picture)
            reach = paint_overlays(painter, self._placement, self._overlays)
            self.paint_above(painter)
            self._note_reach(reach, event.rect())
        if self.hasFocus():
            painter.setPen(QColor(DRAWN["plumb"]))
            painter.drawRect(self.rect().adjusted(0, 0, -1, -1))

    def paint_above(self, painter: QPainter) -> None:
        """Paint what lies over the overlays; nothing here."""

    def _note_reach(self, reach: QRectF, painted: QRect) -> None:
        """Have all painted anew where something came beside the picture that was cut off."""
        inside = QRectF(rect_with_rim(self._placement, self.devicePixelRatioF()))
        self._draws_beside = not (reach.isEmpty() or inside.contains(reach))
        if self._draws_beside and not painted.contains(self.rect()):
            self.update()

    def _paint_picture(self, painter: QPainter, picture: ShownPicture) -> None:
        place = self._placement
        if place.zoom == 1:
            ratio = self.devicePixelRatioF()
            image = picture.fitted(fitted_size(place, ratio), place.rotation_deg, ratio)
            covered = covered_rect(place, ratio)
            for beside in rects_beside(self.rect(), covered):
                painter.fillRect(beside, GROUND)
            painter.drawImage(covered.topLeft(), image)
            return
        painter.fillRect(self.rect(), GROUND)
        painter.save()
        is_small = place.scale < 1
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, is_small)
        painter.translate(self.width() / 2, self.height() / 2)
        painter.rotate(place.rotation_deg)
        painter.scale(place.scale, place.scale)
        left, top = -0.5 - place.center[0], -0.5 - place.center[1]
        painter.drawImage(QRectF(left, top, *picture.size), picture.whole())
        painter.restore()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802  (Qt's name)
        was_fitted = self._placement.zoom == 1.0
        self._placement = replace(
            self._placement, widget=(max(self.width(), 1), max(self.height(), 1))
        )
        if was_fitted:
            self._placement = self._placement.fitted()
        super().resizeEvent(event)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802  (Qt's name)
        steps = event.angleDelta().y() / 120
        at = event.position()
        self._place(self._placement.zoomed(WHEEL_STEP**steps, at.x(), at.y()))
        event.accept()

    def _place(self, placement: ImagePlacement) -> None:
        self._placement = placement
        self.update()
