"""The table of roles: nobody may more than a clinic would expect, and every refusal says why."""

import pytest

from adibas.sessions.roles import (
    LEAST,
    TITLES,
    WORDS,
    Permission,
    Role,
    allowed,
    may,
    refusal,
    who_may,
)

OPERATOR = {"find-patients", "register-patients", "take-sessions"}
CLINICIAN = OPERATOR | {
    "see-all-names",
    "see-notes",
    "change-patients",
    "report",
    "compare",
    "export",
}
EVERYTHING = CLINICIAN | {
    "purge",
    "retain",
    "back-up",
    "read-log",
    "manage-people",
    "protect",
    "change-protocols",
}


@pytest.mark.parametrize(
    ("role", "expected"),
    [
        (Role.OPERATOR, OPERATOR),
        (Role.CLINICIAN, CLINICIAN),
        (Role.ADMINISTRATOR, EVERYTHING),
    ],
)
def test_each_role_may_what_the_manual_says_and_nothing_else(role, expected):
    assert {one.value for one in allowed(role)} == expected


def test_everything_that_may_be_refused_has_a_place_in_the_table_and_words():
    assert set(LEAST) == set(WORDS) == set(Permission)
    assert set(TITLES) == set(Role)


def test_a_role_may_all_that_the_ones_before_it_may():
    assert set(allowed(Role.OPERATOR)) < set(allowed(Role.CLINICIAN))
    assert set(allowed(Role.CLINICIAN)) < set(allowed(Role.ADMINISTRATOR))


def test_a_refusal_says_what_who_may_and_what_to_do():
    told = str(refusal(Role.OPERATOR, Permission.REPORT))
    assert told.startswith("Making reports is only for clinicians and administrators")
    assert "you are here as operator" in told
    assert "Ask one of them" in told


def test_who_may_is_named_for_everything():
    for permission in Permission:
        titles = [TITLES[role].lower() for role in Role if may(role, permission)]
        words = who_may(permission)
        assert words == "everybody" or all(title in words for title in titles)
