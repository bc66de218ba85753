"""Where a picture's pixels lie in a widget: fitted, zoomed, moved and turned; without Qt."""

from dataclasses import dataclass
from functools import cached_property

MOST_ZOOM = 40.0
"""Widget pixels a picture pixel."""


@dataclass(frozen=True)
class ImagePlacement:
    """A picture of (width, height) pixels shown in a widget of (width, height) pixels.

    Pixel (0, 0) is the centre of the top-left pixel, so the picture reaches from -0.5 to
    width - 0.5.

    Attributes
    ----------
    picture, widget : (int, int)
        Sizes, (width, height).
    rotation_deg : int
        0, 90, 180 or 270, clockwise.
    zoom : float
        1 = the whole picture fits.
    center : (float, float)
        The picture's pixel in the middle of the widget.
    """

    picture: tuple[int, int]
    widget: tuple[int, int]
    rotation_deg: int = 0
    zoom: float = 1.0
    center: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def scale(self) -> float:
        """Widget pixels in one pixel of the picture."""
        width, height = self.picture
        if self.rotation_deg in (90, 270):
            width, height = height, width
        fitting = min(self.widget[0] / max(width, 1), self.widget[1] / max(height, 1))
        return max(fitting, 1e-6) * self.zoom

    def to_widget(self, u: float, v: float) -> tuple[float, float]:
        """Return where pixel (u, v) of the picture lies in the widget."""
        x, y = _turned(u - self.center[0], v - self.center[1], self.rotation_deg)
        return x * self.scale + self.widget[0] / 2, y * self.scale + self.widget[1] / 2

    def to_picture(self, x: float, y: float) -> tuple[float, float]:
        """Return which pixel of the picture lies at (x, y) of the widget."""
        du, dv = _turned(
            (x - self.widget[0] / 2) / self.scale,
            (y - self.widget[1] / 2) / self.scale,
            (360 - self.rotation_deg) % 360,
        )
        return du + self.center[0], dv + self.center[1]

    def contains(self, u: float, v: float) -> bool:
        """Say whether (u, v) lies in the picture."""
        return 0 <= u + 0.5 < self.picture[0] and 0 <= v + 0.5 < self.picture[1]

    def fitted(self) -> "ImagePlacement":
        """Return the placement with the whole picture in the middle."""
        width, height = self.picture
        middle = ((width - 1) / 2, (height - 1) / 2)
        return ImagePlacement(self.picture, self.widget, self.rotation_deg, 1.0, middle)

    def zoomed(self, factor: float, x: float, y: float) -> "ImagePlacement":
        """Return the placement nearer by `factor`; what lies at (x, y) of the widget stays."""
        u, v = self.to_picture(x, y)
        most = max(1.0, MOST_ZOOM * self.zoom / self.scale)
        zoom = min(max(self.zoom * factor, 1.0), most)
        nearer = ImagePlacement(self.picture, self.widget, self.rotation_deg, zoom, self.center)
        moved_u, moved_v = nearer.to_picture(x, y)
        return nearer.centered(self.center[0] + u - moved_u, self.center[1] + v - moved_v)

    def moved(self, dx: float, dy: float) -> "ImagePlacement":
        """Return the placement with the picture moved by (dx, dy) pixels of the widget."""
        u, v = self.to_picture(self.widget[0] / 2 - dx, self.widget[1] / 2 - dy)
        return self.centered(u, v)

    def centered(self, u: float, v: float) -> "ImagePlacement":
        """Return the placement with pixel (u, v) in the middle, as far as the picture reaches."""
        width, height = self.widget
        if self.rotation_deg in (90, 270):
            width, height = height, width
        return ImagePlacement(
            self.picture,
            self.widget,
            self.rotation_deg,
            self.zoom,
            (
                _inside(u, self.picture[0], width / self.scale),
                _inside(v, self.picture[1], height / self.scale),
            ),
        )


def _inside(center: float, size: int, seen: float) -> float:
    """Keep the seen stretch within the picture; a picture that is smaller stays in the middle."""
    if seen >= size:
        return (size - 1) / 2
    return min(max(center, seen / 2 - 0.5), size - 0.5 - seen / 2)


def _turned(x: float, y: float, clockwise_deg: int) -> tuple[float, float]:
    if clockwise_deg == 90:  # noqa: PLR2004  (a quarter)
        return -y, x
    if clockwise_deg == 180:  # noqa: PLR2004  (a half)
        return -x, -y
    if clockwise_deg == 270:  # noqa: PLR2004  (three quarters)
        return y, -x
    return x, y
