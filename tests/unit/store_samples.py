"""Stores, patients and captures for the tests of the session store."""

import itertools
from datetime import UTC, date, datetime, timedelta

import keyring
import numpy as np
import sqlcipher3.dbapi2 as sqlcipher
from keyring.backend import KeyringBackend
from keyring.errors import PasswordDeleteError

from adibas.data.markers import Marker, RejectedBlob
from adibas.data.patients import Consent, Identity
from adibas.data.posture import Provenance
from adibas.data.sessions import SessionSetup
from adibas.data.surface import BurstDisparity
from adibas.sessions import NewCapture, open_store
from adibas.sessions.key_wrapping import Argon2Params
from adibas.sessions.keys import load_key
from tests.unit.recorded_frames import CALIBRATION

PASSPHRASE = "correct horse battery"
CHEAP = Argon2Params(iterations=1, lanes=1, memory_kib=8)
NAME = "Ximena Ñandú-Quetzal"
IDENTITY = Identity(NAME, date(2014, 3, 27), "HC-004711")
START = datetime(2026, 11, 21, 9, 0, tzinfo=UTC)


class MemoryKeyring(KeyringBackend):
    """A keyring that ends with the test."""

    priority = 1

    def __init__(self):
        super().__init__()
        self.entries = {}

    def get_password(self, service, username):
        return self.entries.get((service, username))

    def set_password(self, service, username, password):
        self.entries[service, username] = password

    def delete_password(self, service, username):
        if (service, username) not in self.entries:
            raise PasswordDeleteError("no such entry")
        del self.entries[service, username]


def use_keyring(monkeypatch, backend):
    """Let the program find `backend`, never the desktop's keyring."""
    for name in ("get_password", "set_password", "delete_password"):
        monkeypatch.setattr(keyring, name, getattr(backend, name))
    monkeypatch.setattr(keyring, "get_keyring", lambda: backend)
    return backend


def minutes_clock(start=START, step=timedelta(minutes=5)):
    """A clock that goes on by five minutes at every look."""
    counter = itertools.count()
    return lambda: start + next(counter) * step


def open_sample(folder, **options):
    """The store in `folder` behind `PASSPHRASE`, made where it is missing."""
    options = {"operator": "op", "clock": minutes_clock(), "key_params": CHEAP} | options
    return open_store(folder, PASSPHRASE, **options)


def raw_connection(folder, name="adibas.db"):
    """The database as somebody with the key and without this program opens it."""
    connection = sqlcipher.connect(str(folder / name), isolation_level=None)
    connection.execute(f"PRAGMA key = \"x'{load_key(folder, PASSPHRASE).hex()}'\"")
    return connection


def marker(label="m01", u=30.25, position_m=(0.1, -0.2, 1.9)):
    covariance_m2 = np.diag([1e-6, 2e-6, 1 / 3])
    if position_m is None:
        return Marker(label, u, 20.1, 4.0, np.eye(2) / 3)
    return Marker(label, u, 20.1, 4.0, np.eye(2) / 3, np.array(position_m), covariance_m2)


def new_capture(view="anterior", recording_id="", detected=None, **fields):
    if detected is None:
        detected = (marker(), marker("m02", 61.0), marker("m03", 90.0, None))
    return NewCapture(
        view=view,
        recording_id=recording_id,
        first_frame=2,
        n_frames=30,
        calibration=CALIBRATION,
        detected=detected,
        rejected=(RejectedBlob(5.5, 6.25, "too large for a marker at that distance"),),
        provenance=Provenance("ab", "sha256:cd", "0.1.0", "2026-11-21", {"a": {"b": [1, 0.1]}}),
        notices=("The recording was cut: é.",),
        **fields,
    )


def picture(seed=0):
    return np.random.default_rng(seed).integers(0, 256, (96, 64, 3), dtype=np.uint8)


def surface():
    mean_per_m = np.linspace(0.3, 1.2, 24 * 32, dtype=np.float32).reshape(24, 32)
    mean_per_m[3, 4] = np.nan
    return BurstDisparity(mean_per_m, np.arange(24 * 32, dtype=np.int64).reshape(24, 32), 30)


def consent(*purposes, given_utc=START):
    """What a patient agreed to: treatment if nothing is named."""
    return Consent(purposes or ("treatment",), "Somebody", False, given_utc)


def add_patient(store, identity=IDENTITY, **fields):
    """A patient as a clinic adds one before it measures: with a consent."""
    patient = store.patients.add(identity, **fields)
    return store.patients.give_consent(patient.pseudonym, consent())


def add_session(store, identity=IDENTITY):
    patient = add_patient(store, identity)
    return store.sessions.start(patient.pseudonym, SessionSetup())


def add_capture(store, session=None, **fields):
    session = session or add_session(store)
    return store.captures.add(session.session_id, new_capture(**fields), picture(), surface())


def all_bytes(folder):
    """Everything on the disk, by path."""
    paths = sorted(path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}
