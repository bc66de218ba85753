"""Texts for the user, in the user's language.

One set of gettext catalogues under ``resources/translations`` serves core, command line, reports
and window. English is the language of the source: without a catalogue a text stands for itself.
"""

import gettext
import locale
import os

from adibas.errors import AdibasError
from adibas.resources import resource_path

DOMAIN = "adibas"


def system_language() -> str:
    """Return the two-letter language of the environment, or ``en``."""
    chosen = os.environ.get("LANGUAGE") or locale.getlocale()[0] or "en"
    return chosen.split(":")[0].split("_")[0].lower()


class Texts:
    """The catalogue in use; it can be changed while the program runs."""

    def __init__(self, language: str) -> None:
        self.use(language)

    def use(self, language: str) -> None:
        """Speak `language` (two letters) from now on, English where no catalogue is found."""
        self._catalogue = gettext.translation(
            DOMAIN, resource_path("translations"), languages=[language], fallback=True
        )

    def translate(self, text: str) -> str:
        """Return `text` in the language in use."""
        return self._catalogue.gettext(text)

    def describe(self, error: AdibasError) -> str:
        """Return what `error` says, in the language in use."""
        return self.translate(error.message_id).format(**error.fields)

    def translate_plural(self, singular: str, plural: str, count: int) -> str:
        """Return the form that fits `count`."""
        return self._catalogue.ngettext(singular, plural, count)


_texts = Texts(system_language())
use_language = _texts.use
translate = _texts.translate
translate_plural = _texts.translate_plural
describe = _texts.describe
