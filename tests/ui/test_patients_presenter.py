"""What the patients screen decides, over a real store and without any widget."""

from datetime import UTC, date, datetime
from unittest.mock import create_autospec

import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.patients import Consent, Identity
from adibas.data.posture import Provenance
from adibas.data.sessions import Session, SessionSetup
from adibas.geometry.pinhole import Intrinsics
from adibas.measures import protocol_store
from adibas.sessions import NewCapture
from tests.unit.store_samples import add_patient, consent
from ui.jobs import JobRunner
from ui.patients.content import (
    ConsentEntry,
    EntryError,
    PatientEntry,
    UndoOffer,
    read_birth_date,
)
from ui.patients.form_presenter import FormPresenter, FormView
from ui.patients.history_presenter import HistoryPresenter, HistoryView, can_repeat
from ui.patients.presenter import PatientListView, PatientsPresenter, PatientView
from ui.patients.undo import Undo, UndoView
from ui.workspace import Workspace

TODAY = date(2026, 5, 4)
NOW = datetime(2026, 5, 4, 12, tzinfo=UTC)


class Screen:
    """Three presenters with autospecced views, as the screen builds them."""

    def __init__(self, workspace):
        self.told, self.wanted = [], []
        workspace.noticed.subscribe(lambda kind, sentence: self.told.append((kind, sentence)))
        workspace.screen_wanted.subscribe(self.wanted.append)
        self.workspace = workspace
        self.list = create_autospec(PatientListView, instance=True)
        self.patient = create_autospec(PatientView, instance=True)
        self.history = create_autospec(HistoryView, instance=True)
        self.form = create_autospec(FormView, instance=True)
        self.strip = create_autospec(UndoView, instance=True)
        self.undo = Undo(self.strip, workspace)
        self.patients = PatientsPresenter(
            (self.list, self.patient), workspace, self.undo, lambda: TODAY
        )
        self.sessions = HistoryPresenter(self.history, workspace, self.undo)
        self.forms = FormPresenter(self.form, workspace, self.patients.refresh, lambda: NOW)
        self.enter()

    def enter(self):
        self.patients.enter()
        self.sessions.enter()

    def leave(self):
        self.patients.leave()
        self.sessions.leave()

    def listed(self):
        return [line.row.identity.name for line in self.list.show_patients.call_args.args[0]]

    def shown(self):
        return self.patient.show_patient.call_args.args[0]

    def shown_history(self):
        return self.history.show_history.call_args.args[0]


@pytest.fixture
def screen(workspace):
    return Screen(workspace)


@pytest.fixture
def ana(store):
    return add_patient(store, Identity("Ana Ruiz", date(2014, 3, 27), "HC-1"), sex="female")


@pytest.fixture
def bernat(store):
    """Without a consent."""
    return store.patients.add(Identity("Bernat Puig"))


@pytest.fixture
def only_looking(read_only_store, inline_jobs, preferences, ana):
    """A screen over the store that another window holds, with a patient chosen."""
    workspace = Workspace(read_only_store, inline_jobs, preferences, None)
    screen = Screen(workspace)
    screen.patients.choose(ana.pseudonym)
    return screen


def calibration():
    camera = CameraCalibration(64, 48, Intrinsics(500.0, 500.0, 31.5, 23.5))
    return RgbdCalibration(color=camera)


def add_capture(store, session, view="anterior", picture=None):
    new = NewCapture(
        view, "", 0, 30, calibration(), (), (), Provenance("", "", "0.1.0", "2026", {})
    )
    if picture is None:
        picture = np.full((48, 64, 3), 90, np.uint8)
    return store.captures.add(session.session_id, new, picture)


# Search and choice


@pytest.mark.usefixtures("ana", "bernat")
def test_every_key_lists_who_fits_and_how_old_they_are(screen):
    screen.patients.search("ru")
    assert screen.listed() == ["Ana Ruiz"]
    lines, is_cut = screen.list.show_patients.call_args.args[0], False
    assert lines[0].age_years == 12
    assert screen.list.show_patients.call_args.kwargs == {"is_cut": is_cut}
    screen.patients.search("")
    assert screen.listed() == ["Ana Ruiz", "Bernat Puig"]


def test_a_list_that_was_cut_says_so(screen, store):
    for number in range(201):
        store.patients.add(Identity(f"Patient {number:03}"))
    screen.patients.search("")
    assert len(screen.listed()) == 200
    assert screen.list.show_patients.call_args.kwargs == {"is_cut": True}


def test_a_chosen_patient_becomes_that_of_all_screens(screen, ana):
    screen.patients.choose(ana.pseudonym)
    assert screen.workspace.patient == ana
    assert screen.shown().patient == ana
    assert screen.shown().consent == "given"
    screen.list.show_chosen.assert_called_with(ana.pseudonym)


def test_choosing_the_same_patient_again_changes_nothing(screen, ana):
    screen.patients.choose(ana.pseudonym)
    told = []
    screen.workspace.patient_changed.subscribe(lambda: told.append(1))
    screen.patients.choose(ana.pseudonym)
    assert not told


def test_a_patient_who_is_not_there_is_told(screen):
    screen.patients.choose("P-NOBODY")
    assert screen.workspace.patient is None
    assert screen.told[0][0] == "bad"


def test_what_other_screens_do_is_followed_while_seen_and_read_anew_on_return(screen, ana, bernat):
    screen.workspace.choose_patient(bernat)
    assert screen.shown().patient == bernat
    screen.leave()
    screen.workspace.choose_patient(ana)
    screen.workspace.choose_session(
        screen.workspace.store.sessions.start(ana.pseudonym, SessionSetup())
    )
    assert screen.shown().patient == bernat
    screen.enter()
    assert screen.shown().patient == ana
    assert len(screen.shown_history().sessions) == 1


def test_a_patient_changed_elsewhere_is_shown_with_the_new_content(screen, store, ana):
    screen.patients.choose(ana.pseudonym)
    store.patients.change(ana.pseudonym, notes="new")
    screen.patients.refresh()
    assert screen.workspace.patient.notes == "new"


def test_a_patient_who_is_gone_is_left(screen, store, ana):
    screen.patients.choose(ana.pseudonym)
    store.patients.purge(ana.pseudonym)
    screen.patients.refresh()
    assert screen.workspace.patient is None
    assert screen.told[0][0] == "bad"
    screen.patient.show_patient.assert_called_with(None)


def test_a_closed_screen_listens_no_more(screen, ana):
    screen.patients.close()
    screen.sessions.close()
    screen.workspace.choose_patient(ana)
    assert screen.shown() is None


# Deleting


def test_a_deleted_patient_can_be_brought_back_in_place(screen, ana):
    screen.patients.choose(ana.pseudonym)
    screen.patients.delete()
    assert screen.listed() == []
    assert screen.workspace.patient is None
    screen.strip.show_undo.assert_called_with(UndoOffer("patient", "Ana Ruiz"))
    screen.undo.take_back()
    assert screen.listed() == ["Ana Ruiz"]
    assert screen.workspace.patient.pseudonym == ana.pseudonym
    screen.strip.show_undo.assert_called_with(None)


def test_nothing_is_undone_twice(screen, store, ana):
    screen.patients.choose(ana.pseudonym)
    screen.patients.delete()
    screen.undo.take_back()
    store.patients.delete(ana.pseudonym)
    screen.undo.take_back()
    assert store.patients.get(ana.pseudonym).is_deleted


def test_without_a_chosen_patient_nothing_is_deleted_restored_or_purged(screen, ana):
    screen.patients.delete()
    screen.patients.restore()
    screen.patients.ask_purge()
    assert not screen.workspace.store.patients.get(ana.pseudonym).is_deleted
    screen.patient.ask_purge.assert_not_called()


def test_deleted_patients_are_shown_on_request_and_restored(screen, ana):
    screen.patients.choose(ana.pseudonym)
    screen.patients.show_deleted(is_wanted=True)
    screen.patients.delete()
    assert screen.listed() == ["Ana Ruiz"]
    assert screen.shown().patient.is_deleted
    assert not screen.shown_history().can_start
    screen.patients.restore()
    assert not screen.shown().patient.is_deleted
    assert screen.shown_history().can_start


def test_a_patient_is_purged_after_the_pseudonym_was_asked_for(screen, store, ana):
    store.sessions.start(ana.pseudonym, SessionSetup())
    screen.patients.show_deleted(is_wanted=True)
    screen.patients.choose(ana.pseudonym)
    screen.patients.ask_purge()
    screen.patient.ask_purge.assert_not_called()  # one that is not hidden
    screen.patients.delete()
    screen.patients.ask_purge()
    question = screen.patient.ask_purge.call_args.args[0]
    assert (question.word, question.n_sessions) == (ana.pseudonym, 1)
    screen.patients.purge(ana.pseudonym)
    assert screen.listed() == []
    assert screen.workspace.patient is None
    assert store.patients.search("", with_deleted=True) == ()
    assert screen.told[-1][0] == "good"


@pytest.fixture
def stop_purges(screen, store, monkeypatch):
    """Let real threads work, and ask them to stop in the middle of each removal; wait for them."""
    runner = JobRunner(screen.workspace.report_problem)
    monkeypatch.setattr(screen.workspace, "jobs", runner)
    for purged in (store.patients, store.sessions):

        def stopped(one, purge=purged.purge):
            runner.cancel_all()
            purge(one)

        monkeypatch.setattr(purged, "purge", stopped)
    yield runner
    runner.close()


def test_that_a_patient_was_purged_is_told_although_somebody_wanted_to_stop_it(
    screen, ana, stop_purges, qtbot
):
    screen.patients.show_deleted(is_wanted=True)
    screen.patients.choose(ana.pseudonym)
    screen.patients.delete()
    screen.patients.purge(ana.pseudonym)
    qtbot.waitUntil(lambda: not stop_purges.is_busy)
    assert screen.told[-1] == ("good", "The patient was removed for good.")
    assert screen.workspace.patient is None
    assert screen.listed() == []
    screen.patients.purge(ana.pseudonym)
    qtbot.waitUntil(lambda: not stop_purges.is_busy)
    assert screen.told[-1][0] == "bad", "nor is an error swallowed"


def test_that_a_session_was_purged_is_told_although_somebody_wanted_to_stop_it(
    screen, store, ana, stop_purges, qtbot
):
    session = store.sessions.start(ana.pseudonym, SessionSetup())
    screen.patients.choose(ana.pseudonym)
    screen.workspace.choose_session(session)
    screen.sessions.purge(session.session_id)
    qtbot.waitUntil(lambda: not stop_purges.is_busy)
    assert screen.told[-1] == ("good", "The session was removed for good.")
    assert screen.workspace.session is None
    assert screen.shown_history().sessions == ()


def test_purging_another_patient_leaves_the_chosen_one(screen, ana, bernat):
    screen.patients.choose(bernat.pseudonym)
    screen.patients.purge(ana.pseudonym)
    assert screen.workspace.patient == bernat


# Sessions


def test_a_session_starts_at_once_and_goes_on_to_the_capture(screen, ana):
    screen.patients.choose(ana.pseudonym)
    screen.sessions.start()
    session = screen.workspace.session
    assert session.patient == ana.pseudonym
    assert session.setup == SessionSetup()
    assert screen.wanted == ["capture"]
    assert screen.told == []


def test_without_a_consent_no_session_starts_and_the_way_to_one_is_open(screen, store, bernat):
    screen.patients.choose(bernat.pseudonym)
    screen.sessions.start()
    assert screen.workspace.session is None
    ((kind, sentence),) = screen.told
    assert kind == "warning"
    assert "no consent for treatment stands on record" in sentence
    assert screen.shown().consent == "none"
    screen.form.show_consents.assert_called_once_with(bernat)
    screen.forms.give(ConsentEntry(("teaching",), False))
    assert screen.shown().consent == "other"
    screen.sessions.start()
    screen.forms.give(ConsentEntry(("treatment",), False))
    assert screen.told[-1] == ("good", "The consent is recorded: a capture can be made.")
    screen.sessions.start()
    assert screen.workspace.session.patient == bernat.pseudonym
    refused = [one for one in store.audit.entries() if one.action == "refuse"]
    assert [(one.subject, one.detail) for one in refused] == [
        (bernat.pseudonym, {"lacks": "consent"})
    ] * 2


def test_a_consent_that_the_capture_page_asks_for_leads_back_to_it(screen, bernat):
    screen.patients.choose(bernat.pseudonym)
    screen.workspace.ask_consent(back_to="capture")
    screen.form.show_consents.assert_called_once_with(bernat)
    screen.forms.give(ConsentEntry(("treatment",), False))
    assert screen.wanted == ["patients", "capture"]


def test_a_form_that_is_being_filled_in_stays_when_a_consent_is_asked_for(screen, bernat):
    screen.patients.choose(bernat.pseudonym)
    screen.forms.edit()
    screen.workspace.ask_consent()
    screen.form.show_consents.assert_not_called()
    assert screen.told == [
        ("warning", "Save or cancel what is being typed, then record the consent.")
    ]


def test_a_session_follows_the_protocol_that_is_chosen_for_new_ones(screen, ana, bernat):
    screen.patients.choose(ana.pseudonym)
    (protocols, chosen) = screen.history.show_protocols.call_args.args
    assert {"sapo-1", "upper-quadrant"} <= {name for name, _title in protocols}
    assert chosen == ""
    screen.sessions.choose_protocol("sapo-1")
    screen.sessions.start()
    assert screen.workspace.session.setup == SessionSetup(protocol="sapo-1")
    screen.patients.choose(bernat.pseudonym)
    assert screen.history.show_protocols.call_count == 1, "they were read before"


def test_a_protocol_that_is_gone_is_not_followed(screen, ana):
    screen.workspace.preferences.change(protocol="gone")
    screen.patients.choose(ana.pseudonym)
    assert screen.history.show_protocols.call_args.args[1] == ""
    screen.sessions.start()
    assert screen.workspace.session.setup.protocol == ""


def test_a_protocol_that_was_made_or_deleted_on_another_screen_is_known(
    screen, ana, tmp_path, monkeypatch
):
    monkeypatch.setattr(protocol_store, "own_folder", lambda: tmp_path)
    text = protocol_store.protocol_text("sapo-1").replace('"sapo-1"', '"mine"', 1)
    screen.patients.choose(ana.pseudonym)
    (tmp_path / "mine.json").write_text(text, "utf-8")
    screen.sessions.enter()
    assert "mine" in dict(screen.history.show_protocols.call_args.args[0])
    screen.sessions.choose_protocol("mine")
    (tmp_path / "mine.json").unlink()
    screen.sessions.enter()
    assert "mine" not in dict(screen.history.show_protocols.call_args.args[0])
    assert screen.workspace.preferences.now.protocol == ""


def test_sessions_are_compared_until_the_one_that_is_chosen(screen, store, ana):
    first = store.sessions.start(ana.pseudonym, SessionSetup())
    second = store.sessions.start(ana.pseudonym, SessionSetup())
    screen.patients.choose(ana.pseudonym)
    screen.sessions.compare(second.session_id)
    assert screen.workspace.session == second
    screen.sessions.compare("")
    assert screen.workspace.session == second
    store.sessions.delete(first.session_id)
    screen.sessions.show_deleted(is_wanted=True)
    screen.sessions.compare(first.session_id)
    assert screen.workspace.session == second
    assert screen.wanted == ["comparison"] * 3


def test_a_consent_counts_for_a_capture_where_it_is_for_treatment(screen, store, bernat):
    store.patients.give_consent(bernat.pseudonym, consent("research", "teaching"))
    screen.patients.choose(bernat.pseudonym)
    assert screen.shown().consent == "other"
    store.patients.give_consent(bernat.pseudonym, consent("treatment"))
    screen.patients.refresh()
    assert screen.shown().consent == "given"


def test_without_a_patient_no_session_starts(screen):
    screen.sessions.start()
    screen.sessions.start_like_last()
    screen.sessions.continue_last()
    assert screen.workspace.session is None
    assert screen.wanted == []
    assert not screen.shown_history().can_start


def test_the_last_session_is_continued_or_repeated_with_its_set_up(screen, store, ana):
    store.sessions.start(ana.pseudonym, SessionSetup())
    setup = SessionSetup(source="openni2", rotation_deg=90, protocol="spine")
    last = store.sessions.start(ana.pseudonym, setup)
    screen.patients.choose(ana.pseudonym)
    assert screen.shown_history().can_continue
    screen.sessions.continue_last()
    assert screen.workspace.session == last
    screen.sessions.start_like_last()
    assert screen.workspace.session.session_id != last.session_id
    assert screen.workspace.session.setup == setup
    assert screen.wanted == ["capture", "capture"]


def test_the_second_session_of_a_day_can_be_called_a_repeat_and_the_next_one_is_none(
    screen, store, ana
):
    first, second = (store.sessions.start(ana.pseudonym, SessionSetup()) for _n in range(2))
    screen.patients.choose(ana.pseudonym)
    assert screen.shown_history().can_repeat == {second.session_id}
    screen.sessions.continue_last()
    screen.sessions.call_repeat(second.session_id, is_repeat=True)
    assert store.sessions.get(second.session_id).setup.is_repeat
    assert screen.workspace.session.setup.is_repeat, "what is saved next keeps it"
    assert not store.sessions.get(first.session_id).setup.is_repeat
    screen.sessions.start_like_last()
    assert not screen.workspace.session.setup.is_repeat
    screen.sessions.call_repeat(second.session_id, is_repeat=False)
    assert not store.sessions.get(second.session_id).setup.is_repeat
    screen.sessions.call_repeat("gone", is_repeat=True)
    store.sessions.delete(first.session_id)
    screen.sessions.refresh()
    assert second.session_id not in screen.shown_history().can_repeat


@pytest.mark.usefixtures("three_hours_behind_utc")
def test_an_evening_past_midnight_of_utc_is_one_day_of_repeats():
    begun = ("2026-11-02 20:45", "2026-11-02 21:15", "2026-11-03 10:45")
    sessions = tuple(
        Session(
            one, "P-1", datetime.fromisoformat(f"{one}-03:00").astimezone(UTC), "op", SessionSetup()
        )
        for one in begun
    )
    assert can_repeat(sessions) == {begun[1]}


def test_a_session_opens_in_review_at_the_wanted_or_first_capture(screen, store, ana):
    session = store.sessions.start(ana.pseudonym, SessionSetup())
    first, second = add_capture(store, session), add_capture(store, session, "posterior")
    screen.patients.choose(ana.pseudonym)
    screen.sessions.open(session.session_id)
    assert screen.workspace.capture_id == first.capture_id
    screen.sessions.open(session.session_id, second.capture_id)
    assert screen.workspace.capture_id == second.capture_id
    assert screen.workspace.session.session_id == session.session_id
    assert screen.wanted == ["review", "review"]
    screen.history.show_current.assert_called_with(session.session_id)


def test_a_session_without_captures_opens_without_one(screen, store, ana):
    session = store.sessions.start(ana.pseudonym, SessionSetup())
    screen.patients.choose(ana.pseudonym)
    screen.sessions.open(session.session_id)
    assert screen.workspace.capture_id is None
    assert screen.wanted == ["review"]


def test_a_session_that_is_not_listed_does_not_open(screen, ana):
    screen.patients.choose(ana.pseudonym)
    screen.sessions.open("unknown")
    screen.sessions.delete("unknown")
    screen.sessions.ask_purge("unknown")
    assert screen.wanted == []
    screen.history.ask_purge.assert_not_called()


def test_a_deleted_session_is_left_undone_and_restored(screen, store, ana):
    session = store.sessions.start(ana.pseudonym, SessionSetup())
    screen.patients.choose(ana.pseudonym)
    screen.workspace.choose_session(session)
    screen.sessions.delete(session.session_id)
    assert screen.workspace.session is None
    assert screen.shown_history().sessions == ()
    assert not screen.shown_history().can_continue
    screen.undo.take_back()
    assert len(screen.shown_history().sessions) == 1
    screen.sessions.show_deleted(is_wanted=True)
    screen.sessions.delete(session.session_id)
    screen.sessions.delete(session.session_id)
    assert screen.shown_history().sessions[0].is_deleted
    screen.sessions.open(session.session_id)
    assert screen.wanted == []
    assert screen.told[-1][0] == "warning"
    screen.sessions.restore(session.session_id)
    assert not screen.shown_history().sessions[0].is_deleted


def test_a_session_is_purged_after_the_pseudonym_was_asked_for(screen, store, ana):
    session = store.sessions.start(ana.pseudonym, SessionSetup())
    screen.patients.choose(ana.pseudonym)
    screen.sessions.show_deleted(is_wanted=True)
    screen.sessions.ask_purge(session.session_id)
    screen.history.ask_purge.assert_not_called()  # one that is not hidden
    screen.sessions.delete(session.session_id)
    screen.sessions.ask_purge(session.session_id)
    assert screen.history.ask_purge.call_args.args[0].word == ana.pseudonym
    screen.sessions.purge(session.session_id)
    assert screen.shown_history().sessions == ()
    assert screen.told[-1][0] == "good"


def test_pictures_come_upright_and_one_that_is_lost_leaves_a_gap(screen, store, ana, monkeypatch):
    session = store.sessions.start(ana.pseudonym, SessionSetup(rotation_deg=90))
    picture = np.zeros((48, 64, 3), np.uint8)
    picture[:, :32] = 200  # light at the left: at the top once it is turned clockwise
    seen = add_capture(store, session, "anterior", picture)
    lost = add_capture(store, session, "posterior")
    read = store.captures.thumbnail

    def thumbnail(capture_id):
        return read("unknown" if capture_id == lost.capture_id else capture_id)

    monkeypatch.setattr(store.captures, "thumbnail", thumbnail)
    screen.patients.choose(ana.pseudonym)
    screen.sessions.load_thumbnails((session.session_id,))
    first, second = screen.history.show_thumbnails.call_args.args[0][session.session_id]
    assert (first.capture_id, first.view) == (seen.capture_id, "anterior")
    assert first.picture_rgb.shape == (64, 48, 3)
    assert first.picture_rgb[:28].min() > 150
    assert first.picture_rgb[36:].max() < 60
    assert second.picture_rgb is None


def test_a_session_that_cannot_be_read_has_no_pictures(screen, store, ana):
    session = store.sessions.start(ana.pseudonym, SessionSetup())
    screen.patients.choose(ana.pseudonym)
    store.close()
    screen.sessions.load_thumbnails((session.session_id,))
    screen.history.show_thumbnails.assert_called_with({session.session_id: ()})


def test_a_store_that_fails_is_told_and_shows_nothing_old(screen, store, ana):
    store.sessions.start(ana.pseudonym, SessionSetup())
    screen.patients.choose(ana.pseudonym)
    store.close()
    screen.sessions.refresh()
    assert screen.told[-1][0] == "bad"
    assert screen.shown_history().sessions == ()
    screen.sessions.start()
    assert screen.wanted == []


def test_what_cannot_be_hidden_or_shown_again_is_told_and_stays(screen, store, ana):
    session = store.sessions.start(ana.pseudonym, SessionSetup())
    screen.patients.choose(ana.pseudonym)
    store.close()
    screen.patients.delete()
    screen.patients.restore()
    screen.sessions.delete(session.session_id)
    screen.sessions.restore(session.session_id)
    assert [kind for kind, _sentence in screen.told] == ["bad"] * 4
    assert screen.workspace.patient == ana
    screen.strip.show_undo.assert_called_once_with(None)


# Forms


def test_a_new_patient_is_saved_and_chosen(screen):
    screen.forms.add()
    screen.form.show_entry.assert_called_once_with(PatientEntry(), is_new=True)
    screen.forms.save(PatientEntry(" Eva Mas ", "1/2/1990", " 7 ", "female", "knee "))
    patient = screen.workspace.patient
    assert patient.identity == Identity("Eva Mas", date(1990, 2, 1), "7")
    assert (patient.sex, patient.notes, patient.consents) == ("female", "knee", ())
    screen.form.close_form.assert_called_once_with()


def test_a_patient_is_changed_in_place(screen, store, ana):
    screen.patients.choose(ana.pseudonym)
    screen.forms.edit()
    entry = screen.form.show_entry.call_args.args[0]
    assert entry == PatientEntry("Ana Ruiz", "27/03/2014", "HC-1", "female", "")
    screen.form.show_age.assert_called_with(12)
    screen.forms.save(PatientEntry("Ana Ruiz Gil", "", "HC-1", "", "note"))
    assert store.patients.get(ana.pseudonym).identity == Identity("Ana Ruiz Gil", None, "HC-1")


def test_an_unknown_birth_date_stays_empty_in_the_form(screen, bernat):
    screen.patients.choose(bernat.pseudonym)
    screen.forms.edit()
    assert screen.form.show_entry.call_args.args[0].birth_date == ""


@pytest.mark.parametrize(
    ("entry", "consent", "field"),
    [
        (PatientEntry("  "), None, "name"),
        (PatientEntry("Eva", "31/2/2020"), None, "birth_date"),
        (PatientEntry("Eva"), ConsentEntry((), False), "purposes"),
        (PatientEntry("Eva"), ConsentEntry(("research",), True, " "), "guardian"),
    ],
)
def test_what_is_wrong_is_said_at_its_field_and_nothing_is_saved(
    screen, store, entry, consent, field
):
    screen.forms.add()
    screen.forms.save(entry, consent)
    assert screen.form.show_problem.call_args.args[0] == field
    assert store.patients.search("") == ()
    screen.form.close_form.assert_not_called()


@pytest.mark.usefixtures("ana")
@pytest.mark.parametrize(
    "entry",
    [
        PatientEntry("Someone", "", "HC-1"),
        PatientEntry("ana ruiz", "27/3/2014"),
        PatientEntry("Ana Rui\u0301z", "27/3/2014"),
    ],
)
def test_a_patient_like_another_one_is_saved_on_the_second_wish(screen, store, entry):
    screen.forms.add()
    screen.forms.save(entry)
    assert screen.form.show_problem.call_args.args[0] == "name"
    assert len(store.patients.search("")) == 1
    screen.forms.save(entry)
    assert len(store.patients.search("")) == 2


def test_a_record_number_is_found_among_many_that_contain_it(screen, store):
    for number in range(60):
        store.patients.add(Identity(f"Ana {number:02d}", record_number=f"7{number:02d}"))
    store.patients.add(Identity("Zoe", record_number="7"))
    screen.forms.add()
    screen.forms.save(PatientEntry("Zoé Puig", record_number="7"))
    assert screen.form.show_problem.call_args.args[0] == "name"
    assert len(store.patients.search("")) == 61


@pytest.mark.usefixtures("ana")
def test_a_patient_with_the_same_name_but_another_birth_date_is_somebody_else(screen, store):
    screen.forms.add()
    screen.forms.save(PatientEntry("Ana Ruiz", "1/1/1960"))
    assert len(store.patients.search("ana")) == 2


def test_a_child_is_asked_for_its_guardian(screen):
    screen.forms.note_birth_date("5.5.2008")
    screen.form.show_age.assert_called_with(17)
    screen.form.propose_guardian.assert_called_with(is_guardian=True)
    screen.forms.note_birth_date("4.5.2008")
    screen.form.show_age.assert_called_with(18)
    screen.form.propose_guardian.assert_called_with(is_guardian=False)
    screen.forms.note_birth_date("4.5.20")
    screen.form.show_age.assert_called_with(None)


def test_a_guardian_or_the_patient_consents(screen, bernat):
    screen.forms.add()
    screen.forms.save(PatientEntry("Pau", "1/1/2020"), ConsentEntry(("treatment",), True, "Iu "))
    assert screen.workspace.patient.consents == (Consent(("treatment",), "Iu", True, NOW),)
    screen.patients.choose(bernat.pseudonym)
    screen.forms.edit_consents()
    screen.form.show_consents.assert_called_with(bernat)
    screen.form.propose_guardian.assert_called_with(is_guardian=False)
    screen.forms.give(ConsentEntry((), False))
    assert screen.form.show_problem.call_args.args[0] == "purposes"
    screen.forms.give(ConsentEntry(("research", "teaching"), False))
    given = Consent(("research", "teaching"), "Bernat Puig", False, NOW)
    assert screen.workspace.patient.consents == (given,)


def test_a_consent_is_withdrawn(screen, ana):
    screen.patients.choose(ana.pseudonym)
    screen.forms.edit_consents()
    screen.form.propose_guardian.assert_called_with(is_guardian=True)
    screen.forms.withdraw(0)
    assert screen.shown().consent == "withdrawn"


def test_a_consent_that_cannot_be_saved_adds_the_patient_only_once(screen, store, monkeypatch):
    fails = [True]
    give = store.patients.give_consent

    def give_consent(pseudonym, consent):
        return give("P-NOBODY" if fails else pseudonym, consent)

    monkeypatch.setattr(store.patients, "give_consent", give_consent)
    entry, consent = PatientEntry("Eva"), ConsentEntry(("treatment",), False)
    screen.forms.add()
    screen.forms.save(entry, consent)
    screen.form.close_form.assert_not_called()
    assert screen.told[-1][0] == "bad"
    fails.clear()
    screen.forms.save(entry, consent)
    assert len(store.patients.search("eva")) == 1
    assert len(screen.workspace.patient.consents) == 1


def test_a_cancelled_form_closes(screen):
    screen.forms.add()
    screen.forms.cancel()
    screen.form.close_form.assert_called_once_with()


def test_without_a_chosen_patient_no_form_opens_for_one(screen):
    screen.forms.edit()
    screen.forms.edit_consents()
    screen.forms.give(ConsentEntry(("treatment",), False))
    screen.forms.withdraw(0)
    screen.form.show_entry.assert_not_called()
    screen.form.show_consents.assert_not_called()


def test_a_store_that_is_only_read_offers_no_change(only_looking):
    only_looking.list.show_rights.assert_called_with(is_read_only=True, sees_all_names=True)
    assert not only_looking.shown().can_change
    history = only_looking.shown_history()
    assert (history.can_start, history.can_change, history.is_read_only) == (False, False, True)
    only_looking.forms.add()
    only_looking.forms.edit()
    only_looking.forms.edit_consents()
    only_looking.patients.delete()
    only_looking.form.show_entry.assert_not_called()
    only_looking.form.show_consents.assert_not_called()
    assert only_looking.told == []


# What is typed


@pytest.mark.parametrize(
    "text", ["27/3/2014", "27.03.2014", " 27-3-2014", "2014-03-27", "27 3 2014"]
)
def test_a_birth_date_is_read_as_people_write_it(text):
    assert read_birth_date(text, TODAY) == date(2014, 3, 27)


@pytest.mark.parametrize(
    "text", ["27/3/14", "32/1/2000", "3/27/2014", "May", "5/5/2026", "1/1/1890"]
)
def test_what_is_no_birth_date_is_refused(text):
    with pytest.raises(EntryError):
        read_birth_date(text, TODAY)


def test_no_birth_date_is_none():
    assert read_birth_date("  ", TODAY) is None


TYPED = PatientEntry("Carla", "1/2/2015", "HC-3", "female", "writes with\nthe left hand")
CONSENT = ConsentEntry(("treatment", "research"), is_guardian=True, guardian="Dora")


def kept(screen, *typed):
    """Return the draft of a form in which this stands."""
    screen.form.typed.return_value = typed
    draft = screen.forms.draft()
    screen.form.reset_mock()
    return draft


def test_without_an_open_form_there_is_nothing_to_give_back(screen):
    screen.form.typed.return_value = None
    assert screen.forms.draft() == ""


@pytest.mark.parametrize("consent", [CONSENT, None])
def test_a_new_patient_is_given_back_as_typed_and_can_be_saved(screen, store, consent):
    screen.forms.add()
    screen.forms.take_back(kept(screen, TYPED, consent))
    screen.form.show_entry.assert_called_once_with(TYPED, is_new=True)
    screen.form.show_age.assert_called_with(11)
    assert [call.args[0] for call in screen.form.show_consent.call_args_list] == (
        [] if consent is None else [consent]
    )
    screen.forms.save(TYPED, consent)
    (row,) = store.patients.search("carla")
    assert len(store.patients.get(row.pseudonym).consents) == (0 if consent is None else 1)


def test_a_changed_patient_is_given_back_and_saved_as_the_same(screen, store, ana):
    screen.patients.choose(ana.pseudonym)
    screen.forms.edit()
    draft = kept(screen, TYPED, None)
    screen.forms.add()
    screen.forms.take_back(draft)
    assert screen.form.show_entry.call_args.kwargs == {"is_new": False}
    screen.forms.save(TYPED)
    assert store.patients.get(ana.pseudonym).identity.name == "Carla"


def test_a_consent_is_given_back(screen, store, ana):
    screen.patients.choose(ana.pseudonym)
    screen.forms.edit_consents()
    screen.forms.take_back(kept(screen, None, CONSENT))
    screen.form.show_consents.assert_called_once_with(store.patients.get(ana.pseudonym))
    screen.form.show_consent.assert_called_once_with(CONSENT)
    screen.forms.give(CONSENT)
    assert store.patients.get(ana.pseudonym).consents[-1].given_by == "Dora"


def test_that_the_patient_of_a_form_is_gone_is_told(screen, store, ana):
    screen.patients.choose(ana.pseudonym)
    screen.forms.edit()
    draft = kept(screen, TYPED, None)
    store.patients.delete(ana.pseudonym)
    store.patients.purge(ana.pseudonym)
    screen.forms.take_back(draft)
    assert screen.told[-1][0] == "bad"
    screen.form.show_entry.assert_not_called()
