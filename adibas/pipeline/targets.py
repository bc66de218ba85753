"""What markers look like, as a document that a session keeps: learned colours, or LEDs."""

from collections.abc import Mapping
from dataclasses import replace

from adibas.errors import MarkerError
from adibas.markers.color_files import colors_from_json, colors_to_json
from adibas.markers.color_model import ColorModel
from adibas.markers.led import LedParams
from adibas.pipeline.posture import MarkerTarget

LED_FORMAT = "adibas-leds"


def target_to_document(target: MarkerTarget) -> dict[str, object]:
    """Return what `target_from_document` reads."""
    if isinstance(target, ColorModel):
        return colors_to_json(target)
    return {"format": LED_FORMAT, "version": 1, "least_brightness": target.least_brightness}


def target_from_document(document: Mapping[str, object]) -> MarkerTarget:
    """Return the markers that a session was set up for.

    Raises
    ------
    MarkerError
        The document is damaged, or of a later version.
    """
    try:
        if document.get("format") == LED_FORMAT:
            return _leds(document)
        return colors_from_json(document)
    except (ValueError, TypeError, KeyError, OverflowError) as error:
        raise MarkerError(
            "The markers of that session cannot be read. Learn their colour again."
        ) from error


def _leds(document: Mapping[str, object]) -> LedParams:
    brightness = document["least_brightness"]
    if document.get("version") != 1 or not isinstance(brightness, int | float):
        raise ValueError("another version")
    return replace(LedParams(), least_brightness=float(brightness))
