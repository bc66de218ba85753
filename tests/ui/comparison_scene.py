"""A patient with sessions of named landmarks, photographed from the front, in a real store."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import cv2
import numpy as np

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.patients import Identity
from adibas.data.posture import Provenance
from adibas.data.sessions import SessionSetup
from adibas.geometry.pinhole import Intrinsics, project
from adibas.geometry.planes import Plane
from adibas.sessions import NewCapture
from tests.unit import store_samples
from tests.unit.standing_points import seen_from, standing

WIDTH, HEIGHT = 640, 512
CAMERA = CameraCalibration(WIDTH, HEIGHT, Intrinsics(525.0, 525.0, 319.5, 255.5))
CALIBRATION = RgbdCalibration(
    color=CAMERA,
    floor=Plane(np.array([0.0, -1.0, 0.0]), 1.0),
    gravity=np.array([0.0, 1.0, 0.0]),
    gravity_sd_rad=0.002,
)
PROVENANCE = Provenance("", "", "1", "2026-01-01T00:00:00+00:00", {})
START = datetime(2026, 3, 2, 9, 0, tzinfo=UTC)


class StepClock:
    """Goes on by a minute at every look, and by days when told."""

    def __init__(self):
        self.now = START

    def __call__(self):
        self.now += timedelta(minutes=1)
        return self.now

    def days_pass(self, n_days):
        self.now += timedelta(days=n_days)


def placed(view, left_acromion_higher_m, rng=None):
    """Return the markers of a view, each with its pixel; with `rng` a millimetre beside."""
    places = standing()
    if rng is not None:
        places = {name: place + rng.normal(0.0, 0.001, 3) for name, place in places.items()}
    places["left_acromion"] = places["left_acromion"] + (0.0, left_acromion_higher_m, 0.0)
    markers = seen_from(view, places)
    for one in markers:
        u, v = project(one.position_m, CAMERA.intrinsics)
        object.__setattr__(one, "u", float(u))
        object.__setattr__(one, "v", float(v))
    return tuple(one for one in markers if 0 <= one.u < WIDTH and 0 <= one.v < HEIGHT)


def painted(markers, tone):
    """Return a wall with a figure made of the markers."""
    picture = np.full((HEIGHT, WIDTH, 3), (205, 200, tone), np.uint8)
    for one in markers:
        cv2.circle(picture, (round(one.u), round(one.v)), 5, (20, 60, 220), -1, cv2.LINE_AA)
    return picture


def add_session(store, patient, height_m, *, views=("anterior",), protocol="sapo-1", rng=None):
    """Add a session whose left acromion is so much higher than the right; return it."""
    session = store.sessions.start(patient, SessionSetup(protocol=protocol))
    for view in views:
        markers = placed(view or "anterior", height_m, rng)
        new = NewCapture(
            view=view,
            recording_id="",
            first_frame=0,
            n_frames=30,
            calibration=CALIBRATION,
            detected=markers,
            rejected=(),
            provenance=PROVENANCE,
        )
        store.captures.add(session.session_id, new, painted(markers, 150 + round(1000 * height_m)))
    return store.sessions.get(session.session_id)


def add_patient(store, name="Somebody"):
    return store_samples.add_patient(store, Identity(name))


def fill_clinic(store, clock, n_patients=10):
    """Measure patients twice, markers placed anew, a millimetre apart or so."""
    rng = np.random.default_rng(7)
    for number in range(n_patients):
        patient = add_patient(store, f"Patient {number}").pseudonym
        for is_repeat in (False, True):
            session = add_session(store, patient, 0.004 * number, rng=rng)
            setup = replace(session.setup, is_repeat=is_repeat)
            store.sessions.change(session.session_id, setup=setup)
        clock.days_pass(1)
