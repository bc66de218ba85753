"""A store on another computer's disk maps nothing into memory, since the disk can go."""

import pytest
import sqlcipher3.dbapi2 as sqlcipher

from adibas.sessions import sqlite_file
from adibas.sessions.network_disks import is_on_network
from tests.unit.store_samples import IDENTITY, open_sample

MOUNTS = r"""22 1 254:0 / / rw,relatime shared:1 - ext4 /dev/vda rw
30 22 0:40 / {folder}/share rw,nosuid shared:9 - nfs4 server:/clinic rw,vers=4.2
31 22 0:41 / {folder}/with\040space rw - cifs //server/clinic rw
32 30 0:42 / {folder}/share/stick rw - vfat /dev/sdb1 rw
34 22 0:44 / {folder}/bound rw - fuse /somewhere rw
35 22 8:17 / {folder}/disk rw - fuseblk /dev/sdc1 rw
33 22 0:43 / {folder}/home rw - fuse.sshfs me@server:/ rw
"""


@pytest.fixture
def mounts(tmp_path):
    path = tmp_path / "mountinfo"
    path.write_text(MOUNTS.replace("{folder}", str(tmp_path)))
    return path


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("share/store", True),
        ("with space/store", True),
        ("home/store", True),
        ("share", True),
        ("bound/store", True),
        ("disk/store", False),
        ("share/stick/store", False),
        ("shared/store", False),
        ("store", False),
    ],
)
def test_the_innermost_mount_says_what_a_folder_lies_on(tmp_path, mounts, name, expected):
    assert is_on_network(tmp_path / name, mounts) is expected


@pytest.mark.parametrize("text", ["", "nonsense", "\x00 - nfs"])
def test_where_nothing_is_told_a_folder_is_local(tmp_path, text):
    path = tmp_path / "mounts"
    path.write_text(text)
    assert not is_on_network(tmp_path, path)
    assert not is_on_network(tmp_path, tmp_path / "missing")


def test_a_store_on_a_share_maps_no_file_and_one_of_before_is_opened(tmp_path, monkeypatch):
    with open_sample(tmp_path / "store") as store:
        store.patients.add(IDENTITY)
        assert (tmp_path / "store" / "adibas.db-shm").exists()
    monkeypatch.setattr(sqlite_file, "is_on_network", lambda _folder: True)
    with open_sample(tmp_path / "store") as store:
        store.patients.add(IDENTITY)
        assert not (tmp_path / "store" / "adibas.db-shm").exists()
        with open_sample(tmp_path / "store") as reader:
            assert reader.is_read_only
            assert len(reader.patients.search("")) == 2
        store.patients.add(IDENTITY)
        assert [finding.text for finding in store.verify().findings] == []
    monkeypatch.undo()
    with open_sample(tmp_path / "store") as store:
        assert len(store.patients.search("")) == 3


def test_our_sqlite_maps_nothing_else_into_memory():
    connection = sqlcipher.connect(":memory:")
    assert connection.execute("PRAGMA mmap_size").fetchall() in ([], [(0,)])
    connection.close()
