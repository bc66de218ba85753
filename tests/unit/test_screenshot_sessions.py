"""What the pictures of the window show: a clinic that repeats its measures."""

from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.pipeline.clinic_repeats import is_repeat_of
from adibas.sessions import open_store
from adibas.sessions.key_wrapping import Argon2Params
from installers.screenshot_sessions import N_OTHERS, add_sessions_to_compare
from tests.unit.store_samples import add_patient

PASSPHRASE = "four words are enough"
CHEAP = Argon2Params(iterations=1, lanes=1, memory_kib=8)


def test_every_other_patient_was_measured_twice_on_one_day(tmp_path):
    with open_store(tmp_path, PASSPHRASE, operator="M. Puig", key_params=CHEAP) as store:
        demo = add_patient(store, Identity("Demo patient")).pseudonym
        session_id = store.sessions.start(demo, SessionSetup()).session_id
    add_sessions_to_compare(tmp_path, session_id, PASSPHRASE, CHEAP)
    with open_store(tmp_path, PASSPHRASE, operator="M. Puig", key_params=CHEAP) as store:
        others = [one for one in store.patients.search("", limit=50) if one.pseudonym != demo]
        assert len(others) == N_OTHERS
        for other in others:
            last, first = store.sessions.of_patient(other.pseudonym)
            assert is_repeat_of(last, first)
