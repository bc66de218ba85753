"""The window: how soon it is usable, what drawing costs, and how long the user waits."""

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
from adibas.data.patients import Identity
from adibas.data.posture import Provenance
from adibas.data.sessions import SessionSetup
from adibas.pipeline.frozen import freeze
from adibas.pipeline.live import LiveFrame, LiveView, SensorState
from adibas.sensors.ports import SensorOptions
from adibas.sensors.simulator import SimulatorCamera
from adibas.sessions import NewCapture, SessionStore, open_store
from benchmarks.memory_keyring import dumped, use_memory_keyring
from benchmarks.startup_probe import KEY_VARIABLE
from benchmarks.table import Row

SEED = 11
FRAME_RATE_HZ = 30
PASSPHRASE = "four words are enough"  # noqa: S105  (of a store that is thrown away)
START_S, SECONDS_A_SCREEN = 3.0, 4.0
SLIDER_STEPS = (6, 12, 18, 24, 30, 36, 42, 48, 54, 60)


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
    yield from _drawing_rows(n_rounds=30 if quick else 200)
    yield from _slider_rows()


def _startup_rows(folder: Path, n_rounds: int) -> Iterable[Row]:
    """Time the windows in turn, so that a busy moment of the machine meets all of them."""
    with open_store(folder / "locked" / "store", PASSPHRASE):
        pass
    places = {"empty": folder, "passphrase": folder / "locked", "patients": folder}
    times: dict[str, list[float]] = {kind: [] for kind in places}
    for _ in range(n_rounds + 1):
        for kind, place in places.items():
            command = [sys.executable, "-m", "benchmarks.startup_probe", kind, str(place)]
            start = time.perf_counter()
            subprocess.run(command, check=True, capture_output=True)  # noqa: S603
            times[kind].append(time.perf_counter() - start)
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
    from PySide6.QtWidgets import QApplication

    from benchmarks.heartbeat import Heartbeat
    from ui.application import Application
    from ui.navigation import TITLES
    from ui.preferences import PreferencesFile
    from ui.screens import preload

    app = QApplication.instance()
    if not isinstance(app, QApplication):
        app = QApplication([])
    preload().join()
    preferences = PreferencesFile(folder / "preferences.json")
    application = Application(app, preferences, folder / "store")
    heartbeat = Heartbeat(app)
    application.start()
    heartbeat.live_through("start", START_S)
    for _ in range(n_rounds):
        for name in TITLES:
            application.window.show_screen(name)
            heartbeat.live_through(name, SECONDS_A_SCREEN)
    heartbeat.stop()
    application.close()
    where, longest_ms = heartbeat.longest()
    told = f"longest block of the window, all screens with the live simulator (in {where})"
    yield Row(told, longest_ms, "ms")


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


def _drawing_rows(n_rounds: int) -> Iterable[Row]:
    """Count the CPU time of drawing alone: conversion, overlays and painting of both pictures."""
    from PySide6.QtWidgets import QApplication

    from ui.capture.view import CaptureScreen

    app = QApplication.instance() or QApplication([])
    frames = _live_frames(n_frames=4, color_size=(640, 480))
    screen = CaptureScreen()
    screen.show_both()
    screen.resize(1280, 800)
    screen.show()
    app.processEvents()
    for frame in frames:
        screen.show_frame(frame)
        app.processEvents()
    start_s = time.process_time()
    for index in range(n_rounds):
        screen.show_frame(frames[index % len(frames)])
        app.processEvents()
    per_frame_s = (time.process_time() - start_s) / n_rounds
    screen.close()
    told = "drawing 640x480 colour + depth with overlays at 30 frames/s: share of a core"
    yield Row(told, 100 * per_frame_s * FRAME_RATE_HZ, "%", 5.0, "goal <=")


def _slider_rows() -> Iterable[Row]:
    """Time a step of the sensitivity: the region grows, and the picture with it is drawn."""
    from PySide6.QtWidgets import QApplication

    from adibas.markers.color_model import LearningParams
    from adibas.pipeline.learning_board import LearningBoard
    from ui.widgets.image_view import ImageView
    from ui.widgets.overlays import Region

    app = QApplication.instance() or QApplication([])
    (frame,) = _live_frames(n_frames=1, color_size=(1280, 1024))
    picture = freeze(frame, None)
    if picture is None:
        raise ValueError("the simulator gives no colour")
    board = LearningBoard(picture.color_rgb, LearningParams())
    board.click(640, 300)
    view = ImageView()
    view.resize(900, 720)
    view.show()
    view.set_picture(picture.color_rgb)
    times_ms = []
    for sensitivity in (*SLIDER_STEPS, *SLIDER_STEPS):

        def step(sensitivity: float = sensitivity) -> None:
            board.set_sensitivity(sensitivity)
            view.set_overlays((Region(board.taken(), "selected", is_filled=True),))
            app.processEvents()

        times_ms.append(1e3 * _seconds(step))
    view.close()
    slowest = max(times_ms[len(SLIDER_STEPS) :])
    yield Row("a step of the sensitivity at 1280x1024, slowest", slowest, "ms", 50.0, "goal <=")


def _live_frames(n_frames: int, color_size: tuple[int, int]) -> tuple[LiveFrame, ...]:
    """Return frames as the live view of the simulator gives them."""
    import threading

    class Listener:
        """Keeps the first frames in which somebody is seen."""

        def __init__(self) -> None:
            self.frames: list[LiveFrame] = []
            self.is_full = threading.Event()

        def frame_arrived(self, frame: LiveFrame) -> None:
            """Keep a frame."""
            if frame.outline is not None:
                self.frames.append(frame)
            if len(self.frames) >= n_frames:
                self.is_full.set()

        def state_changed(self, state: SensorState) -> None:
            """Want no states."""

    listener = Listener()
    live = LiveView(listener)
    live.open("simulator", SensorOptions(color_size=color_size))
    listener.is_full.wait(120)
    live.close()
    return tuple(listener.frames[:n_frames])


def _seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start
