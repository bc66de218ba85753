"""A protocol on a whole body: each view by its own markers, and by the landmarks of all views."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from adibas.arrays import FloatArray
from adibas.data.markers import Marker
from adibas.data.protocol_measures import MeasureResult, ProtocolMeasures, VerticalOrigin
from adibas.data.sentence import Sentence
from adibas.geometry.rigid import RigidTransform
from adibas.measures.protocol_measures import UNKNOWN_LABEL, Capturing, measure_protocol
from adibas.measures.sight_plane import Vertical, vertical_of
from adibas.pipeline.body_landmarks import Landmark, MarkedView, as_markers
from adibas.pipeline.protocol_measuring import ProtocolWish
from adibas.surface.patient_axes import UP, level_camera_from_patient


@dataclass(frozen=True, slots=True, eq=False)
class SideMeasures:
    """What a protocol measures on one side of the body.

    Attributes
    ----------
    view : str
    seen : ProtocolMeasures or None
        By the markers of the view itself; None where there is no such view.
    fused : ProtocolMeasures
        By the landmarks of all views, as a sensor would see them to which the patient shows this
        side squarely, in the axes of the first view.
    """

    view: str
    seen: ProtocolMeasures | None
    fused: ProtocolMeasures

    def pairs(self) -> tuple[tuple[MeasureResult | None, MeasureResult], ...]:
        """Return each measure of the side as the view itself gives it, and as all views do."""
        seen = (None,) * len(self.fused.results) if self.seen is None else self.seen.results
        return tuple(zip(seen, self.fused.results, strict=True))


def protocol_of_body(
    wish: ProtocolWish,
    views: Sequence[MarkedView],
    landmarks: Sequence[Landmark],
    patient_from_camera: RigidTransform,
) -> tuple[SideMeasures, ...]:
    """Follow a protocol on all its sides, also on those that were not captured.

    Parameters
    ----------
    views : sequence of MarkedView
        The first gives the axes.
    patient_from_camera : RigidTransform
        Of the first view's depth camera.
    """
    vertical = _patient_vertical(views[0], patient_from_camera)
    marks = as_markers(landmarks)
    by_hand = frozenset[str]().union(*(view.by_hand for view in views))
    seen = {view.view: _seen(wish, view) for view in views}
    sides = []
    for side in wish.protocol.views:
        turn = level_camera_from_patient(side)
        capturing = Capturing(side, replace(vertical, up=turn @ vertical.up), wish.plane, by_hand)
        turned = [_rotated(mark, turn) for mark in marks]
        fused = measure_protocol(wish.protocol, turned, capturing)
        # Most landmarks belong to other sides.
        told = tuple(notice for notice in fused.notices if notice.message != UNKNOWN_LABEL)
        sides.append(SideMeasures(side, seen.get(side), replace(fused, notices=told)))
    return tuple(sides)


def _seen(wish: ProtocolWish, view: MarkedView) -> ProtocolMeasures:
    vertical = vertical_of(view.seen.calibration)
    if vertical.origin is VerticalOrigin.UNKNOWN:  # the floor that is seen tells the sides at least
        up = view.seen.calibration.color_from_depth.rotation @ view.seen.floor.normal
        vertical = replace(vertical, up=up)
    capturing = Capturing(view.view, vertical, wish.plane, view.by_hand)
    return measure_protocol(wish.protocol, view.markers, capturing)


def _patient_vertical(view: MarkedView, patient_from_camera: RigidTransform) -> Vertical:
    """Return the vertical that the first view's calibration knows, else that of the floor seen."""
    vertical = vertical_of(view.seen.calibration)
    if vertical.origin is VerticalOrigin.UNKNOWN:
        return Vertical(UP, 0.0, VerticalOrigin.FLOOR, is_sd_known=False)
    depth_from_color = view.seen.calibration.color_from_depth.rotation.T
    return replace(vertical, up=patient_from_camera.rotation @ depth_from_color @ vertical.up)


def _rotated(mark: Marker, turn: FloatArray) -> Marker:
    if mark.position_m is None or mark.covariance_m2 is None or mark.shared_m is None:
        raise ValueError("a fused landmark has a place")
    return replace(
        mark,
        position_m=turn @ mark.position_m,
        covariance_m2=turn @ mark.covariance_m2 @ turn.T,
        shared_m=turn @ mark.shared_m,
    )


def notices_of_sides(sides: Sequence[SideMeasures]) -> tuple[Sentence, ...]:
    """Return what must be known of the measures, each sentence once."""
    told: list[Sentence] = []
    for side in sides:
        seen = () if side.seen is None else side.seen.notices
        for notice in (*seen, *side.fused.notices):
            if notice not in told:
                told.append(notice)
    return tuple(told)
