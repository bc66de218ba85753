"""Texts for the user, in the user's language.

One set of gettext catalogues under ``resources/translations`` serves core, command line, reports
and window. English is the language of the source: without a catalogue a text stands for itself.
"""

import gettext
import locale
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from pathlib import Path

from adibas.errors import AdibasError
from adibas.resources import resource_path

DOMAIN = "adibas"
LANGUAGES = {"en": "English", "es": "Español", "ca": "Català", "pt": "Português"}
"""What the program speaks, each language by its own name; Portuguese as in Brazil, for all."""

VARIABLES = ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG")
"""Of the environment, the strongest first, as gettext reads them."""

DECIMAL_COMMA = ("es", "ca", "pt")
NAMES_ON_WINDOWS = {"spanish": "es", "catalan": "ca", "portuguese": "pt"}

_spoken: ContextVar[str] = ContextVar("spoken")
"""Language of the block of `speaking` that this thread is in."""


@cache
def _catalogue(folder: Path, language: str) -> gettext.NullTranslations:
    return gettext.translation(DOMAIN, folder, languages=[language], fallback=True)


class Message(str):
    """An English text of the program; it is translated where it is shown.

    As a field of an error it is translated with the error.
    """

    __slots__ = ()


def message(text: str) -> Message:
    """Mark a constant as a text for the user: it stands in the catalogues."""
    return Message(text)


def two_letters(tag: str) -> str:
    """Return the language of a tag such as ``es_MX.UTF-8``, ``ca@valencia`` or ``es-ES``."""
    name = tag.lower()
    for separator in ".@_-":
        name = name.split(separator)[0]
    return NAMES_ON_WINDOWS.get(name, name)


def system_language() -> str:
    """Return the first language of the environment that the program speaks, or ``en``."""
    wishes = next((os.environ[name] for name in VARIABLES if os.environ.get(name)), None)
    wished = (wishes or locale.getlocale()[0] or "en").split(":")
    return next((two_letters(tag) for tag in wished if two_letters(tag) in LANGUAGES), "en")


class Texts:
    """The catalogue in use; it can be changed while the program runs, or for one block."""

    def __init__(self, language: str) -> None:
        self.use(language)

    def use(self, language: str) -> None:
        """Speak `language` (a tag) from now on, English where no catalogue is found."""
        self._language = two_letters(language)

    @property
    def language(self) -> str:
        """The two letters of the language in use here."""
        return _spoken.get(self._language)

    @contextmanager
    def speaking(self, language: str) -> Iterator[None]:
        """Speak `language` (a tag) inside the block; other threads go on as they were."""
        token = _spoken.set(two_letters(language))
        try:
            yield
        finally:
            _spoken.reset(token)

    def translate(self, text: str) -> str:
        """Return `text` in the language in use."""
        return self._catalogue().gettext(text) if text else ""  # "" is the catalogue's header

    def _catalogue(self) -> gettext.NullTranslations:
        return _catalogue(resource_path("translations"), self.language)

    def describe(self, error: AdibasError) -> str:
        """Return what `error` says, in the language in use."""
        return self.translate(error.message_id).format(**self._translated(error.fields))

    def _translated(self, fields: Mapping[str, object]) -> dict[str, object]:
        return {
            name: self.translate(value) if isinstance(value, Message) else spoken(value)
            for name, value in fields.items()
        }

    def translate_plural(self, singular: str, plural: str, count: int) -> str:
        """Return the form that fits `count`."""
        return self._catalogue().ngettext(singular, plural, count)


_texts = Texts(system_language())
use_language = _texts.use
speaking = _texts.speaking
translate = _texts.translate
translate_plural = _texts.translate_plural
describe = _texts.describe


def spoken_language() -> str:
    """Return the two letters of the language in use here."""
    return _texts.language


def decimal_text(value: float, n_decimals: int) -> str:
    """Return a number as a reader of the language in use expects it on paper; never a ``-0``."""
    return f"{value:z.{n_decimals}f}".replace(".", decimal_mark())


class SpokenNumber(float):
    """A number that a sentence with ``{name:.1f}`` shows as the language in use writes it."""

    def __format__(self, spec: str) -> str:
        return super().__format__(spec).replace(".", decimal_mark())


def spoken(value: object) -> object:
    """Return what a sentence shows of a value: numbers that are no integers as `SpokenNumber`."""
    return SpokenNumber(value) if isinstance(value, float) else value


def decimal_mark() -> str:
    """Return what stands before the decimals in the language in use."""
    return "," if spoken_language() in DECIMAL_COMMA else "."
