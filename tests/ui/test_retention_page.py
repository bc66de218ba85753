"""How long patients are kept: the rules, the list, and the removal that asks for a word."""

from datetime import UTC, date, datetime

import pytest
from PySide6.QtWidgets import QPlainTextEdit, QPushButton, QSpinBox

from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import StoreError
from adibas.sessions.purging import Purge
from adibas.texts import use_language
from tests.ui.conftest import NoSensor
from tests.unit.store_samples import add_session, open_sample
from ui.settings.screen import build_settings_screen
from ui.widgets.typed_consent import TypedConsent
from ui.workspace import Workspace

THEN, NOW = datetime(2008, 5, 5, tzinfo=UTC), datetime(2026, 11, 22, tzinfo=UTC)


@pytest.fixture
def years(tmp_path, inline_jobs, preferences):
    """A workspace whose store was used in 2008 and now."""
    moment = [THEN]
    with open_sample(tmp_path / "store", clock=lambda: moment[0]) as store:
        add_session(store, Identity("Old Adult", date(1960, 1, 1)))
        add_session(store, Identity("Old Child", date(2003, 1, 1)))
        moment[0] = NOW
        add_session(store, Identity("New Adult", date(1960, 1, 1)))
        yield Workspace(store, inline_jobs, preferences, NoSensor())


@pytest.fixture
def page(qtbot, years):
    screen = build_settings_screen(years)
    qtbot.addWidget(screen)
    screen.resize(1000, 900)
    screen.show()
    screen._tabs.setCurrentWidget(screen.protected)
    yield screen.protected.retention
    screen.closed()
    use_language("en")


def names(workspace):
    rows = workspace.store.patients.search("", limit=10, with_deleted=True)
    return sorted(row.identity.name for row in rows)


def button(page, text):
    (found,) = [one for one in page.findChildren(QPushButton) if one.text().startswith(text)]
    return found


def listed(page):
    return page.findChild(QPlainTextEdit).toPlainText().splitlines()


def consent(page, word):
    """Ask for the removal, type a word, and press the button."""
    button(page, "Remove them").click()
    dialog = page.findChildren(TypedConsent)[-1]
    dialog.field.setText(word)
    dialog.remove.click()
    dialog.reject()


def test_who_would_go_is_listed_with_name_and_reason_and_nobody_goes(page, years):
    assert not button(page, "Remove them").isVisible()
    button(page, "Whose time").click()
    (line,) = listed(page)
    assert line.startswith("Old Adult (P-")
    assert "1 session: an adult, last seen 2008-05-05" in line
    assert names(years) == ["New Adult", "Old Adult", "Old Child"]


def test_only_the_right_word_removes_them_for_good(page, years):
    button(page, "Whose time").click()
    consent(page, "2")
    assert names(years) == ["New Adult", "Old Adult", "Old Child"]
    consent(page, "1")
    assert names(years) == ["New Adult", "Old Child"]
    assert listed(page) == ["1 patient was removed for good."]
    assert not button(page, "Remove them").isVisible()


@pytest.fixture
def two(years, page):
    """Two whose time is over, listed; the names of the first and the second to go."""
    years.preferences.change(child_until_age=20)
    button(page, "Whose time").click()
    first, second = (line.split(" (")[0] for line in listed(page))
    (row,) = years.store.patients.search(first)
    years.choose_patient(years.store.patients.get(row.pseudonym))
    return first, second


@pytest.fixture
def told(years):
    notices = []
    years.noticed.subscribe(lambda kind, sentence: notices.append((kind, sentence)))
    return notices


def test_a_removal_that_is_stopped_tells_who_is_gone_and_lists_who_is_left(
    page, years, two, told, inline_jobs
):
    _first, second = two
    inline_jobs.is_stopped = True
    consent(page, "2")
    inline_jobs.is_stopped = False
    assert names(years) == sorted(["New Adult", second])
    assert years.patient is None
    assert told == [("good", "1 patient was removed for good.")]
    (line,) = listed(page)
    assert line.startswith(second)
    consent(page, "1")
    assert names(years) == ["New Adult"]


def test_a_removal_that_fails_tells_who_is_gone_and_why_and_lists_who_is_left(
    page, years, two, told, monkeypatch
):
    first, second = two
    purge = Purge.patient

    def fail_at_second(self, pseudonym, **how):
        if years.store.patients.names()[pseudonym] == second:
            raise StoreError("It is in use.")
        return purge(self, pseudonym, **how)

    monkeypatch.setattr(Purge, "patient", fail_at_second)
    consent(page, "2")
    assert told == [("bad", "1 patient was removed for good. It is in use.")]
    assert first not in names(years)
    assert years.patient is None
    (line,) = listed(page)
    assert line.startswith(second)


def test_who_came_back_meanwhile_is_not_told_as_removed(page, years, two, told, monkeypatch):
    first, second = two
    purge = Purge.patient

    def purge_and_come_back(self, pseudonym, **how):
        (row,) = years.store.patients.search(second)
        years.store.sessions.start(row.pseudonym, SessionSetup())
        return purge(self, pseudonym, **how)

    monkeypatch.setattr(Purge, "patient", purge_and_come_back)
    consent(page, "2")
    assert told == [("good", "1 patient was removed for good.")]
    assert first not in names(years)
    assert second in names(years)


def test_other_rules_are_kept_and_put_the_list_away(page, years):
    button(page, "Whose time").click()
    _years, age = page.findChildren(QSpinBox)
    age.setValue(20)
    assert years.preferences.now.child_until_age == 20
    assert listed(page) == []
    assert not button(page, "Remove them").isVisible(), "it was another list"
    button(page, "Whose time").click()
    assert sorted(line.split(" (")[0] for line in listed(page)) == ["Old Adult", "Old Child"]


def test_where_nobodys_time_is_over_nothing_can_be_removed(page, years):
    years.preferences.change(retention_years=40, child_until_age=60)
    button(page, "Whose time").click()
    assert listed(page) == ["Nobody's time is over by these rules."]
    assert not button(page, "Remove them").isVisible()


def test_whoever_is_removed_is_no_longer_the_chosen_patient(page, years):
    (row,) = years.store.patients.search("old adult")
    years.choose_patient(years.store.patients.get(row.pseudonym))
    button(page, "Whose time").click()
    consent(page, "1")
    assert years.patient is None
