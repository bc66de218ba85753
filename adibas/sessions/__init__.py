"""The store of patients, sessions, captures and their sealed files.

What needs the database is imported when it is first asked for: SQLAlchemy takes a quarter of a
second, and the window can ask for the passphrase meanwhile.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from adibas.errors import StoreError
from adibas.sessions.keys import KeyState, change_passphrase, key_state
from adibas.sessions.places import default_store_folder

if TYPE_CHECKING:
    from adibas.sessions.audit import AuditEntry
    from adibas.sessions.captures import NewCapture
    from adibas.sessions.opening import open_store
    from adibas.sessions.patient_search import PatientRow
    from adibas.sessions.store import SessionStore
    from adibas.sessions.stored_recordings import RecordingFacts, StoredRecordingWriter
    from adibas.sessions.verification import Finding, VerifyReport

_MODULES = {
    "AuditEntry": "audit",
    "Finding": "verification",
    "NewCapture": "captures",
    "PatientRow": "patient_search",
    "RecordingFacts": "stored_recordings",
    "SessionStore": "store",
    "StoredRecordingWriter": "stored_recordings",
    "VerifyReport": "verification",
    "open_store": "opening",
}

__all__ = [
    "AuditEntry",
    "Finding",
    "KeyState",
    "NewCapture",
    "PatientRow",
    "RecordingFacts",
    "SessionStore",
    "StoreError",
    "StoredRecordingWriter",
    "VerifyReport",
    "change_passphrase",
    "default_store_folder",
    "key_state",
    "open_store",
]


def __getattr__(name: str) -> Any:
    """Import what is asked for."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
