"""Reviewing a saved capture: markers set by hand get positions, and every measure anew."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import Float32Array, FloatArray, UInt8Array
from adibas.data.calibration import RgbdCalibration
from adibas.data.corrections import FreeMeasure
from adibas.data.markers import Marker, pixels_uv
from adibas.data.measures import AngleMeasure, DistanceMeasure
from adibas.data.posture import PostureAnalysis
from adibas.data.sessions import Capture
from adibas.data.surface import BurstDisparity
from adibas.markers.position import PositionFinder, PositionParams
from adibas.markers.snapping import HAND_RADIUS_PX, HAND_SD_PX, Snap, by_hand, snap
from adibas.measures.geometry_tables import all_angles, all_distances
from adibas.pipeline.posture import MarkerTarget
from adibas.texts import message

REACH_PX = 15.0
"""How far from a click a marker may be to be meant: about 40 mm at 2 m in a 1280 wide picture."""

CORRECTED = message("Markers were corrected by hand.")


@dataclass(frozen=True, slots=True)
class Measures:
    """Distances and angles of some markers."""

    distances: tuple[DistanceMeasure, ...]
    angles: tuple[AngleMeasure, ...]


class CaptureSurface:
    """The surface of a capture, and where the pixels of its picture lie on it.

    `burst` is the one that was saved, or None.

    Parameters
    ----------
    surface : BurstDisparity or None
        As saved; None where it was not kept: then markers get no positions.
    calibration : RgbdCalibration
        Of the capture.
    detected : sequence of Marker
        Those of the capture: the skin about them tells how noisy its depth is.
    """

    def __init__(
        self,
        surface: BurstDisparity | None,
        calibration: RgbdCalibration,
        detected: Sequence[Marker] = (),
    ) -> None:
        if calibration.color is None:
            raise ValueError("a capture has a colour camera")
        self.burst = surface
        self._camera = calibration.color
        self._finder = (
            None
            if surface is None
            else PositionFinder(surface, calibration, PositionParams(), pixels_uv(detected))
        )

    def measured(
        self,
        label: str,
        u: float,
        v: float,
        covariance_px2: FloatArray | None = None,
        radius_px: float = HAND_RADIUS_PX,
    ) -> Marker:
        """Return the marker at a pixel, with its position where the depth gives one.

        Parameters
        ----------
        label : str
            Its name.
        u, v : float
            Centre in the colour picture, pixels.
        covariance_px2 : (2, 2) array or None
            Of (u, v); None: as sure as a hand is, one pixel.
        radius_px : float
            Of its disc.
        """
        if covariance_px2 is None:
            covariance_px2 = np.eye(2) * HAND_SD_PX**2
        plain = Marker(label, u, v, radius_px, np.array(covariance_px2, float))
        if self._finder is None or not self._is_in_picture(u, v):
            return plain
        return self._finder.placed(plain)

    def snapped(
        self,
        picture_rgb: UInt8Array,
        u: float,
        v: float,
        reach_px: float = REACH_PX,
        target: MarkerTarget | None = None,
    ) -> Snap:
        """Return the centre of the marker nearest to a click, or the click where there is none.

        Parameters
        ----------
        picture_rgb : (H, W, 3) array
            Of the capture.
        u, v : float
            Where it was clicked, pixels.
        reach_px : float
            How far from the click the centre may be; 0 takes the click.
        target : MarkerTarget or None
            What markers look like; None takes any small blob that stands out.
        """
        if not reach_px > 0:
            return by_hand(u, v)
        position_m = self.measured("here", u, v).position_m
        distance_m = None if position_m is None else float(position_m[2])
        return snap(picture_rgb, (u, v), reach_px, target, (distance_m, self._camera.intrinsics.fx))

    def _is_in_picture(self, u: float, v: float) -> bool:
        return -0.5 <= u <= self._camera.width - 0.5 and -0.5 <= v <= self._camera.height - 0.5  # noqa: PLR2004


def measures_of(markers: tuple[Marker, ...]) -> Measures:
    """Return the distance of every pair of markers and the angles of every triplet."""
    return Measures(all_distances(markers), all_angles(markers))


def chosen_measures(markers: tuple[Marker, ...], chosen: tuple[FreeMeasure, ...]) -> Measures:
    """Return only the measures that were asked for, in their order: while a marker is dragged.

    Those whose markers are gone or have no position are left out.
    """
    placed = {marker.label: marker for marker in markers if marker.position_m is not None}
    distances: list[DistanceMeasure] = []
    angles: list[AngleMeasure] = []
    for measure in chosen:
        if not placed.keys() >= set(measure.labels):
            continue
        corners = tuple(placed[label] for label in measure.labels)
        distances += all_distances(corners) if len(corners) == 2 else ()  # noqa: PLR2004
        # Of the three angles of a triplet the second has its vertex at the second marker.
        angles += [angle for angle in all_angles(corners) if angle.vertex == measure.labels[1]]
    return Measures(tuple(distances), tuple(angles))


def posture_analysis(
    capture: Capture,
    picture_rgb: UInt8Array,
    patient: str = "",
    surface_per_m: Float32Array | None = None,
) -> PostureAnalysis:
    """Return the analysis of a capture with its markers as corrected, for reports.

    Parameters
    ----------
    capture : Capture
        As the store keeps it.
    picture_rgb : (H, W, 3) array
        Its picture.
    patient : str
        A pseudonym.
    surface_per_m : (H', W') float32 array or None
        Mean of 1/z, 1/metres (`BurstDisparity.mean_per_m`); None where none was kept.
    """
    markers = capture.markers()
    measures = measures_of(markers)
    was_corrected = any(
        correction.kind in ("add", "delete", "move")
        for correction in capture.history.corrections[: capture.history.n_done]
    )
    return PostureAnalysis(
        patient=patient,
        view=capture.view,
        n_frames=capture.n_frames,
        first_frame=capture.first_frame,
        markers=markers,
        rejected=capture.rejected,
        distances=measures.distances,
        angles=measures.angles,
        picture_rgb=picture_rgb,
        calibration=capture.calibration,
        provenance=capture.provenance,
        notices=(*capture.notices, *((CORRECTED,) if was_corrected else ())),
        surface_per_m=surface_per_m,
    )
