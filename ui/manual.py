"""The built manual: which of its pages belongs to a screen. Knows nothing of Qt."""

from pathlib import Path

from adibas.resources import resource_path

PAGES = {
    "start": "data",
    "patients": "first-session",
    "capture": "sensor",
    "markers": "markers",
    "review": "protocols",
    "reports": "intervals",
    "comparison": "intervals",
    "behaviour": "behaviour",
    "calibration": "calibration",
    "settings": "data",
}
"""By the names of the help's pages; the store is locked where the help begins."""


def manual_page(screen: str, language: str) -> Path | None:
    """Return the page of a screen, in English where it is missing in `language`.

    None: the manual was not built, as in a source tree that nobody has set up.
    """
    built = resource_path("manual", "manual")
    paths = (built / one / f"{PAGES[screen]}.html" for one in (language, "en"))
    return next((path for path in paths if path.is_file()), None)
