"""A session as a clinic hands it over: a protocol, two views, a name, and notes that tell it."""

import itertools
from dataclasses import replace

import numpy as np

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.measures import DistanceMeasure
from adibas.data.posture import Provenance
from adibas.data.report import CaptureReport
from adibas.data.sessions import SessionSetup
from adibas.geometry.pinhole import Intrinsics
from adibas.sessions import NewCapture
from tests.unit.standing_points import seen_from, standing
from tests.unit.store_samples import IDENTITY, NAME, add_patient

NOTES = f"{NAME} asked about her back"
SECRETS = (NAME, "Ximena", "Quetzal", "HC-004711", "2014-03-27", "20140327", "her back")
LEVEL_CAMERA = RgbdCalibration(
    color=CameraCalibration(160, 120, Intrinsics(100.0, 100.0, 80.0, 60.0)),
    gravity=np.array([0.0, 1.0, 0.0]),
    gravity_sd_rad=0.002,
    sensor_serial="S-1",
)
PROVENANCE = Provenance("ab" * 32, "sha256:" + "cd" * 32, "0.1.0", "2026-11-21T10:00:00", {})


def add_clinic_session(store, protocol="sapo-1"):
    """Add a patient with one session: front and right side, without ears from the front."""
    patient = add_patient(store, IDENTITY, sex="female")
    session = store.sessions.start(patient.pseudonym, SessionSetup(protocol=protocol))
    session = store.sessions.change(session.session_id, notes=NOTES)
    for view in ("anterior", "right_lateral"):
        markers = seen_from(view, standing())
        new = NewCapture(
            view=view,
            recording_id="",
            first_frame=0,
            n_frames=30,
            calibration=LEVEL_CAMERA,
            detected=tuple(
                one for one in markers if view != "anterior" or "tragus" not in one.label
            ),
            rejected=(),
            provenance=PROVENANCE,
        )
        store.captures.add(session.session_id, new, np.full((120, 160, 3), 90, np.uint8))
    return store.sessions.get(session.session_id)


def secrets_in(data):
    """Return what of the identity is found in bytes, in any encoding that files use."""
    encodings = ("utf-8", "latin-1", "utf-16-le", "utf-16-be")
    return [secret for secret in SECRETS if any(secret.encode(one) in data for one in encodings)]


def hostile(report):
    """Return a session whose names try readers: scripts, marks of formats, what nobody can print.

    One view comes twice, and one was not told.
    """
    names = ("l·l Ωμέγα", "<b>&amp;", "a\x00\x1b[2J", "back\\slash^=", "ñ" * 40, "\ud800")
    first = report.captures[0].analysis
    markers = tuple(
        replace(marker, label=name) for marker, name in zip(first.markers, names, strict=False)
    )
    distances = tuple(
        DistanceMeasure(a, b, 0.3, (0.299, 0.301)) for a, b in itertools.pairwise(names)
    )
    analysis = replace(first, markers=markers, distances=distances, angles=(), measures=None)
    captures = tuple(
        CaptureReport(replace(analysis, view=view)) for view in ("anterior", "anterior", "")
    )
    return replace(report, captures=captures, operator="Dr. \\ ^ \x07 Ñ" * 9, rotation_deg=90)
