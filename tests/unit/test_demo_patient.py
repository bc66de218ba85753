"""The demo patient is called as in the user's language, until somebody makes it another one."""

import pytest

from adibas.data.patients import Identity
from adibas.sessions import open_store
from adibas.sessions.demo_patient import DEMO_RECORD_NUMBER, demo_patient, rename_demo_patient
from adibas.texts import speaking
from tests.unit.store_samples import PASSPHRASE, open_sample


@pytest.fixture
def store(tmp_path):
    with open_sample(tmp_path / "store") as opened, speaking("en"):
        yield opened


def test_it_is_renamed_in_another_language_and_once_only(store):
    made = demo_patient(store)
    assert rename_demo_patient(store) is None, "the language is the same"
    with speaking("ca"):
        renamed = rename_demo_patient(store)
        assert rename_demo_patient(store) is None
    assert renamed == store.patients.get(made.pseudonym)
    assert renamed.identity.name == "Pacient de demostració"
    assert renamed.identity.record_number == DEMO_RECORD_NUMBER
    assert "simulat" in renamed.notes


@pytest.mark.parametrize(
    "change", [{"identity": Identity("Ana", None, DEMO_RECORD_NUMBER)}, {"notes": "mine"}]
)
def test_one_that_somebody_changed_stays_as_it_is(store, change):
    changed = store.patients.change(demo_patient(store).pseudonym, **change)
    with speaking("es"):
        assert rename_demo_patient(store) is None
        assert demo_patient(store) == changed


def test_without_it_or_in_a_window_that_only_reads_nothing_happens(store):
    with speaking("es"):
        assert rename_demo_patient(store) is None
    demo_patient(store)
    with open_store(store.folder, PASSPHRASE) as second, speaking("es"):
        assert second.is_read_only
        assert rename_demo_patient(second) is None
