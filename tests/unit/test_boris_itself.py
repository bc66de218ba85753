"""BORIS itself opens the projects that we write, pairs the same events, and counts the same."""

import dataclasses
import json
import os
import subprocess
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from adibas.behaviour.budget import budgets
from adibas.recordings.boris_writing import told_modifiers, write_boris
from tests.unit.coding_samples import coding, codings

ROOT = Path(__file__).parents[2]
BORIS = ROOT / ".venv-boris" / "bin" / "python"
READER = Path(__file__).with_name("boris_reader.py")
NO_FOCUS = "No focal subject"
MISSING = "BORIS is missing: installers/setup.sh ci"

pytestmark = pytest.mark.skipif(not BORIS.exists(), reason=MISSING)


def read_by_boris(path):
    """Return what `boris_reader` tells of a project."""
    ran = subprocess.run(
        [str(BORIS), str(READER), str(path)],
        capture_output=True,
        text=True,
        check=True,
        env={"PATH": os.environ["PATH"], "PYTHONUTF8": "1"},
        timeout=120,
    )
    return json.loads(ran.stdout)


def as_boris_has(one):
    """Return the events of a coding, sorted, in BORIS' words."""
    events = []
    for part in one.occurrences:
        behaviour = one.ethogram.behaviour(part.behaviour)
        at_s = (part.begin_ms / 1000, part.end_ms / 1000)
        is_state = behaviour.kind == "state"
        events.append(
            (
                *(one.name, part.subject or NO_FOCUS, part.behaviour),
                "STATE" if is_state else "POINT",
                told_modifiers(behaviour, part.modifiers),
                *at_s,
                part.comment,
                part.end_comment,
            )
        )
    return sorted(events)


def counted(one):
    """Return count, whole and mean duration in seconds of what was seen, by whom and what."""
    return {
        (one.name, part.subject or NO_FOCUS, part.behaviour): (
            part.count,
            part.total_ms / 1000 if part.is_state else None,
            part.mean_ms / 1000 if part.mean_ms is not None else None,
        )
        for part in budgets(one)
        if part.count
    }


def number(told):
    return None if told == "NA" else float(told)


@settings(
    max_examples=6,
    phases=[Phase.generate],  # to shrink what BORIS reads takes minutes
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(st.lists(codings(), min_size=6, max_size=6))
def test_boris_reads_pairs_and_counts_what_we_write_as_we_do(tmp_path, some):
    some = [dataclasses.replace(one, name=f"s{place}") for place, one in enumerate(some)]
    write_boris(tmp_path / "c.boris", some)
    told = read_by_boris(tmp_path / "c.boris")
    assert told["problem"] == ""
    assert told["usable"] == [one.name for one in some]
    events = sorted(tuple(one.values()) for one in told["events"])
    assert events == sorted(event for one in some for event in as_boris_has(one))
    by_boris = {
        (one["observation"], one["subject"], one["behavior"]): (
            one["number"],
            number(one["duration"]),
            number(one["duration_mean"]),
        )
        for one in told["budgets"]
    }
    ours = {key: value for one in some for key, value in counted(one).items()}
    assert by_boris.keys() == ours.keys()
    for key, (count, total_s, mean_s) in ours.items():
        # BORIS rounds to a millisecond.
        assert by_boris[key] == (count, pytest.approx(total_s), pytest.approx(mean_s, abs=6e-4))


def test_boris_reads_modifiers_comments_and_films(tmp_path):
    one = coding(
        ("seated", 1, 2.5, "child", (), "calm", "called"),
        ("fidgets", 1, 3, "child", ("pen,hair", "left"), "why"),
        ("fidgets", 1, 3, "peer", ("pen", "")),
        ("nods", 4, 4, "", ("2",)),
        media=("film.mp4",),
    )
    write_boris(tmp_path / "c.boris", [one])
    told = read_by_boris(tmp_path / "c.boris")
    assert told["problem"] == ""
    assert [tuple(event.values())[1:] for event in told["events"]] == [
        (NO_FOCUS, "nods", "POINT", "2", 4.0, 4.0, "", ""),
        ("child", "fidgets", "STATE", "pen,hair|left", 1.0, 3.0, "why", ""),
        ("child", "seated", "STATE", "", 1.0, 2.5, "calm", "called"),
        ("peer", "fidgets", "STATE", "pen|None", 1.0, 3.0, "", ""),
    ]
