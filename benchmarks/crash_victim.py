"""Works in a store, tells what has been saved, and waits to be killed."""

import json
import time
import zlib
from dataclasses import replace
from datetime import date
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Protocol

import numpy as np

from adibas.arrays import UInt8Array
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.corrections import CorrectionHistory, MarkerCorrection
from adibas.data.frames import EncodedImage, SensorFrame, SourceInfo
from adibas.data.markers import Marker
from adibas.data.patients import PURPOSE_OF_CAPTURE, Consent, Identity
from adibas.data.posture import VIEWS, Provenance
from adibas.data.sessions import Capture, SessionSetup
from adibas.data.surface import BurstDisparity
from adibas.geometry.pinhole import Intrinsics
from adibas.recordings import RecordingOptions
from adibas.recordings.rvl import encode_rvl
from adibas.sessions import NewCapture, SessionStore, open_store
from adibas.sessions.key_wrapping import Argon2Params

PASSPHRASE = "long enough for a store that nobody needs"  # noqa: S105
CHEAP = Argon2Params(iterations=1, lanes=1, memory_kib=8)
FRAME_NS = 33_333_333
MOST_FRAMES = 300
SECONDS_A_FRAME = 0.001
SHAPE = (24, 32)
CALIBRATION = RgbdCalibration(color=CameraCalibration(80, 60, Intrinsics(70, 70, 40, 30)))

# Loaded once before the processes part; else each of them would spend its life on it.
encode_rvl(np.zeros(SHAPE, np.uint16))


class Said(Protocol):
    """Takes one JSON list for each thing that the store has acknowledged."""

    def send_bytes(self, data: bytes, /) -> None:
        """Take the next one."""


class Victim:
    """One process' work.

    Parameters
    ----------
    said : Said
        Such as a connection to another process.
    most_frames : int
        Of a recording.
    """

    def __init__(
        self,
        store: SessionStore,
        said: Said,
        rng: np.random.Generator,
        most_frames: int = MOST_FRAMES,
    ) -> None:
        self._most_frames = most_frames
        self._store = store
        self._said = said
        self._rng = rng

    def _say(self, *words: str | int) -> None:
        self._said.send_bytes(json.dumps(words).encode())

    def work_for_ever(self) -> None:
        """Add a patient; then one session after the other with recording and captures."""
        pseudonym = self.add_patient()
        while True:
            self.work_once(pseudonym)

    def add_patient(self) -> str:
        """Add a patient; return the pseudonym."""
        identity = Identity("Somebody", date(1990, 1, 2), str(self._rng.integers(10**6)))
        patient = self._store.patients.add(identity)
        consent = Consent((PURPOSE_OF_CAPTURE,), identity.name, False, patient.created_utc)
        self._store.patients.give_consent(patient.pseudonym, consent)
        self._say("patient", patient.pseudonym)
        return patient.pseudonym

    def work_once(self, pseudonym: str) -> None:
        """Take one session with a recording and captures."""
        session = self._store.sessions.start(pseudonym, SessionSetup())
        self._say("session", session.session_id)
        recording_id = self._record(session.session_id)
        for view in VIEWS:
            self._correct(self._capture(session.session_id, recording_id, view))

    def _record(self, session_id: str) -> str:
        writer = self._store.recordings.create(session_id, SourceInfo(), RecordingOptions())
        with writer:
            for i in range(int(self._rng.integers(1, self._most_frames))):
                time.sleep(SECONDS_A_FRAME)
                writer.write(self._frame(i))
                self._say("frame", writer.recording_id, i)
        self._say("recording", writer.recording_id, writer.n_frames)
        return writer.recording_id

    def _frame(self, number: int) -> SensorFrame:
        time_ns = number * FRAME_NS
        depth = self._rng.integers(0, 9000, SHAPE, dtype=np.uint16)
        color = EncodedImage("jpeg", self._rng.bytes(int(self._rng.integers(500, 30_000))))
        return SensorFrame(number, time_ns, depth, color, time_ns)

    def _capture(self, session_id: str, recording_id: str, view: str) -> Capture:
        picture: UInt8Array = self._rng.integers(0, 256, (60, 80, 3), dtype=np.uint8)
        surface = BurstDisparity(np.ones(SHAPE, np.float32), np.full(SHAPE, 9, np.int64), 9)
        new = NewCapture(
            view=view,
            recording_id=recording_id,
            first_frame=0,
            n_frames=1,
            calibration=CALIBRATION,
            detected=(marker("m01", 10.0), marker("m02", 20.0)),
            rejected=(),
            provenance=Provenance("", "", "", "2026-01-01T00:00:00+00:00", {}),
        )
        capture = self._store.captures.add(session_id, new, picture, surface)
        self._say("capture", capture.capture_id, zlib.crc32(picture.tobytes()))
        return capture

    def _correct(self, capture: Capture) -> None:
        """Move a marker some times, each change saved."""
        corrections: tuple[MarkerCorrection, ...] = ()
        before = capture.detected[0]
        for i in range(1, int(self._rng.integers(1, 4))):
            after = replace(before, u=before.u + i)
            corrections = (*corrections, MarkerCorrection(before, after))
            history = CorrectionHistory(corrections, len(corrections))
            self._store.captures.correct(capture.capture_id, history)
            self._say("correction", capture.capture_id, len(corrections))
            before = after


def marker(label: str, u: float) -> Marker:
    """Return a marker without a position."""
    return Marker(label, u, 5.0, 3.0, np.eye(2))


def work(folder: str, seed: int, said: Connection) -> None:
    """Open the store and work in it until the process is killed."""
    rng = np.random.default_rng(seed)
    with open_store(Path(folder), PASSPHRASE, operator="victim", key_params=CHEAP) as store:
        said.send_bytes(b'["opened"]')
        Victim(store, said, rng).work_for_ever()
