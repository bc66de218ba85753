"""What the behaviour screen decides, without Qt: over real recordings, drafts and a real store."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import create_autospec

import numpy as np
import pytest

from adibas.behaviour.agreement import AgreementParams
from adibas.data.coding import Coding, Occurrence, Section
from adibas.data.ethogram import Behaviour, Ethogram, Subject
from adibas.data.patients import Identity
from adibas.data.sentence import Sentence
from adibas.data.sessions import SessionSetup
from adibas.errors import LimbError, RecordingError
from adibas.pipeline.behaviour import ESTIMATED, BehaviourAnalysis
from adibas.pipeline.coding_drafts import BesideRecording, read_draft
from adibas.pipeline.draft_history import note_blind, write_history
from adibas.pipeline.found_joints import FoundJoints
from adibas.recordings import create_recording
from adibas.recordings.codings import read_codings
from adibas.recordings.ethogram_json import read_ethogram, shipped_ethogram, write_ethogram
from adibas.reports.codings import write_codings
from adibas.texts import message
from tests.ui.behaviour_scene import (
    FRAME_MS,
    INFO,
    N_FRAMES,
    InlineFeed,
    make_frames,
    make_recording,
    time_ms,
)
from tests.ui.conftest import NoSensor
from tests.unit import store_samples
from tests.unit.store_samples import add_patient
from ui.behaviour.counts_presenter import EVERYBODY
from ui.behaviour.playing import Playing, frame_at, frame_times_ms
from ui.behaviour.presenter import BehaviourPresenter, BehaviourView
from ui.behaviour.scheme import fields_of, without
from ui.behaviour.sources import ALL
from ui.behaviour.tables import TextTable
from ui.workspace import Workspace


class LazyKeeper:
    """Writes drafts when somebody waits for it."""

    def __init__(self):
        self.waiting = {}
        self.is_closed = False

    def keep(self, place, history, at_ms):
        self.waiting[place] = (history, at_ms)

    def flush(self):
        for place, kept in self.waiting.items():
            write_history(place, *kept)
        self.waiting.clear()

    def close(self):
        self.flush()
        self.is_closed = True


class Clock:
    """Seconds that the test lets pass."""

    def __init__(self):
        self.now_s = 100.0

    def __call__(self):
        return self.now_s


class Scene:
    """A presenter over a view that only notes what it is told."""

    def __init__(self, workspace, folder):
        self.workspace, self.folder = workspace, folder
        self.view = create_autospec(BehaviourView, instance=True)
        self.feed, self.keeper, self.clock = InlineFeed(), LazyKeeper(), Clock()
        self.presenter = BehaviourPresenter(
            self.view, workspace, self.feed, self.keeper, self.clock
        )
        self.told = []
        workspace.noticed.subscribe(lambda kind, sentence: self.told.append((kind, sentence)))

    @property
    def coding(self):
        return self.presenter.coding

    @property
    def events(self):
        return [
            (one.behaviour, one.begin_ms, one.end_ms)
            for one in self.coding.draft.coding.occurrences
        ]

    @property
    def index(self):
        return self.view.show_frame.call_args.args[1].index

    @property
    def timeline(self):
        return self.view.show_timeline.call_args.args[0]

    def kept(self, path, observer=""):
        """Return the draft that is on the disk."""
        self.keeper.flush()
        return read_draft(BesideRecording(path, observer))

    def open(self, name="child.mcap"):
        path = self.folder / name
        if not path.exists():
            make_recording(path)
        self.presenter.open_file(path)
        return path

    def seated(self, first, last):
        self.presenter.go_to(first)
        self.coding.press("seated")
        self.presenter.go_to(last)
        self.coding.press("seated")


@pytest.fixture
def scene(inline_jobs, preferences, tmp_path):
    """Without a store: no session is looked at."""
    scene = Scene(Workspace(None, inline_jobs, preferences, NoSensor()), tmp_path)
    yield scene
    scene.presenter.close()


@pytest.fixture
def stored_scene(workspace, tmp_path):
    """Over a real store."""
    scene = Scene(workspace, tmp_path)
    yield scene
    scene.presenter.close()


def test_frames_have_whole_milliseconds_and_never_run_back():
    times_ns = np.array([1_000_499_999, 1_033_500_001, 900_000_000, 1_100_000_000])
    assert frame_times_ms(times_ns) == (1000, 1034, 1034, 1100)


def test_the_frame_at_a_time_is_the_last_one_that_is_not_later():
    assert [frame_at((10, 20, 20, 30), at) for at in (0, 10, 19, 20, 99)] == [0, 0, 0, 2, 3]


def test_a_change_of_speed_goes_on_from_where_the_video_is():
    playing = Playing(tuple(range(0, 10_000, 100)))
    playing.start(10, 50.0)
    assert playing.due(51.0) == 20
    playing.set_speed(4.0, 51.0)
    assert playing.due(52.0) == 60
    playing.stop()
    assert not playing.is_on


def test_without_a_recording_nothing_can_be_done(scene):
    scene.presenter.enter()
    scene.view.show_source.assert_called_with("", "")
    presenter, coding = scene.presenter, scene.coding
    for action in (
        *(presenter.play_or_stop, presenter.tick, presenter.go_to_end, coding.undo, coding.redo),
        *(coding.accept, coding.remove, coding.set_begin, coding.set_end, coding.keep, coding.show),
        *(presenter.files.end_blind, lambda: coding.select_next(1), coding.select_next_proposed),
        *(lambda: coding.press("seated"), lambda: coding.release("seated")),
        *(lambda: coding.use_ethogram(shipped_ethogram()),),
        *(lambda: presenter.go_to_ms(5), lambda: presenter.finding.find(())),
        *(lambda: presenter.files.open_coding(Path("a.csv")),),
        *(lambda: presenter.files.save_as(Path("a.csv")),),
        *(lambda: presenter.files.save_scheme(Path("a.json")),),
        *(lambda: presenter.files.begin_blind("MP"),),
        *(lambda: presenter.files.change_scheme(fields_of(shipped_ethogram())),),
        *(lambda: presenter.counts.write(Path("a.xlsx")),),
        *(lambda: presenter.counts.compare_file(Path("a.csv")),),
        *(lambda: presenter.counts.write_agreement(Path("a.xlsx")),),
        *(lambda: presenter.counts.set_seen(is_seen=True),),
    ):
        action()
    assert not presenter.key("s")
    assert presenter.now_ms() == 0
    assert scene.feed.asked == []
    scene.view.show_timeline.assert_not_called()


def test_a_recording_opens_on_its_first_frame(scene):
    scene.open()
    assert scene.presenter.source.title == "child"
    picture, position = scene.view.show_frame.call_args.args
    assert int(picture[0, 0, 0]) == 0
    assert (position.index, position.n_frames, position.time_ms) == (0, N_FRAMES, time_ms(0))
    assert scene.coding.draft.coding.ethogram == shipped_ethogram()
    scene.presenter.enter()
    scene.view.show_source.assert_called_once_with("child", "child")


def test_a_key_that_was_not_pressed_here_ends_nothing(scene):
    scene.open()
    scene.coding.is_holding = True
    scene.presenter.key_let_go("h")
    assert scene.events == []
    assert not scene.view.show_desk.call_args.args[0].can_undo


def test_a_file_that_is_no_recording_is_told(scene):
    (scene.folder / "a.mcap").write_bytes(b"nothing")
    scene.presenter.open_file(scene.folder / "a.mcap")
    (problem,) = scene.workspace.jobs.problems
    assert isinstance(problem, RecordingError)
    assert scene.presenter.source is None


def test_a_recording_without_frames_is_told(scene):
    make_recording(scene.folder / "empty.mcap", 0)
    scene.presenter.open_file(scene.folder / "empty.mcap")
    (problem,) = scene.workspace.jobs.problems
    assert "no frames" in str(problem)


def test_what_a_crash_took_of_a_recording_is_told(scene):
    path = make_recording(scene.folder / "child.mcap")
    path.write_bytes(path.read_bytes()[:-400])
    scene.presenter.open_file(path)
    assert scene.told[-1][0] == "warning"


def test_frames_are_stepped_through_and_bounded(scene):
    scene.open()
    scene.presenter.step(3)
    assert scene.index == 3
    scene.presenter.step(-30)
    assert scene.index == 0
    scene.presenter.go_to_end()
    assert scene.index == N_FRAMES - 1
    scene.presenter.go_to_ms(time_ms(40) + 5)
    assert scene.index == 40
    scene.presenter.skip_s(1.0)
    assert scene.index == 70


def test_quick_steps_count_although_frames_come_later(scene):
    scene.open()
    scene.feed.waits = True
    for _step in range(3):
        scene.presenter.step(1)
    assert scene.feed.asked[-1] == 3
    scene.feed.give(3)
    assert scene.index == 3


def test_a_running_video_follows_the_clock(scene):
    scene.open()
    scene.presenter.play_or_stop()
    scene.clock.now_s += 0.5
    scene.presenter.tick()
    assert scene.index == 15
    scene.presenter.tick()
    assert scene.feed.asked[-2:] == [0, 15]
    scene.presenter.set_speed(0.25)
    scene.clock.now_s += 0.4
    scene.presenter.tick()
    assert scene.index == 18
    scene.presenter.play_or_stop()
    scene.clock.now_s += 1.0
    scene.presenter.tick()
    assert scene.index == 18


def test_a_slow_disk_leaves_frames_out_and_does_not_fall_behind(scene):
    scene.open()
    scene.presenter.play_or_stop()
    scene.feed.waits = True
    for _tick in range(5):
        scene.clock.now_s += 0.1
        scene.presenter.tick()
    assert scene.feed.asked == [0, 3]
    scene.feed.give(3)
    scene.presenter.tick()
    assert scene.feed.asked[-1] == 15


def test_the_end_stops_the_video_and_play_begins_anew(scene):
    scene.open()
    scene.presenter.play_or_stop()
    scene.clock.now_s += 60.0
    scene.presenter.tick()
    assert scene.index == N_FRAMES - 1
    assert scene.view.show_playing.call_args.kwargs["is_on"] is False
    scene.presenter.play_or_stop()
    scene.presenter.tick()
    assert scene.index == 0


def test_a_skip_does_not_stop_the_video(scene):
    scene.open()
    scene.presenter.play_or_stop()
    scene.feed.waits = True
    scene.presenter.skip_s(1.0)
    assert scene.view.show_playing.call_args.kwargs["is_on"] is True


def test_speeds_have_a_slowest_and_a_fastest(scene):
    for _press in range(9):
        scene.presenter.change_speed(1)
    assert scene.view.show_playing.call_args.kwargs["speed"] == 4.0
    for _press in range(9):
        scene.presenter.change_speed(-1)
    assert scene.view.show_playing.call_args.kwargs["speed"] == 0.25


def test_a_damaged_frame_is_told_and_shown_as_none(scene):
    scene.open()
    scene.presenter.play_or_stop()
    scene.feed.failed.emit(7, RecordingError("Frame 7 is damaged."))
    picture, position = scene.view.show_frame.call_args.args
    assert picture is None
    assert position.index == 7
    assert scene.told[-1] == ("bad", "Frame 7 is damaged.")


def test_keys_code_behaviours_and_choose_subjects(scene):
    scene.open()
    assert scene.presenter.key("P")
    assert scene.events == [("changes posture", time_ms(0), time_ms(0))]
    scene.coding.choose_subject("")
    assert scene.presenter.key("1")
    assert scene.view.show_desk.call_args.args[0].subject == "child"
    assert not scene.presenter.key("?")


def test_a_key_that_is_held_lasts_and_its_repeats_count_nothing(scene):
    scene.open()
    scene.coding.is_holding = True
    for index in (0, 1, 2):
        scene.presenter.go_to(index)
        scene.presenter.key("h")
    scene.presenter.key_let_go("h")
    scene.presenter.key_let_go("?")
    assert scene.events == [("fidgets with hands", time_ms(0), time_ms(2))]


def test_letting_a_key_go_means_nothing_where_presses_count(scene):
    scene.open()
    scene.presenter.key("h")
    scene.presenter.key_let_go("h")
    assert scene.coding.draft.begun


def test_what_does_not_fit_is_told_and_changes_nothing(scene):
    scene.open()
    scene.seated(2, 30)
    scene.presenter.go_to(10)
    scene.coding.press("leaves seat")
    assert scene.told[-1][0] == "bad"
    assert scene.events == [("seated", time_ms(2), time_ms(30))]
    assert not scene.coding.draft.begun


def test_every_step_is_kept_and_taken_back(scene):
    path = scene.open()
    scene.seated(0, 30)
    assert scene.kept(path).coding.occurrences[0].end_ms == time_ms(30)
    scene.coding.undo()
    assert scene.events == []
    assert scene.coding.draft.begun
    scene.coding.redo()
    scene.coding.redo()
    assert scene.events == [("seated", time_ms(0), time_ms(30))]


def test_a_state_that_lasts_while_the_video_runs_is_kept_as_long_as_it_is(scene):
    path = scene.open()
    scene.presenter.play_or_stop()
    for seconds in (0.5, 2.0):
        scene.clock.now_s += seconds
        scene.presenter.tick()
    assert scene.kept(path) is None
    scene.coding.press("seated")
    scene.presenter.go_to(0)
    scene.coding.press("looks at the task")
    scene.presenter.play_or_stop()
    for seconds in (2.0, 0.1, 2.0):
        scene.clock.now_s += seconds
        scene.presenter.tick()
    (looks, _seated) = scene.kept(path).coding.occurrences
    assert looks.end_ms == time_ms(63)


def test_what_was_coded_is_there_when_the_recording_is_opened_again(scene):
    path = scene.open()
    scene.seated(0, 30)
    scene.presenter.leave()
    scene.presenter.open_file(path)
    assert scene.events == [("seated", time_ms(0), time_ms(30))]


def test_events_are_gone_through_in_their_order(scene):
    scene.open()
    scene.seated(10, 20)
    scene.presenter.go_to(50)
    scene.coding.press("raises hand")
    scene.presenter.go_to(30)
    scene.coding.select(None)
    scene.coding.select_next(1)
    assert scene.index == 50
    scene.coding.select_next(1)
    assert scene.index == 50
    scene.coding.select_next(-1)
    assert scene.index == 10
    assert scene.view.show_selected.call_args.args[0].occurrence.behaviour == "seated"
    scene.presenter.go_to(30)
    scene.coding.select(None)
    scene.coding.select_next(-1)
    assert scene.index == 10


def test_the_chosen_event_is_set_by_the_frame_that_is_seen(scene):
    scene.open()
    scene.seated(10, 20)
    scene.coding.select(scene.coding.draft.coding.occurrences[0])
    scene.presenter.go_to(5)
    scene.coding.set_begin()
    scene.presenter.go_to(40)
    scene.coding.set_end()
    assert scene.events == [("seated", time_ms(5), time_ms(40))]
    scene.presenter.go_to(1)
    scene.coding.set_end()
    assert scene.told[-1][0] == "bad"
    scene.coding.remove()
    assert scene.events == []
    assert scene.view.show_selected.call_args.args[0] is None


def test_a_point_event_moves_as_a_whole(scene):
    scene.open()
    scene.coding.press("raises hand")
    scene.coding.select(scene.coding.draft.coding.occurrences[0])
    scene.presenter.go_to(8)
    scene.coding.set_begin()
    assert scene.events == [("raises hand", time_ms(8), time_ms(8))]
    scene.presenter.go_to(9)
    scene.coding.set_end()
    assert scene.events == [("raises hand", time_ms(9), time_ms(9))]


def test_a_state_that_lasts_can_be_looked_at(scene):
    scene.open()
    scene.coding.press("seated")
    scene.coding.select(scene.coding.draft.begun[0])
    assert scene.view.show_selected.call_args.args[0].layer == "begun"


SEEN = Ethogram("program", (Behaviour("waves"),), (Subject("person 1"),))


def analysis(*spans, notices=()):
    """Return what the program would see: waves from frame to frame."""
    events = tuple(
        Occurrence("waves", time_ms(first), time_ms(last), "person 1") for first, last in spans
    )
    whole = (time_ms(0), time_ms(N_FRAMES - 1))
    detected = Coding("child", SEEN, *whole, events, "ADiBAS")
    found = create_autospec(BehaviourAnalysis, instance=True)
    found.detected, found.notices = detected, notices
    return found


@pytest.fixture
def seeing(monkeypatch):
    """Let the program see what a test says; what it was asked for is returned."""
    asked = []

    def see(found):
        def analyse(request, progress):
            asked.append(request)
            progress(1, 1)
            if isinstance(found, Exception):
                raise found
            return found

        monkeypatch.setattr("adibas.pipeline.behaviour.analyse_behaviour", analyse)
        return asked

    return see


def test_detected_events_are_decided_one_after_the_other(scene, seeing):
    seeing(analysis((10, 20), (30, 40), (50, 60)))
    path = scene.open()
    scene.presenter.finding.find(())
    assert "3 events found" in scene.told[-1][1]
    assert scene.index == 10
    assert scene.view.show_selected.call_args.args[0].layer == "proposed"
    scene.coding.accept()
    assert scene.index == 30
    scene.coding.remove()
    assert scene.index == 50
    chosen = scene.coding.draft.proposed[0]
    scene.coding.change(chosen, replace(chosen, end_ms=time_ms(55)))
    scene.coding.accept()
    assert "decided" in scene.told[-1][1]
    waves = [("waves", time_ms(10), time_ms(20)), ("waves", time_ms(50), time_ms(55))]
    assert scene.events == waves
    assert {one.subject for one in scene.coding.draft.coding.occurrences} == {"child"}
    assert scene.kept(path).proposed == ()


def test_detected_events_wait_for_another_day(scene, seeing):
    seeing(analysis((10, 20)))
    path = scene.open()
    scene.presenter.finding.find(())
    scene.presenter.leave()
    scene.presenter.open_file(path)
    assert [bar.layer for bar in scene.timeline.bars] == ["proposed"]
    scene.coding.select_next_proposed()
    assert scene.index == 10


def test_nothing_to_find_is_told_and_notices_are_not_lost(scene, seeing):
    notice = Sentence(message("Person 1 is out of view."))
    asked = seeing(analysis(notices=(Sentence(ESTIMATED), notice)))
    path = scene.open()
    scene.presenter.finding.find((Path("model.json"),))
    kind, told = scene.told[-1]
    assert kind == "warning"
    assert told == "0 events found. Enter takes one, Delete rejects it. Person 1 is out of view."
    assert (asked[0].source, asked[0].models) == (path, (Path("model.json"),))


def test_a_recording_in_which_nobody_is_found_is_told(scene, seeing):
    seeing(LimbError("Nobody was found in {file}. {reason}", file="a", reason=""))
    scene.open()
    scene.presenter.finding.find(())
    assert isinstance(scene.workspace.jobs.problems[-1], LimbError)
    assert scene.view.show_finding.call_args.kwargs["is_on"] is False


def test_what_is_found_in_a_recording_that_was_left_is_not_shown(scene, seeing, monkeypatch):
    seeing(analysis((10, 20)))
    scene.open()
    jobs = scene.workspace.jobs
    start, later = jobs.start, []

    def wait(label, work, done, failed=None, ended=None):
        return start(label, work, later.append if "Finding" in label else done, failed, ended)

    monkeypatch.setattr(jobs, "start", wait)
    scene.presenter.finding.find(())
    scene.open("other.mcap")
    done = scene.presenter.finding._on_found
    done(None, later[0])
    assert scene.coding.draft.proposed == ()


def test_nothing_is_decided_twice(scene):
    scene.open()
    scene.seated(1, 2)
    scene.coding.select(scene.coding.draft.coding.occurrences[0])
    scene.coding.accept()
    assert scene.events == [("seated", time_ms(1), time_ms(2))]


def test_an_event_that_a_locked_scheme_lacks_stays_a_proposal(scene, seeing):
    seeing(analysis((10, 20)))
    scene.open()
    scene.coding.use_ethogram(replace(shipped_ethogram(), is_locked=True))
    scene.presenter.finding.find(())
    scene.coding.accept()
    assert scene.told[-1][0] == "bad"
    assert len(scene.coding.draft.proposed) == 1


def test_sections_are_marked_and_removed(scene):
    scene.open()
    section = Section("game", time_ms(0), time_ms(30))
    scene.coding.mark_section(section)
    assert scene.timeline.sections == (section,)
    scene.coding.remove_section(section)
    assert scene.timeline.sections == ()


@pytest.mark.parametrize("ending", ["csv", "xlsx", "boris", "eaf"])
def test_a_coding_is_saved_and_opened_again(scene, ending):
    scene.open()
    scene.seated(10, 20)
    copy = scene.folder / f"copy.{ending}"
    scene.presenter.files.save_as(copy)
    assert scene.told[-1][0] == "good"
    scene.coding.undo()
    scene.presenter.files.open_coding(copy)
    assert scene.events == [("seated", time_ms(10), time_ms(20))]
    scene.coding.undo()
    assert scene.events == []


def test_observers_programs_count_from_the_beginning_of_the_video(scene):
    scene.open()
    scene.seated(0, 10)
    scene.presenter.files.save_as(scene.folder / "copy.boris")
    (found,) = read_codings(scene.folder / "copy.boris")
    assert found.occurrences[0].begin_ms == 0


def test_a_coding_that_cannot_be_read_is_told(scene):
    scene.open()
    scene.seated(10, 20)
    scene.presenter.files.open_coding(scene.folder / "missing.csv")
    scene.presenter.counts.compare_file(scene.folder / "missing.csv")
    assert len(scene.workspace.jobs.problems) == 2
    assert scene.events == [("seated", time_ms(10), time_ms(20))]


def later_jobs(scene, monkeypatch):
    """Let jobs wait until what is returned is called."""
    jobs = scene.workspace.jobs
    start, waiting = jobs.start, []
    monkeypatch.setattr(jobs, "start", lambda *told, **more: waiting.append((told, more)))

    def run():
        now = waiting[:]
        waiting.clear()
        for told, more in now:
            start(*told, **more)

    return run


def test_a_coding_that_is_read_too_late_is_not_taken(scene, monkeypatch):
    scene.open()
    scene.seated(10, 20)
    copy = scene.folder / "copy.csv"
    scene.presenter.files.save_as(copy)
    scene.coding.undo()
    run = later_jobs(scene, monkeypatch)
    scene.presenter.files.open_coding(copy)
    scene.presenter.counts.compare_file(copy)
    scene.presenter.files.begin_blind("XY")
    run()
    assert scene.events == []
    assert scene.timeline.bars == ()


def test_what_changes_while_two_are_compared_is_compared_after_it(scene, monkeypatch):
    scene.open()
    other = other_coding(scene, 0, 60)
    scene.presenter.counts.compare_file(other)
    run = later_jobs(scene, monkeypatch)
    scene.seated(0, 60)
    run()
    run()
    assert not [bar for bar in scene.timeline.bars if bar.layer == "difference"]
    scene.coding.undo()
    scene.presenter.counts.forget()
    scene.view.reset_mock()
    run()
    scene.view.show_agreement.assert_not_called()


def test_a_coding_without_a_scheme_keeps_the_one_in_use(scene):
    scene.open()
    (scene.folder / "none.csv").write_text(
        "recording,label,begin_s,end_s,kind\nchild,,5.0,6.0,session\n"
    )
    scene.presenter.files.open_coding(scene.folder / "none.csv")
    assert scene.coding.draft.coding.ethogram == shipped_ethogram()


def test_a_scheme_is_opened_saved_and_changed(scene):
    scene.open()
    scheme = replace(shipped_ethogram(), name="mine", behaviours=shipped_ethogram().behaviours[3:])
    scheme = replace(scheme, behaviours=tuple(replace(b, excludes=()) for b in scheme.behaviours))
    write_ethogram(scene.folder / "mine.json", scheme)
    scene.presenter.files.open_scheme(scene.folder / "mine.json")
    assert scene.coding.draft.coding.ethogram.name == "mine"
    scene.coding.press("turns away")
    files = scene.presenter.files
    fields = fields_of(scheme)
    assert "turns away is coded" in files.change_scheme(without(fields, 1))
    assert files.change_scheme(without(fields, 0)) == ""
    files.save_scheme(scene.folder / "saved.json")
    assert len(read_ethogram(scene.folder / "saved.json").behaviours) == 6
    scene.coding.undo()
    assert len(scene.coding.draft.coding.ethogram.behaviours) == 7


def test_a_second_observer_sees_nothing_of_the_first_one(scene, seeing):
    seeing(analysis((10, 20)))
    path = scene.open()
    scene.seated(0, 30)
    scene.presenter.finding.find(())
    files = scene.presenter.files
    files.begin_blind("MP")
    assert scene.coding.is_blind
    assert scene.index == 0
    assert scene.events == []
    assert scene.timeline.bars == ()
    assert scene.view.show_desk.call_args.args[0].is_locked
    for forbidden in (
        lambda: scene.presenter.finding.find(()),
        lambda: files.open_coding(BesideRecording(path).path("coding")),
        lambda: scene.presenter.counts.compare_file(BesideRecording(path).path("coding")),
        lambda: files.begin_blind("XY"),
    ):
        forbidden()
    assert scene.timeline.bars == ()
    scene.coding.use_ethogram(shipped_ethogram())
    assert "locked" in scene.told[-1][1]
    scene.seated(0, 60)
    assert scene.kept(path, "MP").coding.observer == "MP"
    files.end_blind()
    assert scene.events == [("seated", time_ms(0), time_ms(30))]
    layers = [bar.layer for bar in scene.timeline.bars]
    assert {"coded", "other", "difference", "proposed"} == set(layers)


def test_a_second_observer_goes_on_another_day(scene):
    path = scene.open()
    scene.presenter.files.begin_blind("MP")
    scene.seated(0, 60)
    scene.presenter.files.end_blind()
    scene.presenter.open_file(path)
    assert scene.events == []
    assert not scene.coding.is_blind
    scene.presenter.files.begin_blind("MP")
    assert scene.events == [("seated", time_ms(0), time_ms(60))]


def test_opening_a_recording_again_shows_a_blind_observer_nothing(scene):
    path = scene.open()
    scene.seated(0, 30)
    scene.presenter.files.begin_blind("MP")
    scene.seated(0, 60)
    scene.presenter.leave()
    for _time in range(2):
        scene.presenter.open_file(path)
        assert scene.coding.is_blind
        assert scene.view.show_blind.call_args.args == ("MP",)
        assert scene.events == [("seated", time_ms(0), time_ms(60))]
        assert {bar.layer for bar in scene.timeline.bars} == {"coded"}
    scene.presenter.files.end_blind()
    assert scene.events == [("seated", time_ms(0), time_ms(30))]
    scene.coding.undo()
    assert scene.coding.draft.begun, "the first observer's steps are there, too"
    scene.presenter.open_file(path)
    assert not scene.coding.is_blind


def test_who_codes_blind_and_has_coded_nothing_yet_stays_blind(scene):
    path = make_recording(scene.folder / "child.mcap")
    note_blind(BesideRecording(path), "MP")
    scene.presenter.open_file(path)
    assert scene.coding.is_blind
    assert scene.events == []
    assert scene.view.show_desk.call_args.args[0].is_locked


def test_what_was_coded_on_another_day_is_taken_back_step_by_step(scene):
    path = scene.open()
    scene.seated(0, 30)
    scene.presenter.go_to(40)
    scene.coding.press("raises hand")
    scene.coding.undo()
    scene.presenter.leave()
    scene.presenter.open_file(path)
    desk = scene.view.show_desk.call_args.args[0]
    assert (desk.can_undo, desk.can_redo) == (True, True)
    scene.coding.redo()
    assert len(scene.events) == 2
    for _step in range(3):
        scene.coding.undo()
    assert scene.events == []


def test_steps_that_cannot_be_read_are_told_and_the_coding_is_there(scene):
    path = scene.open()
    scene.seated(0, 30)
    scene.coding.close()
    scene.keeper.flush()
    BesideRecording(path).path("steps").write_text("{", "utf-8")
    scene.presenter.open_file(path)
    assert "cannot be undone" in scene.told[-1][1]
    assert scene.events == [("seated", time_ms(0), time_ms(30))]


def test_a_second_observer_has_initials_of_his_own(scene):
    scene.workspace.preferences.change(operator="AB")
    scene.open()
    for initials in (" ", "AB"):
        scene.presenter.files.begin_blind(initials)
        assert scene.told[-1][0] == "bad"
        assert not scene.coding.is_blind


def shown_counts(scene):
    return scene.view.show_counts.call_args.args[0]


def test_counts_follow_the_coding_while_they_are_seen(scene):
    scene.open()
    scene.presenter.counts.set_seen(is_seen=True)
    scene.seated(0, 30)
    line = next(one for one in shown_counts(scene).lines if "seated" in one)
    assert "0.99" in line
    for kind in ("bins", "events", "transitions"):
        scene.presenter.counts.choose_table(kind)
        assert shown_counts(scene).titles
    scene.presenter.counts.choose_table("bins")
    scene.presenter.counts.set_bin(1.0)
    assert len(shown_counts(scene).lines) == 3
    scene.view.show_counts.reset_mock()
    scene.presenter.counts.set_seen(is_seen=False)
    scene.coding.undo()
    scene.view.show_counts.assert_not_called()


def test_sampling_says_what_it_would_have_seen(scene):
    scene.open()
    scene.seated(0, 15)
    counts = scene.presenter.counts
    counts.set_seen(is_seen=True)
    counts.set_bin(1.0)
    shares = {}
    for kind in ("partial", "whole", "momentary"):
        counts.choose_table(kind)
        shares[kind] = next(one[2:] for one in shown_counts(scene).lines if one[1] == "seated")
    assert shares == {
        "partial": ("33.3", "16.9"),
        "whole": ("0.0", "16.9"),
        "momentary": ("0.0", "16.9"),
    }


def test_transitions_say_what_began_after_what(scene):
    scene.open()
    scene.coding.press("seated")
    scene.presenter.go_to(9)
    scene.coding.press("leaves seat")
    scene.presenter.go_to(12)
    scene.presenter.counts.set_seen(is_seen=True)
    scene.presenter.counts.choose_table("transitions")
    assert shown_counts(scene).lines == (("child", "seated", "leaves seat", "1"),)


@pytest.mark.parametrize("ending", ["xlsx", "csv"])
def test_counts_are_written(scene, ending):
    scene.open()
    scene.seated(0, 30)
    path = scene.folder / f"counts.{ending}"
    scene.presenter.counts.write(path)
    assert scene.told[-1][0] == "good"
    assert path.stat().st_size


def other_coding(scene, first, last):
    """Write the coding of another observer."""
    whole = (time_ms(0), time_ms(N_FRAMES - 1))
    seen = (Occurrence("seated", time_ms(first), time_ms(last), "child"),)
    path = scene.folder / "other.csv"
    write_codings(path, [Coding("child", shipped_ethogram(), *whole, seen, "MP")], "en")
    return path


def test_agreement_names_its_methods_and_shows_where_two_differ(scene):
    scene.open()
    scene.seated(0, 30)
    counts = scene.presenter.counts
    counts.compare_file(other_coding(scene, 0, 60))
    table, sentence = scene.view.show_agreement.call_args.args
    assert "Kappa by units of time (Cohen)" in {line[0] for line in table.lines}
    assert any(line[1] == "\N{EN DASH}" and line[4] for line in table.lines)
    assert "0 events not agreed on, and 1.0 s" in sentence
    differences = [bar for bar in scene.timeline.bars if bar.layer == "difference"]
    assert [(bar.begin_ms, bar.end_ms) for bar in differences] == [(time_ms(30), time_ms(60))]
    scene.coding.undo()
    scene.coding.undo()
    (alone,) = [bar for bar in scene.timeline.bars if bar.layer == "difference"]
    assert (alone.begin_ms, alone.end_ms) == (time_ms(0), time_ms(60))
    counts.set_params(AgreementParams(unit_ms=100))
    counts.write_agreement(scene.folder / "agreement.xlsx")
    assert (scene.folder / "agreement.xlsx").stat().st_size


def test_what_the_program_measured_is_written_with_the_coding(scene, seeing, monkeypatch):
    seeing(analysis((10, 20)))
    scene.open()
    scene.presenter.finding.find(())
    written = []
    monkeypatch.setattr("ui.behaviour.counts_presenter.divided", lambda *told: told)
    monkeypatch.setattr("ui.behaviour.counts_presenter.replace", lambda _found, **more: more)
    monkeypatch.setattr(
        "adibas.reports.behaviour.write_behaviour", lambda *told: written.append(told)
    )
    scene.presenter.counts.write(scene.folder / "all.xlsx")
    ((found, path, _language),) = written
    assert found["observed"] == scene.coding.coding()
    assert path.name == "all.xlsx"


def test_a_second_observer_is_not_shown_what_was_compared(scene):
    scene.open()
    scene.presenter.counts.compare_file(other_coding(scene, 0, 60))
    scene.presenter.files.begin_blind("XY")
    assert scene.view.show_agreement.call_args.args == (TextTable(), "")
    assert scene.timeline.bars == ()


def test_codings_that_share_no_scheme_are_told(scene):
    scene.open()
    scene.seated(0, 30)
    scheme = Ethogram("", (Behaviour("seated", "point"),))
    whole = (time_ms(0), time_ms(N_FRAMES - 1))
    scene.presenter.counts.compare(Coding("child", scheme, *whole, (), "MP"))
    assert "state for one observer" in str(scene.workspace.jobs.problems[-1])


def test_another_recording_is_not_compared_with_what_was_compared_before(scene):
    scene.open()
    scene.presenter.counts.compare_file(other_coding(scene, 0, 60))
    scene.open("second.mcap")
    assert scene.view.show_agreement.call_args.args == (TextTable(), "")
    assert {bar.layer for bar in scene.timeline.bars} == set()


def test_a_recording_of_the_session_is_coded_and_sealed(stored_scene):
    scene, store = stored_scene, stored_scene.workspace.store
    patient = add_patient(store, Identity("Rosa Ibarra", None, "HC-77"))
    session = store.sessions.start(patient.pseudonym, SessionSetup())
    with store.recordings.create(session.session_id, INFO) as writer:
        for frame in make_frames(9):
            writer.write(frame)
    scene.workspace.choose_patient(patient)
    scene.workspace.choose_session(session)
    (choice,) = scene.view.show_stored.call_args.args[0]
    assert choice.recording_id == writer.recording_id
    scene.presenter.open_stored(writer.recording_id)
    title, name = scene.view.show_source.call_args.args
    assert title == f"{choice.created_utc:%Y-%m-%d %H:%M}"
    assert name == writer.recording_id[:8]
    scene.seated(0, 5)
    scene.presenter.open_stored(writer.recording_id)
    assert scene.events == [("seated", time_ms(0), time_ms(5))]
    assert not list(scene.folder.rglob("*.csv"))
    scene.presenter.files.save_as(scene.folder / "copy.eaf")
    scene.presenter.counts.write(scene.folder / "counts.csv")
    logged = [one.subject for one in store.audit.entries() if one.action == "export"]
    assert logged == 2 * [session.session_id]
    assert len(scene.presenter.source.access.sha256(scene.presenter.source.path)) == 64
    scene.presenter.open_stored("ab" * 16)
    assert scene.presenter.source.path == Path(writer.recording_id)


def test_a_recording_of_a_capture_is_called_by_its_day_and_view(stored_scene):
    scene, store = stored_scene, stored_scene.workspace.store
    session = store_samples.add_session(store)
    with store.recordings.create(session.session_id, INFO) as writer:
        for frame in make_frames(3):
            writer.write(frame)
    recording_id = writer.recording_id
    store_samples.add_capture(store, session, view="posterior", recording_id=recording_id)
    scene.workspace.choose_session(session)
    (choice,) = scene.view.show_stored.call_args.args[0]
    scene.presenter.open_stored(recording_id)
    title = scene.view.show_source.call_args.args[0]
    assert title == f"{choice.created_utc:%Y-%m-%d %H:%M}, Back"


def test_a_recording_of_another_session_is_left(stored_scene):
    scene, store = stored_scene, stored_scene.workspace.store
    patient = add_patient(store, Identity("Rosa Ibarra", None, "HC-77"))
    session, later = (store.sessions.start(patient.pseudonym, SessionSetup()) for _ in range(2))
    with store.recordings.create(session.session_id, INFO) as writer:
        for frame in make_frames(9):
            writer.write(frame)
    scene.workspace.choose_session(session)
    scene.presenter.open_stored(writer.recording_id)
    scene.workspace.choose_session(session)
    scene.coding.press("seated")
    source, finding = scene.presenter.source, scene.presenter.finding
    assert source is not None
    finding.keep_joints(source, FoundJoints(()))
    assert finding.joints is not None
    scene.workspace.choose_session(later)
    assert scene.presenter.source is None
    assert scene.coding.draft is None
    finding.keep_joints(source, FoundJoints(()))
    assert finding.joints is None, "what was found of one who was left is of no use for the next"
    scene.view.show_source.assert_called_with("", "")
    scene.workspace.choose_session(None)
    scene.open()
    scene.workspace.choose_session(session)
    assert scene.presenter.source.title == "child"


@pytest.fixture
def late(stored_scene, monkeypatch):
    """A recording of Rosa's session; recordings that are opened wait until the test says so."""
    scene, store = stored_scene, stored_scene.workspace.store
    rosa = add_patient(store, Identity("Rosa Ibarra", None, "HC-77"))
    session = store.sessions.start(rosa.pseudonym, SessionSetup())
    with store.recordings.create(session.session_id, INFO) as writer:
        for frame in make_frames(9):
            writer.write(frame)
    scene.workspace.choose_patient(rosa)
    scene.workspace.choose_session(session)
    openings, closed = [], []

    def hold(_label, work, done):
        opened = work(None)
        reader, close = opened.reader, opened.reader.close
        monkeypatch.setattr(reader, "close", lambda: closed.append(reader) or close())
        openings.append(SimpleNamespace(reader=reader, arrive=lambda: done(opened)))

    monkeypatch.setattr(scene.workspace.jobs, "start", hold)
    return SimpleNamespace(openings=openings, closed=closed, recording_id=writer.recording_id)


def test_a_recording_that_comes_when_another_patient_is_looked_at_is_not_shown(stored_scene, late):
    scene, workspace = stored_scene, stored_scene.workspace
    scene.presenter.open_stored(late.recording_id)
    workspace.choose_patient(add_patient(workspace.store, Identity("Bernat")))
    (opening,) = late.openings
    opening.arrive()
    assert scene.presenter.source is None
    assert scene.coding.draft is None
    assert late.closed == [opening.reader]
    scene.view.show_frame.assert_not_called()


def test_of_two_recordings_the_one_that_was_wanted_last_is_shown(stored_scene, late):
    scene = stored_scene
    scene.presenter.open_stored(late.recording_id)
    scene.open("child.mcap")
    first, last = late.openings
    last.arrive()
    first.arrive()
    assert scene.presenter.source.name == "child"
    assert late.closed == [first.reader]


def test_what_a_second_window_writes_has_a_line_in_the_audit_log(second_window, store, tmp_path):
    scene = Scene(second_window, tmp_path)
    scene.keeper.flush = lambda: None  # it keeps no drafts
    session = store_samples.add_session(store)
    with store.recordings.create(session.session_id, INFO) as writer:
        for frame in make_frames(3):
            writer.write(frame)
    second_window.choose_session(session)
    scene.presenter.open_stored(writer.recording_id)
    scene.presenter.files.save_as(tmp_path / "copy.eaf")
    scene.presenter.note_map()
    scene.presenter.close()
    lines = [one for one in reversed(store.audit.entries()) if one.action == "export"]
    assert [(one.operator, one.subject) for one in lines] == 2 * [("second", session.session_id)]
    assert [one.detail["kind"] for one in lines] == ["coding", "map"]


def test_another_language_says_everything_again(scene):
    scene.open()
    scene.presenter.counts.compare_file(other_coding(scene, 0, 60))
    scene.presenter.counts.set_seen(is_seen=True)
    scene.view.reset_mock()
    scene.presenter.refresh()
    scene.view.show_desk.assert_called()
    scene.view.show_counts.assert_called_once()
    scene.view.show_agreement.assert_called_once()


def test_closing_keeps_everything_and_ends_threads(scene):
    path = scene.open()
    scene.coding.press("seated")
    scene.presenter.go_to(20)
    scene.presenter.close()
    assert scene.feed.is_closed
    assert scene.keeper.is_closed
    (one,) = scene.kept(path).coding.occurrences
    assert one.end_ms == time_ms(20)


def test_what_is_measured_is_shown_once_the_program_has_looked(scene, seeing, monkeypatch):
    seeing(analysis((10, 20)))
    scene.open()
    counts = scene.presenter.counts
    counts.set_seen(is_seen=True)
    counts.choose_table("joints")
    scene.view.show_unmeasured.assert_called_with(is_unmeasured=True)
    assert scene.view.show_counts.call_args.args == (TextTable(),)
    counts.choose_table("activity")
    assert scene.view.show_plot.call_args.args == (None,)
    monkeypatch.setattr("ui.behaviour.counts_presenter.divided", lambda *told: told[1:])
    monkeypatch.setattr("ui.behaviour.counts_presenter.measured_table", lambda *told: told)
    monkeypatch.setattr("ui.behaviour.counts_presenter.heat_map", lambda *told: told)
    scene.presenter.finding.find(())
    scene.view.show_unmeasured.assert_called_with(is_unmeasured=False)
    assert scene.view.show_plot.call_args.args[0][2] == 60_000
    counts.choose_table("paths")
    assert scene.view.show_counts.call_args.args == (("paths", ((), 60_000)),)
    counts.choose_table("raster")
    assert [name[:5] for name in scene.view.show_plot.call_args.args[0].rows] == ["waves"]


def test_the_activity_of_one_person_is_shown_and_events_are_of_everybody(
    scene, seeing, monkeypatch
):
    several = analysis((10, 20))
    several.people = (SimpleNamespace(person=1), SimpleNamespace(person=2))
    seeing(several)
    scene.open()
    counts = scene.presenter.counts
    monkeypatch.setattr("ui.behaviour.counts_presenter.divided", lambda found, *_told: found)
    monkeypatch.setattr("ui.behaviour.counts_presenter.of_person", lambda _found, person: person)
    shown = []
    monkeypatch.setattr(
        "ui.behaviour.counts_presenter.measured_table",
        lambda kind, found: shown.append((kind, found if found == 2 else "everybody")),
    )
    scene.presenter.finding.find(())
    counts.set_seen(is_seen=True)
    counts.choose_table("joints")
    names = ((1, "Person 1"), (2, "Person 2"))
    scene.view.show_people.assert_called_with(names, EVERYBODY)
    counts.choose_person(2)
    scene.view.show_people.assert_called_with(names, 2)
    counts.choose_table("detected")
    scene.view.show_people.assert_called_with((), EVERYBODY)
    assert shown == [("joints", "everybody"), ("joints", 2), ("detected", "everybody")]


def test_recordings_that_follow_one_another_are_one_observation(scene):
    paths = [make_recording(scene.folder / f"part {number}.mcap", 30) for number in (10, 2)]
    scene.presenter.open_files(paths)
    title, name = scene.view.show_source.call_args.args
    assert title == "part 2 and 1 more"
    assert "a second stands for the break" in scene.told[-1][1]
    scene.presenter.go_to_end()
    assert scene.index == 59
    coding = scene.coding.draft.coding
    assert coding.media == ("part 2", "part 10")
    seam_ms = time_ms(29) + 1000
    assert coding.variables[1] == ("part 10 begins [s]", f"{seam_ms / 1000:.3f}")
    assert coding.end_ms == seam_ms + FRAME_MS * 29
    scene.seated(10, 40)
    scene.presenter.open_file(paths[0])
    assert scene.events == [], "what is coded of a part alone is another coding"
    scene.presenter.open_files(paths[::-1])
    assert [event[0] for event in scene.events] == ["seated"]
    assert (scene.folder / f"{name}.coding.csv").exists()
    scene.presenter.open_files(paths[:1])
    assert scene.presenter.source.parts == ()


def test_a_part_of_another_camera_is_told(scene):
    first = make_recording(scene.folder / "a.mcap", 3)
    other = scene.folder / "b.mcap"
    with create_recording(other, replace(INFO, sensor_serial="T2")) as writer:
        for frame in make_frames(3):
            writer.write(frame)
    scene.presenter.open_files([first, other])
    assert "another camera" in str(scene.workspace.jobs.problems[-1])
    assert scene.presenter.source is None


@pytest.mark.parametrize("n_recordings", [1, 2])
def test_joints_are_looked_for_as_the_pictures_of_the_session_were_turned(
    stored_scene, seeing, n_recordings
):
    scene, store = stored_scene, stored_scene.workspace.store
    patient = add_patient(store, Identity("Rosa Ibarra", None, "HC-77"))
    session = store.sessions.start(patient.pseudonym, SessionSetup(rotation_deg=90))
    for _number in range(n_recordings):
        with store.recordings.create(session.session_id, INFO) as writer:
            for frame in make_frames(9):
                writer.write(frame)
    asked = seeing(analysis())
    scene.workspace.choose_session(session)
    scene.presenter.open_stored(writer.recording_id if n_recordings == 1 else ALL)
    scene.presenter.finding.find(())
    assert [request.rotation_deg for request in asked] == [90]


def test_all_recordings_of_a_session_are_one_observation(stored_scene):
    scene, store = stored_scene, stored_scene.workspace.store
    patient = add_patient(store, Identity("Rosa Ibarra", None, "HC-77"))
    session = store.sessions.start(patient.pseudonym, SessionSetup())
    for n_frames in (9, 5):
        with store.recordings.create(session.session_id, INFO) as writer:
            for frame in make_frames(n_frames):
                writer.write(frame)
    scene.workspace.choose_session(session)
    scene.presenter.open_stored(ALL)
    scene.presenter.go_to_end()
    assert scene.index == 13
    assert scene.view.show_source.call_args.args[0].endswith(" and 1 more")
    scene.seated(0, 12)
    scene.presenter.open_stored(writer.recording_id)
    assert scene.events == []
    scene.presenter.open_stored(ALL)
    assert [event[0] for event in scene.events] == ["seated"]
    assert len(scene.presenter.source.access.sha256(Path("any"))) == 64
    scene.workspace.choose_session(None)
    scene.keeper.flush()
    store.sessions.purge(session.session_id)
    assert not list(store.folder.glob("codings/*/*.sealed"))
