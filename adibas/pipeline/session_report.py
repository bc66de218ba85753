"""What a report shows, out of what was analysed or what the store keeps."""

from dataclasses import replace

from adibas import __version__
from adibas.arrays import Float32Array, UInt8Array
from adibas.data.posture import PostureAnalysis
from adibas.data.report import CaptureReport, PictureChoice, SessionReport
from adibas.data.sessions import Capture, Session
from adibas.pipeline.protocol_measuring import ProtocolWish, with_measures
from adibas.pipeline.review import posture_analysis


def report_of_analysis(
    analysis: PostureAnalysis,
    language: str,
    pictures: PictureChoice = PictureChoice.AS_IS,
    rotation_deg: int = 0,
) -> SessionReport:
    """Return the report of one capture that belongs to no session."""
    return SessionReport(
        patient=analysis.patient,
        captures=(CaptureReport(analysis),),
        language=language,
        pictures=pictures,
        version=__version__,
        rotation_deg=rotation_deg,
    )


def report_of_session(
    session: Session,
    captures: tuple[CaptureReport, ...],
    language: str,
    pictures: PictureChoice = PictureChoice.AS_IS,
) -> SessionReport:
    """Return the report of a session's captures; see `capture_report`."""
    patient = session.patient
    return SessionReport(
        patient=patient,
        captures=tuple(
            replace(capture, analysis=replace(capture.analysis, patient=patient))
            for capture in captures
        ),
        language=language,
        pictures=pictures,
        version=__version__,
        started_utc=session.started_utc,
        operator=session.operator,
        protocol=session.setup.protocol,
        notes=session.notes,
        rotation_deg=session.setup.rotation_deg,
    )


def capture_report(
    capture: Capture,
    picture_rgb: UInt8Array,
    surface_per_m: Float32Array | None,
    protocol: ProtocolWish | None = None,
    rotation_deg: int = 0,
) -> CaptureReport:
    """Measure a capture as it was corrected.

    Parameters
    ----------
    picture_rgb : (H, W, 3) uint8 array
        The capture's colour picture.
    surface_per_m : (H', W') float32 array or None
        Mean of 1/z, 1/metres (`BurstDisparity.mean_per_m`); None where none was kept.
    protocol : ProtocolWish or None
        What to measure besides distances and angles.
    rotation_deg : int
        Of the session: how far its pictures are turned clockwise to be upright.
    """
    analysis = posture_analysis(capture, picture_rgb, surface_per_m=surface_per_m)
    by_hand = capture.history.placed_by_hand()
    if protocol is not None:
        analysis = with_measures(analysis, protocol, by_hand, rotation_deg)
    return CaptureReport(analysis, by_hand, capture.history.measures())
