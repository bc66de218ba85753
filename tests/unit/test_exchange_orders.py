"""Whom an order is of, as the store keeps a patient."""

from dataclasses import replace
from datetime import date, datetime

import pytest

from adibas.exchange.orders import Order, ordered_person, start_of

ORDER = Order("A-1", "", " HC-004711", "Ñandú^Ximena", "20140327", "F", "R-1", "Posture", "")


@pytest.mark.parametrize(
    ("written", "name"),
    [
        ("Ñandú^Ximena", "Ximena Ñandú"),
        ("Ibarra Ruiz^Rosa^María^Dra.^PhD", "Dra. Rosa María Ibarra Ruiz PhD"),
        ("Yamada^Tarou=山田^太郎=やまだ^たろう", "Tarou Yamada"),
        ("Rosa Ibarra", "Rosa Ibarra"),
        ("Ibarra^^^^^^", "Ibarra"),
        ("Iba\x1b[2Jrra^", "Iba[2Jrra"),
        ("", ""),
    ],
)
def test_a_name_is_said_given_name_first(written, name):
    assert ordered_person(replace(ORDER, patient_name=written)).name == name


def test_birth_date_record_number_and_sex_are_taken_over():
    person = ordered_person(ORDER)
    assert (person.birth_date, person.record_number, person.sex) == (
        date(2014, 3, 27),
        "HC-004711",
        "female",
    )
    assert "Ximena" not in repr(person)


@pytest.mark.parametrize("born", ["", "2014", "20140230", "unknown"])
def test_what_is_no_day_is_no_birth_date(born):
    assert ordered_person(replace(ORDER, birth_date=born)).birth_date is None


@pytest.mark.parametrize(("told", "sex"), [("M", "male"), ("f", "female"), ("O", ""), ("", "")])
def test_a_sex_that_the_store_does_not_know_is_not_told(told, sex):
    assert ordered_person(replace(ORDER, sex=told)).sex == sex


@pytest.mark.parametrize(
    ("told", "start"),
    [
        ("20261121090000", datetime(2026, 11, 21, 9, 0)),
        ("202611210930", datetime(2026, 11, 21, 9, 30)),
        ("20261121", datetime(2026, 11, 21)),
        ("", None),
        ("soon", None),
    ],
)
def test_an_order_begins_when_the_list_says(told, start):
    assert start_of(replace(ORDER, start=told)) == start
