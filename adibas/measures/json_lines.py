"""JSON of which every value knows its line, so that a mistake can be shown where it stands.

Hostile files are refused: too large, too deep, keys that come twice, numbers that are none.
"""

import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from adibas.errors import ProtocolError

LARGEST_FILE = 4_000_000
"""Characters; the largest protocol that is shipped has 40,000."""
DEEPEST = 16
LONGEST_NUMBER = 40

_DECODER = json.JSONDecoder()
_BLANK = re.compile(r"[ \t\r\n]*")
_NUMBER = re.compile(r"-?(?:0|[1-9]\d*)(?:\.\d+)?(?:[eE][-+]?\d+)?")
_WORDS: dict[str, bool | None] = {"true": True, "false": False, "null": None}

Value: TypeAlias = "dict[str, Node] | list[Node] | str | float | bool | None"


@dataclass(frozen=True, slots=True)
class Node:
    """A value, and the line that it begins on, from 1."""

    value: Value
    line: int


def parse_lines(text: str, file: str) -> Node:
    """Return the document in `text`.

    Parameters
    ----------
    text : str
        JSON.
    file : str
        Its name, for the error.

    Raises
    ------
    ProtocolError
        It is no JSON, larger than a protocol can be, or has a key twice.
    """
    if len(text) > LARGEST_FILE:
        raise ProtocolError(
            "{file} is larger than any protocol. Choose a protocol file.", file=file
        )
    return _Reader(text, file).document()


class _Reader:
    """Goes through the text once, from left to right."""

    def __init__(self, text: str, file: str) -> None:
        self._text = text
        self._file = file
        self._at = 0
        self._line = 1
        self._counted_to = 0
        self._depth = 0

    def document(self) -> Node:
        node = self._value()
        self._skip_blank()
        if self._at < len(self._text):
            raise self._broken()
        return node

    def _value(self) -> Node:
        self._skip_blank()
        line = self._current_line()
        match self._text[self._at : self._at + 1]:
            case "{":
                return Node(self._nested(self._object), line)
            case "[":
                return Node(self._nested(self._array), line)
            case '"':
                return Node(self._string(), line)
            case _:
                return Node(self._plain(), line)

    def _nested(self, read: "Callable[[], dict[str, Node] | list[Node]]") -> Value:
        self._depth += 1
        if self._depth > DEEPEST:
            raise ProtocolError(
                "{file}, line {line}: brackets are nested deeper than in any protocol. Close them.",
                file=self._file,
                line=self._current_line(),
            )
        self._at += 1
        found = read()
        self._depth -= 1
        return found

    def _object(self) -> dict[str, Node]:
        found: dict[str, Node] = {}
        while not self._closes("}", is_first=not found):
            self._skip_blank()
            line = self._current_line()
            key = self._string()
            if key in found:
                raise ProtocolError(
                    "{file}, line {line}: {key} stands twice. Remove one of them.",
                    file=self._file,
                    line=line,
                    key=key,
                )
            self._take(":")
            found[key] = self._value()
        return found

    def _array(self) -> list[Node]:
        found: list[Node] = []
        while not self._closes("]", is_first=not found):
            found.append(self._value())
        return found

    def _closes(self, bracket: str, *, is_first: bool) -> bool:
        """Say whether the bracket closes here; if not, take the comma before the next value."""
        self._skip_blank()
        if self._text.startswith(bracket, self._at):
            self._at += 1
            return True
        if not is_first:
            self._take(",")
        return False

    def _string(self) -> str:
        if not self._text.startswith('"', self._at):
            raise self._broken()
        try:
            text, self._at = _DECODER.raw_decode(self._text, self._at)
        except json.JSONDecodeError as error:
            raise self._broken() from error
        return str(text)

    def _plain(self) -> float | bool | None:
        for word, value in _WORDS.items():
            if self._text.startswith(word, self._at):
                self._at += len(word)
                return value
        found = _NUMBER.match(self._text, self._at)
        if found is None or len(found.group()) > LONGEST_NUMBER:
            raise self._broken()
        number = float(found.group())
        if not math.isfinite(number):
            raise self._broken()
        self._at = found.end()
        return number

    def _take(self, sign: str) -> None:
        self._skip_blank()
        if not self._text.startswith(sign, self._at):
            raise self._broken()
        self._at += 1

    def _skip_blank(self) -> None:
        found = _BLANK.match(self._text, self._at)
        self._at = self._at if found is None else found.end()

    def _current_line(self) -> int:
        self._line += self._text.count("\n", self._counted_to, self._at)
        self._counted_to = self._at
        return self._line

    def _broken(self) -> ProtocolError:
        return ProtocolError(
            "{file}, line {line}: this is no JSON. Look for a missing comma, quotation mark or "
            "bracket there or in the line before.",
            file=self._file,
            line=self._current_line(),
        )
