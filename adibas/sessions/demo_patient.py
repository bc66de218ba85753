"""Somebody to try the program with: every new store has a simulated patient."""

from adibas.data.patients import PURPOSE_OF_CAPTURE, Consent, Identity, Patient
from adibas.sessions.store import SessionStore
from adibas.texts import LANGUAGES, speaking
from adibas.texts import translate as _

DEMO_RECORD_NUMBER = "DEMO"


def demo_patient(store: SessionStore) -> Patient:
    """Return the demo patient of a store, added with a consent where there is none.

    One whose consent somebody withdrew stays without.
    """
    pseudonym = _pseudonym(store)
    if pseudonym is None:
        patient = store.patients.add(demo_identity(), notes=demo_notes())
    else:
        patient = store.patients.get(pseudonym)
    if patient.consents or store.is_read_only:
        return patient
    return store.patients.give_consent(patient.pseudonym, _consent(store))


def _consent(store: SessionStore) -> Consent:
    return Consent((PURPOSE_OF_CAPTURE,), demo_identity().name, False, store.audit.now_utc())


def rename_demo_patient(store: SessionStore) -> Patient | None:
    """Let the demo patient be called as in the language in use.

    One whom somebody gave another name, birth date or note stays as it is.

    Returns
    -------
    patient : Patient or None
        As renamed; None where nothing was changed.
    """
    pseudonym = None if store.is_read_only else _pseudonym(store)
    if pseudonym is None:
        return None
    patient = store.patients.get(pseudonym)
    now = (demo_identity(), demo_notes())
    if (patient.identity, patient.notes) not in _in_all_languages() - {now}:
        return None
    return store.patients.change(pseudonym, identity=now[0], notes=now[1])


def demo_identity() -> Identity:
    """Return who the demo patient is, in the language in use."""
    return Identity(_("Demo patient"), record_number=DEMO_RECORD_NUMBER)


def demo_notes() -> str:
    """Return what is noted on the demo patient, in the language in use."""
    return _("A simulated patient, to try the program with the simulator as the sensor.")


def _pseudonym(store: SessionStore) -> str | None:
    for row in store.patients.search(DEMO_RECORD_NUMBER):
        if row.identity.record_number == DEMO_RECORD_NUMBER:
            return row.pseudonym
    return None


def _in_all_languages() -> set[tuple[Identity, str]]:
    said = set()
    for language in LANGUAGES:
        with speaking(language):
            said.add((demo_identity(), demo_notes()))
    return said
