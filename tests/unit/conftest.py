"""Where a store is put, and a small posture analysis: several tests share them."""

import numpy as np
import pytest

from adibas.data.calibration import RgbdCalibration
from adibas.data.markers import Marker, RejectedBlob
from adibas.data.measures import AngleMeasure, DistanceMeasure
from adibas.data.posture import PostureAnalysis, Provenance
from tests.unit.store_samples import PASSPHRASE


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where a store is put; the command line is given its passphrase."""
    monkeypatch.setenv("ADIBAS_PASSPHRASE", PASSPHRASE)
    return tmp_path / "store"


@pytest.fixture
def analysis():
    """Three markers with positions 3-4-5 apart, one without; a hostile label and pseudonym."""
    sd2 = np.diag([1e-6, 1e-6, 4e-6])

    def marker(label, u, position_m):
        return Marker(label, u, 20.25, 4.0, np.eye(2) / 16, np.array(position_m), sd2.copy())

    return PostureAnalysis(
        patient='=HYPERLINK("http://x")',
        view="anterior",
        n_frames=30,
        first_frame=0,
        markers=(
            marker("m01", 30.5, [0.0, 0.0, 2.0]),
            marker("m02", 60.5, [0.3, 0.0, 2.0]),
            marker("@m03", 90.5, [0.0, 0.4, 2.0]),
            Marker("m04", 120.5, 20.25, 4.0, np.eye(2)),
        ),
        rejected=(RejectedBlob(5.0, 6.0, "too large for a marker at that distance"),),
        distances=(
            DistanceMeasure("m01", "m02", 0.3, (0.299, 0.301)),
            DistanceMeasure("m01", "@m03", 0.4, (0.399, 0.401)),
            DistanceMeasure("m02", "@m03", 0.5, (0.499, 0.501)),
        ),
        angles=(
            AngleMeasure("m02", "m01", "@m03", np.pi / 2, (1.56, 1.58), 0.001),
            AngleMeasure("m01", "m02", "@m03", np.arctan2(4, 3), (0.92, 0.94), 0.0),
            AngleMeasure("m01", "@m03", "m02", np.arctan2(3, 4), (0.63, 0.65), 0.0),
        ),
        picture_rgb=np.full((120, 160, 3), 90, np.uint8),
        calibration=RgbdCalibration(sensor_serial="S1"),
        provenance=Provenance(
            "ab" * 32,
            "sha256:" + "cd" * 32,
            "0.1.0",
            "2026-11-21T10:00:00+00:00",
            {"detection": {"threshold": 12.5, "name": "-x"}},
        ),
        notices=("The recording was cut: 30 whole frames are left.",),
    )
