"""Ethograms and codings: what is refused, budgets that add up, and samples of time."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from adibas.behaviour.budget import (
    bin_spans,
    budgets,
    conditions,
    gaps,
    merged,
    shared_ms,
    time_bins,
    transitions,
)
from adibas.behaviour.sampling import SAMPLINGS, samples
from adibas.data.coding import Coding, Occurrence, Section, problems_of
from adibas.data.ethogram import Behaviour, Ethogram, Modifier, Subject
from adibas.errors import AdibasError, BehaviourError
from adibas.recordings.ethogram_json import (
    ethogram_document,
    read_ethogram,
    shipped_ethogram,
    write_ethogram,
)
from adibas.texts import LANGUAGES, speaking
from tests.unit.coding_samples import ETHOGRAM, coding, codings


def first_problem(*occurrence, observed_ms=(0, 60_000)):
    found = list(problems_of(ETHOGRAM, [Occurrence(*occurrence)], observed_ms))
    return found[0].sentence.text if found else ""


@pytest.mark.parametrize(
    ("occurrence", "words"),
    [
        (("dances", 0, 1), "not in the ethogram"),
        (("seated", 0, 1, "dog"), "dog is not in the ethogram"),
        (("seated", 5, 1), "ends before it begins"),
        (("seated", 0, 60_001), "outside the session"),
        (("nods", 0, 1), "it lasts"),
        (("seated", 0, 1, "", ("red",)), "modifier red"),
        (("fidgets", 0, 1, "", ("pen,shoe",)), "modifier pen,shoe"),
        (("fidgets", 0, 1, "", ("", "pen")), "modifier pen"),
        (("nods", 0, 0, "", ("often",)), "modifier often"),
    ],
)
def test_an_occurrence_that_cannot_be_is_told(occurrence, words):
    assert words in first_problem(*occurrence)


@pytest.mark.parametrize(
    "occurrence",
    [
        ("fidgets", 0, 1, "child", ("pen,hair", "left")),
        ("nods", 3, 3, "peer", ("2.5",)),
        ("fidgets", 0, 60_000, "", ("", "left")),
    ],
)
def test_an_occurrence_that_can_be_is_taken(occurrence):
    assert not first_problem(*occurrence)


def test_states_that_exclude_each_other_are_told_at_the_later_one():
    events = [Occurrence("up", 5, 9), Occurrence("seated", 0, 6), Occurrence("up", 0, 6, "child")]
    problems = list(problems_of(ETHOGRAM, events, (0, 10)))
    assert [problem.place for problem in problems] == [0]
    assert "up at 0.005 s begins while seated still lasts" in problems[0].sentence.text


def test_the_same_state_may_last_twice_with_other_modifiers_only():
    same = [Occurrence("fidgets", 0, 6, "", ("pen",)), Occurrence("fidgets", 5, 9, "", ("pen", ""))]
    other = [Occurrence("fidgets", 0, 6, "", ("pen",)), Occurrence("fidgets", 5, 9)]
    assert [problem.place for problem in problems_of(ETHOGRAM, same, (0, 10))] == [1]
    assert list(problems_of(ETHOGRAM, other, (0, 10))) == []


def test_states_may_touch_and_other_behaviours_may_last_meanwhile():
    found = coding(("seated", 0, 6), ("up", 6, 9), ("fidgets", 2, 8), ("nods", 3, 3))
    assert [one.behaviour for one in found.occurrences] == ["seated", "fidgets", "nods", "up"]
    assert list(problems_of(ETHOGRAM, found.occurrences, (0, 60_000))) == []


def test_a_coding_that_cannot_be_is_never_built():
    with pytest.raises(ValueError, match="ends before"):
        Coding("x", ETHOGRAM, 5, 0)
    with pytest.raises(ValueError, match="not in the ethogram"):
        coding(("dances", 0, 1))
    with pytest.raises(ValueError, match="section game overlaps"):
        coding(sections=(Section("game", 0, 9), Section("game", 8, 12)))


@pytest.mark.parametrize(
    ("behaviours", "subjects", "words"),
    [
        ((Behaviour("a"), Behaviour("a")), (), "no name of its own"),
        ((Behaviour(""),), (), "no name of its own"),
        ((Behaviour("a"),), (Subject("x"), Subject("x")), "subject"),
        ((Behaviour("a", excludes=("b",)),), (), "unknown"),
        ((Behaviour("a", excludes=("a",)),), (), "excludes itself"),
    ],
)
def test_an_ethogram_without_clear_names_is_never_built(behaviours, subjects, words):
    with pytest.raises(ValueError, match=words):
        Ethogram("e", behaviours, subjects)


def test_behaviours_are_found_by_name():
    assert ETHOGRAM.behaviour("nods").kind == "point"
    assert ETHOGRAM.behaviour("dances") is None
    assert ETHOGRAM.exclusions == {("seated", "up"), ("up", "seated")}
    assert Modifier("m", ("a",)).allows("a")
    assert coding(("nods", 1, 1)).subjects == ("", "child", "peer")
    assert coding(("nods", 1, 1, "child")).subjects == ("child", "peer")


def test_counts_and_durations_are_those_of_a_session_done_by_hand():
    found = coding(("seated", 10, 20), ("seated", 30, 45), ("nods", 12, 12), ("fidgets", 50, 50))
    seated, _up, fidgets, nods = budgets(found)[:4]
    assert (seated.count, seated.total_ms, seated.share) == (2, 25_000, 25 / 60)
    assert (seated.per_minute, seated.mean_ms, seated.latency_ms) == (2.0, 12_500, 10_000)
    assert (nods.count, nods.total_ms, nods.share, nods.mean_ms) == (1, 0, None, None)
    assert (fidgets.count, fidgets.total_ms, fidgets.mean_ms) == (1, 0, 0.0)


def test_time_without_length_has_no_rate():
    (one, *_), empty = budgets(coding(end_ms=0)), coding(end_ms=0)
    assert (one.per_minute, one.share, one.latency_ms) == (None, None, None)
    assert len(time_bins(empty, 1000)) == 1


@settings(max_examples=30)
@given(codings(), st.integers(700, 40_000))
def test_bins_add_up_to_the_session(found, length_ms):
    bins = time_bins(found, length_ms)
    assert sum(one.end_ms - one.begin_ms for one in bins) == found.duration_ms
    for place, whole in enumerate(budgets(found)):
        parts = [one.budgets[place] for one in bins]
        assert sum(part.total_ms for part in parts) == whole.total_ms
        assert sum(part.count for part in parts) == whole.count
        assert sum(part.observed_ms for part in parts) == whole.observed_ms


@settings(max_examples=30)
@given(codings())
def test_conditions_add_up_to_the_session(found):
    parts = conditions(found)
    if not found.sections:
        assert parts == ()
        return
    assert sum(part.observed_ms for part in parts) == found.duration_ms
    for place, whole in enumerate(budgets(found)):
        assert sum(part.budgets[place].total_ms for part in parts) == whole.total_ms
        assert sum(part.budgets[place].count for part in parts) == whole.count


@settings(max_examples=30)
@given(codings())
def test_states_that_exclude_each_other_last_no_longer_than_the_session(found):
    for subject in found.subjects:
        lasting = [
            one.total_ms
            for one in budgets(found)
            if one.subject == subject and one.behaviour in ("seated", "up")
        ]
        assert sum(lasting) <= found.duration_ms


def test_conditions_hold_what_was_in_their_sections():
    found = coding(
        ("seated", 5, 25), sections=(Section("game", 0, 10_000), Section("game", 20_000, 30_000))
    )
    game, rest = conditions(found)
    assert (game.name, game.observed_ms, game.budgets[0].total_ms) == ("game", 20_000, 10_000)
    assert (rest.name, rest.observed_ms, rest.budgets[0].total_ms) == ("", 40_000, 10_000)
    assert game.budgets[0].count == 1
    assert rest.budgets[0].count == 0


@settings(max_examples=30)
@given(codings())
def test_every_beginning_but_the_last_is_followed_by_one(found):
    for table in transitions(found):
        begun = sum(one.subject == table.subject for one in found.occurrences)
        assert sum(map(sum, table.counts)) == max(begun - 1, 0)


def test_transitions_are_those_of_a_session_done_by_hand():
    found = coding(("seated", 0, 5), ("up", 5, 9), ("seated", 9, 12), ("nods", 10, 10))
    table = transitions(found)[0]
    assert table.counts[0] == (0, 1, 0, 1)
    assert table.counts[1] == (1, 0, 0, 0)
    assert table.share(0, 1) == 0.5
    assert table.share(2, 0) is None


spans = st.lists(
    st.tuples(st.integers(0, 50), st.integers(0, 50)).map(sorted).map(tuple), max_size=6
)


@given(spans, spans)
def test_spans_are_those_of_single_milliseconds(some, others):
    within = set(range(50))

    def moments(parts):
        return {at for begin, end in parts for at in range(begin, end)}

    assert moments(gaps(some, (0, 50))) == within - moments(some)
    assert shared_ms(merged(some), merged(others)) == len(moments(some) & moments(others))


def test_bins_that_do_not_last_are_refused():
    with pytest.raises(ValueError, match="must last"):
        bin_spans(0, 10, 0)


@settings(max_examples=30)
@given(codings(), st.integers(1, 5).map(lambda n: 2000 * n))
def test_samples_are_those_of_single_moments(found, interval_ms):
    """Against the definition, interval by interval and millisecond by millisecond (ends only)."""
    for sampling in SAMPLINGS:
        for one in samples(found, sampling, interval_ms):
            seen = found.of(one.behaviour, one.subject)
            states = merged((s.begin_ms, s.end_ms) for s in seen if s.end_ms > s.begin_ms)
            for number, score in enumerate(one.scores):
                begin = number * interval_ms
                end = min(begin + interval_ms, found.end_ms)
                shared = shared_ms(states, [(begin, end)])
                starts = [s.begin_ms for s in seen]
                last = end == found.end_ms
                expected = {
                    "partial": shared > 0
                    or any(begin <= at < end or (last and at == end) for at in starts),
                    "whole": shared == end - begin,
                    "momentary": any(a < end <= b for a, b in states),
                }[sampling]
                assert score == expected, (sampling, one.behaviour, number)


def test_partial_intervals_say_too_much_and_whole_ones_too_little():
    found = coding(("seated", 5, 15), ("seated", 32, 38))
    shares = {name: samples(found, name, 10_000)[0].share for name in SAMPLINGS}
    true_share = samples(found, "partial", 10_000)[0].true_share
    assert shares["whole"] == 0.0 < true_share < shares["partial"] == 0.5
    assert shares["momentary"] == pytest.approx(1 / 6)


def test_an_ethogram_is_the_same_after_a_file(tmp_path):
    write_ethogram(tmp_path / "e.json", ETHOGRAM)
    assert read_ethogram(tmp_path / "e.json") == ETHOGRAM


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_example_names_its_sources_and_has_no_score_in_every_language(language):
    english = shipped_ethogram()
    with speaking(language):
        shipped = shipped_ethogram()
    assert len(shipped.sources) == len(english.sources)
    assert all(one.sources and one.description for one in shipped.behaviours)
    assert len({one.key for one in shipped.behaviours}) == len(english.behaviours)
    order = [one.name for one in shipped.behaviours]
    in_english = [one.name for one in english.behaviours]
    places = {tuple(order.index(name) for name in pair) for pair in shipped.exclusions}
    assert places == {tuple(in_english.index(name) for name in pair) for pair in english.exclusions}
    same = ("kind", "color")
    assert [[getattr(one, name) for name in same] for one in shipped.behaviours] == [
        [getattr(one, name) for name in same] for one in english.behaviours
    ]
    assert (order == in_english) == (language == "en")
    assert "score" not in json.dumps(ethogram_document(shipped)["behaviours"])


def broken(tmp_path, change):
    document = ethogram_document(ETHOGRAM)
    change(document)
    path = tmp_path / "broken.json"
    path.write_text(json.dumps(document, indent=0), "utf-8")
    with pytest.raises(AdibasError) as caught:
        read_ethogram(path)
    return str(caught.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda d: d["behaviours"][0].update(kind="mood"), "mood is not known here"),
        (lambda d: d["behaviours"][2].update(name="nods"), "stands twice"),
        (lambda d: d["behaviours"][1].update(excludes=["sky"]), "cannot exclude sky"),
        (lambda d: d["behaviours"][1].update(score=3), "score is not known here"),
        (lambda d: d.update(format="other"), "no ethogram of this version"),
        (lambda d: d.update(exclusive_groups=[["up", "sky"]]), "sky, which is no behaviour"),
        (lambda d: d["behaviours"][2]["modifiers"][0].update(values=["a,b"]), "no comma"),
        (lambda d: d["behaviours"][0].pop("name"), "name is missing"),
    ],
)
def test_a_mistake_in_an_ethogram_is_told_with_its_line(tmp_path, change, words):
    told = broken(tmp_path, change)
    assert words in told
    assert "broken.json, line " in told


def test_a_missing_ethogram_is_told(tmp_path):
    with pytest.raises(BehaviourError, match="cannot be read"):
        read_ethogram(tmp_path / "none.json")
