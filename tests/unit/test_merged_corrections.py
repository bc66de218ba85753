"""Two operators correct the markers of one capture: nothing of either is lost without a choice."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.data.corrections import (
    CorrectionHistory,
    FreeMeasure,
    MarkerCorrection,
    MeasureCorrection,
)
from adibas.data.markers import AutomaticName
from adibas.sessions.merged_corrections import HistoryMerge
from tests.unit.store_samples import marker

DETECTED = (marker("m01", 10.0), marker("m02", 20.0), marker("m03", 30.0))
NOTHING = CorrectionHistory()
FIELDS = {"move": "u", "name": "label"}
LABELS = st.sampled_from(["m01", "m02", "m03", "a", "b"])


def history(*steps, begin=NOTHING, detected=DETECTED):
    """A stack of ("move", label, u), ("name", label, new), ("add", label, u), ("delete", label)."""
    for kind, label, *more in steps:
        before = {one.label: one for one in begin.markers(detected)}.get(label)
        after = None
        if kind == "add":
            after = marker(label, *more)
        elif kind != "delete":
            after = replace(before, **{FIELDS[kind]: more[0]})
        begin = begin.after(MarkerCorrection(before, after))
    return begin


def places(of, detected=DETECTED):
    return {one.label: one.u for one in of.markers(detected)}


def merge(theirs, mine, seen=NOTHING):
    return HistoryMerge(DETECTED, seen, theirs, mine)


def test_corrections_of_different_markers_come_together():
    both = merge(history(("move", "m01", 11.0)), history(("move", "m02", 21.0)))
    assert both.clashes == ()
    assert places(both.history({})) == {"m01": 11.0, "m02": 21.0, "m03": 30.0}


def test_a_name_by_one_and_a_place_by_the_other_make_one_marker():
    both = merge(history(("name", "m01", "C7")), history(("move", "m01", 12.0)))
    assert both.clashes == ()
    assert places(both.history({})) == {"C7": 12.0, "m02": 20.0, "m03": 30.0}
    again = merge(history(("move", "m01", 12.0)), history(("name", "m01", "C7")))
    assert places(again.history({})) == places(both.history({}))


def test_a_name_by_a_model_and_a_place_by_the_other_operator_stay_the_model_s_word():
    word = AutomaticName("shipped, 2024-01-01", 0.98)
    named = MarkerCorrection(DETECTED[0], replace(DETECTED[0], label="neck", named_by=word))
    for theirs, mine in (
        (NOTHING.after(named), history(("move", "m01", 12.0))),
        (history(("move", "m01", 12.0)), NOTHING.after(named)),
    ):
        found = merge(theirs, mine).history({}).markers(DETECTED)[0]
        assert (found.label, found.u, found.named_by) == ("neck", 12.0, word)


def test_a_name_that_was_given_twice_in_a_row_is_followed_to_both_markers():
    mine = history(("add", "a", 1.0), ("name", "a", "b"), ("add", "a", 2.0))
    both = merge(history(("move", "m01", 11.0)), mine)
    assert places(both.history({})) == places(mine) | {"m01": 11.0}


def test_the_same_by_both_is_done_once():
    both = merge(history(("name", "m01", "C7")), history(("name", "m01", "C7")))
    assert both.clashes == ()
    assert both.history({}).n_done == 1


CLASHES = [
    (("move", "m01", 11.0), ("move", "m01", 12.0), {"m01": 11.0}, {"m01": 12.0}),
    (("name", "m01", "C7"), ("name", "m01", "T1"), {"C7": 10.0}, {"T1": 10.0}),
    (("delete", "m01"), ("move", "m01", 12.0), {}, {"m01": 12.0}),
    (("move", "m01", 11.0), ("delete", "m01"), {"m01": 11.0}, {}),
    (("add", "C7", 11.0), ("add", "C7", 12.0), {"C7": 11.0}, {"C7": 12.0}),
    (("name", "m01", "C7"), ("name", "m02", "C7"), {"C7": 10.0}, {"C7": 20.0}),
    (("add", "C7", 11.0), ("name", "m01", "C7"), {"C7": 11.0}, {"C7": 10.0}),
]


@pytest.mark.parametrize(("theirs", "mine", "if_theirs", "if_mine"), CLASHES)
@pytest.mark.parametrize("is_mine", [False, True])
def test_whoever_saves_second_chooses(theirs, mine, if_theirs, if_mine, is_mine):
    stacks = history(theirs), history(mine)
    both = merge(*stacks)
    (clash,) = both.clashes
    merged = places(both.history({clash.name: is_mine}))
    expected = if_mine if is_mine else if_theirs
    assert {label: merged[label] for label in expected} == expected
    assert merged == places(stacks[is_mine])
    assert bool(both.lost({clash.name: is_mine})) != is_mine


def test_exchanged_names_are_followed():
    swap = history(("name", "m01", "x"), ("name", "m02", "m01"), ("name", "x", "m02"))
    both = merge(history(("move", "m03", 33.0)), swap)
    assert both.clashes == ()
    assert places(both.history({})) == {"m02": 10.0, "m01": 20.0, "m03": 33.0}


def test_what_one_takes_back_and_the_other_builds_on_is_brought_together():
    seen = history(("move", "m01", 11.0))
    both = merge(history(("move", "m02", 21.0), begin=seen), seen.undone(), seen)
    assert both.clashes == ()
    assert places(both.history({})) == {"m01": 10.0, "m02": 21.0, "m03": 30.0}


def test_free_measures_of_both_stay_and_follow_names():
    measured = MeasureCorrection(None, FreeMeasure(("m01", "m02")))
    other = MeasureCorrection(None, FreeMeasure(("m03", "m02")))
    seen = NOTHING.after(measured)
    theirs = history(("name", "m01", "C7"), begin=seen)
    both = merge(theirs, seen.after(other), seen)
    assert [one.labels for one in both.history({}).measures()] == [("C7", "m02"), ("m03", "m02")]
    gone = merge(theirs, seen.after(MeasureCorrection(FreeMeasure(("m01", "m02")), None)), seen)
    assert gone.clashes == ()


steps = st.lists(
    st.one_of(
        st.tuples(st.just("move"), LABELS, st.sampled_from([1.0, 2.0])),
        st.tuples(st.just("name"), LABELS, st.sampled_from(["a", "b", "m01", "m02"])),
        st.tuples(st.just("add"), st.sampled_from(["a", "b"]), st.sampled_from([1.0, 2.0])),
        st.tuples(st.just("delete"), st.sampled_from(["m01", "m02", "a"])),
    ),
    max_size=6,
)


def possible(wished, begin=NOTHING):
    """The stack of those wished corrections that can be made one after the other."""
    for step in wished:
        now = {one.label for one in begin.markers(DETECTED)}
        kind, label = step[:2]
        target = {"add": label, "name": step[-1]}.get(kind)
        if (kind == "add" or label in now) and target not in now:
            begin = history(step, begin=begin)
    return begin


@given(steps, steps, steps, st.booleans())
def test_any_two_stacks_become_one_that_fits_and_begins_with_theirs(common, one, other, is_mine):
    seen = possible(common)
    theirs, mine = possible(one, seen), possible(other, seen)
    both = merge(theirs, mine, seen)
    taken = {clash.name: is_mine for clash in both.clashes}
    merged = both.history(taken)
    assert merged.corrections[: theirs.n_done] == theirs.corrections
    found = places(merged)
    if not both.clashes:
        assert both.lost(taken) == ()
    if places(mine) == places(seen):
        assert found == places(theirs)
    if places(theirs) == places(seen):
        assert found == places(mine)


@given(steps, steps, steps)
def test_of_every_marker_that_was_mine_something_is_left(common, one, other):
    seen = possible(common)
    theirs, mine = possible(one, seen), possible(other, seen)
    both = merge(theirs, mine, seen)
    taken = dict.fromkeys((clash.name for clash in both.clashes), False)
    kept = places(both.history(taken)).items()
    lost = {(c.after.label, c.after.u) for c in both.lost(taken) if c.after is not None}
    before = places(seen).items()
    labels, us = {label for label, _ in kept}, {u for _, u in kept}
    for label, u in set(places(mine).items()) - set(before):
        is_there = (label, u) in kept or (label in labels and u in us)
        assert is_there or (label, u) in lost
