"""Markers of two sessions over a picture, and two pictures in one."""

from adibas.arrays import UInt8Array
from adibas.data.landmark_texts import landmark_text
from adibas.data.markers import Marker
from adibas.pipeline.picture_overlay import PictureOverlay, mixed
from ui.comparison.content import Pair
from ui.widgets.overlays import Dot, Line, Overlay, Role


def marker_overlays(markers: tuple[Marker, ...], role: Role) -> tuple[Overlay, ...]:
    """Return the markers of one session with their names."""
    return tuple(
        Dot(one.u, one.v, one.radius_px, landmark_text(one.label), role, key=one.label)
        for one in markers
    )


def both_overlays(pair: Pair) -> tuple[Overlay, ...]:
    """Return the markers of both sessions in the later picture, joined where they are the same."""
    if pair.earlier is None or pair.later is None or pair.overlay is None:
        return ()
    before = {one.label: _moved(one, pair.overlay) for one in pair.earlier.markers}
    now = {one.label: (one.u, one.v) for one in pair.later.markers}
    joined = [Line(*before[name], *now[name]) for name in before if name in now]
    radii = {one.label: one.radius_px for one in (*pair.earlier.markers, *pair.later.markers)}
    return (
        *joined,
        *(Dot(*place, radii[name], role="earlier", key=name) for name, place in before.items()),
        *(
            Dot(*place, radii[name], landmark_text(name), "later", key=name)
            for name, place in now.items()
        ),
    )


def blended(pair: Pair, share: float) -> UInt8Array | None:
    """Return the picture of both; `share` of the later one."""
    if pair.laid_rgb is None or pair.later is None:
        return None
    return mixed(pair.laid_rgb, pair.later.picture_rgb, share)


def _moved(marker: Marker, overlay: PictureOverlay) -> tuple[float, float]:
    return overlay.moved(marker.u, marker.v)
