"""What a report is made of: captures, and which of their markers a hand has placed."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.data.corrections import CorrectionHistory, MarkerCorrection
from adibas.data.markers import Marker
from adibas.data.report import CaptureReport, PictureChoice, SessionReport


def at(label, u):
    return Marker(label, u, 20.0, 4.0, np.eye(2))


def history(*corrections):
    found = CorrectionHistory()
    for before, after in corrections:
        found = found.after(MarkerCorrection(before, after))
    return found


def test_added_and_moved_markers_are_placed_by_hand_and_renamed_ones_are_not():
    corrections = history(
        (at("m01", 10), at("m01", 11)),
        (None, at("m05", 40)),
        (at("m02", 20), at("c7", 20)),
    )
    assert corrections.placed_by_hand() == {"m01", "m05"}


def test_a_new_name_goes_with_the_marker_that_a_hand_has_placed():
    corrections = history((at("m01", 10), at("m01", 11)), (at("m01", 11), at("c7", 11)))
    assert corrections.placed_by_hand() == {"c7"}
    assert corrections.undone().undone().placed_by_hand() == frozenset()


def test_a_deleted_marker_is_placed_by_nobody():
    corrections = history((at("m01", 10), at("m01", 11)), (at("m01", 11), None))
    assert corrections.placed_by_hand() == frozenset()


def test_a_report_needs_a_capture_and_an_upright_turn(analysis):
    capture = CaptureReport(analysis)
    report = SessionReport("p1", (capture,), notes="a name might stand here")
    assert report.pictures is PictureChoice.AS_IS
    assert "might" not in repr(report)
    with pytest.raises(ValueError, match="capture"):
        SessionReport("p1", ())
    with pytest.raises(ValueError, match="rotation"):
        SessionReport("p1", (capture,), rotation_deg=45)


def test_the_surface_of_an_analysis_is_a_read_only_image(analysis):
    surface_per_m = np.full((4, 5), 0.5, np.float32)
    assert replace(analysis, surface_per_m=surface_per_m).surface_per_m is surface_per_m
    with pytest.raises(ValueError, match="read-only"):
        surface_per_m[0, 0] = 1.0
    with pytest.raises(ValueError, match="surface_per_m"):
        replace(analysis, surface_per_m=np.zeros(3, np.float32))
