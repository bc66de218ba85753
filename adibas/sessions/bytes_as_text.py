"""Bytes as texts of a JSON document."""

import base64
import binascii
from collections.abc import Mapping


def text_of(data: bytes) -> str:
    """Return bytes as text."""
    return base64.b64encode(data).decode()


def bytes_of(document: Mapping[str, object], name: str) -> bytes:
    """Return the bytes that a text of a document stands for.

    Raises
    ------
    ValueError
        It is missing or damaged.
    """
    value = document.get(name)
    if not isinstance(value, str):
        raise ValueError(f"{name} is missing")  # noqa: TRY004  (the file's fault)
    try:
        return base64.b64decode(value, validate=True)
    except binascii.Error as error:
        raise ValueError(f"{name} is damaged") from error
