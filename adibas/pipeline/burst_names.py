"""The markers of a burst get their names, by their places and by the body that its depth shows."""

from dataclasses import dataclass

from adibas.data.calibration import RgbdCalibration
from adibas.data.markers import Marker
from adibas.pipeline.posture import MarkerFindings
from adibas.pipeline.seen_body import with_body
from adibas.pipeline.skeleton_names import with_names
from adibas.pipeline.view_check import doubts_about_view
from adibas.skeleton.namer import Namer
from adibas.texts import Message


@dataclass(frozen=True, slots=True, eq=False)
class BurstNames:
    """The markers of a burst with their names.

    Attributes
    ----------
    markers : tuple of Marker
        In the order of what was found.
    namer : Namer or None
        Who named them, and whether it knew the body; None where nobody knows the landmarks.
    doubts : tuple of Message
        What must be known of the declared view.
    """

    markers: tuple[Marker, ...]
    namer: Namer | None
    doubts: tuple[Message, ...] = ()


def name_burst(
    namer: Namer | None,
    found: MarkerFindings,
    view: str,
    calibration: RgbdCalibration,
    named_by_hand: frozenset[str] = frozenset(),
    rotation_deg: int = 0,
) -> BurstNames:
    """Name the markers of a burst; see `with_names`.

    Parameters
    ----------
    namer : Namer or None
        Who knows the landmarks (`adibas.pipeline.namers.namer_of`); None: no marker gets a name.
    found : MarkerFindings
    """
    if namer is None:
        return BurstNames(found.markers, None)
    seeing = with_body(
        namer, found.surface.depth_m, view, calibration, rotation_deg, found.put_together
    )
    markers = with_names(seeing, found.markers, view, calibration, named_by_hand, rotation_deg)
    doubts = doubts_about_view(namer, markers, view, calibration, rotation_deg)
    return BurstNames(markers, seeing, doubts)
