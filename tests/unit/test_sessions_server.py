"""A store whose database is on a real PostgreSQL server: nothing readable there, nothing lost."""

import itertools
import json
from dataclasses import replace
from datetime import date

import pytest

from adibas.cli import main
from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import (
    NotAllowedError,
    PassphraseError,
    ServerAwayError,
    ServerPasswordError,
    StoreError,
)
from adibas.sessions import open_store
from adibas.sessions import server as server_module
from adibas.sessions.coding_drafts import InStore
from adibas.sessions.moving import move_to_server
from adibas.sessions.restoring import restore_into
from adibas.sessions.roles import Role
from adibas.sessions.rows import change_row
from adibas.sessions.schema import SESSIONS
from adibas.sessions.server_address import parse_address, read_server_file, write_server_file
from tests.unit import postgres_server
from tests.unit.recorded_frames import INFO, make_frames
from tests.unit.store_samples import (
    CHEAP,
    IDENTITY,
    NAME,
    PASSPHRASE,
    MemoryKeyring,
    add_capture,
    add_session,
    minutes_clock,
    open_sample,
    picture,
    raw_connection,
    use_keyring,
)

pytestmark = pytest.mark.skipif(postgres_server.PROGRAMS is None, reason=postgres_server.MISSING)
_NUMBERS = itertools.count()


server = postgres_server.server


@pytest.fixture
def database(server):
    """The name of a new, empty database."""
    name = f"adibas{next(_NUMBERS)}"
    server.make_database(name)
    return name


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


@pytest.fixture
def opened(server, database, folder):
    """Opens the store, which is on the server, once or several times."""
    open_sample(folder).close()
    move_to_server(folder, PASSPHRASE, server.address(database), server.password)

    def open_it(operator="op", **options):
        options = {"clock": minutes_clock(), "server_password": server.password} | options
        return open_store(folder, PASSPHRASE, operator=operator, **options)

    return open_it


def dump(server, database):
    """Everything that the server holds, as whoever looks after it can read it."""
    tables = server.ask(database, "SELECT tablename FROM pg_tables WHERE schemaname = 'public'")
    return "\n".join(server.ask(database, f"SELECT * FROM {table}") for table in tables.split())


def test_a_used_store_moves_to_the_server_with_all_that_it_holds(server, database, folder):
    with open_sample(folder) as store:
        capture = add_capture(store)
        before = store.patients.search("")
        lines = store.audit.entries()
    move_to_server(folder, PASSPHRASE, server.address(database), server.password)
    assert read_server_file(folder) == server.address(database)
    assert server.password not in (folder / "server.json").read_text()
    with open_store(folder, PASSPHRASE, server_password=server.password) as store:
        assert store.server == "127.0.0.1"
        assert store.patients.search("") == before
        assert store.captures.get(capture.capture_id).markers()[0].u == 30.25
        assert (store.captures.picture(capture.capture_id) == picture()).all()
        assert store.audit.entries()[-len(lines) :] == lines
        assert store.verify().is_sound
        add_capture(store)  # numbers go on behind the copied ones
        assert store.verify().is_sound


def test_the_server_reads_no_name_picture_measure_or_key(server, database, opened):
    with opened() as store:
        capture = add_capture(store)
        session = store.sessions.change(capture.session_id, notes="limps on Tuesdays")
        pseudonym, key = session.patient, store._key.hex()
        file_key = store.captures._files._database  # the keys of files are rows, too
        with file_key.reading() as transaction:
            keys = [row[0] for row in transaction.exec_driver_sql("SELECT key FROM files")]
    readable = dump(server, database)
    for secret in (NAME, "Ximena", "ximena", "2014-03-27", "HC-004711", "limps", "position_m", key):
        assert secret not in readable
    assert all(len(one) > 32 for one in keys)
    assert pseudonym in readable  # which is what puts the rows in order


@pytest.mark.parametrize("text", ["ximena", "NANDU quetzal", "004711", "27/03/2014", ""])
def test_patients_are_found_as_in_a_file(opened, tmp_path, text):
    others = [Identity("Ana 100%", date(2001, 1, 2), "A_1"), Identity("Zoë", None, "x"), IDENTITY]
    with opened() as store, open_sample(tmp_path / "file") as file:
        for one in others:
            store.patients.add(one)
            file.patients.add(one)
        hidden = store.patients.search("zoe")[0].pseudonym
        store.patients.delete(hidden)
        file.patients.delete(file.patients.search("zoe")[0].pseudonym)
        names = [[row.identity for row in s.patients.search(text)] for s in (store, file)]
        assert names[0] == names[1] != []
        both = [len(s.patients.search("", with_deleted=True)) for s in (store, file)]
        assert both == [3, 3]
        assert len(store.patients.search("", limit=1)) == 1


def test_two_workstations_write_at_the_same_time(opened):
    with opened("Ana") as ana, opened("Bea") as bea:
        session = add_session(ana)
        other = bea.sessions.start(session.patient, SessionSetup())
        assert {one.session_id for one in ana.sessions.of_patient(session.patient)} == {
            session.session_id,
            other.session_id,
        }
        assert not ana.is_read_only
        assert not bea.is_read_only
        assert ana.verify().is_sound
        assert {line.operator for line in ana.audit.entries()} >= {"Ana", "Bea"}


def test_what_another_workstation_records_is_neither_recovered_nor_purged(opened):
    frames = make_frames(3)
    with opened("Ana") as ana:
        session = add_session(ana)
        writer = ana.recordings.create(session.session_id, INFO)
        with opened("Bea") as bea:
            assert bea.recordings.of_session(session.session_id) == ()
            with pytest.raises(StoreError, match="being made"):
                bea.patients.purge(session.patient)
            assert bea.verify().is_sound
            for frame in frames:
                writer.write(frame)
            writer.close()
            (facts,) = bea.recordings.of_session(session.session_id)
            assert facts.n_frames == 3
            bea.patients.purge(session.patient)
        assert ana.patients.search("") == ()


def test_the_audit_log_of_the_server_cannot_be_rewritten(server, database, opened):
    opened().close()
    for statement in ("UPDATE audit SET operator = 'x'", "DELETE FROM audit", "TRUNCATE audit"):
        with pytest.raises(Exception, match="exit status"):
            server.ask(database, statement)


def test_a_value_that_somebody_exchanged_on_the_server_is_noticed(server, database, opened):
    with opened() as store:
        pseudonym = add_session(store).patient
    server.ask(database, "UPDATE identities SET name = record_number")
    with opened() as store:
        with pytest.raises(StoreError, match="changed or damaged there"):
            store.patients.get(pseudonym)
        assert [one.kind for one in store.verify().findings] == ["database"]


def test_a_backup_of_the_server_becomes_a_store_of_its_own(opened, tmp_path):
    with opened() as store:
        capture = add_capture(store)
        path = tmp_path / "out" / "b.adibas-backup"
        store.backups.write(path)
    restore_into(path, tmp_path / "again", PASSPHRASE)
    with open_sample(tmp_path / "again") as again:
        assert again.server == ""
        assert again.patients.search("ximena")[0].identity == IDENTITY
        assert (again.captures.picture(capture.capture_id) == picture()).all()
        assert again.verify().is_sound
        add_capture(again)
    with opened() as store:
        summary = store.backups.restore(path)
        assert summary.n_patients == 0
        store.patients.purge(store.patients.search("")[0].pseudonym)
        assert store.verify().is_sound


def test_without_its_password_the_server_is_asked_for_one(opened, server, monkeypatch):
    use_keyring(monkeypatch, MemoryKeyring())
    for wrong in (None, "wrong"):
        with pytest.raises(ServerPasswordError) as told:
            opened(server_password=wrong)
        assert server.password not in str(told.value)
        assert "wrong" not in str(told.value)


def test_a_password_in_the_keyring_opens_the_store(opened, server, folder, monkeypatch):
    from adibas.sessions.server_password import keep_password

    use_keyring(monkeypatch, MemoryKeyring())
    keep_password(read_server_file(folder), server.password)
    with opened(server_password=None) as store:
        assert store.verify().is_sound


@pytest.mark.usefixtures("opened")
def test_only_an_empty_database_is_taken(server, database, tmp_path):
    other = tmp_path / "other"
    open_sample(other).close()
    with pytest.raises(StoreError, match="not empty"):
        move_to_server(other, PASSPHRASE, server.address(database), server.password)
    open_sample(other).close()
    assert not (other / "server.json").exists()


@pytest.mark.usefixtures("opened")
def test_the_database_of_another_store_is_refused(server, tmp_path, folder):
    other = tmp_path / "other"
    open_sample(other).close()
    (other / "server.json").write_text((folder / "server.json").read_text())
    with pytest.raises(StoreError, match="another patient store"):
        open_store(other, PASSPHRASE, server_password=server.password)


def test_an_open_store_stays_in_its_file(server, database, folder):
    with open_sample(folder), pytest.raises(StoreError, match="another window"):
        move_to_server(folder, PASSPHRASE, server.address(database), server.password)


def test_a_window_that_only_reads_keeps_the_database_where_it_is(server, database, folder):
    with open_sample(folder) as writer, open_sample(folder) as reader:
        writer.close()
        with pytest.raises(StoreError, match="another window"):
            move_to_server(folder, PASSPHRASE, server.address(database), server.password)
        reader.note_export("report", "x")
    move_to_server(folder, PASSPHRASE, server.address(database), server.password)
    with open_store(folder, PASSPHRASE, server_password=server.password) as store:
        assert "export" in {line.action for line in store.audit.entries()}


def test_who_still_reads_the_file_of_a_moved_store_is_told_and_leaves_no_line_there(
    server, database, folder, monkeypatch
):
    # on a network disk an open file without a transaction has no lock that others see
    monkeypatch.setattr("adibas.sessions.sqlite_file.is_on_network", lambda _folder: True)
    with open_sample(folder) as writer, open_sample(folder) as reader:
        writer.close()
        move_to_server(folder, PASSPHRASE, server.address(database), server.password)
        for act in (lambda: reader.note_export("report", "x"), lambda: reader.patients.search("")):
            with pytest.raises(StoreError, match="gone to a server meanwhile"):
                act()
    with raw_connection(folder, "adibas.db.before-server") as kept:
        assert kept.execute("SELECT count(*) FROM audit WHERE action = 'export'").fetchone() == (0,)


def test_a_store_of_one_keyring_cannot_be_shared(server, database, folder, monkeypatch):
    use_keyring(monkeypatch, MemoryKeyring())
    open_store(folder).close()
    with pytest.raises(PassphraseError, match="passphrase first"):
        move_to_server(folder, None, server.address(database), server.password)


def test_a_server_that_was_started_anew_between_two_changes_is_not_noticed(opened, server):
    with opened() as store:
        session = add_session(store)
        server.kill()
        server.start()
        store.sessions.change(session.session_id, notes="still here")
        assert store.sessions.get(session.session_id).notes == "still here"


def test_a_server_that_goes_away_is_told_and_the_same_can_be_tried_again(opened, server):
    with opened() as store:
        session = add_session(store)
        server.kill()
        try:
            with pytest.raises(ServerAwayError, match="does not answer") as told:
                store.sessions.change(session.session_id, notes="limps")
            assert "limps" not in str(told.value)
        finally:
            server.start()
        assert store.sessions.get(session.session_id).notes == ""
        store.sessions.change(session.session_id, notes="limps")
        assert store.sessions.get(session.session_id).notes == "limps"
        assert store.verify().is_sound


def test_a_server_that_goes_away_within_a_change_undoes_it(opened, server, monkeypatch):
    with opened() as store:
        session = add_session(store)
        write = store.audit.write

        def kill_before(*arguments, **detail):
            server.kill()
            write(*arguments, **detail)

        monkeypatch.setattr(store.audit, "write", kill_before)
        try:
            with pytest.raises(ServerAwayError):
                store.sessions.change(session.session_id, notes="limps")
        finally:
            monkeypatch.undo()
            server.start()
        assert store.sessions.get(session.session_id).notes == ""
        store.sessions.change(session.session_id, notes="limps")
        assert store.verify().is_sound


@pytest.mark.parametrize(
    ("text", "sslmode", "is_here"),
    [
        ("postgresql://adibas@server.example/clinic", "verify-full", False),
        ("postgresql://server.example/clinic?sslmode=disable", "disable", False),
        ("postgresql://server.example/clinic?sslmode=require", "require", False),
        ("postgresql://adibas@127.0.0.1:5433/clinic", "prefer", True),
        ("postgresql://localhost/clinic", "prefer", True),
        ("postgresql://[::1]:5433/clinic", "prefer", True),
        ("postgresql://%2Frun%2FPostgres/clinic", "prefer", True),
        ("postgresql://localhost.example/clinic", "verify-full", False),
        ("postgresql://localhost,server.example/clinic", "verify-full", False),
    ],
)
def test_other_computers_are_reached_through_tls_unless_told_otherwise(text, sslmode, is_here):
    address = parse_address(text)
    assert address.connection()["sslmode"] == sslmode
    assert address.is_here == is_here
    assert parse_address(str(address)) == address


@pytest.mark.parametrize(
    "text",
    [
        "",
        "server/clinic",
        "mysql://server/clinic",
        "postgresql://server",
        "postgresql:///clinic",
        "postgresql://server:port/clinic",
        "postgresql://adibas:geheim@server/clinic",
        "postgresql://server/clinic?password=geheim",
        "postgresql://server/clinic?sslmode=prefer",
        "postgresql://server/clinic?sslmode=allow",
    ],
)
def test_what_is_no_safe_address_is_refused_and_not_repeated(text):
    with pytest.raises(StoreError) as told:
        parse_address(text)
    assert "geheim" not in str(told.value)


@pytest.mark.parametrize("content", ["", "{", "[]", json.dumps({"format": "adibas-server"})])
def test_a_damaged_server_file_is_told(folder, content):
    open_sample(folder).close()
    (folder / "server.json").write_text(content)
    with pytest.raises(StoreError, match=r"server\.json"):
        open_store(folder, PASSPHRASE, key_params=CHEAP)


def test_the_command_moves_a_store_and_works_with_it(server, database, folder, monkeypatch, capsys):
    monkeypatch.setenv("ADIBAS_PASSPHRASE", PASSPHRASE)
    monkeypatch.setenv("ADIBAS_SERVER_PASSWORD", server.password)
    with open_sample(folder) as store:
        pseudonym = add_session(store).patient
    moved = main(["sessions", "to-server", str(server.address(database)), "--store", str(folder)])
    listed = main(["sessions", "list", "--store", str(folder)])
    out, err = capsys.readouterr()
    assert (moved, listed, err) == (0, 0, "")
    assert pseudonym in out
    assert server.password not in out
    monkeypatch.setenv("ADIBAS_SERVER_PASSWORD", "wrong")
    assert main(["sessions", "list", "--store", str(folder)]) != 0
    out, err = capsys.readouterr()
    assert "needs the password" in err
    assert "wrong" not in err


def test_an_address_with_a_password_is_not_printed(folder, capsys):
    open_sample(folder).close()
    address = "postgresql://adibas:geheim@server/clinic"
    assert main(["sessions", "to-server", address, "--store", str(folder)]) != 0
    out, err = capsys.readouterr()
    assert "no place in the address" in err
    assert "geheim" not in out + err


@pytest.mark.parametrize(
    "way",
    [
        ("", False, False, None),
        ("", True, True, True),
        ("verify-ca", True, True, True),
        ("require", False, True, True),
        ("disable", False, True, False),
    ],
)
def test_a_real_server_elsewhere_is_reached_as_the_address_says(
    server, opened, folder, tmp_path, way
):
    sslmode, knows_certificate, is_let_in, is_encrypted = way
    opened().close()
    certificate = tmp_path / "server.crt"
    certificate.write_bytes((server.folder / "data" / "server.crt").read_bytes())
    known = str(certificate) if knows_certificate else ""
    elsewhere = {"host": postgres_server.OTHER, "sslmode": sslmode, "sslrootcert": known}
    write_server_file(folder, replace(read_server_file(folder), **elsewhere))
    if not is_let_in:
        with pytest.raises(ServerAwayError, match="no certificate that this computer trusts"):
            opened()
        return
    with opened() as store, store._database.reading() as transaction:
        ssl = "SELECT ssl FROM pg_stat_ssl WHERE pid = pg_backend_pid()"
        assert transaction.exec_driver_sql(ssl).scalar_one() is is_encrypted


def test_no_password_is_taken_from_a_file(opened, server, tmp_path, monkeypatch):
    use_keyring(monkeypatch, MemoryKeyring())
    secret = tmp_path / "pgpass"
    secret.write_text(f"*:*:*:*:{server.password}\n")
    secret.chmod(0o600)
    monkeypatch.setenv("PGPASSFILE", str(secret))
    with pytest.raises(ServerPasswordError):
        opened(server_password=None)


def test_two_code_one_recording_under_the_same_initials_and_none_is_overwritten(opened):
    with opened("Ana") as ana, opened("Bea") as bea:
        with ana.recordings.create(add_session(ana).session_id, INFO) as writer:
            for frame in make_frames(3):
                writer.write(frame)
        first, second = (InStore(one.recordings, writer.recording_id) for one in (ana, bea))
        assert first.read("coding") is second.read("coding") is None
        first.write("coding", "seated")
        first.write("coding", "seated, standing")
        with pytest.raises(StoreError, match="same initials"):
            second.write("coding", "walking")
        assert second.read("coding") == "seated, standing"
        second.write("coding", "seated, standing, walking")
        other = InStore(bea.recordings, writer.recording_id, "BE")
        assert other.read("coding") is None
        other.write("coding", "walking")
        with pytest.raises(StoreError, match="same initials"):
            first.write("coding", "lying")
        assert first.read("coding") == "seated, standing, walking"


def test_who_waits_too_long_for_another_workstation_is_told_and_can_try_again(opened, monkeypatch):
    monkeypatch.setattr(server_module, "SETTINGS", "-c lock_timeout=100ms")
    with opened("Ana") as ana, opened("Bea") as bea:
        session = add_session(ana)
        with (
            ana._database.changing(),
            pytest.raises(ServerAwayError, match="Another workstation is just changing"),
        ):
            bea.sessions.change(session.session_id, notes="limps")
        bea.sessions.change(session.session_id, notes="limps")
        assert ana.sessions.get(session.session_id).notes == "limps"


def test_a_server_that_goes_away_in_the_moment_of_saving_leaves_no_false_word(opened, server):
    with opened() as store:
        session = add_session(store)
        try:
            with (
                pytest.raises(StoreError, match="it is not known whether it was") as told,
                store._database.changing() as transaction,
            ):
                change_row(transaction, SESSIONS, session.session_id, notes="limps")
                server.kill()
            assert not isinstance(told.value, ServerAwayError)  # no button that saves it twice
        finally:
            server.start()
        assert store.sessions.get(session.session_id).notes == ""


def test_people_of_a_store_on_a_server_open_it_with_their_roles(opened, folder, server):
    with opened() as store:
        session = add_session(store)
        store.people.add("Anna", Role.ADMINISTRATOR, "anna has a long one", CHEAP)
    options = {"server_password": server.password, "clock": minutes_clock()}
    with (
        open_store(folder, "anna has a long one", **options) as anna,
        open_store(folder, "anna has a long one", **options) as elsewhere,
    ):
        anna.people.add("Boris", Role.CLINICIAN, "boris likes numbers 7", CHEAP)
        elsewhere.people.add("Carla", Role.OPERATOR, "carla, still another", CHEAP)
        assert [one.name for one in anna.people.all()] == ["Anna", "Boris", "Carla"]
    with open_store(folder, "carla, still another", **options) as store:
        assert store.patients.search("")[0].identity == Identity(session.patient)
        with pytest.raises(NotAllowedError):
            store.patients.purge(session.patient)
    with open_store(folder, "anna has a long one", **options) as store:
        refused = next(one for one in store.audit.entries() if one.action == "refuse")
        assert (refused.operator, refused.patient) == ("Carla", session.patient)
        assert store.verify().is_sound
