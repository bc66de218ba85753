"""Protocol files: what is shipped is whole, and every mistake is told with its line."""

import json
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.data.protocols import (
    CONVENTION,
    KINDS,
    Landmark,
    MeasureDefinition,
    ReferenceValue,
    Wording,
    same_label,
)
from adibas.data.views import VIEWS
from adibas.errors import ProtocolError
from adibas.measures import protocol_store
from adibas.measures.json_lines import DEEPEST, LARGEST_FILE, parse_lines
from adibas.measures.protocol_file import check_protocol, load_protocol, read_protocol
from adibas.measures.protocol_store import find_protocol, protocol_files
from adibas.texts import LANGUAGES, speaking

SHIPPED = ("joints-15", "sapo-1", "trunk-symmetry", "upper-quadrant")


def small():
    """A protocol of two landmarks, their middle, and one measure."""
    return {
        "format": "adibas-protocol",
        "version": 1,
        "id": "small",
        "revision": "1",
        "title": "Small",
        "source": "made up",
        "landmarks": [
            {"id": "left_a", "name": {"en": "A, left", "ca": "A, esquerra"}, "views": ["anterior"]},
            {"id": "right_a", "name": "A, right", "views": ["anterior", "posterior"]},
        ],
        "derived": [{"id": "mid", "name": "Middle", "of": {"left_a": 0.5, "right_a": 0.5}}],
        "measures": [
            {
                "id": "M",
                "name": "Level",
                "views": ["anterior"],
                "kind": "line_to_horizontal",
                "points": ["right_a", "mid"],
                "unit": "deg",
                "axis": "left",
                "positive": "left higher",
                "references": [
                    {"kind": "population", "mean": 1, "sd": 2, "who": "ten", "source": "a paper"}
                ],
            }
        ],
    }


def mistakes(document):
    """Return what is said of a document, a member a line."""
    checked = read_protocol(json.dumps(document, indent=1), "my.json")
    assert (checked.protocol is None) == bool(checked.errors)
    for error in checked.errors:
        assert str(error).startswith("my.json, line ")
    return [str(error) for error in checked.errors]


def test_the_small_protocol_is_right():
    checked = read_protocol(json.dumps(small()), "my.json")
    protocol = checked.protocol
    assert checked.errors == ()
    assert protocol.views == ("anterior",)
    assert protocol.measures_of("posterior") == ()
    assert protocol.marked_for(("right_a", "mid")) == ("right_a", "left_a")
    assert [one.landmark_id for one in protocol.unmarked("anterior", ())] == ["left_a", "right_a"]
    assert protocol.unmarked("anterior", ("A, Right", "left a", "m01")) == ()
    assert [one.landmark_id for one in protocol.unmarked("posterior", ())] == ["right_a"]
    assert protocol.marks("anterior", "A, Right")
    assert not protocol.marks("posterior", "left a")
    assert not protocol.marks("anterior", "m01")
    assert protocol.shares_of(("right_a", "mid")) == {"right_a": (1.0, 0.5), "left_a": (0.0, 0.5)}


def test_the_line_of_a_mistake_is_that_of_the_value():
    document = small()
    document["measures"][0]["points"][0] = "right_b"
    text = json.dumps(document, indent=1)
    line = next(n for n, one in enumerate(text.split("\n"), 1) if "right_b" in one)
    (error,) = read_protocol(text, "my.json").errors
    assert error.fields["line"] == line
    assert str(error) == (
        f"my.json, line {line}: the landmark right_b is not known. Add it to landmarks, or "
        "correct the name."
    )


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda d: d.pop("title"), "title is missing"),
        (lambda d: d.update(title=3), "here must stand a text"),
        (lambda d: d.update(title={"english": "x"}), "english is no language"),
        (lambda d: d.update(title="x" * 2001), "longer than 2000"),
        (lambda d: d.update(format="other"), "no protocol of ADiBAS"),
        (lambda d: d.update(version=2), "later version"),
        (lambda d: d.update(version=True), "here must stand a number"),
        (lambda d: d.update(colour="red"), "colour is not known here"),
        (lambda d: d.update(id="a b"), "no name for a program"),
        (lambda d: d.update(landmarks={}), "here must stand a list"),
        (lambda d: d.update(measures=[]), "nothing is measured"),
        (lambda d: d.update(measures=[7]), "here must stand a group of values"),
        (lambda d: d.update(every_pair="yes"), "either true or false"),
        (lambda d: d["landmarks"][0].pop("views"), "views is missing"),
        (lambda d: d["landmarks"][0].update(views=[]), "no view is named"),
        (lambda d: d["landmarks"][0].update(views=["front"]), "the view front is not known"),
        (lambda d: d["landmarks"][0].update(id="right_a"), "the id right_a stands twice"),
        (lambda d: d["landmarks"][0].update(aliases=["a  RIGHT", "A, right"]), "share the label"),
        (lambda d: d["derived"][0].update(id="left_a"), "the id left_a stands twice"),
        (lambda d: d["derived"][0].pop("of"), "of is missing"),
        (lambda d: d["derived"][0].update(of={"left_a": 0.5, "right_a": 0.6}), "sum to 1.1"),
        (lambda d: d["derived"][0].update(of={"left_a": 0.4, "right_a": 0.6}), "have no source"),
        (lambda d: d["derived"][0].update(of={"left_a": 0.5, "who": 0.5}), "who is not known"),
        (lambda d: d["derived"][0].update(of={"left_a": "half"}), "here must stand a number"),
        (lambda d: d["measures"].append(d["measures"][0]), "the id M stands twice"),
        (lambda d: d["measures"][0].update(kind="guess"), "guess is no kind of measure"),
        (lambda d: d["measures"][0].pop("kind"), "kind is missing"),
        (lambda d: d["measures"][0].update(unit="mm"), "mm is no unit of line_to_horizontal"),
        (lambda d: d["measures"][0].update(axis="anterior"), "anterior is no direction"),
        (lambda d: d["measures"][0].pop("axis"), "axis is missing"),
        (lambda d: d["measures"][0].update(axis=["left"]), "here must stand a text"),
        (lambda d: d["measures"][0].update(axis={"left": 1}), "here must stand a text"),
        (lambda d: d["measures"][0].update(unit=["deg"]), "here must stand a text"),
        (lambda d: d["measures"][0].pop("positive"), "positive is missing"),
        (lambda d: d["measures"][0].update(points=["mid"]), "takes 2 points, and here are 1"),
        (lambda d: d["measures"][0].update(points=["mid", "mid"]), "a line from mid to itself"),
        (lambda d: d["measures"][0].update(points=["mid", 5]), "here must stand a text"),
        (lambda d: d["measures"][0].pop("points"), "points is missing"),
        (lambda d: d["measures"][0].update(views=["posterior"]), "mid is no landmark of the view"),
        (lambda d: d["measures"][0].update(kind="distance", unit="mm"), "distance has no axis"),
        (lambda d: d["measures"][0]["references"][0].pop("source"), "has no source"),
        (lambda d: d["measures"][0]["references"][0].pop("who"), "who is missing"),
        (lambda d: d["measures"][0]["references"][0].update(sd=-2), "cannot be negative"),
        (lambda d: d["measures"][0]["references"][0].update(kind="normal"), "no kind of reference"),
        (lambda d: d.update(landmarks=[{}] * 2001), "more than 2000 of landmarks"),
    ],
)
def test_every_mistake_is_told(change, told):
    document = small()
    change(document)
    assert any(told in one for one in mistakes(document)), mistakes(document)


def test_derived_landmarks_in_a_circle_are_told():
    document = small()
    document["derived"] += [
        {"id": "p", "name": "P", "of": {"q": 1}},
        {"id": "q", "name": "Q", "of": {"p": 0.5, "mid": 0.5}},
    ]
    told = mistakes(document)
    assert len(told) == 2
    assert "p is computed from itself, through: q" in told[0]


def test_derived_landmarks_may_rest_on_derived_ones():
    document = small()
    document["derived"].insert(
        0, {"id": "quarter", "name": "Quarter", "of": {"mid": 0.5, "left_a": 0.5}}
    )
    protocol = read_protocol(json.dumps(document), "my.json").protocol
    assert protocol.shares_of(("quarter",)) == {"left_a": (0.75,), "right_a": (0.25,)}


def test_every_triplet_of_too_many_landmarks_is_refused():
    document = small() | {"every_triplet": True, "derived": [], "measures": []}
    document["landmarks"] = [
        {"id": f"p{n}", "name": f"P {n}", "views": ["anterior"]} for n in range(41)
    ]
    assert any("every triplet of more than 40" in one for one in mistakes(document))


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("{", 1),
        ("{\n'a': 1}", 2),
        ('{"a": 1\n "b": 2}', 2),
        ('{"a": [1,\n 2', 2),
        ('{"a": nope}', 1),
        ('{"a": 1e999}', 1),
        ('{"a": NaN}', 1),
        ('{"a": "\n"}', 1),
        ("{}\n\n x", 3),
        ('{"a": 1,\n "a": 2}', 2),
        ("[" * (DEEPEST + 1), 1),
        ('{"a": ' + "9" * 50 + "}", 1),
    ],
)
def test_what_is_no_json_is_told_with_its_line(text, line):
    with pytest.raises(ProtocolError) as caught:
        parse_lines(text, "my.json")
    assert caught.value.fields["line"] == line


def test_a_file_that_is_far_too_large_is_refused():
    with pytest.raises(ProtocolError, match="larger than any protocol"):
        parse_lines(" " * (LARGEST_FILE + 1), "my.json")


json_values = st.recursive(
    st.none() | st.booleans() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=20,
)


def plain(node):
    value = node.value
    if isinstance(value, dict):
        return {key: plain(part) for key, part in value.items()}
    return [plain(part) for part in value] if isinstance(value, list) else value


@given(json_values)
def test_any_json_is_read_as_python_reads_it(document):
    assert plain(parse_lines(json.dumps(document, indent=1), "x")) == document


@given(st.text(), st.integers(0, 1200), st.integers(0, 40))
def test_a_damaged_protocol_is_refused_in_words_or_is_whole(put, at, taken):
    text = json.dumps(small(), indent=1)
    checked = read_protocol(text[:at] + put + text[at + taken :], "my.json")
    assert (checked.protocol is None) == bool(checked.errors)


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_protocols_are_right_and_speak_every_language(name):
    protocol = find_protocol(name)
    assert protocol.protocol_id == name
    wordings = [protocol.title, *(one.name for one in (*protocol.landmarks, *protocol.derived))]
    for measure in protocol.measures:
        wordings += [measure.name, *([measure.positive] if measure.positive else [])]
        assert all(one.source for one in measure.references)
    assert {frozenset(one.by_language) for one in wordings} == {frozenset(LANGUAGES)}


def test_sapo_has_its_29_measures_and_its_landmarks():
    sapo = find_protocol("sapo-1")
    counts = {view: len(sapo.measures_of(view)) for view in VIEWS}
    # One more in three views: the centre of gravity.
    assert counts == {"anterior": 11, "posterior": 3, "right_lateral": 9, "left_lateral": 9}
    seen = {view: [one for one in sapo.landmarks if view in one.views] for view in VIEWS}
    assert {view: len(found) for view, found in seen.items()} == {
        "anterior": 27,
        "posterior": 41,
        "right_lateral": 31,
        "left_lateral": 31,
    }
    masses = {one.landmark_id: sum(one.weights.values()) for one in sapo.derived}
    assert masses == pytest.approx(dict.fromkeys(masses, 1.0))


def test_no_default_of_a_program_is_called_a_population():
    sapo = find_protocol("sapo-1")
    defaults = [
        reference
        for measure in sapo.measures
        for reference in measure.references
        if "SAPO" in reference.who
    ]
    assert {one.kind for one in defaults} == {CONVENTION}
    assert all("no normal value" in one.note for one in defaults)


def test_protocols_are_found_by_name_and_by_file(tmp_path, monkeypatch):
    monkeypatch.setattr(protocol_store, "own_folder", lambda: tmp_path)
    (tmp_path / "small.json").write_text(json.dumps(small()), encoding="utf-8")
    (tmp_path / "sapo-1.json").write_text("{}", encoding="utf-8")
    assert set(protocol_files()) == {"small", *SHIPPED}
    assert find_protocol("small").title.text == "Small"
    assert len(find_protocol("sapo-1").measures) == 32
    assert find_protocol(str(tmp_path / "small.json")).protocol_id == "small"
    with pytest.raises(ProtocolError, match=r"No protocol is named none. Known are: joints-15"):
        find_protocol("none")
    with pytest.raises(ProtocolError, match="is missing"):
        load_protocol(tmp_path / "sapo-1.json")


def test_a_file_is_read_once_until_it_changes(tmp_path):
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(small()), encoding="utf-8")
    first = load_protocol(path)
    assert load_protocol(path) is first
    path.write_text(json.dumps(small() | {"title": "Another"}), encoding="utf-8")
    os.utime(path, ns=(0, path.stat().st_mtime_ns + 1))
    assert load_protocol(path).title.text == "Another"


def test_every_pair_and_triplet_are_measured_where_all_are_seen():
    document = small() | {"every_pair": True, "every_triplet": True, "derived": [], "measures": []}
    document["landmarks"].append({"id": "c", "name": "C", "views": ["posterior"]})
    protocol = read_protocol(json.dumps(document), "my.json").protocol
    ids = {one.measure_id: one.views for one in protocol.measures}
    assert ids["D.left_a.right_a"] == ("anterior",)
    assert ids["D.right_a.c"] == ("posterior",)
    assert ids["A.right_a.left_a.c"] == ()
    assert len(ids) == 6


def test_files_that_cannot_be_read_are_told(tmp_path):
    assert "cannot be read" in str(check_protocol(tmp_path / "gone.json").errors[0])
    (tmp_path / "latin.json").write_bytes(b'{\n"id": "\xe9"}')
    assert "line 2: this is no text in UTF-8" in str(
        check_protocol(tmp_path / "latin.json").errors[0]
    )


def test_wordings_speak_the_language_in_use_else_english_else_any():
    both = Wording({"en": "knee", "ca": "genoll"})
    with speaking("ca"):
        assert both.text == "genoll"
    with speaking("es"):
        assert both.text == "knee"
        assert Wording({"ca": "genoll"}).text == "genoll"
    with pytest.raises(ValueError, match="words"):
        Wording({"en": ""})


def test_labels_are_compared_without_case_and_underscores():
    assert same_label(" Left_Acromion ") == same_label("left  acromion") == "left acromion"
    landmark = Landmark("left_a", Wording({"en": "A, left"}), ("anterior",), ("Ala",))
    assert landmark.labels == {"left a", "a, left", "ala"}


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"points": ("a",)}, "takes 2 points"),
        ({"unit": "mm"}, "no length"),
        ({"axis": ""}, "needs axis"),
        ({"kind": "distance", "unit": "mm"}, "has no axis"),
        ({"axis": "anterior"}, "not seen"),
    ],
)
def test_definitions_that_do_not_fit_are_bugs(change, told):
    right = {"kind": "line_to_horizontal", "points": ("a", "b"), "unit": "deg", "axis": "left"}
    name, views = Wording({"en": "x"}), ("anterior",)
    assert MeasureDefinition("X", name, views, **right).per_unit == pytest.approx(0.0174533)
    with pytest.raises(ValueError, match=told):
        MeasureDefinition("X", name, views, **(right | change))


def test_no_reference_stands_without_source_or_people():
    with pytest.raises(ValueError, match="source"):
        ReferenceValue(CONVENTION, 1.0, None, "people", " ")
    with pytest.raises(ValueError, match="whom"):
        ReferenceValue(CONVENTION, 1.0, None, "", "a paper")
    with pytest.raises(ValueError, match="kind"):
        ReferenceValue("normal", 1.0, None, "people", "a paper")


def test_every_kind_is_measured_in_some_unit():
    assert {rule.quantity for rule in KINDS.values()} == {"angle", "length", "share"}
