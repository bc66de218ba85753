"""How fast reports are written."""

import tempfile
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from adibas.data.calibration import RgbdCalibration
from adibas.data.markers import Marker
from adibas.data.posture import PostureAnalysis, Provenance
from adibas.measures.geometry_tables import all_angles, all_distances
from adibas.pipeline.session_report import report_of_analysis
from adibas.reports import write_report
from benchmarks.table import Row
from benchmarks.works import median_ms

N_MARKERS = 15
N_VIEWS = 4
SEED = 5
GOAL_MS = 200.0


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure CPU time; with `quick` fewer rounds."""
    analysis = _analysis()
    n_measures = len(analysis.distances) + len(analysis.angles)
    n_rounds = 3 if quick else 9
    report = report_of_analysis(analysis, "en")
    views = replace(report, captures=report.captures * N_VIEWS)
    with tempfile.TemporaryDirectory() as folder:
        excel, pdf = Path(folder) / "report.xlsx", Path(folder) / "report.pdf"
        excel_ms = median_ms(lambda: write_report(report, excel), n_rounds)
        pdf_ms = median_ms(lambda: write_report(report, pdf), n_rounds)
        views_ms = median_ms(lambda: write_report(views, pdf), n_rounds)
    name = f"Excel report of {N_MARKERS} markers, {n_measures:,} distances and angles, CPU time"
    yield Row(name, excel_ms, "ms", GOAL_MS, "goal <=")
    yield Row("PDF report of the same, one view, CPU time", pdf_ms, "ms")
    yield Row(f"PDF report of {N_VIEWS} views, CPU time", views_ms, "ms")


def _analysis() -> PostureAnalysis:
    rng = np.random.default_rng(SEED)
    positions_m = rng.uniform((-0.4, -0.9, 1.9), (0.4, 0.9, 2.1), (N_MARKERS, 3))
    markers = tuple(
        Marker(
            label=f"m{number:02d}",
            u=float(640 + 525 * x_m),
            v=float(512 + 525 * y_m),
            radius_px=4.0,
            covariance_px2=np.eye(2) * 0.01,
            position_m=np.array([x_m, y_m, z_m]),
            covariance_m2=np.eye(3) * 1e-6,
        )
        for number, (x_m, y_m, z_m) in enumerate(positions_m, 1)
    )
    return PostureAnalysis(
        patient="patient-1",
        view="anterior",
        n_frames=30,
        first_frame=0,
        markers=markers,
        rejected=(),
        distances=all_distances(markers),
        angles=all_angles(markers),
        picture_rgb=rng.integers(0, 256, (1024, 1280, 3), np.uint8),
        calibration=RgbdCalibration(),
        provenance=Provenance("ab" * 32, "sha256:" + "cd" * 32, "0", "2026-01-01T00:00:00", {}),
    )
