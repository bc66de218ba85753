"""The store of patients, sessions, captures and their sealed files."""

from adibas.errors import StoreError
from adibas.sessions.audit import AuditEntry
from adibas.sessions.captures import NewCapture
from adibas.sessions.keys import KeyState, change_passphrase, key_state
from adibas.sessions.patients import PatientRow
from adibas.sessions.store import SessionStore, default_store_folder, open_store
from adibas.sessions.stored_recordings import RecordingFacts, StoredRecordingWriter
from adibas.sessions.verification import Finding, VerifyReport

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
