"""What the report screen offers, previews and writes, without Qt, over a real store."""

from unittest.mock import create_autospec

import openpyxl
import pytest

from adibas.data.report import PictureChoice
from adibas.data.sessions import SessionSetup
from adibas.errors import FileError
from adibas.texts import use_language
from tests.ui.comparison_scene import add_patient, add_session
from tests.ui.review_scene import new_capture, picture_rgb, saved_session
from ui.reports import presenter as reports
from ui.reports.presenter import ReportsPresenter, ReportsView


@pytest.fixture(autouse=True)
def english_afterwards():
    yield
    use_language("en")


@pytest.fixture
def view():
    return create_autospec(ReportsView, instance=True)


@pytest.fixture
def saved(store):
    return saved_session(store, ("anterior", "posterior"))


@pytest.fixture
def presenter(view, workspace):
    presenter = ReportsPresenter(view, workspace)
    yield presenter
    presenter.close()


def lines(view):
    return view.show_sessions.call_args.args[0]


def look_at(workspace, saved):
    workspace.choose_patient(saved[0])
    workspace.choose_session(saved[1])


def test_without_a_session_it_says_what_to_do(presenter, view):
    presenter.enter()
    assert lines(view) == ()
    assert "No session has a capture" in view.show_no_preview.call_args.args[0]


def test_the_session_that_is_looked_at_is_chosen_and_previewed(presenter, view, workspace, saved):
    look_at(workspace, saved)
    presenter.enter()
    ((line,),) = (lines(view),)
    assert (line.session_id, line.who, line.is_chosen) == (saved[1].session_id, "Somebody", True)
    head, pages = view.show_preview.call_args.args
    assert [page.title for page in pages] == ["Anterior", "Posterior"]
    assert all(page.picture_rgb.ndim == 3 for page in pages)
    assert saved[0].pseudonym in str(head)
    assert "Somebody" not in str(head)


def test_a_choice_of_several_stays_until_another_session_is_looked_at(
    presenter, view, workspace, store, saved
):
    other = saved_session(store)
    look_at(workspace, saved)
    presenter.enter()
    both = (saved[1].session_id, other[1].session_id)
    presenter.choose_sessions(both)
    presenter.leave()
    presenter.enter()
    assert {line.session_id for line in lines(view) if line.is_chosen} == set(both)
    presenter.leave()
    look_at(workspace, other)
    presenter.enter()
    assert [line.session_id for line in lines(view) if line.is_chosen] == [other[1].session_id]


def test_a_session_whose_patient_was_hidden_is_neither_shown_nor_written(
    presenter, view, workspace, store, saved, tmp_path
):
    other = saved_session(store)
    look_at(workspace, saved)
    presenter.enter()
    presenter.choose_sessions((saved[1].session_id, other[1].session_id))
    presenter.leave()
    store.patients.delete(saved[0].pseudonym)
    workspace.choose_patient(None)
    presenter.enter()
    assert [(one.session_id, one.is_chosen) for one in lines(view)] == [(other[1].session_id, True)]
    head, _pages = view.show_preview.call_args.args
    assert other[0].pseudonym in str(head)
    presenter.write(tmp_path / "out", (".csv",))
    (file,) = (tmp_path / "out").iterdir()
    assert file.name.startswith(other[0].pseudonym)
    presenter.leave()
    store.patients.restore(saved[0].pseudonym)
    look_at(workspace, saved)
    presenter.enter()
    assert [one.session_id for one in lines(view) if one.is_chosen] == [saved[1].session_id]


def test_a_session_is_chosen_before_it_has_captures(presenter, view, workspace, store, saved):
    session = store.sessions.start(saved[0].pseudonym, SessionSetup())
    look_at(workspace, (saved[0], session))
    presenter.enter()
    assert "no capture" in view.show_no_preview.call_args.args[0]
    presenter.leave()
    store.captures.add(session.session_id, new_capture(), picture_rgb())
    workspace.choose_session(store.sessions.get(session.session_id))
    presenter.enter()
    assert [one.session_id for one in lines(view) if one.is_chosen] == [session.session_id]


def test_the_same_choice_is_not_previewed_twice(presenter, view, workspace, saved):
    look_at(workspace, saved)
    presenter.enter()
    presenter.choose_sessions((saved[1].session_id,))
    assert view.show_preview.call_count == 1
    presenter.choose_sessions(())
    assert "Choose a session" in view.show_no_preview.call_args.args[0]


def test_sessions_without_captures_are_not_offered(presenter, view, store, saved):
    store.sessions.start(saved[0].pseudonym, SessionSetup())
    presenter.enter()
    assert [line.session_id for line in lines(view)] == [saved[1].session_id]


def test_an_old_session_that_is_looked_at_is_offered_first(
    presenter, view, workspace, store, saved, monkeypatch
):
    saved_session(store)
    monkeypatch.setattr(reports, "MOST_SESSIONS", 1)
    look_at(workspace, saved)
    presenter.enter()
    assert lines(view)[0].session_id == saved[1].session_id
    assert len(lines(view)) == 2


def test_new_content_of_the_session_is_shown_only_where_somebody_looks(
    presenter, view, workspace, saved
):
    look_at(workspace, saved)
    view.show_sessions.assert_not_called()
    presenter.enter()
    workspace.choose_session(saved[1])
    assert view.show_sessions.call_count == 2
    presenter.leave()
    workspace.choose_session(saved[1])
    assert view.show_sessions.call_count == 2


def test_the_report_speaks_as_the_window_until_another_language_is_chosen(
    presenter, view, workspace, saved
):
    look_at(workspace, saved)
    workspace.preferences.change(theme="dark")
    assert view.show_wish.call_count == 1
    workspace.preferences.change(language="es")
    assert view.show_wish.call_args.args[0].language == "es"
    view.show_preview.assert_not_called()
    presenter.enter()
    head, _pages = view.show_preview.call_args.args
    assert "Paciente" in str(head)
    workspace.preferences.change(language="en")
    assert "Paciente" not in str(view.show_preview.call_args.args[0])
    presenter.choose_language("ca")
    assert "Pacient" in str(view.show_preview.call_args.args[0])
    workspace.preferences.change(language="es")
    assert view.show_wish.call_args.args[0].language == "ca"


def test_pictures_are_shown_as_wished(presenter, view, workspace, saved):
    look_at(workspace, saved)
    presenter.enter()
    plain = view.show_preview.call_args.args[1][0].picture_rgb
    presenter.choose_pictures(PictureChoice.DEPTH)
    assert (view.show_preview.call_args.args[1][0].picture_rgb != plain).any()


def test_notes_are_left_out_where_the_pictures_hide_who_it_is(
    presenter, view, workspace, store, saved
):
    store.sessions.change(saved[1].session_id, notes="Marta says her knee hurts")
    look_at(workspace, saved)
    presenter.enter()

    def is_told():
        return "Marta" in str(view.show_preview.call_args.args[0])

    assert is_told()
    for choice in (PictureChoice.DEPTH, PictureChoice.BLURRED):
        presenter.choose_pictures(choice)
        assert not view.show_wish.call_args.args[0].with_notes
    presenter.choose_pictures(PictureChoice.DEPTH)
    assert not is_told()
    presenter.choose_notes(with_notes=True)
    assert is_told()
    presenter.choose_pictures(PictureChoice.AS_IS)
    presenter.choose_notes(with_notes=False)
    assert not is_told()


def test_more_sessions_than_are_listed_are_told(presenter, view, store, saved, monkeypatch):
    monkeypatch.setattr(reports, "MOST_SESSIONS", 2)
    presenter.enter()
    assert view.show_sessions.call_args.kwargs == {"n_newest": None}
    saved_session(store)
    presenter.enter()
    assert view.show_sessions.call_args.kwargs == {"n_newest": None}
    saved_session(store)
    presenter.enter()
    assert view.show_sessions.call_args.kwargs == {"n_newest": 2}
    assert saved[1].session_id not in {line.session_id for line in lines(view)}


def test_what_cannot_be_previewed_says_why(presenter, view, store, saved):
    session = store.sessions.start(saved[0].pseudonym, SessionSetup())
    presenter.choose_sessions((session.session_id,))
    assert "no capture" in view.show_no_preview.call_args.args[0]


class LongJob:
    """A job that runs until it is stopped."""

    is_running = True

    def cancel(self):
        self.is_running = False


def test_a_newer_preview_takes_the_place_of_one_in_work(presenter, workspace, saved):
    jobs = []
    workspace.jobs.start = lambda *_words: jobs.append(LongJob()) or jobs[-1]
    presenter.choose_sessions((saved[1].session_id,))
    presenter.choose_pictures(PictureChoice.DEPTH)
    assert [job.is_running for job in jobs] == [False, True]


def test_reports_are_written_noted_and_the_folder_remembered(
    presenter, view, store, saved, told, tmp_path
):
    other = saved_session(store)
    presenter.choose_sessions((saved[1].session_id, other[1].session_id))
    presenter.write(tmp_path / "out", (".xlsx", ".csv"))
    files = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert len(files) == 4
    assert told == [("good", told[0][1])]
    assert told[0][1].startswith("4 files are written")
    view.show_written.assert_called_with(tmp_path / "out")
    assert presenter.folder == str(tmp_path / "out")
    exported = [entry for entry in store.audit.entries(50) if entry.action == "export"]
    assert {entry.subject for entry in exported} == {saved[1].session_id, other[1].session_id}
    workbook = openpyxl.load_workbook(next((tmp_path / "out").glob("*.xlsx")))
    assert "Somebody" not in str(
        [row for one in workbook for row in one.iter_rows(values_only=True)]
    )


@pytest.mark.parametrize(("chosen", "kinds"), [(True, ()), (False, (".xlsx",))])
def test_nothing_is_written_without_a_session_and_a_kind(
    presenter, saved, told, tmp_path, chosen, kinds
):
    presenter.choose_sessions((saved[1].session_id,) if chosen else ())
    presenter.write(tmp_path / "out", kinds)
    assert told[-1][0] == "warning"
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_written_is_told_and_the_attempt_noted(
    presenter, view, store, saved, inline_jobs, tmp_path
):
    (tmp_path / "out").write_text("a file stands here")
    presenter.choose_sessions((saved[1].session_id,))
    presenter.write(tmp_path / "out", (".xlsx",))
    (problem,) = inline_jobs.problems
    assert isinstance(problem, FileError)
    view.show_written.assert_called_once_with(None)
    assert any(entry.action == "export" for entry in store.audit.entries(50))


def test_the_user_may_stop_the_writing(presenter, view, saved, inline_jobs, tmp_path, told):
    presenter.choose_sessions((saved[1].session_id,))
    inline_jobs.is_stopped = True
    presenter.write(tmp_path / "out", (".csv", ".xlsx"))
    assert len(list((tmp_path / "out").iterdir())) == 1
    assert not told
    view.show_written.assert_called_once_with(None)


def test_reports_that_were_written_when_stop_was_pressed_are_told(
    presenter, view, saved, inline_jobs, tmp_path, told
):
    presenter.choose_sessions((saved[1].session_id,))
    inline_jobs.is_stopped_late = True
    presenter.write(tmp_path / "out", (".csv", ".xlsx"))
    assert told[0][1].startswith("2 files are written")
    view.show_written.assert_called_with(tmp_path / "out")


def test_a_store_that_is_only_read_can_be_reported_and_the_log_says_so(
    second_window, store, saved, view, tmp_path
):
    presenter = ReportsPresenter(view, second_window)
    presenter.choose_sessions((saved[1].session_id,))
    presenter.write(tmp_path / "out", (".csv",))
    presenter.close()
    assert len(list((tmp_path / "out").glob("*.csv"))) == 1
    (line,) = [entry for entry in store.audit.entries() if entry.action == "export"]
    assert (line.operator, line.subject) == ("second", saved[1].session_id)


def test_a_patient_removed_while_the_list_is_read_is_told_by_the_pseudonym(
    presenter, view, store, saved, monkeypatch
):
    monkeypatch.setattr(store.patients, "names", dict)
    presenter.enter()
    assert lines(view)[0].who == saved[0].pseudonym


def test_a_report_tells_what_changed_since_an_earlier_session(presenter, view, workspace, store):
    patient = add_patient(store)
    visits = [add_session(store, patient.pseudonym, 0.01 * number) for number in range(3)]
    workspace.choose_patient(patient)
    workspace.choose_session(visits[2])
    presenter.enter()
    offered, chosen = view.show_earlier.call_args.args
    assert {one.session_id for one in offered} == {one.session_id for one in visits[:2]}
    assert chosen == ""
    presenter.choose_earlier(visits[0].session_id)
    head, _pages = view.show_preview.call_args.args
    assert "Compared with the session of (UTC)" in dict(head)
    presenter.choose_sessions((visits[1].session_id,))
    assert view.show_earlier.call_args.args[1] == visits[0].session_id
    presenter.choose_sessions((visits[0].session_id,))
    assert view.show_earlier.call_args.args == ((), "")
    head, _pages = view.show_preview.call_args.args
    assert "Compared with the session of (UTC)" not in dict(head)
    presenter.choose_sessions(tuple(one.session_id for one in visits))
    assert view.show_earlier.call_args.args == ((), "")
