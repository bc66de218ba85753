"""Patients, sessions and corrections: what they refuse, and that a history can be undone."""

from dataclasses import replace
from datetime import UTC, date, datetime

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.data.calibration import RgbdCalibration
from adibas.data.corrections import (
    CorrectionHistory,
    FreeMeasure,
    MarkerCorrection,
    MeasureCorrection,
)
from adibas.data.markers import Marker
from adibas.data.patients import Consent, Identity, Patient
from adibas.data.posture import Provenance
from adibas.data.sessions import Capture, Session, SessionSetup

NOW = datetime(2026, 11, 21, tzinfo=UTC)


def marker(label, u=0.0):
    return Marker(label, u, 0.0, 2.0, np.eye(2))


def patient(born=None, **changes):
    return Patient("P-1", Identity("Ada Lovelace", born), "female", "limps", NOW, **changes)


@pytest.mark.parametrize(
    ("born", "on", "age"),
    [
        (date(2010, 5, 6), date(2026, 5, 5), 15),
        (date(2010, 5, 6), date(2026, 5, 6), 16),
        (date(2012, 2, 29), date(2026, 2, 28), 13),
        (None, date(2026, 1, 1), None),
    ],
)
def test_an_age_is_counted_in_whole_years(born, on, age):
    assert patient(born).age_years(on) == age


def test_who_a_patient_is_stands_in_no_printed_text():
    consent = Consent(("research",), "Lord Byron", True, NOW)
    printed = f"{patient(consents=(consent,))!r} {consent} {Identity('Ada Lovelace')}"
    for secret in ("Ada", "Byron", "limps"):
        assert secret not in printed
    session = Session("s1", "P-1", NOW, "operator", SessionSetup(), notes="limps")
    assert "limps" not in repr(session)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Identity("  "),
        lambda: replace(patient(), sex="other"),
        lambda: Consent((), "A", False, NOW),
        lambda: Consent(("sale",), "A", False, NOW),
        lambda: Consent(("research",), " ", False, NOW),
        lambda: SessionSetup(rotation_deg=45),
        lambda: capture(view="above"),
        lambda: MarkerCorrection(None, None),
        lambda: MarkerCorrection(None, marker(" ")),
        lambda: MarkerCorrection(None, marker("m" * 41)),
        lambda: FreeMeasure(("a",)),
        lambda: FreeMeasure(("a", "b", "a")),
        lambda: MeasureCorrection(None, None),
        lambda: MeasureCorrection(FreeMeasure(("a", "b")), FreeMeasure(("a", "c"))),
        lambda: CorrectionHistory((), 1),
        lambda: CorrectionHistory((), -1),
        lambda: CorrectionHistory().undone(),
        lambda: CorrectionHistory().redone(),
    ],
)
def test_what_makes_no_sense_is_refused(make):
    with pytest.raises(ValueError, match=r"\w"):
        make()


def capture(view="anterior", history=None):
    return Capture(
        capture_id="c1",
        session_id="s1",
        view=view,
        captured_utc=NOW,
        recording_id="r1",
        first_frame=0,
        n_frames=30,
        calibration=RgbdCalibration(),
        detected=(marker("m01"), marker("m02")),
        rejected=(),
        provenance=Provenance("", "", "", "", {}),
        history=history or CorrectionHistory(),
    )


def test_corrections_change_the_markers_and_keep_their_order():
    renamed = MarkerCorrection(marker("m01"), marker("left_knee", 3.0))
    moved = MarkerCorrection(marker("left_knee", 3.0), marker("left_knee", 4.0))
    added = MarkerCorrection(None, marker("m03", 9.0))
    deleted = MarkerCorrection(marker("m02"), None)
    kinds = [one.kind for one in (renamed, moved, added, deleted)]
    assert kinds == ["rename", "move", "add", "delete"]
    history = CorrectionHistory()
    for one in (renamed, moved, added, deleted):
        history = history.after(one)
    found = [(m.label, m.u) for m in capture(history=history).markers()]
    assert found == [("left_knee", 4.0), ("m03", 9.0)]
    assert [m.label for m in capture(history=history.undone()).markers()] == [
        "left_knee",
        "m02",
        "m03",
    ]


@pytest.mark.parametrize(
    "wrong",
    [
        MarkerCorrection(marker("m09"), None),
        MarkerCorrection(None, marker("m02")),
        MarkerCorrection(marker("m01"), marker("m02")),
    ],
)
def test_a_history_that_does_not_fit_is_refused(wrong):
    with pytest.raises(ValueError, match="m0"):
        capture(history=CorrectionHistory().after(wrong)).markers()


def test_free_measures_come_and_go():
    angle, distance = FreeMeasure(("a", "b", "c")), FreeMeasure(("a", "b"))
    added = [MeasureCorrection(None, angle), MeasureCorrection(None, distance)]
    removed = MeasureCorrection(angle, None)
    assert [one.kind for one in (*added, removed)] == [
        "add-measure",
        "add-measure",
        "remove-measure",
    ]
    history = CorrectionHistory().after(added[0]).after(added[1])
    assert history.measures() == (angle, distance)
    assert history.after(removed).measures() == (distance,)


def test_a_free_measure_follows_the_name_of_its_marker():
    history = CorrectionHistory().after(MeasureCorrection(None, FreeMeasure(("a", "b", "c"))))
    renamed = history.after(MarkerCorrection(marker("b"), marker("knee")))
    assert renamed.measures() == (FreeMeasure(("a", "knee", "c")),)
    assert renamed.undone().measures() == history.measures()


def test_a_marker_that_is_added_changes_no_free_measure():
    history = CorrectionHistory().after(MeasureCorrection(None, FreeMeasure(("a", "b"))))
    assert history.after(MarkerCorrection(None, marker("c"))).measures() == history.measures()


def test_a_free_measure_goes_with_its_marker_and_comes_back_with_it():
    kept, lost = FreeMeasure(("a", "c")), FreeMeasure(("a", "b"))
    history = CorrectionHistory()
    for measure in (lost, kept):
        history = history.after(MeasureCorrection(None, measure))
    deleted = history.after(MarkerCorrection(marker("b"), None))
    assert deleted.measures() == (kept,)
    assert deleted.undone().measures() == (lost, kept)


@given(st.lists(st.sampled_from(["do", "undo", "redo"]), max_size=30))
def test_undo_takes_back_and_redo_brings_again(steps):
    history, done, undone = CorrectionHistory(), [], []
    for number, step in enumerate(steps):
        one = MarkerCorrection(None, marker(f"n{number}"))
        if step == "do":
            history, done, undone = history.after(one), [*done, one.after.label], []
        elif step == "undo" and history.can_undo:
            history = history.undone()
            undone.append(done.pop())
        elif step == "redo" and history.can_redo:
            history = history.redone()
            done.append(undone.pop())
        assert [m.label for m in history.markers(())] == done
        assert (history.can_undo, history.can_redo) == (bool(done), bool(undone))
