"""Draws every screen of the window in every language, theme and size: ``make screenshots``.

A demo session is taken first, through the same calls as in the window; then one window speaks
each language in turn, so that what is not translated at once would be seen. One more set of each
language has letters of twice the size. Pictures go to ``build/screenshots``; with ``--docs`` one
set in English goes to ``docs/screenshots``, with ``--manual`` what the manual shows to its folders.
"""

import argparse
import os
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PySide6.QtGui import QPixmap

from adibas.texts import LANGUAGES
from installers.manual.pictures import save_picture
from installers.studio import SIZE, Studio, opened_studio

PROJECT = Path(__file__).parents[1]
SIZES = (SIZE, (1920, 1080))
THEMES = ("light", "dark")
LARGEST_LETTERS = 2.0


def main() -> int:
    """Draw all screens; return 0."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--docs", action="store_true", help="one set in English, for docs")
    parser.add_argument("--manual", action="store_true", help="those that the manual shows")
    parser.add_argument(
        "--only",
        default="",
        help="sets whose name matches, as in es_light; with --manual pictures, as in settings-2",
    )
    options = parser.parse_args()
    with opened_studio() as studio:
        for path in _drawn(studio, options):
            sys.stdout.write(f"{path}\n")
    return 0


def _drawn(studio: Studio, options: argparse.Namespace) -> Iterator[Path]:
    if options.manual:
        return _draw_manual(studio, options.only)
    return _draw_docs(studio) if options.docs else _draw_looks(studio, options.only)


def _draw_docs(studio: Studio) -> Iterator[Path]:
    folder = PROJECT / "docs" / "screenshots"
    yield _saved(studio.unlock(), folder / "unlock.png")
    studio.wear("en")
    for name, picture in studio.pictures():
        yield _saved(picture, folder / f"{name}.png")


def _draw_manual(studio: Studio, only: str) -> Iterator[Path]:
    studio.unlock()
    for language in LANGUAGES:
        studio.wear(language)
        for name, picture in studio.pictures():
            if re.search(only, name):
                yield from save_picture(picture, language, name)


def _draw_looks(studio: Studio, only: str) -> Iterator[Path]:
    folder = PROJECT / "build" / "screenshots"
    yield _saved(studio.unlock(), folder / "unlock_en_light.png")
    for look in _looks():
        if not re.search(only, look.suffix):
            continue
        studio.wear(look.language, look.theme, look.font_scale, look.size)
        for name, picture in studio.pictures():
            yield _saved(picture, folder / f"{name}{look.suffix}.png")


def _saved(picture: QPixmap, path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    picture.save(str(path))
    return path


@dataclass(frozen=True, slots=True)
class _Look:
    """What the window looks like in one set, and the end of its files' names."""

    language: str
    theme: str
    size: tuple[int, int]
    suffix: str
    font_scale: float = 1.0


def _looks() -> Iterator[_Look]:
    for language in LANGUAGES:
        for theme in THEMES:
            for width, height in SIZES:
                suffix = f"_{language}_{theme}_{width}x{height}"
                yield _Look(language, theme, (width, height), suffix)
    for language in LANGUAGES:
        suffix = f"_{language}_light_large-letters"
        yield _Look(language, "light", SIZE, suffix, LARGEST_LETTERS)


if __name__ == "__main__":
    raise SystemExit(main())
