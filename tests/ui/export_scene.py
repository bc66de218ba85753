"""A clinic's session in a real store, and no server but those that a test names."""

import pytest

from adibas.exchange import dicom_pictures, servers
from adibas.reports import pdf
from tests.unit.exchange_samples import add_clinic_session


@pytest.fixture
def named_servers(tmp_path, monkeypatch):
    """Where this test's servers stand; what this computer has is left alone."""
    path = tmp_path / "servers" / "servers.json"
    monkeypatch.setattr(servers, "servers_file", lambda: path)
    return path


@pytest.fixture
def clinic_session(store, monkeypatch):
    """Two views of a named patient with notes, drawn small for speed."""
    monkeypatch.setattr(pdf, "PICTURE_HEIGHT_PX", 200)
    monkeypatch.setattr(dicom_pictures, "HEIGHT_PX", 200)
    return add_clinic_session(store)


def exports(store):
    """Return what left the store, newest first."""
    return [one.detail["kind"] for one in store.audit.entries() if one.action == "export"]
