"""One line of JSON, as the tables keep what has no column of its own."""

import json
from typing import Any


def to_json(value: object) -> str:
    """Return `value` as one line; equal values give equal lines."""
    return json.dumps(value, sort_keys=True, ensure_ascii=False, separators=(",", ":"))


def from_json(text: str) -> Any:
    """Return what a line holds."""
    return json.loads(text)
