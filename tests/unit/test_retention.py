"""Who is kept how long, what a removal leaves, and when the disk is full."""

import json
from datetime import UTC, date, datetime, timedelta

import pytest

from adibas.cli import main
from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import StoreError
from adibas.sessions.disk_use import DAYS_A_MONTH, DiskForecast
from adibas.sessions.retention import RetentionRules
from tests.unit.recorded_frames import INFO, make_frames
from tests.unit.store_samples import PASSPHRASE, add_capture, add_session, open_sample

RULES = RetentionRules(years=15, child_until_age=25)


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


def seen(folder, born, day):
    """A patient whose only session was on `day`."""
    moment = datetime(day.year, day.month, day.day, 12, tzinfo=UTC)
    with open_sample(folder, clock=lambda: moment) as store:
        return add_session(store, Identity("A", born)).patient


def expired(folder, today, rules=RULES):
    with open_sample(folder) as store:
        return [(one.pseudonym, one.reason) for one in store.retention.expired(rules, today)]


def test_an_adult_is_kept_for_the_years_and_not_a_day_more(folder):
    adult = seen(folder, date(1980, 5, 5), date(2010, 3, 4))
    assert expired(folder, date(2025, 3, 3)) == []
    assert expired(folder, date(2025, 3, 4)) == [(adult, "adult")]


def test_a_child_is_kept_up_to_the_age_at_least(folder):
    small = seen(folder, date(2008, 6, 1), date(2010, 3, 4))
    assert expired(folder, date(2033, 5, 31)) == []
    assert expired(folder, date(2033, 6, 1)) == [(small, "child")]
    grown = seen(folder, date(1993, 6, 1), date(2011, 5, 31))
    assert (grown, "child") in expired(folder, date(2026, 5, 31))
    assert expired(folder, date(2026, 5, 30)) == []


def test_a_patient_without_birth_date_may_have_been_a_newborn(folder):
    unknown = seen(folder, None, date(2004, 2, 29))
    assert expired(folder, date(2029, 2, 27)) == []
    assert expired(folder, date(2029, 2, 28)) == [(unknown, "unknown")]


def test_the_last_session_counts_also_a_hidden_one_and_who_never_came(folder):
    moments = iter([datetime(2000, 1, 1, tzinfo=UTC)])
    now = [next(moments)]
    with open_sample(folder, clock=lambda: now[0]) as store:
        never = store.patients.add(Identity("N", date(1970, 1, 1))).pseudonym
        came = add_session(store, Identity("C", date(1970, 1, 1))).patient
        now[0] = datetime(2009, 1, 1, tzinfo=UTC)
        late = store.sessions.start(came, SessionSetup())
        store.sessions.delete(late.session_id)
    assert expired(folder, date(2020, 1, 1)) == [(never, "adult")]
    assert expired(folder, date(2024, 1, 1)) == [(never, "adult"), (came, "adult")]


def test_only_applying_removes_and_the_log_tells(folder):
    old = seen(folder, date(1980, 5, 5), date(2000, 3, 4))
    young = seen(folder, date(1980, 5, 5), date(2024, 3, 4))
    today = date(2025, 1, 1)
    told = []
    with open_sample(folder) as store:
        (only,) = store.retention.expired(RULES, today)
        assert "2000-03-04" in only.text
        assert "2015-03-04" in only.text
        assert len(store.patients.search("")) == 2
        (gone,) = store.retention.apply(RULES, today, lambda *step: told.append(step))
        assert (gone.pseudonym, told) == (old, [(1, 1)])
        assert [row.pseudonym for row in store.patients.search("")] == [young]
        lines = [(line.action, line.subject) for line in store.audit.entries(3)]
        assert lines == [("view", "patients"), ("purge", "store"), ("purge", old)]
        assert store.retention.apply(RULES, today) == ()
        assert store.verify().is_sound


def test_a_removal_that_is_stopped_leaves_the_rest_and_the_log_sums_up_who_is_gone(folder):
    for day in (date(2000, 3, 4), date(2001, 3, 4), date(2002, 3, 4)):
        seen(folder, date(1980, 5, 5), day)
    today = date(2025, 1, 1)

    def stop(done, _total):
        if done == 2:
            raise InterruptedError

    with open_sample(folder) as store:
        *_gone, last = store.retention.expired(RULES, today)
        with pytest.raises(InterruptedError):
            store.retention.apply(RULES, today, stop)
        assert store.retention.expired(RULES, today) == (last,)
        (line,) = [one for one in store.audit.entries() if one.detail.get("by") == "retention"]
        assert (line.action, line.subject) == ("purge", "store")
        assert int(line.detail["patients"]) == 2


def test_who_comes_back_while_others_are_removed_stays_with_the_new_session(folder):
    born = date(1980, 5, 5)
    first, second, third = (seen(folder, born, date(2000 + i, 3, 4)) for i in range(3))
    today = datetime(2025, 1, 1, tzinfo=UTC)
    with open_sample(folder, clock=lambda: today) as store:

        def come_back(done, _total):
            if done == 1:
                store.sessions.start(second, SessionSetup())
                store.patients.purge(third)

        gone = store.retention.apply(RULES, today.date(), come_back)
        assert [one.pseudonym for one in gone] == [first]
        assert [row.pseudonym for row in store.patients.search("")] == [second]
        assert len(store.sessions.of_patient(second)) == 2
        (line,) = [one for one in store.audit.entries() if one.detail.get("by") == "retention"]
        assert int(line.detail["patients"]) == 1


def test_a_reader_removes_nobody(folder):
    seen(folder, date(1980, 5, 5), date(2000, 3, 4))
    with open_sample(folder) as first, open_sample(folder) as second:
        try_it = pytest.raises(StoreError, match="another window")
        with try_it:
            second.retention.apply(RULES, date(2025, 1, 1))
        assert len(first.patients.search("")) == 1


@pytest.mark.parametrize("numbers", [(0, 25), (5, 17)])
def test_rules_that_make_no_sense_are_none(numbers):
    with pytest.raises(ValueError, match="no rules"):
        RetentionRules(*numbers)


def test_years_beyond_the_calendar_are_one_sentence(folder):
    seen(folder, date(1980, 5, 5), date(2000, 3, 4))
    with pytest.raises(StoreError, match="Give fewer"):
        expired(folder, date(2025, 1, 1), RetentionRules(years=9000))


def test_the_disk_is_forecast_from_what_the_last_days_took(folder):
    now = [datetime(2026, 1, 1, tzinfo=UTC)]
    with open_sample(folder, clock=lambda: now[0]) as store:
        assert store.forecast_disk().months_left is None
        session = add_session(store)
        for day in (1, 100, 120):
            now[0] = datetime(2026, 1, 1, tzinfo=UTC) + timedelta(days=day)
            with store.recordings.create(session.session_id, INFO) as writer:
                for frame in make_frames(2, seed=day):
                    writer.write(frame)
            if day == 1:
                assert store.forecast_disk().bytes_per_month is None
        add_capture(store, session)
        now[0] = datetime(2026, 1, 1, tzinfo=UTC) + timedelta(days=150)
        forecast = store.forecast_disk()
        sizes = [one.size_bytes for one in store.recordings.of_session(session.session_id)][1:]
    sizes += [path.stat().st_size for path in (folder / "pictures").rglob("*.sealed")]
    assert forecast.bytes_per_month == pytest.approx(sum(sizes) / 90 * DAYS_A_MONTH)
    assert DiskForecast(100, 25.0).months_left == 4
    assert DiskForecast(100, 0.0).months_left is None


def test_the_command_lists_and_removes_when_asked(folder, monkeypatch, capsys):
    monkeypatch.setenv("ADIBAS_PASSPHRASE", PASSPHRASE)
    old = seen(folder, date(1980, 5, 5), date(2000, 3, 4))
    words = ["sessions", "retention", "--store", str(folder), "--years", "20"]
    assert main(words) == 0
    out = capsys.readouterr().out
    assert old in out
    assert "nothing was removed" in out
    assert "GB are free" in out
    assert main([*words, "--apply", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [one["pseudonym"] for one in told["patients"]] == [old]
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["patients"] == []
    with pytest.raises(SystemExit, match="2"):
        main([*words, "--child-until-age", "12"])
