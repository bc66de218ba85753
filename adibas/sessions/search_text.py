"""Texts as the search compares them: small letters without accents."""

import unicodedata
from datetime import date

from adibas.data.patients import Identity

ESCAPE = "\\"


def simplified(text: str) -> str:
    """Return `text` in small letters, without accents, with single spaces."""
    # Twice: a letter's compatible form may be a capital, and a small letter may come apart.
    folded = unicodedata.normalize("NFKD", text).casefold()
    parts = unicodedata.normalize("NFKD", folded)
    plain = "".join(letter for letter in parts if not unicodedata.combining(letter))
    return " ".join(plain.split())


def searchable(identity: Identity, pseudonym: str) -> str:
    """Return everything by which a patient is found: name, number, pseudonym, birth date."""
    known = [identity.name, identity.record_number, pseudonym, *date_texts(identity.birth_date)]
    return simplified(" ".join(known))


def patterns(text: str) -> list[str]:
    """Return a LIKE pattern for each word of a search."""
    escaped = simplified(text)
    for letter in (ESCAPE, "%", "_"):
        escaped = escaped.replace(letter, ESCAPE + letter)
    return [f"%{word}%" for word in escaped.split()]


def date_texts(day: date | None) -> list[str]:
    """Return a date as it may be typed; nothing of one that is not known."""
    if day is None:
        return []
    return [day.isoformat(), f"{day:%d/%m/%Y}", f"{day:%d.%m.%Y}"]
