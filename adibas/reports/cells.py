"""Text that a spreadsheet must not take for a formula."""

from functools import lru_cache

from adibas.files import printable

FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")


@lru_cache(maxsize=4096)
def neutralised(text: str) -> str:
    """Put an apostrophe before text that a spreadsheet would run as a formula.

    Source: OWASP, CSV Injection.
    """
    text = printable(text)
    return f"'{text}" if text.startswith(FORMULA_STARTS) else text
