"""A protocol followed on a posture analysis."""

from collections.abc import Collection
from dataclasses import dataclass, replace

from adibas.data.markers import Marker
from adibas.data.posture import PostureAnalysis
from adibas.data.protocol_measures import PlaneChoice, ProtocolMeasures
from adibas.data.protocols import Protocol
from adibas.data.sessions import Capture, Session
from adibas.errors import ProtocolError
from adibas.measures.protocol_measures import Capturing, measure_protocol
from adibas.measures.protocol_store import find_protocol
from adibas.measures.sight_plane import vertical_of
from adibas.texts import Message, message

NO_VIEW = message(
    "Which side the picture shows was not told, so that nothing of the protocol was measured in it."
)
LOST_PROTOCOL = message(
    "The protocol of this session cannot be read on this computer: its measures are missing."
)


@dataclass(frozen=True, slots=True)
class ProtocolWish:
    """Which protocol to follow, and the plane of its projected values."""

    protocol: Protocol
    plane: PlaneChoice = PlaneChoice.SENSOR


def check_view(wish: ProtocolWish, view: str) -> None:
    """Raise ProtocolError where the protocol measures nothing in a view, or none was told."""
    views = wish.protocol.views
    if not view:
        raise ProtocolError(
            "A protocol needs to know which side is seen. Give --view with one of: {views}.",
            views=", ".join(views),
        )
    if view not in views:
        raise ProtocolError(
            "The protocol {name} measures nothing in the view {view}. Its views are: {views}.",
            name=wish.protocol.protocol_id,
            view=view,
            views=", ".join(views),
        )


def with_measures(
    analysis: PostureAnalysis,
    wish: ProtocolWish,
    by_hand: Collection[str] = (),
    rotation_deg: int = 0,
) -> PostureAnalysis:
    """Return the analysis with the measures of a protocol.

    Parameters
    ----------
    analysis : PostureAnalysis
        Its markers' labels say which landmarks they are.
    wish : ProtocolWish
        What to measure.
    by_hand : collection of str
        Labels of markers that were placed by hand.
    rotation_deg : int
        How far the picture is turned clockwise to be upright.
    """
    if not analysis.view:
        return replace(analysis, notices=(*analysis.notices, NO_VIEW))
    vertical = vertical_of(analysis.calibration, rotation_deg)
    capturing = Capturing(analysis.view, vertical, wish.plane, by_hand)
    provenance = analysis.provenance
    parameters = {
        **provenance.parameters,
        "protocol": {
            "id": wish.protocol.protocol_id,
            "revision": wish.protocol.revision,
            "plane": wish.plane.value,
        },
    }
    return replace(
        analysis,
        measures=measure_protocol(wish.protocol, analysis.markers, capturing),
        provenance=replace(provenance, parameters=parameters),
    )


def measured_capture(
    capture: Capture,
    markers: tuple[Marker, ...],
    wish: ProtocolWish,
    rotation_deg: int,
    by_hand: Collection[str] | None = None,
) -> ProtocolMeasures:
    """Return a protocol's measures on markers of a capture.

    Parameters
    ----------
    capture : Capture
    markers : tuple of Marker
        As corrected, or as they are being corrected.
    wish : ProtocolWish
        Whose protocol knows the capture's view.
    rotation_deg : int
        How far the picture is turned clockwise to be upright.
    by_hand : collection of str or None
        Labels of markers that were placed by hand; None: those of the saved corrections.
    """
    vertical = vertical_of(capture.calibration, rotation_deg)
    placed = capture.history.placed_by_hand() if by_hand is None else by_hand
    return measure_protocol(
        wish.protocol, markers, Capturing(capture.view, vertical, wish.plane, placed)
    )


def wish_of_session(session: Session) -> tuple[ProtocolWish | None, tuple[Message, ...]]:
    """Return the protocol that a session names, and what to tell where it cannot be read."""
    if not session.setup.protocol:
        return None, ()
    try:
        return ProtocolWish(find_protocol(session.setup.protocol)), ()
    except ProtocolError:
        return None, (LOST_PROTOCOL,)
