"""Every operation of the store is refused to those roles whom the table refuses it.

The roles that may are written here once more, by hand: the table is checked, not used.
"""

from datetime import UTC, date, datetime, timedelta

import pytest

from adibas.data.corrections import CorrectionHistory
from adibas.data.patients import Consent, Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import AdibasError, NotAllowedError
from adibas.measures.protocol_store import find_protocol
from adibas.pipeline.clinic_repeats import reliability_in_clinic
from adibas.pipeline.protocol_measuring import ProtocolWish
from adibas.pipeline.session_comparison import compare_by_protocol, patient_trends
from adibas.pipeline.skeleton_sessions import train_from_sessions
from adibas.pipeline.stored_report import ReportWish, stored_report
from adibas.sessions import open_store, roles
from adibas.sessions.backup_schedule import BackupPlan
from adibas.sessions.moving import move_to_server
from adibas.sessions.retention import RetentionRules
from adibas.sessions.roles import Role
from adibas.sessions.server_address import parse_address
from tests.unit.recorded_frames import INFO, make_frames
from tests.unit.store_samples import (
    CHEAP,
    IDENTITY,
    NAME,
    START,
    add_capture,
    add_session,
    all_bytes,
    minutes_clock,
    new_capture,
    open_sample,
    picture,
)

WORDS = {
    Role.OPERATOR: "carla, still another",
    Role.CLINICIAN: "boris likes numbers 7",
    Role.ADMINISTRATOR: "anna has a long one",
}
ALL = {Role.OPERATOR, Role.CLINICIAN, Role.ADMINISTRATOR}
TREATING = {Role.CLINICIAN, Role.ADMINISTRATOR}
HEADS = {Role.ADMINISTRATOR}
CONSENT = Consent(("treatment",), "Rosalia", True, datetime(2026, 11, 1, tzinfo=UTC))
SAPO = ProtocolWish(find_protocol("sapo-1"))
RULES, TODAY = RetentionRules(), date(2026, 11, 22)


class Scene:
    """A store that somebody has open, and what is in it."""

    def __init__(self, store, tmp_path, session, capture_id, recording_id):
        self.store, self.tmp_path, self.session = store, tmp_path, session
        self.patient, self.session_id = session.patient, session.session_id
        self.capture_id, self.recording_id = capture_id, recording_id


OPERATIONS = {
    "list": (ALL, lambda x: x.store.patients.search("")),
    "look for": (ALL, lambda x: x.store.patients.search("ximena")),
    "look at": (ALL, lambda x: x.store.patients.get(x.patient)),
    "add": (ALL, lambda x: x.store.patients.add(Identity("Somebody New"))),
    "give consent": (ALL, lambda x: x.store.patients.give_consent(x.patient, CONSENT)),
    "withdraw consent": (ALL, lambda x: x.store.patients.withdraw_consent(x.patient, 0)),
    "begin": (ALL, lambda x: x.store.sessions.start(x.patient, SessionSetup())),
    "see a session": (ALL, lambda x: x.store.sessions.get(x.session_id)),
    "note": (ALL, lambda x: x.store.sessions.change(x.session_id, notes="tall")),
    "capture": (
        ALL,
        lambda x: x.store.captures.add(x.session_id, new_capture(), picture()),
    ),
    "see captures": (ALL, lambda x: x.store.captures.of_session(x.session_id)),
    "see a picture": (ALL, lambda x: x.store.captures.picture(x.capture_id)),
    "correct": (ALL, lambda x: x.store.captures.correct(x.capture_id, CorrectionHistory())),
    "put a capture aside": (ALL, lambda x: x.store.captures.delete(x.capture_id)),
    "take a capture back": (ALL, lambda x: x.store.captures.restore(x.capture_id)),
    "record": (ALL, lambda x: x.store.recordings.create(x.session_id, INFO).abandon()),
    "play": (ALL, lambda x: x.store.recordings.open(x.recording_id).close()),
    "check": (ALL, lambda x: x.store.verify()),
    "own passphrase": (
        ALL,
        lambda x: x.store.people.change_passphrase(
            WORDS[x.store.role], "quite another sentence", CHEAP
        ),
    ),
    "backup that is due": (
        ALL,
        lambda x: x.store.backups.write_planned(BackupPlan(x.tmp_path, 7, 4)),
    ),
    "all names": (TREATING, lambda x: x.store.patients.names()),
    "change": (TREATING, lambda x: x.store.patients.change(x.patient, notes="knee")),
    "rename": (
        TREATING,
        lambda x: x.store.patients.change(x.patient, identity=Identity("Other")),
    ),
    "hide": (TREATING, lambda x: x.store.patients.delete(x.patient)),
    "show again": (TREATING, lambda x: x.store.patients.restore(x.patient)),
    "hide a session": (TREATING, lambda x: x.store.sessions.delete(x.session_id)),
    "show a session again": (TREATING, lambda x: x.store.sessions.restore(x.session_id)),
    "report": (TREATING, lambda x: stored_report(x.store, x.session_id, ReportWish("en"))),
    "compare": (
        TREATING,
        lambda x: compare_by_protocol(x.store, x.session, x.session, SAPO, {}),
    ),
    "trends": (TREATING, lambda x: patient_trends(x.store, x.session, SAPO, {})),
    "repeats": (TREATING, lambda x: reliability_in_clinic(x.store, SAPO, "op")),
    "export": (
        TREATING,
        lambda x: x.store.recordings.export(x.recording_id, x.tmp_path / "out.mcap"),
    ),
    "note an export": (TREATING, lambda x: x.store.note_export("excel", x.session_id)),
    "purge": (HEADS, lambda x: x.store.patients.purge(x.patient)),
    "purge a session": (HEADS, lambda x: x.store.sessions.purge(x.session_id)),
    "whose time is over": (HEADS, lambda x: x.store.retention.expired(RULES, TODAY)),
    "remove whose time is over": (HEADS, lambda x: x.store.retention.apply(RULES, TODAY)),
    "back up": (
        HEADS,
        lambda x: x.store.backups.write(x.tmp_path / "all.adibas-backup"),
    ),
    "due, with a passphrase": (
        HEADS,
        lambda x: x.store.backups.write_planned(
            BackupPlan(x.tmp_path, 7, 4), "of the backup only", params=CHEAP
        ),
    ),
    "restore": (HEADS, lambda x: x.store.backups.restore(x.tmp_path / "none")),
    "check a backup": (HEADS, lambda x: x.store.backups.verify(x.tmp_path / "none")),
    "learn names": (HEADS, lambda x: train_from_sessions(x.store, lambda _done, _total: None)),
    "log": (HEADS, lambda x: x.store.audit.entries()),
    "people": (HEADS, lambda x: x.store.people.all()),
    "add a person": (
        HEADS,
        lambda x: x.store.people.add("Dora", Role.OPERATOR, "dora is new here", CHEAP),
    ),
    "remove a person": (HEADS, lambda x: x.store.people.remove("clinician")),
    "a role": (HEADS, lambda x: x.store.people.change("operator", role=Role.CLINICIAN)),
    "another's passphrase": (
        HEADS,
        lambda x: x.store.people.change("operator", passphrase="carla forgot it", params=CHEAP),
    ),
}


@pytest.fixture
def scene_of(tmp_path):
    """Opens the store as somebody in a role."""
    folder = tmp_path / "store"
    with open_sample(folder) as store:
        session = add_session(store)
        with store.recordings.create(session.session_id, INFO) as writer:
            for frame in make_frames(2):
                writer.write(frame)
        capture_id = add_capture(store, session).capture_id
        store.patients.change(session.patient, notes="a secret of the knee")
        store.patients.give_consent(session.patient, CONSENT)
        for role, passphrase in reversed(WORDS.items()):
            store.people.add(role.value, role, passphrase, CHEAP)
    opened = []

    def open_as(role, start=START):
        store = open_store(folder, WORDS[role], clock=minutes_clock(start))
        opened.append(store)
        return Scene(store, tmp_path, session, capture_id, writer.recording_id)

    yield open_as
    for store in opened:
        store.close()


def refusals(scene_of):
    """The refused lines, as an administrator reads them."""
    scene = scene_of(Role.ADMINISTRATOR)
    found = [one for one in scene.store.audit.entries() if one.action == "refuse"]
    scene.store.close()
    return found


@pytest.mark.parametrize("role", Role)
@pytest.mark.parametrize("name", OPERATIONS)
def test_an_operation_is_refused_to_those_roles_and_done_for_the_others(scene_of, role, name):
    who, work = OPERATIONS[name]
    scene = scene_of(role)
    if role in who:
        try:
            work(scene)
        except NotAllowedError:
            raise
        except AdibasError as error:  # such as no second session: the role was not the reason
            print(error)  # noqa: T201
        return
    before = all_bytes(scene.tmp_path).keys()
    with pytest.raises(NotAllowedError, match="only for"):
        work(scene)
    assert all_bytes(scene.tmp_path).keys() == before
    scene.store.close()
    (line,) = refusals(scene_of)
    assert line.operator == role.value
    assert line.detail["role"] == role.value


@pytest.mark.parametrize(
    "name",
    [
        name
        for name, (who, _) in OPERATIONS.items()
        if who is ALL
        and name
        not in {
            "see a session",
            "see captures",
            "see a picture",
            "play",
            "check",
            "own passphrase",
            "backup that is due",
        }
    ],
)
def test_what_everybody_may_would_be_refused_too_if_the_table_said_so(scene_of, monkeypatch, name):
    scene = scene_of(Role.OPERATOR)
    stricter = dict.fromkeys(roles.LEAST, Role.CLINICIAN)
    monkeypatch.setattr(roles, "LEAST", stricter)
    with pytest.raises(NotAllowedError):
        OPERATIONS[name][1](scene)


def test_an_operator_is_told_the_names_of_those_he_looks_for_alone(scene_of):
    scene = scene_of(Role.OPERATOR)
    for text in ("", "x", "xi", "x i m"):
        for row in scene.store.patients.search(text):
            assert row.identity == Identity(row.pseudonym)
    (row,) = scene.store.patients.search("ximena")
    assert row.identity == IDENTITY
    scene.store.close()
    (row,) = scene_of(Role.CLINICIAN).store.patients.search("")
    assert row.identity.name == NAME


OTHERS = (
    Identity("Ana Roig", date(2014, 3, 28), "HC-004712"),
    Identity("Ben Serra", date(1961, 7, 2), "HC 4713"),
    Identity("Cia Pons", date(2001, 1, 9), "47"),
    Identity("Dan Ruiz", None, ""),
)


def names_told(store, text):
    """The names that a search tells; whoever has none is found by the pseudonym typed."""
    rows = store.patients.search(text)
    typed = text.casefold().split()
    for row in rows:
        if row.identity == Identity(row.pseudonym):
            assert all(word in row.pseudonym.casefold() for word in typed), text
    return {row.identity.name for row in rows if row.identity != Identity(row.pseudonym)}


def test_a_part_of_a_date_or_number_tells_an_operator_no_name(scene_of):
    scene = scene_of(Role.CLINICIAN)
    for identity in OTHERS:
        scene.store.patients.add(identity)
    scene.store.close()
    store = scene_of(Role.OPERATOR).store
    parts = ("/20", "/19", "/20 /", "2014", "-03-", "27/03/201", "03.2014", "hc-", "HC-0047")
    for text in (*parts, "-00", "p-", "p--", "an", "an ro", "4", "a n r"):
        assert names_told(store, text) == set(), text


def test_letters_of_a_name_or_a_whole_date_or_number_tell_an_operator_whose_it_is(scene_of):
    scene = scene_of(Role.CLINICIAN)
    for identity in OTHERS:
        scene.store.patients.add(identity)
    scene.store.close()
    store = scene_of(Role.OPERATOR).store
    for text in ("27/03/2014", "27.03.2014", "2014-03-27", "hc-004711", "nandu", scene.patient):
        assert names_told(store, text) == {NAME}, text
    assert names_told(store, "roi /20") == {"Ana Roig"}
    assert names_told(store, "hc 4713") == {"Ben Serra"}
    assert names_told(store, "47") == {"Cia Pons"}


def test_names_are_hidden_in_an_order_that_tells_nothing_of_them(scene_of):
    with_names = scene_of(Role.CLINICIAN)
    for name in ("Anna", "Zoe", "Berta", "Yann"):
        with_names.store.patients.add(Identity(name))
    with_names.store.close()
    rows = scene_of(Role.OPERATOR).store.patients.search("", limit=3)
    assert len(rows) == 3
    assert [row.pseudonym for row in rows] == sorted(row.pseudonym for row in rows)


def test_notes_on_a_patient_are_not_for_operators(scene_of):
    scene = scene_of(Role.OPERATOR)
    patients = scene.store.patients
    assert patients.get(scene.patient).notes == ""
    assert patients.give_consent(scene.patient, CONSENT).notes == ""
    assert patients.withdraw_consent(scene.patient, 0).notes == ""
    scene.store.close()
    scene = scene_of(Role.CLINICIAN)
    assert scene.store.patients.get(scene.patient).notes == "a secret of the knee"


def test_planned_backups_of_before_are_removed_where_an_administrator_works_alone(scene_of):
    scene = scene_of(Role.ADMINISTRATOR)
    plan = BackupPlan(scene.tmp_path / "backups", 1, 1)
    plan.folder.mkdir()
    scene.store.backups.write_planned(plan)
    (first,) = plan.folder.iterdir()
    scene.store.close()
    scene = scene_of(Role.OPERATOR, START + timedelta(days=7))
    assert scene.store.backups.write_planned(plan) is not None
    assert len(list(plan.folder.iterdir())) == 2
    scene.store.close()
    scene = scene_of(Role.ADMINISTRATOR, START + timedelta(days=14))
    assert scene.store.backups.write_planned(plan) is not None
    assert len(list(plan.folder.iterdir())) == 1
    assert not first.exists()


@pytest.mark.parametrize("role", [Role.OPERATOR, Role.CLINICIAN])
def test_only_administrators_move_the_database_to_a_server(scene_of, tmp_path, role):
    scene_of(role).store.close()
    before = all_bytes(tmp_path).keys()
    with pytest.raises(NotAllowedError):
        move_to_server(
            tmp_path / "store", WORDS[role], parse_address("postgresql://a@localhost/b"), None
        )
    assert all_bytes(tmp_path).keys() == before
    (line,) = refusals(scene_of)
    assert line.detail["permission"] == "protect"
