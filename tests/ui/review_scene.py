"""A patient, a session and a capture of a wall with blue dots, saved in a real store."""

from contextlib import contextmanager

import cv2
import numpy as np

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.markers import Marker, RejectedBlob
from adibas.data.patients import Identity
from adibas.data.posture import Provenance
from adibas.data.sessions import SessionSetup
from adibas.data.surface import BurstDisparity
from adibas.geometry.pinhole import Intrinsics
from adibas.pipeline.review import CaptureSurface
from adibas.sessions import NewCapture
from tests.unit.store_samples import add_patient
from ui.review.presenter import ReviewPresenter

WIDTH, HEIGHT = 320, 256
WALL_M = 1.0
COLOR = CameraCalibration(WIDTH, HEIGHT, Intrinsics(280.0, 280.0, 160.0, 128.0))
DEPTH = CameraCalibration(WIDTH, HEIGHT, Intrinsics(280.0, 280.0, 160.0, 128.0))
CALIBRATION = RgbdCalibration(COLOR, DEPTH)
SURFACE = BurstDisparity(
    np.full((HEIGHT, WIDTH), 1.0 / WALL_M, np.float32),
    np.full((HEIGHT, WIDTH), 30, np.int64),
    30,
)
DOTS = {"m01": (80.0, 60.0), "m02": (240.0, 60.0), "m03": (160.0, 200.0)}
UNNOTICED = (100.0, 150.0)
"""A dot of the picture that the program did not find."""
REFUSED = RejectedBlob(60.0, 220.0, "It is too large for a marker.")


def picture_rgb():
    """Return the wall with its dots."""
    picture = np.full((HEIGHT, WIDTH, 3), (205, 170, 150), np.uint8)
    for u, v in (*DOTS.values(), UNNOTICED):
        cv2.circle(picture, (round(u), round(v)), 4, (20, 60, 220), -1, cv2.LINE_AA)
    return picture


def detected(names=DOTS):
    """Return the markers as the program found them."""
    surface = CaptureSurface(SURFACE, CALIBRATION)
    return tuple(
        surface.measured(label, *place, np.eye(2) * 0.04, 4.0) for label, place in names.items()
    )


def mm_between(a, b):
    """Return the distance of two pixels on the wall."""
    return float(np.hypot(a[0] - b[0], a[1] - b[1]) / 280.0 * WALL_M * 1000.0)


def new_capture(view="anterior", markers=None, calibration=CALIBRATION):
    """Return a capture before it is saved."""
    return NewCapture(
        view=view,
        recording_id="",
        first_frame=0,
        n_frames=30,
        calibration=calibration,
        detected=detected() if markers is None else markers,
        rejected=(REFUSED,),
        provenance=Provenance("", "", "1", "2024-01-01T00:00:00+00:00", {}),
        notices=("Markers were corrected by hand.",),
    )


def saved_session(
    store,
    views=("anterior",),
    *,
    surface=SURFACE,
    rotation_deg=0,
    protocol="",
    calibration=CALIBRATION,
):
    """Save a patient with one session and return (patient, session, captures)."""
    patient = add_patient(store, Identity("Somebody"))
    setup = SessionSetup(rotation_deg=rotation_deg, protocol=protocol)
    session = store.sessions.start(patient.pseudonym, setup)
    captures = tuple(
        store.captures.add(
            session.session_id, new_capture(view, None, calibration), picture_rgb(), surface
        )
        for view in views
    )
    return patient, store.sessions.get(session.session_id), captures


def places(capture):
    """Return label -> (u, v), rounded, of a capture's markers as corrected."""
    return {one.label: (round(one.u, 3), round(one.v, 3)) for one in capture.markers()}


def told(workspace):
    """Return the list that every notice of the window is added to from now on."""
    sentences = []
    workspace.noticed.subscribe(lambda kind, sentence: sentences.append((kind, sentence)))
    return sentences


def plain_marker(label, u=0.0, v=0.0):
    """Return a marker without a position."""
    return Marker(label, u, v, 2.0, np.eye(2))


@contextmanager
def entered_review(view, workspace, saved):
    """Give the review of a saved session, its first capture open."""
    patient, session, _captures = saved
    workspace.choose_patient(patient)
    workspace.choose_session(session)
    presenter = ReviewPresenter(view, workspace)
    presenter.entered()
    yield presenter
    presenter.close()
