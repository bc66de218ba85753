"""The demo patient's session in a store: four views of the simulator, taken as a user would."""

import threading
from collections.abc import Mapping

from adibas.clock import Clock, utc_now
from adibas.data.posture import VIEWS
from adibas.data.sessions import Session, SessionSetup
from adibas.errors import SensorError
from adibas.pipeline.capturing import CaptureRequest, take_capture
from adibas.pipeline.live import LiveFrame, LiveView, SensorState
from adibas.pipeline.posture import MarkerTarget
from adibas.pipeline.targets import target_to_document
from adibas.progress import Progress
from adibas.sensors.ports import SensorOptions
from adibas.sessions import SessionStore
from adibas.sessions.demo_patient import demo_patient

SOURCE = "simulator"
LONGEST_WAIT_S = 60.0
"""For the first picture of the simulator on a busy computer."""


def take_demo_session(
    store: SessionStore,
    target: MarkerTarget,
    n_frames: int,
    progress: Progress,
    clock: Clock = utc_now,
) -> Session:
    """Take the four views of the demo patient through the live view of the simulator.

    It takes the place of the sessions of demos before; one that somebody has worked on stays.

    Raises
    ------
    StoreError, RecordingError
        The store cannot be written.
    SensorError
        The simulator gives no picture in a minute.
    """
    document: Mapping[str, object] = target_to_document(target)
    setup = SessionSetup(source=SOURCE, markers=document)
    patient = demo_patient(store).pseudonym
    before = store.sessions.of_patient(patient)
    session = store.sessions.start(patient, setup)
    for number, view in enumerate(VIEWS):
        request = CaptureRequest(session.session_id, view, n_frames, target)

        def told(done: int, total: int, number: int = number) -> None:
            progress(number * total + done, len(VIEWS) * total)

        _take(store, request, told, clock)
    for older in before:
        if not _was_worked_on(store, older):
            store.sessions.purge(older.session_id)
    return store.sessions.get(session.session_id)


def _was_worked_on(store: SessionStore, session: Session) -> bool:
    captures = store.captures.of_session(session.session_id)
    return bool(session.notes) or any(one.history.corrections for one in captures)


def _take(store: SessionStore, request: CaptureRequest, progress: Progress, clock: Clock) -> None:
    listener = _FirstFrame()
    live = LiveView(listener)
    try:
        live.open(f"{SOURCE}:{request.view}", SensorOptions())
        if not listener.has_come.wait(LONGEST_WAIT_S):
            raise SensorError("The simulator gives no picture. Close other programs and try again.")
        take_capture(store, live, request, progress, clock)
    finally:
        live.close()


class _FirstFrame:
    """Waits for a sensor to be live."""

    def __init__(self) -> None:
        self.has_come = threading.Event()

    def frame_arrived(self, _frame: LiveFrame) -> None:
        """Note the frame."""
        self.has_come.set()

    def state_changed(self, _state: SensorState) -> None:
        """Want no states: a frame says enough."""
