"""Values and names as the review screen writes them, in the language in use."""

from PySide6.QtCore import QLocale

from adibas.data.landmark_texts import landmark_text
from adibas.texts import message
from adibas.texts import translate as _
from ui.review.content import MeasureRow, Mode, Points

NOTHING = "\u2013"

MODE_TITLES = {
    Mode.CHOOSE: message("Move"),
    Mode.ADD: message("Add"),
    Mode.NAME: message("Name"),
    Mode.DISTANCE: message("Distance"),
    Mode.ANGLE: message("Angle"),
}
MODE_HINTS = {
    Mode.CHOOSE: message(
        "Drag a marker; it snaps to the blob where it is dropped, unless Alt is held. Arrows move "
        "the chosen marker by a pixel, with Shift by ten, with Ctrl by a tenth."
    ),
    Mode.ADD: message(
        "Click where a marker is missing; it snaps to the blob there, unless Alt is held."
    ),
    Mode.DISTANCE: message("Click two markers, one after the other."),
    Mode.ANGLE: message("Click three markers; the angle is at the second one."),
}
NAME_HINT = message(
    "Click {landmark}, or the marker that is there; {n} are left. N passes on to the next one."
)
ALL_NAMED = message("Every landmark of this view has its marker.")
SPACE_HINT = message("Drag or press arrows to turn the surface; 0 looks from the front again.")
READ_ONLY_HINT = message("The store is read only: look and measure, nothing is changed.")
WAIT_HINT = message("The depth of the capture is being read; a moment.")


def mode_hint(points: Points) -> str:
    """Say what a click does."""
    if points.mode is not Mode.NAME:
        return _(MODE_HINTS[points.mode])
    if not points.unnamed:
        return _(ALL_NAMED)
    landmark = landmark_text(points.unnamed[0])
    return _(NAME_HINT).format(landmark=landmark, n=len(points.unnamed))


def number(value: float, decimals: int = 1) -> str:
    """Write a number as the language in use does."""
    locale = QLocale()
    locale.setNumberOptions(QLocale.NumberOption.OmitGroupSeparator)
    return locale.toString(value, "f", decimals)


def measure_name(row: MeasureRow) -> str:
    """Name the markers of a measure; the vertex of an angle stands in the middle."""
    return " \u2013 ".join(map(landmark_text, row.labels))


def value_text(row: MeasureRow) -> str:
    """Write the value with its unit."""
    if row.value is None:
        return NOTHING
    pattern = _("{value}\u00b0") if row.is_angle else _("{value} mm")
    return pattern.format(value=number(row.value))


def interval_text(row: MeasureRow) -> str:
    """Write the ends of the interval."""
    if row.interval is None:
        return NOTHING
    low, high = row.interval
    return _("{low} to {high}").format(low=number(low), high=number(high))


def kind_text(row: MeasureRow) -> str:
    """Say what a measure is."""
    return _("Angle") if row.is_angle else _("Distance")
