"""A coding scheme as it is typed says the same as the scheme, and mistakes are told."""

from dataclasses import replace

import pytest

from adibas.data.ethogram import Behaviour, Ethogram, Modifier, Subject
from adibas.errors import BehaviourError
from adibas.recordings.ethogram_json import shipped_ethogram
from tests.unit.coding_samples import ETHOGRAM
from ui.behaviour.scheme import (
    BehaviourFields,
    SchemeFields,
    TypedScheme,
    ethogram_of,
    fields_of,
    kept_names,
    with_new,
    without,
)


def exclusions(ethogram):
    return ethogram.exclusions


@pytest.mark.parametrize("ethogram", [ETHOGRAM, shipped_ethogram()])
def test_a_scheme_that_nobody_changes_stays_the_same(ethogram):
    typed = ethogram_of(fields_of(ethogram), ethogram)
    assert exclusions(typed) == exclusions(ethogram)
    plain = [replace(one, excludes=()) for one in typed.behaviours]
    assert plain == [replace(one, excludes=()) for one in ethogram.behaviours]
    assert replace(typed, behaviours=ethogram.behaviours) == ethogram


def test_exclusions_that_are_no_group_stay_pairs():
    scheme = Ethogram(
        "pairs", (Behaviour("a", excludes=("b",)), Behaviour("b", excludes=("c",)), Behaviour("c"))
    )
    fields = fields_of(scheme)
    assert [one.group for one in fields.behaviours] == ["1", "1, 2", "2"]
    assert ethogram_of(fields, scheme).exclusions == scheme.exclusions


def test_a_behaviour_is_added_changed_and_taken_away():
    fields = with_new(fields_of(ETHOGRAM), "sleeps")
    assert ethogram_of(fields, ETHOGRAM).behaviours[-1] == Behaviour("sleeps")
    fields = without(fields, 0)
    first = replace(fields.behaviours[0], name=" stands ", kind="point", key="x", modifiers="n: #")
    fields = replace(fields, behaviours=(first, *fields.behaviours[1:]))
    changed = ethogram_of(fields, ETHOGRAM).behaviours[0]
    assert changed == Behaviour(
        "stands", "point", "", "x", "place", modifiers=(Modifier("n", (), "number"),)
    )
    assert kept_names(fields) == {"up": "stands", "fidgets": "fidgets", "nods": "nods"}


def test_modifiers_and_subjects_are_typed_as_texts():
    fields = SchemeFields(
        (BehaviourFields("a", modifiers="with: + pen, hair; side: left; how"),), "child=1, peer"
    )
    scheme = ethogram_of(fields, Ethogram("", ()))
    assert scheme.behaviours[0].modifiers == (
        Modifier("with", ("pen", "hair"), "several"),
        Modifier("side", ("left",)),
        Modifier("how", (), "number"),
    )
    assert scheme.subjects == (Subject("child", "1"), Subject("peer"))


@pytest.mark.parametrize(
    ("behaviours", "subjects", "said"),
    [
        ((BehaviourFields(" "),), "", "no name"),
        ((BehaviourFields("a"), BehaviourFields("a ")), "", "a stands twice"),
        ((BehaviourFields("a", key="x"), BehaviourFields("b", key="x")), "", "key x stands twice"),
        ((BehaviourFields("a", key="x"),), "child=x", "key x stands twice"),
        ((BehaviourFields("a"),), "child, child", "child stands twice"),
        ((BehaviourFields("a", modifiers=": pen"),), "", "no modifier"),
        ((BehaviourFields("a", modifiers="w: a|b"),), "", "no modifier"),
    ],
)
def test_what_makes_no_sense_is_told(behaviours, subjects, said):
    with pytest.raises(BehaviourError, match=said):
        ethogram_of(SchemeFields(behaviours, subjects), Ethogram("", ()))


def test_what_was_typed_is_the_same_after_it_was_a_text():
    opened = fields_of(ETHOGRAM)
    typed = TypedScheme(opened, with_new(opened, "bébe 'agua'"))
    assert TypedScheme.from_text(typed.to_text()) == typed
