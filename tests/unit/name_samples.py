"""Captures whose markers somebody named, in a real store."""

import numpy as np

from adibas.data.corrections import CorrectionHistory, MarkerCorrection
from adibas.data.sessions import SessionSetup
from tests.unit.store_samples import IDENTITY, add_capture, add_patient, add_session, marker

PLACES = {
    "chin": (0.0, -0.6, 2.0),
    "left_side": (0.3, -0.1, 2.1),
    "right_side": (-0.3, -0.1, 2.1),
    "navel": (0.0, 0.2, 1.9),
}


def add_example(store, session, rng, *, places=PLACES, is_corrected=True, view="anterior"):
    """Add a capture of a patient a little different each time; names come from somebody."""
    found = tuple(
        marker(f"m{i:02d}", 30.0 * i, np.array(place) + rng.normal(scale=0.01, size=3))
        for i, place in enumerate(places.values(), 1)
    )
    capture = add_capture(store, session, detected=found, view=view)
    renames = tuple(
        MarkerCorrection(one, marker(name, one.u, one.position_m))
        for one, name in zip(found, places, strict=True)
    )
    if is_corrected:
        store.captures.correct(capture.capture_id, CorrectionHistory(renames, len(renames)))
    return capture


def add_examples(store, n_corrected, *, places=PLACES, view="anterior", protocol=""):
    """Add a session with so many corrected captures, and one that nobody corrected."""
    if protocol:
        patient = add_patient(store, IDENTITY)
        session = store.sessions.start(patient.pseudonym, SessionSetup(protocol=protocol))
    else:
        session = add_session(store)
    rng = np.random.default_rng(0)
    for number in range(n_corrected + 1):
        add_example(store, session, rng, places=places, is_corrected=number > 0, view=view)
    return session
