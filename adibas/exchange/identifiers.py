"""Names for the world that are the same every time the same thing is handed over.

A receiver that gets a session twice must see that it is the same session. Nobody has to be asked
for such a name: it is computed from random ids of the store (RFC 9562, version 5).

Source: DICOM PS3.5, annex B.2 (2.25 and a UUID as a decimal number).
"""

import uuid

NAMESPACE = uuid.UUID("5f0f2c3e-6d53-4f0c-9a6b-1f3c7f3a8e21")
"""Random, of this program."""


def stable_uuid(*parts: str) -> str:
    """Return the UUID of what the parts name."""
    return str(_uuid(*parts))


def stable_uid(*parts: str) -> str:
    """Return the DICOM UID of what the parts name."""
    return f"2.25.{_uuid(*parts).int}"


def _uuid(*parts: str) -> uuid.UUID:
    # Lengths keep ("ab", "c") apart from ("a", "bc"); half a character may stand in what was typed.
    escaped = [part.encode("unicode_escape").decode() for part in parts]
    return uuid.uuid5(NAMESPACE, "".join(f"{len(part)}:{part}" for part in escaped))
