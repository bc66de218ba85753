"""Somebody to try the program with: every new store has a simulated patient."""

from adibas.data.patients import Identity, Patient
from adibas.sessions.store import SessionStore
from adibas.texts import translate as _

DEMO_RECORD_NUMBER = "DEMO"


def demo_patient(store: SessionStore) -> Patient:
    """Return the demo patient of a store, added where there is none."""
    for row in store.patients.search(DEMO_RECORD_NUMBER):
        if row.identity.record_number == DEMO_RECORD_NUMBER:
            return store.patients.get(row.pseudonym)
    return store.patients.add(demo_identity(), notes=demo_notes())


def demo_identity() -> Identity:
    """Return who the demo patient is, in the language in use."""
    return Identity(_("Demo patient"), record_number=DEMO_RECORD_NUMBER)


def demo_notes() -> str:
    """Return what is noted on the demo patient, in the language in use."""
    return _("A simulated patient, to try the program with the simulator as the sensor.")
