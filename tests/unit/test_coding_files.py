"""Codings in the files of other programs: the same after a round trip, and mistakes told."""

import csv
import dataclasses
import io
import json
import xml.etree.ElementTree as ET
import zipfile
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from openpyxl import load_workbook

from adibas.data.coding import Coding, Occurrence, Section
from adibas.data.ethogram import Behaviour, Modifier, Subject
from adibas.errors import AdibasError, BehaviourError
from adibas.recordings.boris_project import read_boris
from adibas.recordings.boris_tables import write_boris_table
from adibas.recordings.boris_writing import project_document, write_boris
from adibas.recordings.coding_csv import read_coding_csv, write_coding_csv
from adibas.recordings.coding_times import milliseconds, seconds_text
from adibas.recordings.codings import CODING_KINDS, read_codings
from adibas.recordings.elan import read_elan
from adibas.recordings.elan_writing import write_elan
from adibas.recordings.ethogram_json import read_ethogram, write_ethogram
from adibas.reports.coding_excel import write_coding_excel
from adibas.reports.coding_report import write_coding_report
from tests.unit.coding_samples import ETHOGRAM, coding, codings

few = settings(
    max_examples=15,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)

WRITERS = {
    "c.boris": write_boris,
    "c.csv": write_coding_csv,
    "c.xlsx": lambda path, some: write_coding_excel(path, some, "en"),
}


@few
@given(codings())
@pytest.mark.parametrize("name", WRITERS)
def test_a_coding_is_the_same_after_a_file(tmp_path, name, one):
    WRITERS[name](tmp_path / name, [one])
    assert read_codings(tmp_path / name) == (one,)


@few
@given(codings())
def test_a_coding_is_the_same_after_elan(tmp_path, one):
    write_elan(tmp_path / "c.eaf", one)
    assert read_codings(tmp_path / "c.eaf") == (one,)


ODD = "a\rb\x0bc"


def odd_coding():
    """A coding with a carriage return and a vertical tab wherever somebody types."""
    nods = Occurrence("nods" + ODD, 3000, 3000, "child" + ODD, (), ODD)
    ethogram = dataclasses.replace(
        ETHOGRAM,
        behaviours=(Behaviour("nods" + ODD, "point"),),
        subjects=(Subject("child" + ODD),),
    )
    whole = Coding("session" + ODD, ethogram, 0, 60_000, (nods,), "AB" + ODD)
    return dataclasses.replace(whole, sections=(Section("game" + ODD, 0, 1000),), description=ODD)


@pytest.mark.parametrize("name", ["c.boris", "c.csv"])
def test_a_carriage_return_stays_where_it_was_typed(tmp_path, name):
    WRITERS[name](tmp_path / name, [odd_coding()])
    assert read_codings(tmp_path / name) == (odd_coding(),)


HALF = "\ud800"
"""Half a character, as a file of JSON escapes one; no UTF-8 holds it."""


def half_coding():
    """A coding with half a character wherever somebody types."""
    ethogram = dataclasses.replace(
        ETHOGRAM,
        name="table" + HALF,
        behaviours=(Behaviour("nods" + HALF, "point", "d" + HALF, "", "c" + HALF),),
        subjects=(Subject("child" + HALF),),
    )
    nods = Occurrence("nods" + HALF, 3000, 3000, "child" + HALF, (), "said" + HALF)
    whole = Coding("session" + HALF, ethogram, 0, 60_000, (nods,), "AB" + HALF)
    return dataclasses.replace(
        whole,
        sections=(Section("game" + HALF, 0, 1000),),
        media=("film" + HALF,),
        variables=(("room" + HALF, "b" + HALF),),
    )


def boxed(one):
    """Return what a dataclass holds, with a box in place of each half of a character."""
    return json.loads(json.dumps(dataclasses.asdict(one)).replace("\\ud800", "\\u25a1"))


@pytest.mark.parametrize("name", [*WRITERS, "c.eaf"])
def test_half_a_character_becomes_a_box_in_every_file(tmp_path, name):
    write = WRITERS.get(name, lambda path, some: write_elan(path, some[0]))
    write(tmp_path / name, [half_coding()])
    (read,) = read_codings(tmp_path / name)
    assert boxed(read) == boxed(half_coding())
    assert HALF not in str(read)


def test_a_workbook_with_a_bell_in_the_name_of_a_behaviour_opens_again(tmp_path):
    bell = Behaviour("nods\x07", "point", modifiers=(Modifier("with\x07", ("pen\x07",)),))
    ethogram = dataclasses.replace(ETHOGRAM, behaviours=(bell,))
    nods = Occurrence("nods\x07", 3000, 3000, "", ("pen\x07",))
    write_coding_excel(tmp_path / "c.xlsx", [Coding("s", ethogram, 0, 9000, (nods,))], "en")
    (read,) = read_codings(tmp_path / "c.xlsx")
    (event,) = read.occurrences
    assert (event.behaviour, event.modifiers) == ("nods\u25a1", ("pen\u25a1",))


@pytest.mark.parametrize(
    "write",
    [write_boris_table, lambda path, some: write_coding_report(some, 1000, path, "en")],
    ids=["boris", "totals"],
)
def test_half_a_character_becomes_a_box_in_what_is_counted(tmp_path, write):
    write(tmp_path / "c.csv", [half_coding()])
    assert "child\N{WHITE SQUARE}" in (tmp_path / "c.csv").read_text("utf-8")


def test_half_a_character_becomes_a_box_in_an_ethogram(tmp_path):
    write_ethogram(tmp_path / "e.json", half_coding().ethogram)
    assert boxed(read_ethogram(tmp_path / "e.json")) == boxed(half_coding().ethogram)


def test_a_carriage_return_stays_in_a_table_of_boris(tmp_path):
    write_boris_table(tmp_path / "c.tsv", [odd_coding()])
    (found,) = read_codings(tmp_path / "c.tsv", odd_coding().ethogram)
    assert found.occurrences == odd_coding().occurrences


def test_characters_that_no_xml_holds_become_a_box_in_elan(tmp_path):
    write_elan(tmp_path / "c.eaf", odd_coding())
    (found,) = read_codings(tmp_path / "c.eaf")
    (event,) = found.occurrences
    assert event.comment == "a\nb\N{WHITE SQUARE}c"
    assert (event.behaviour, event.subject) == ("nods" + ODD, "child" + ODD)


@few
@given(codings())
def test_events_are_the_same_after_a_table_of_boris(tmp_path, one):
    write_boris_table(tmp_path / "c.tsv", [one])
    found = read_codings(tmp_path / "c.tsv", ETHOGRAM)
    if not one.occurrences:
        assert found == ()
        return
    kept = dataclasses.replace(one, observer="", sections=(), media=(), variables=())
    stripped = dataclasses.replace(
        found[0], name=one.name, date=one.date, description=one.description
    )

    # A table has texts without the spaces around them.
    def bare(some):
        return [
            (o.behaviour, o.begin_ms, o.end_ms, o.subject, o.modifiers, o.comment, o.end_comment)
            for o in some.occurrences
        ]

    assert bare(stripped) == bare(kept)
    assert found[0].end_ms == one.end_ms


NAMED = (*WRITERS, "c.eaf")


def written(tmp_path, name, one):
    if name == "c.eaf":
        write_elan(tmp_path / name, one)
    else:
        WRITERS[name](tmp_path / name, [one])
    return tmp_path / name


def with_behaviours(**changes):
    """Return `ETHOGRAM` with some behaviours changed, or left out where it says None."""
    kept = [
        dataclasses.replace(one, excludes=(), **(changes.get(one.name) or {}))
        for one in ETHOGRAM.behaviours
        if changes.get(one.name, {}) is not None
    ]
    return dataclasses.replace(ETHOGRAM, name="other", behaviours=tuple(kept))


@pytest.mark.parametrize("name", NAMED)
def test_an_ethogram_that_is_given_takes_the_place_of_the_files_own(tmp_path, name):
    one = coding(("seated", 1, 2, "child"), ("nods", 3, 3))
    other = with_behaviours(up=None)
    (found,) = read_codings(written(tmp_path, name, one), other)
    assert found == dataclasses.replace(one, ethogram=other)


@pytest.mark.parametrize("name", NAMED)
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"seated": None}, "the behaviour seated is not in the ethogram"),
        ({"seated": {"kind": "point"}}, "seated at 1.000 s is a point event, but it lasts"),
        ({"nods": {"modifiers": ()}}, "nods at 3.000 s has the modifier 2"),
    ],
)
def test_an_event_that_does_not_fit_the_given_ethogram_is_told(tmp_path, name, changes, words):
    one = coding(("seated", 1, 2, "child"), ("nods", 3, 3, "", ("2",)))
    path = written(tmp_path, name, one)
    with pytest.raises(BehaviourError) as refused:
        read_codings(path, with_behaviours(**changes))
    assert words in str(refused.value)


def test_what_a_project_of_boris_knows_no_more_is_a_state_where_the_given_ethogram_says_so(
    tmp_path,
):
    one = coding(("seated", 1, 2, "child"))
    document = project_document([one])
    confs = document["behaviors_conf"].values()
    lacking = {str(at): conf for at, conf in enumerate(confs) if conf["code"] != "seated"}
    path = boris_file(tmp_path, **{**document, "behaviors_conf": lacking})
    assert read_codings(path, ETHOGRAM) == (one,)


def test_several_sessions_share_one_file(tmp_path):
    one = coding(("seated", 1, 2), ("nods", 3, 3))
    two = dataclasses.replace(one, name="=session 2", description="-3", observer="'x")
    for name, write in WRITERS.items():
        write(tmp_path / name, [one, two])
        assert read_codings(tmp_path / name) == (one, two)


def test_no_cell_is_a_formula(tmp_path):
    one = dataclasses.replace(coding(("nods", 3, 3)), name='=HYPERLINK("x")', description="@SUM")
    write_coding_csv(tmp_path / "c.csv", [one])
    cells = [
        cell for row in csv.reader(io.StringIO((tmp_path / "c.csv").read_text())) for cell in row
    ]
    assert not [cell for cell in cells if cell.startswith(("=", "+", "-", "@"))]
    write_coding_excel(tmp_path / "c.xlsx", [one], "en")
    book = load_workbook(tmp_path / "c.xlsx")
    types = {cell.data_type for sheet in book for row in sheet.iter_rows() for cell in row}
    assert "f" not in types
    book.close()


def test_sessions_of_two_schemes_or_one_name_do_not_fit_in_one_file(tmp_path):
    one = coding(("nods", 3, 3))
    other = Coding("other", dataclasses.replace(ETHOGRAM, name="else"), 0, 1)
    for some in ([one, other], [one, one], []):
        with pytest.raises(BehaviourError):
            write_boris(tmp_path / "c.boris", some)
    assert list(tmp_path.iterdir()) == []


# A project as BORIS 7 wrote it, by hand after its format: two observations, one subject, a state
# and a point event with a set of modifiers, in the order and the shapes of the program.
BORIS = {
    "time_format": "hh:mm:ss",
    "project_name": "test",
    "project_date": "2016-11-27T01:55:22",
    "subjects_conf": {"0": {"key": "1", "name": "subject1", "description": "first"}},
    "behavioral_categories": [],
    "coding_map": {},
    "behaviors_conf": {
        "0": {
            "type": "State event", "key": "s", "code": "s", "description": "", "category": "",
            "modifiers": {"0": {"name": "m", "type": 0, "values": ["m1 (a)", "m2", "m3"]}},
            "excluded": "", "coding map": "",
        },
        "1": {"type": "Point event", "key": "p", "code": "p", "modifiers": "", "excluded": "s"},
    },
    "independent_variables": {},
    "observations": {
        "media": {
            "file": {"1": ["a.mp4", "b.mp4"], "2": []}, "type": "MEDIA",
            "date": "2016-11-27T01:57:26", "description": "d", "time offset": 0.0,
            "events": [
                [3.3, "subject1", "s", "m1", "go"], [5.0, "", "p", "", ""],
                [7.75, "subject1", "s", "m1", "stop"], [9.9, "", "s", "None", ""],
                [16.2, "", "s", "None", "", 405],
            ],
            "independent_variables": {"age": "7"},
            "media_info": {"length": {"a.mp4": 359.96, "b.mp4": 179.96}, "fps": {"a.mp4": 25.0}},
        },
        "live": {"file": [], "type": "LIVE", "date": "", "description": "", "time offset": 0.0,
                 "events": [[1.75, "", "p", "", ""]], "scan_sampling_time": 0},
    },
}  # fmt: skip


def boris_file(tmp_path, **changes):
    path = tmp_path / "p.boris"
    path.write_text(json.dumps({**BORIS, **changes}), "utf-8")
    return path


def test_a_project_of_boris_is_read(tmp_path):
    media, live = read_boris(boris_file(tmp_path))
    assert (media.begin_ms, media.end_ms) == (0, 539_920)
    assert media.occurrences == (
        Occurrence("s", 3300, 7750, "subject1", ("m1",), "go", "stop"),
        Occurrence("p", 5000, 5000),
        Occurrence("s", 9900, 16_200),
    )
    assert media.variables == (("age", "7"),)
    assert media.media == ("a.mp4", "b.mp4")
    assert media.ethogram.behaviours[0].modifiers[0].values == ("m1", "m2", "m3")
    assert live.occurrences == (Occurrence("p", 1750, 1750),)
    assert live.end_ms == 1750


def test_a_project_of_boris_says_the_same_after_us(tmp_path):
    """By an independent look at the JSON: every event as BORIS wrote it, but for frame numbers."""
    document = project_document(read_boris(boris_file(tmp_path)))
    events = document["observations"]["media"]["events"]
    wanted = [event[:5] for event in BORIS["observations"]["media"]["events"]]
    assert sorted(map(str, events)) == sorted(map(str, wanted))
    assert document["behaviors_conf"]["1"]["excluded"] == "s"
    assert document["subjects_conf"]["0"]["name"] == "subject1"
    json.dumps(document, allow_nan=False)


def test_an_unpaired_state_of_boris_is_told(tmp_path):
    live = {
        **BORIS["observations"]["live"],
        "events": [[2.0, "", "p", "", ""], [2.718, "", "s", "", ""]],
    }
    with pytest.raises(BehaviourError, match=r"observation live, event 2: s begins at 2.718 s"):
        read_boris(boris_file(tmp_path, observations={"live": live}))


@pytest.mark.parametrize(
    "changes",
    [
        {"observations": {"x": {}}},
        {"observations": {"x": {"events": [[1]]}}},
        {"observations": {"x": {"events": [["soon", "", "p", "", ""]]}}},
        {"observations": {"x": {"events": [[float("inf"), "", "p", "", ""]]}}},
        {"observations": {"x": {"events": [[1.0, "", "dance", "", ""]]}}},
        {"observations": {"x": {"events": [[1.0, "cat", "p", "", ""]]}}},
        {"observations": 3},
        {"behaviors_conf": {"a": 1}},
        {"behaviors_conf": {"0": {"code": "", "type": "Point event"}}},
        {"subjects_conf": [1]},
    ],
)
def test_a_broken_project_is_told(tmp_path, changes):
    with pytest.raises(BehaviourError):
        read_boris(boris_file(tmp_path, **changes))


TABLE_7 = """Observation id\tlunch\t\t\t\t\t\t\t
\t\t\t\t\t\t\t\t
Media file(s)\t\t\t\t\t\t\t\t
Time\tMedia file path\tTotal length\tFPS\tSubject\tBehavior\tModifiers\tComment\tStatus
1.5\ta.mp4\t60.0\t25\tchild\tseated\t\tsits\tSTART
2.0\ta.mp4\t60.0\t25\tchild\tnods\t2\t\tPOINT
4.25\ta.mp4\t60.0\t25\tchild\tseated\t\tends\tSTOP
"""
TABLE_9 = """Observation id,Observation date,Observation duration,Subject,Behavior,\
Behavioral category,Modifier #1,Modifier #2,Behavior type,Time,Comment
lunch,2026-11-21,60.0,No focal subject,fidgets,,pen,left,START,1.5,
lunch,2026-11-21,60.0,No focal subject,fidgets,,pen,left,STOP,2.5,
"""


def test_tables_of_boris_are_read(tmp_path):
    path = tmp_path / "t.tsv"
    path.write_text(TABLE_7)
    (found,) = read_coding_csv(path, ETHOGRAM)
    assert (found.name, found.end_ms) == ("lunch", 60_000)
    assert found.occurrences == (
        Occurrence("seated", 1500, 4250, "child", (), "sits", "ends"),
        Occurrence("nods", 2000, 2000, "child", ("2",)),
    )
    path = tmp_path / "t.csv"
    path.write_text(TABLE_9)
    (found,) = read_coding_csv(path, ETHOGRAM)
    assert found.occurrences == (Occurrence("fidgets", 1500, 2500, "", ("pen", "left")),)


def test_a_table_without_a_scheme_knows_the_modifiers_that_occur(tmp_path):
    one = coding(
        ("fidgets", 1, 2, "child", ("pen,hair", "left")),
        ("fidgets", 3, 4, "child", ("", "left")),
        ("fidgets", 5, 6, "child"),
        ("nods", 7, 7, "child", ("2",)),
        ("seated", 8, 9, "child"),
    )
    write_boris_table(tmp_path / "c.tsv", [one])
    (found,) = read_codings(tmp_path / "c.tsv")
    assert [event.modifiers for event in found.occurrences] == [
        event.modifiers for event in one.occurrences
    ]
    fidgets, nods, seated = found.ethogram.behaviours
    assert [(m.values, m.selection) for m in fidgets.modifiers] == [
        (("hair", "pen"), "several"),
        (("left",), "one"),
    ]
    assert [m.values for m in nods.modifiers] == [("2",)]
    assert seated.modifiers == ()


def test_half_a_state_in_a_table_is_told_with_its_line(tmp_path):
    path = tmp_path / "t.tsv"
    path.write_text("\n".join(TABLE_7.splitlines()[:-1]))
    with pytest.raises(BehaviourError, match=r"line 5: seated at 1.5 s is only half of a state"):
        read_coding_csv(path)
    lines = TABLE_7.splitlines()
    path.write_text("\n".join([*lines[:5], lines[4].replace("1.5", "1.75"), *lines[5:]]))
    with pytest.raises(BehaviourError, match=r"line 5: seated at 1.5 s is only half of a state"):
        read_coding_csv(path)
    path.write_text(TABLE_7 + TABLE_7.splitlines()[-1])
    with pytest.raises(BehaviourError, match=r"line 8: seated at 4.25 s is only half"):
        read_coding_csv(path)


EVENTS = "recording,label,begin_s,end_s,kind\nlunch,wave,1,2.5,state\nlunch,nod,3,3,point\n"


def test_events_of_gestures_are_a_coding(tmp_path):
    path = tmp_path / "events.csv"
    path.write_text(EVENTS)
    (found,) = read_codings(path)
    assert found.occurrences == (Occurrence("wave", 1000, 2500), Occurrence("nod", 3000, 3000))
    assert (found.begin_ms, found.end_ms) == (0, 3000)


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("lunch,wave,2,1,state", "line 4: wave at 2.000 s ends before"),
        ("lunch,wave,x,1,state", "line 4 is no event"),
        (",wave,1,1,state", "line 4 is no event"),
        ("lunch,wave,1,2,mood", "line 4 is no event"),
        ("lunch,wave,2,9,state", "line 4: wave at 2.000 s begins while wave"),
        ("lunch,nod,2,9,point", "line 4: nod at 2.000 s is a point event"),
        ("lunch,task,9,2,section", "the session ends before"),
        ("lunch,,9,2,session", "outside the session"),
        ("lunch,wave,nan,2,state", "line 4 is no event"),
        ("lunch,wave,1,1e308,state", "line 4 is no event"),
    ],
)
def test_a_wrong_row_is_told_with_its_line(tmp_path, row, words):
    path = tmp_path / "events.csv"
    path.write_text(f"{EVENTS}{row}\n")
    with pytest.raises(BehaviourError) as caught:
        read_codings(path)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    "details", ["[]", "3", '{"media": 3}', '{"variables": [1]}', '{"variables": 1}', "[" * 100_000]
)
def test_wrong_details_of_a_session_are_told_with_their_line(tmp_path, details):
    path = tmp_path / "events.csv"
    cell = details.replace('"', '""')
    path.write_text(f'recording,label,begin_s,end_s,kind,details\nlunch,,0,9,session,"{cell}"\n')
    with pytest.raises(BehaviourError, match="line 2 is no event"):
        read_codings(path)


def test_a_file_of_elan_follows_its_schema(tmp_path):
    """Independently of our reader: order of parts, references, no overlap within a tier."""
    one = coding(
        ("fidgets", 0, 4, "child", ("pen",)),
        ("fidgets", 2, 5, "child"),
        ("nods", 3, 3),
        sections=(Section("game", 0, 9000),),
    )
    write_elan(tmp_path / "c.eaf", one)
    root = ET.parse(tmp_path / "c.eaf").getroot()
    order = [part.tag for part in root]
    allowed = ["LICENSE", "HEADER", "TIME_ORDER", "TIER", "LINGUISTIC_TYPE", "LOCALE", "LANGUAGE",
               "CONSTRAINT"]  # fmt: skip
    assert [allowed.index(tag) for tag in order] == sorted(allowed.index(tag) for tag in order)
    slots = {s.get("TIME_SLOT_ID"): int(s.get("TIME_VALUE")) for s in root.iter("TIME_SLOT")}
    types = {t.get("LINGUISTIC_TYPE_ID") for t in root.iter("LINGUISTIC_TYPE")}
    ids = [a.get("ANNOTATION_ID") for a in root.iter("ALIGNABLE_ANNOTATION")]
    assert len(set(ids)) == len(ids) == 4
    names = [tier.get("TIER_ID") for tier in root.iter("TIER")]
    assert len(set(names)) == len(names)
    assert {"fidgets@child", "fidgets@child (2)", "nods", "adibas sections"} <= set(names)
    for tier in root.iter("TIER"):
        assert tier.get("LINGUISTIC_TYPE_REF") in types
        spans = sorted(
            (slots[a.get("TIME_SLOT_REF1")], slots[a.get("TIME_SLOT_REF2")])
            for a in tier.iter("ALIGNABLE_ANNOTATION")
        )
        assert all(begin < end for begin, end in spans)
        assert all(end <= begin for (_, end), (begin, _) in pairwise(spans))


def test_what_was_moved_in_elan_is_moved_here(tmp_path):
    path = tmp_path / "c.eaf"
    write_elan(path, coding(("seated", 1, 2, "child")))
    path.write_text(path.read_text().replace('TIME_VALUE="2000"', 'TIME_VALUE="2500"'))
    assert read_elan(path).occurrences == (Occurrence("seated", 1000, 2500, "child"),)


ELAN = """<?xml version="1.0" encoding="UTF-8"?>
<ANNOTATION_DOCUMENT AUTHOR="me" DATE="2026-01-01T00:00:00+00:00" FORMAT="2.8" VERSION="2.8">
 <HEADER MEDIA_FILE="" TIME_UNITS="milliseconds"><MEDIA_DESCRIPTOR MEDIA_URL="file:///a.mp4"
  MIME_TYPE="video/mp4"/></HEADER>
 <TIME_ORDER><TIME_SLOT TIME_SLOT_ID="ts1" TIME_VALUE="100"/><TIME_SLOT TIME_SLOT_ID="ts2"/>
  <TIME_SLOT TIME_SLOT_ID="ts3" TIME_VALUE="900"/></TIME_ORDER>
 <TIER LINGUISTIC_TYPE_REF="t" TIER_ID="gaze" PARTICIPANT="Ann"><ANNOTATION>
  <ALIGNABLE_ANNOTATION ANNOTATION_ID="a1" TIME_SLOT_REF1="ts1" TIME_SLOT_REF2="ts3">
  <ANNOTATION_VALUE>at the table</ANNOTATION_VALUE></ALIGNABLE_ANNOTATION></ANNOTATION><ANNOTATION>
  <ALIGNABLE_ANNOTATION ANNOTATION_ID="a2" TIME_SLOT_REF1="ts1" TIME_SLOT_REF2="ts2">
  <ANNOTATION_VALUE/></ALIGNABLE_ANNOTATION></ANNOTATION></TIER>
 <TIER LINGUISTIC_TYPE_REF="t" TIER_ID="hand@Ben"/>
 <LINGUISTIC_TYPE LINGUISTIC_TYPE_ID="t" TIME_ALIGNABLE="true"/>
</ANNOTATION_DOCUMENT>
"""


ADDED_TIER = """
 <TIER LINGUISTIC_TYPE_REF="behaviour" TIER_ID="{name}"><ANNOTATION>
  <ALIGNABLE_ANNOTATION ANNOTATION_ID="a99" TIME_SLOT_REF1="ts1" TIME_SLOT_REF2="ts2">
   <ANNOTATION_VALUE>seen again</ANNOTATION_VALUE>
  </ALIGNABLE_ANNOTATION>
 </ANNOTATION></TIER>
 <LINGUISTIC_TYPE """


def test_what_was_added_in_elan_in_a_tier_of_its_own_is_read_or_told(tmp_path):
    path = tmp_path / "c.eaf"
    write_elan(path, coding(("seated", 1, 2, "child")))
    text = path.read_text("utf-8")

    def read_with(name):
        path.write_text(text.replace("<LINGUISTIC_TYPE ", ADDED_TIER.format(name=name)), "utf-8")
        return read_elan(path).occurrences

    seated = Occurrence("seated", 1000, 2000, "child")
    up = Occurrence("up", 1000, 2000, "peer", comment="seen again")
    nods = Occurrence("nods", 1000, 1000, "peer", comment="seen again")
    assert set(read_with("up@peer")) == {seated, up}
    assert set(read_with("nods@peer")) == {seated, nods}
    with pytest.raises(BehaviourError, match="walks is not in the ethogram"):
        read_with("walks@peer")


def test_a_file_that_elan_itself_wrote_is_read(tmp_path):
    path = tmp_path / "talk.eaf"
    path.write_text(ELAN)
    found = read_elan(path)
    assert found.occurrences == (Occurrence("gaze", 100, 900, "Ann", comment="at the table"),)
    assert (found.name, found.observer, found.media) == ("talk", "me", ("file:///a.mp4",))
    with pytest.raises(BehaviourError, match="gaze is not in the ethogram"):
        read_elan(path, ETHOGRAM)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "<a/>",
        '<!DOCTYPE x [<!ENTITY a "b">]><ANNOTATION_DOCUMENT/>',
        ELAN.replace('TIME_VALUE="900"', 'TIME_VALUE="50"'),
        ELAN.replace('TIME_VALUE="900"', 'TIME_VALUE="soon"'),
        ELAN.replace('<TIER LINGUISTIC_TYPE_REF="t" TIER_ID="gaze"', "<TIER"),
    ],
)
def test_a_broken_file_of_elan_is_told(tmp_path, text):
    path = tmp_path / "c.eaf"
    path.write_text(text)
    with pytest.raises(BehaviourError):
        read_elan(path)


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sampled_from(CODING_KINDS), st.integers(0, 5000), st.binary(min_size=1, max_size=3))
def test_any_change_of_bytes_is_read_or_told(tmp_path, kind, at, noise):
    one = coding(("seated", 1, 2, "child"), ("nods", 3, 3), sections=(Section("a", 0, 9),))
    path = tmp_path / f"c{kind}"
    write = {".boris": write_boris, ".csv": write_coding_csv, ".tsv": write_boris_table,
             ".xlsx": lambda p, s: write_coding_excel(p, s, "en"),
             ".eaf": lambda p, s: write_elan(p, s[0])}[kind]  # fmt: skip
    whole = Path(tmp_path / f"whole{kind}")
    if not whole.exists():
        write(whole, [one])
    data = bytearray(whole.read_bytes())
    at %= len(data)
    data[at : at + len(noise)] = noise
    path.write_bytes(bytes(data))
    try:
        found = read_codings(path)
    except AdibasError:
        return
    assert all(isinstance(part, Coding) for part in found)


def parts_of(path):
    with zipfile.ZipFile(path) as archive:
        return {part: archive.read(part).decode() for part in archive.namelist()}


@pytest.mark.parametrize(
    ("part", "old", "new"),
    [
        ("[Content_Types].xml", "<Types", "<Tapes"),
        ("[Content_Types].xml", "PartName", "Port"),
        ("xl/_rels/workbook.xml.rels", 'Id="rId1"', 'Id="rId9"'),
        ("xl/workbook.xml", "</sheets>", ""),
        ("xl/workbook.xml", 'sheetId="1"', 'sheetId="one"'),
        ("xl/worksheets/sheet1.xml", '<row r="2"', '<row r="two"'),
        ("xl/worksheets/sheet1.xml", '<c r="B3" t="inlineStr">', '<c r="B3" t="s"><v>99</v>'),
    ],
)
def test_a_whole_archive_that_is_no_workbook_is_told(tmp_path, part, old, new):
    path = tmp_path / "c.xlsx"
    write_coding_excel(path, [coding(("seated", 1, 2, "child"))], "en")
    parts = parts_of(path)
    assert old in parts[part]
    parts[part] = parts[part].replace(old, new, 1)
    with zipfile.ZipFile(path, "w") as archive:
        for name, text in parts.items():
            archive.writestr(name, text)
    with pytest.raises(BehaviourError, match=r"c\.xlsx cannot be read: "):
        read_codings(path)


def test_other_files_are_told(tmp_path):
    with pytest.raises(BehaviourError, match="must end in one of"):
        read_codings(tmp_path / "c.doc")
    for kind in CODING_KINDS:
        with pytest.raises(BehaviourError, match="cannot be read"):
            read_codings(tmp_path / f"none{kind}")
    (tmp_path / "c.csv").write_text("a,b\n1,2\n")
    with pytest.raises(BehaviourError, match="no table of events"):
        read_codings(tmp_path / "c.csv")


@given(st.integers(-(10**12), 10**12))
def test_every_millisecond_is_kept(time_ms):
    assert milliseconds(seconds_text(time_ms)) == time_ms
