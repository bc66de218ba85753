"""The window: how soon it is usable, what drawing costs, and how long the user waits."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from datetime import UTC, date, datetime
from functools import partial
from pathlib import Path

import numpy as np

from adibas.data.markers import Marker
from adibas.data.patients import PURPOSE_OF_CAPTURE, Consent, Identity
from adibas.data.posture import Provenance
from adibas.data.sessions import SessionSetup
from adibas.sensors.simulator import SimulatorCamera
from adibas.sessions import NewCapture, SessionStore, open_store
from benchmarks.memory_keyring import dumped, use_memory_keyring
from benchmarks.startup_probe import KEY_VARIABLE
from benchmarks.table import Row

SEED = 11
PASSPHRASE = "four words are enough"  # noqa: S105  (of a store that is thrown away)


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` fewer rounds, patients and sessions."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    ring = use_memory_keyring()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with open_store(folder / "store") as store:
            yield from _search_rows(store, n_patients=500 if quick else 10_000)
            yield from _session_rows(store, n_sessions=20 if quick else 1_000)
        os.environ[KEY_VARIABLE] = dumped(ring)
        yield from _startup_rows(folder, n_rounds=2 if quick else 9)
        yield from _block_rows(folder, n_rounds=1 if quick else 3)
        yield from _drawing_rows(folder, n_blocks=3 if quick else 20)


def _startup_rows(folder: Path, n_rounds: int) -> Iterable[Row]:
    """Time the windows in turn, so that a busy moment of the machine meets all of them."""
    with open_store(folder / "locked" / "store", PASSPHRASE):
        pass
    places = {"empty": folder, "passphrase": folder / "locked", "patients": folder}
    times: dict[str, list[float]] = {kind: [] for kind in places}
    for _ in range(n_rounds + 1):
        for kind, place in places.items():
            work = partial(_told_by, "startup_probe", kind, str(place), compiled=folder)
            times[kind].append(_seconds(work))
    empty_s, *ours_s = (float(np.median(seconds[1:])) for seconds in times.values())
    yield Row("an empty PySide6 + pyqtgraph window, warm", empty_s, "s")
    for told, seconds in zip(
        (
            "window that can be used (asks for the passphrase)",
            "patients listed (key from a keyring)",
        ),
        ours_s,
        strict=True,
    ):
        yield Row(f"{told}, over the empty one", seconds / empty_s, "x", 1.6, "goal <=")


def _block_rows(folder: Path, n_rounds: int) -> Iterable[Row]:
    """Go through all screens with the live simulator; note how long the window did not answer."""
    blocks = _told_by("block_probe", str(folder), str(n_rounds), compiled=folder)
    blocks_ms: dict[str, tuple[float, float]] = json.loads(blocks)
    told = "longest block of the window, all screens with the live simulator"
    where = max(blocks_ms, key=lambda name: blocks_ms[name][0])
    yield Row(f"{told} (in {where})", blocks_ms[where][0], "ms")
    where = max(blocks_ms, key=lambda name: blocks_ms[name][1])
    yield Row(f"{told}: the thread's own work (in {where})", blocks_ms[where][1], "ms of CPU")


def _search_rows(store: SessionStore, n_patients: int) -> Iterable[Row]:
    rng = np.random.default_rng(SEED)
    first = ("Ana", "Joan", "María", "Núria", "Pere", "Lluís", "Sofia", "Marc", "Àngels", "José")
    last = ("García", "Puig", "Martí", "Soler", "López", "Vila", "Serra", "Roca", "Ferrer", "Mas")
    for index in range(n_patients):
        name = f"{rng.choice(first)} {rng.choice(last)} {rng.choice(last)}"
        born = date(1940 + int(rng.integers(75)), 1 + int(rng.integers(12)), 5)
        store.patients.add(Identity(name, born, f"R{index:05d}"))
    typed = ("g", "ga", "gar", "garc", "garcia", "jose", "mas ", "R0012", "194", "zz")
    times_ms = [1e3 * _seconds(partial(store.patients.search, text)) for text in typed]
    told = f"search among {n_patients} patients: slowest of {len(times_ms)} keys"
    yield Row(told, max(times_ms), "ms", 50.0, "goal <=")


def _session_rows(store: SessionStore, n_sessions: int) -> Iterable[Row]:
    """Open sessions of one capture with a picture of 1280 x 1024 and 15 markers."""
    (patient, *_others) = store.patients.search("", limit=1)
    camera = SimulatorCamera("anterior")
    frame = camera.read()
    info = camera.info
    camera.close()
    if frame is None or info.calibration is None:
        raise ValueError("the simulator gives no frame")
    picture_rgb = np.random.default_rng(SEED).integers(0, 256, (1024, 1280, 3), dtype=np.uint8)
    markers = tuple(
        Marker(f"m{i:02d}", 40.0 * i, 50.0 * i, 4.0, np.eye(2), np.ones(3), np.eye(3) * 1e-6)
        for i in range(1, 16)
    )
    consent = Consent((PURPOSE_OF_CAPTURE,), patient.identity.name, False, store.audit.now_utc())
    store.patients.give_consent(patient.pseudonym, consent)
    ids = []
    for _ in range(n_sessions):
        session = store.sessions.start(patient.pseudonym, SessionSetup())
        with store.recordings.create(session.session_id, info) as writer:
            writer.write(frame)
        new = NewCapture(
            view="anterior",
            recording_id=writer.recording_id,
            first_frame=0,
            n_frames=1,
            calibration=info.calibration,
            detected=markers,
            rejected=(),
            provenance=Provenance("", "", "", "", {}),
            captured_utc=datetime.now(UTC),
        )
        store.captures.add(session.session_id, new, picture_rgb, None)
        ids.append(session.session_id)

    def open_one(session_id: str) -> None:
        store.sessions.get(session_id)
        for capture in store.captures.of_session(session_id):
            capture.markers()
            store.captures.picture(capture.capture_id)

    chosen = np.random.default_rng(SEED).choice(ids, min(20, n_sessions), replace=False)
    times_ms = [1e3 * _seconds(partial(open_one, str(one))) for one in chosen]
    told = f"open a saved session out of {n_sessions}: median of {len(times_ms)}"
    yield Row(told, float(np.median(times_ms)), "ms", 300.0, "goal <=")


def _drawing_rows(folder: Path, n_blocks: int) -> Iterable[Row]:
    """Draw in a process of its own, whose OpenCV is set up as in the program."""
    told = _told_by("drawing_probe", str(n_blocks), compiled=folder)
    small, large, least, slowest_ms = (float(word) for word in told.split())
    name = "drawing 640x480 colour + depth with overlays at 30 frames/s: share of a core"
    yield Row(f"{name}, window of 1280x800", 100 * small, "%", 5.0, "goal <=")
    yield Row(f"{name}, window of 1280x800, least disturbed second", 100 * least, "%")
    yield Row(f"{name}, window of 1920x1080", 100 * large, "%")
    name = "a step of the sensitivity at 1280x1024, slowest"
    yield Row(name, slowest_ms, "ms", 50.0, "goal <=")


def _told_by(probe: str, *arguments: str, compiled: Path) -> str:
    """Return what a probe prints: in a process of its own the window is as the program has it.

    An installed program was compiled once: what Python compiles lies in `compiled`, whatever the
    caller's environment says.
    """
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(compiled / "bytecode")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    command = [sys.executable, "-m", f"benchmarks.{probe}", *arguments]
    done = subprocess.run(  # noqa: S603
        command, check=True, capture_output=True, text=True, env=environment
    )
    return done.stdout


def _seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start
