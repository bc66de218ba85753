"""Text as files can hold it, and that a spreadsheet must not take for a formula."""

import re
from functools import lru_cache

FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")
UNPRINTABLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff\ufffe\uffff]")
"""No XML file holds these; tab and line feed may stay."""


def printable(text: str) -> str:
    """Return the text with a box in place of characters that no file holds."""
    return UNPRINTABLE.sub("\N{WHITE SQUARE}", text)


@lru_cache(maxsize=4096)
def neutralised(text: str) -> str:
    """Put an apostrophe before text that a spreadsheet would run as a formula.

    Source: OWASP, CSV Injection.
    """
    text = printable(text)
    return f"'{text}" if text.startswith(FORMULA_STARTS) else text
